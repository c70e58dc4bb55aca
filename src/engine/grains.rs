//! The grains: a structure of arrays of packed 4-vectors, one entry per living grain.
//!
//! The index of a grain may change (re-ordering in memory, breakage); its [`Grains::id`] never does. Everything that is
//! summed over grains is summed in the order of ids, so that memory order cannot change a bit.

use crate::material::Material;
use crate::math::real::Real;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// State of all grains. Velocities and spins are those of the last half step (leapfrog).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Grains {
    /// Centre x, y, z and radius, m.
    pub pos: Vec<[f64; 4]>,
    /// Velocity, m/s; the last lane is the inverse of the inertial mass, 1/kg.
    pub vel: Vec<[f64; 4]>,
    /// Spin, rad/s; the last lane is the excess of the radius that sets the stiffness of contacts over the grain's own radius, divided by the latter:
    /// 0 but for daughters under [`crate::contact::ContactLaw::LinearInherited`].
    pub spin: Vec<[f64; 4]>,
    /// Real mass, kg (the inertial mass differs from it in inertia-scaled runs).
    pub mass: Vec<f64>,
    /// Persistent identity, in order of creation.
    pub id: Vec<u32>,
    /// Key of the grain's random streams ([`crate::math::random`]).
    pub lineage: Vec<u64>,
    /// 0 for initial grains, one more for each breakage.
    pub generation: Vec<u8>,
    /// Step in which the grain was born of a breakage; 0 for initial grains.
    pub born: Vec<u64>,
    pub material: Vec<u8>,
    /// Limit strength sigma_lim, Pa (infinite where the grain cannot break).
    pub strength: Vec<f64>,
    /// Largest load the grain bears, in the units of the failure criterion ([`crate::breakage::criterion::FailureCriterion::threshold`]).
    pub breakage_threshold: Vec<f64>,
    /// Work since the ledger's start, J: contact path, slip, viscous, local damping.
    pub work: Vec<[f64; 4]>,
    /// The identity the next new grain gets.
    pub next_id: u32,
}

/// As [`Grains::stiffness_radius`], from the entries of [`Grains::pos`] and [`Grains::spin`].
#[inline(always)]
pub fn stiffness_radius<R: Real>(pos: [R; 4], spin: [R; 4]) -> R {
    pos[3] + pos[3] * spin[3]
}

/// Volume of a sphere, m^3.
pub fn sphere_volume(r: f64) -> f64 {
    4.0 / 3.0 * PI * (r * r * r)
}

impl Grains {
    pub fn len(&self) -> usize {
        self.pos.len()
    }

    pub fn is_empty(&self) -> bool {
        self.pos.is_empty()
    }

    /// Adds a grain at rest that cannot break, with its real mass as inertia; returns its index.
    pub fn add(&mut self, centre: [f64; 3], radius: f64, material: u8, materials: &[Material]) -> usize {
        let mass = materials[material as usize].density * sphere_volume(radius);
        let i = self.len();
        self.pos.push([centre[0], centre[1], centre[2], radius]);
        self.vel.push([0.0, 0.0, 0.0, 1.0 / mass]);
        self.spin.push([0.0; 4]);
        self.mass.push(mass);
        self.id.push(self.next_id);
        self.lineage.push(crate::math::random::lineage_root(self.next_id));
        self.generation.push(0);
        self.born.push(0);
        self.material.push(material);
        self.strength.push(f64::INFINITY);
        self.breakage_threshold.push(f64::INFINITY);
        self.work.push([0.0; 4]);
        self.next_id += 1;
        i
    }

    /// The radius that sets the stiffness of the contacts of grain `i`, m.
    pub fn stiffness_radius(&self, i: usize) -> f64 {
        stiffness_radius(self.pos[i], self.spin[i])
    }

    /// Inertial mass of grain `i`, kg.
    pub fn inertia(&self, i: usize) -> f64 {
        1.0 / self.vel[i][3]
    }

    /// Indices in the order of ids.
    pub fn by_id(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        order.sort_unstable_by_key(|&i| self.id[i as usize]);
        order
    }

    /// Total real mass, kg, and total volume, m^3.
    pub fn mass_and_volume(&self) -> (f64, f64) {
        self.by_id().iter().fold((0.0, 0.0), |(m, v), &i| {
            let i = i as usize;
            (m + self.mass[i], v + sphere_volume(self.pos[i][3]))
        })
    }

    /// Re-orders all arrays so that new index `k` holds what was at `order[k]`.
    pub fn permute(&mut self, order: &[u32]) {
        fn apply<T: Copy>(v: &mut Vec<T>, order: &[u32]) {
            *v = order.iter().map(|&i| v[i as usize]).collect();
        }
        apply(&mut self.pos, order);
        apply(&mut self.vel, order);
        apply(&mut self.spin, order);
        apply(&mut self.mass, order);
        apply(&mut self.id, order);
        apply(&mut self.lineage, order);
        apply(&mut self.generation, order);
        apply(&mut self.born, order);
        apply(&mut self.material, order);
        apply(&mut self.strength, order);
        apply(&mut self.breakage_threshold, order);
        apply(&mut self.work, order);
    }
}
