//! The arrays of grains: one entry per grain that exists now.
//!
//! The index of a grain changes when grains are sorted in memory or break; its identity [`Grains::id`] never does. Sums over grains are taken in
//! the order of identities, so that the order in memory changes no bit of a result.
//!
//! Position, velocity and spin are packed in vectors of four numbers, which fill one SIMD register; the fourth number (lane 3) holds something else.
//! [`Grains::radius`], [`Grains::inertia`] and [`Grains::stiffness_radius`] read those lanes by name; the inner loops use the lanes themselves.

use crate::check::{self, Checked, lengths, numbers, positive};
use crate::material::Material;
use crate::math::real::Real;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// State of all grains. Velocities and spins are those of the last half step (leapfrog: half a step before the positions).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Grains {
    /// Centre x, y, z, m; lane 3: radius, m.
    pub pos: Vec<[f64; 4]>,
    /// Velocity x, y, z, m/s; lane 3: inverse of the inertial mass, 1/kg.
    pub vel: Vec<[f64; 4]>,
    /// Angular velocity x, y, z, rad/s; lane 3: (R_s − r)/r with the radius r and the radius R_s that sets the stiffness of the grain's contacts. It is 0
    /// but for daughters under [`crate::contact::ContactLaw::LinearInherited`], which keep the stiffness of the grain that broke.
    pub spin: Vec<[f64; 4]>,
    /// Real mass, kg; with inertia scaling the inertial mass is another one ([`Grains::inertia`]).
    pub mass: Vec<f64>,
    /// Identity of the grain, given in the order of creation; never used again for another grain.
    pub id: Vec<u32>,
    /// Key of the grain's random draws ([`crate::math::random`]).
    pub lineage: Vec<u64>,
    /// Number of breakages between a grain of the start and this one: 0 for grains of the start.
    pub generation: Vec<u8>,
    /// Step of the breakage that made the grain; 0 for grains of the start.
    pub born: Vec<u64>,
    /// Index of the material.
    pub material: Vec<u8>,
    /// Limit strength σ_lim, Pa; infinite where the grain cannot break.
    pub strength: Vec<f64>,
    /// Largest load the grain bears, in the units of the failure criterion ([`crate::breakage::criterion::FailureCriterion::threshold`]).
    pub breakage_threshold: Vec<f64>,
    /// Work since the energy ledger was opened, J: of contact forces on their path, lost in slip, lost in viscous damping, lost in local damping. A contact
    /// between two grains is counted at its first end.
    pub work: Vec<[f64; 4]>,
    /// Identity that the next new grain gets.
    pub next_id: u32,
}

/// Radius that sets the stiffness of a grain's contacts, m, from its entries of [`Grains::pos`] and [`Grains::spin`].
#[inline(always)]
pub fn stiffness_radius<R: Real>(pos: [R; 4], spin: [R; 4]) -> R {
    pos[3] + pos[3] * spin[3]
}

/// Volume of a sphere of radius `r`, m: 4/3 π r³, m³.
pub fn sphere_volume(r: f64) -> f64 {
    4.0 / 3.0 * PI * (r * r * r)
}

impl Grains {
    /// Number of grains.
    pub fn len(&self) -> usize {
        self.pos.len()
    }

    /// Whether there are no grains.
    pub fn is_empty(&self) -> bool {
        self.pos.is_empty()
    }

    /// Adds a grain at rest that cannot break (infinite strength), with its real mass as inertial mass; returns its index. `centre` and `radius` in m;
    /// `material` is an index into `materials`.
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

    /// Radius of grain `i`, m: lane 3 of [`Grains::pos`].
    #[inline(always)]
    pub fn radius(&self, i: usize) -> f64 {
        self.pos[i][3]
    }

    /// Radius that sets the stiffness of the contacts of grain `i`, m, from lane 3 of [`Grains::spin`].
    pub fn stiffness_radius(&self, i: usize) -> f64 {
        stiffness_radius(self.pos[i], self.spin[i])
    }

    /// Inertial mass of grain `i`, kg, from lane 3 of [`Grains::vel`]: the real mass, or what inertia scaling has made of it.
    pub fn inertia(&self, i: usize) -> f64 {
        1.0 / self.vel[i][3]
    }

    /// Sets the inertial mass of grain `i`, kg.
    pub fn set_inertia(&mut self, i: usize, inertia: f64) {
        self.vel[i][3] = 1.0 / inertia;
    }

    /// Indices of all grains in the order of their identities.
    pub fn by_id(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.len() as u32).collect();
        order.sort_unstable_by_key(|&i| self.id[i as usize]);
        order
    }

    /// Total real mass, kg, and total volume, m³, of all grains.
    pub fn mass_and_volume(&self) -> (f64, f64) {
        self.by_id().iter().fold((0.0, 0.0), |(m, v), &i| {
            let i = i as usize;
            (m + self.mass[i], v + sphere_volume(self.pos[i][3]))
        })
    }

    /// Checks what does not depend on anything else: lists of one length, identities, sizes, masses and motions that can be. `materials`: their number.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, materials: usize) -> Checked {
        let Grains { pos, vel, spin, mass, id, lineage, generation, born, material, strength, breakage_threshold, work, next_id } =
            self;
        let own = [pos.len(), vel.len(), spin.len(), mass.len(), id.len(), lineage.len(), generation.len(), born.len()];
        let more = [material.len(), strength.len(), breakage_threshold.len(), work.len()];
        lengths("grains", pos.len(), own.into_iter().chain(more))?;
        check::identities("grain", id, *next_id)?;
        numbers("places of grains", pos.as_flattened())?;
        numbers("velocities of grains", vel.as_flattened())?;
        numbers("spins of grains", spin.as_flattened())?;
        numbers("works of grains", work.as_flattened())?;
        positive("radii of grains", pos.iter().map(|p| p[3]))?;
        positive("inverse inertial masses of grains", vel.iter().map(|v| v[3]))?;
        positive("radii of the stiffness of grains", (0..pos.len()).map(|i| self.stiffness_radius(i)))?;
        positive("masses of grains", mass)?;
        // those of grains that cannot break are infinite
        check::all("strengths of grains", strength.iter().chain(breakage_threshold), "not from 0 on", |x| x >= 0.0)?;
        material.iter().try_for_each(|m| check::below("material", *m, materials))
    }

    /// Re-orders all arrays: entry `k` becomes the one that was at `order[k]`.
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
