//! Gradual birth: how the daughters of a broken grain (the mother) enter the assembly without a shock.
//!
//! A daughter placed at once in the mother's sphere has the mother's overlaps with neighbours, which load the smaller sphere to 0.9 to 1.2 of its own mean
//! limit. And neighbours that the mother has supported would move into the gap within a few steps. Gradual birth avoids both:
//!
//! - Daughters begin so small that they overlap no neighbour and no wall, hence without force, and grow to their size. A daughter whose load comes near
//!   its limit stops growing for a while, so that none is broken by its own growth. If the mother was pressed so deep into a wall or neighbour that a
//!   daughter at its edge would begin inside of that, all daughters begin in proportion in the largest sphere around the mother's centre that overlaps nothing.
//! - Each contact of the mother with a neighbour continues as a contact of the neighbour with the place of the mother, and *softens*: its normal force is that
//!   of the contact law times the share of a number of steps that is left. The mother loses its strength gradually, as a cracking grain does, and the
//!   neighbours approach slowly enough for their contacts to follow. If a neighbour moves away, the contact ends, so nothing is thrown.
//!
//! A daughter has its final mass from birth on; only its radius grows. The work of growth and of softening contacts is counted
//! ([`crate::dem::ledger::Ledger`]). Softening contacts push the neighbours only: the mother's contacts were nearly in equilibrium, so the momentum is small.
//! If a neighbour breaks, its softening contacts end.

use crate::boundary::Wall;
use crate::breakage::Criterion;
use crate::check::{Checked, below, ensure, numbers, positive};
use crate::contact::pair::PairTable;
use crate::contact::pairs::Pairs;
use crate::contact::sweep;
use crate::dem::physics::Physics;
use crate::dem::{State, mean_stress};
use crate::grains::Grains;
use crate::math::vector::{dot, plus, scaled};
use crate::neighbours::Neighbours;
use crate::neighbours::adjacency::Entry;
use serde::{Deserialize, Serialize};

/// Consequences of breakages that are still going on.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Aftermath {
    /// Growing daughters, in the order of birth.
    growing: Vec<Growing>,
    /// Softening contacts.
    fading: Vec<Fading>,
}

/// A grain that grows to its final size.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Growing {
    /// Index of the grain.
    grain: u32,
    /// Final radius, m.
    target: f64,
    /// Largest growth of the radius in a step, m.
    rate: f64,
    /// Growth of the radius in the last step, m.
    grown: f64,
    /// Number of steps for which it still waits before it grows on.
    wait: u32,
}

/// A softening contact of a broken grain with a neighbour.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Fading {
    /// Index of the neighbour.
    grain: u32,
    /// Material of the broken grain.
    material: u8,
    /// Centre, which moves on with `velocity`, and radius of the broken grain, m.
    place: [f64; 4],
    /// Velocity of the broken grain when it broke, m/s.
    velocity: [f64; 3],
    /// Radius that set the stiffness of the broken grain, m.
    stiffness_radius: f64,
    /// Largest overlap of the contact, m.
    largest: f64,
    /// Number of steps left.
    left: u32,
    /// Number of steps in all.
    of: u32,
    /// Present force on the neighbour, N.
    force: [f64; 3],
    /// Present tangent stiffness, N/m.
    stiffness: f64,
}

/// A grain grows while its load is below this share of its threshold.
const EASE: f64 = 0.9;
/// Number of steps for which a grain waits when its load is above that.
const WAIT: u32 = 16;
/// Smallest radius at birth over the final radius.
const LEAST: f64 = 0.1;

/// Spheres (centre and radius, m) that daughters must not overlap at birth.
#[derive(Default)]
pub struct Obstacles(Vec<[f64; 4]>);

impl Obstacles {
    /// The grains that overlap grain `m`; daughters inside of its sphere cannot reach any other.
    pub fn around(m: usize, g: &Grains, neighbours: &Neighbours, pairs: &Pairs) -> Obstacles {
        let overlaps = |q: &[f64; 4]| {
            let (d, reach) = (sweep::difference(g.pos[m], *q), g.radius(m) + q[3]);
            dot(d, d) < reach * reach
        };
        Obstacles(neighbours.around(m, pairs).map(|(_, j)| g.pos[j]).filter(overlaps).collect())
    }

    /// Largest radius, m, with which a daughter at `centre` overlaps no obstacle and no wall, limited to `radius` and to at least `LEAST` times that.
    pub fn free_radius(&self, centre: [f64; 3], radius: f64, walls: &[Wall]) -> f64 {
        self.gap(centre, walls).clamp(LEAST * radius, radius)
    }

    /// Whether a daughter at `centre` with the final radius `radius`, m, would overlap an obstacle or wall even with the smallest radius at birth.
    pub fn bury(&self, centre: [f64; 3], radius: f64, walls: &[Wall]) -> bool {
        self.gap(centre, walls) < LEAST * radius
    }

    /// Distance to the nearest surface of an obstacle or wall, m; negative behind it.
    fn gap(&self, [x, y, z]: [f64; 3], walls: &[Wall]) -> f64 {
        let point = [x, y, z, 0.0];
        let of_wall = |w: &Wall| w.shape.towards(point).1;
        let of_grain = |q: &[f64; 4]| {
            let d = sweep::difference(point, *q);
            dot(d, d).sqrt() - q[3]
        };
        walls.iter().map(of_wall).chain(self.0.iter().map(of_grain)).fold(f64::INFINITY, f64::min)
    }
}

impl Aftermath {
    /// Whether nothing is going on.
    pub fn is_empty(&self) -> bool {
        self.growing.is_empty() && self.fading.is_empty()
    }

    /// Checks that grains which grow or touch broken ones are there, and that growth and softening end. `materials`: their number.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, g: &Grains, materials: usize) -> Checked {
        let mut growing: Vec<u32> = self.growing.iter().map(|x| x.grain).collect();
        growing.sort_unstable();
        ensure(growing.windows(2).all(|w| w[0] != w[1]), || "a grain grows twice".into())?;
        for x in &self.growing {
            below("growing grain", x.grain, g.len())?;
            positive("growth of grains", [x.target, x.rate])?;
            numbers("growth of grains", [x.grown])?;
            ensure(x.wait <= WAIT, || format!("a growing grain waits for {} steps", x.wait))?;
        }
        for x in &self.fading {
            below("grain at a broken one", x.grain, g.len())?;
            below("material", x.material, materials)?;
            positive("radii of broken grains", [x.place[3], x.stiffness_radius])?;
            numbers("broken grains", x.place.iter().chain(&x.velocity).chain(&x.force).chain([&x.largest, &x.stiffness]))?;
            ensure((1..=x.of).contains(&x.left), || format!("a contact softens for {} of {} steps", x.left, x.of))?;
        }
        Ok(())
    }

    /// Largest growth of a radius in one step, m.
    pub fn fastest_growth(&self) -> f64 {
        self.growing.iter().map(|x| x.rate).fold(0.0, f64::max)
    }

    /// Lets grain `grain` grow to the radius `target`, m, by at most `rate`, m, in a step.
    pub fn grow(&mut self, grain: usize, target: f64, rate: f64) {
        self.growing.push(Growing { grain: grain as u32, target, rate, grown: 0.0, wait: 0 });
    }

    /// Final radius of grain `i`, m: its present one if it does not grow.
    pub fn radius(&self, i: usize, g: &Grains) -> f64 {
        self.growing.iter().find(|x| x.grain == i as u32).map_or(g.radius(i), |x| x.target)
    }

    /// Turns the contacts of grain `m`, which breaks, with its neighbours into softening contacts over `steps` steps.
    pub fn release(&mut self, m: usize, g: &Grains, neighbours: &Neighbours, pairs: &Pairs, steps: u32) {
        for e in neighbours.contacts.of(m).filter(|e| !e.is_wall()) {
            if pairs.touch[e.slot()].overlap <= 0.0 || steps == 0 {
                continue;
            }
            let [first, second] = pairs.ends[e.slot()];
            let [u, v, w, _] = g.vel[m];
            self.fading.push(Fading {
                grain: if e.second_end() { first } else { second },
                material: g.material[m],
                place: g.pos[m],
                velocity: [u, v, w],
                stiffness_radius: g.stiffness_radius(m),
                largest: pairs.largest(e.slot(), pairs.touch[e.slot()].overlap),
                left: steps,
                of: steps,
                force: [0.0; 3],
                stiffness: 0.0,
            });
        }
    }

    /// Computes the forces of the softening contacts at the present positions.
    pub fn compute_forces(&mut self, physics: &Physics, g: &Grains, table: &PairTable) {
        for x in &mut self.fading {
            let i = x.grain as usize;
            let (p, q) = (x.place, g.pos[i]);
            let d = sweep::difference(p, q);
            let distance = dot(d, d).sqrt();
            let overlap = p[3] + q[3] - distance;
            (x.force, x.stiffness) = ([0.0; 3], 0.0);
            if overlap > 0.0 && distance > 0.0 {
                let r_eff = sweep::r_eff(x.stiffness_radius, g.stiffness_radius(i));
                let elastic =
                    physics.contact.law.elastic(overlap, x.largest.max(overlap), r_eff, table.grains(x.material, g.material[i]));
                let share = f64::from(x.left) / f64::from(x.of);
                x.force = scaled(d, share * elastic.force / distance);
                x.stiffness = share * elastic.k_n;
            }
        }
    }

    /// Final radii of all grains, m.
    pub fn radii(&self, g: &Grains) -> Vec<f64> {
        let mut radii: Vec<f64> = g.pos.iter().map(|p| p[3]).collect();
        for x in &self.growing {
            radii[x.grain as usize] = x.target;
        }
        radii
    }

    /// Ends growth and softening contacts of grain `m`, which breaks.
    pub fn forget(&mut self, m: usize) {
        self.growing.retain(|x| x.grain != m as u32);
        self.fading.retain(|x| x.grain != m as u32);
    }

    /// Indices of grains whose contacts change fast: those that grow, and those with softening contacts.
    pub fn restless(&self) -> impl Iterator<Item = usize> + '_ {
        let growing = self.growing.iter().filter(|x| x.wait == 0).map(|x| x.grain as usize);
        growing.chain(self.fading.iter().map(|x| x.grain as usize))
    }

    /// Adds the forces of softening contacts to the external forces on grains; `grains`: number of grains.
    pub fn add_forces(&self, external_forces: &mut Vec<[[f64; 4]; 2]>, grains: usize) {
        if self.fading.is_empty() {
            return;
        }
        external_forces.resize(grains, [[0.0; 4]; 2]);
        for x in &self.fading {
            let [force, _] = &mut external_forces[x.grain as usize];
            force.iter_mut().zip(x.force).for_each(|(sum, f)| *sum += f);
        }
    }

    /// Force of softening contacts on grain `i`, N.
    pub fn on(&self, i: usize) -> [f64; 3] {
        self.of(i).fold([0.0; 3], |sum, x| plus(sum, x.force))
    }

    /// Sum of the tangent stiffnesses of the softening contacts of grain `i`, N/m.
    pub fn stiffness(&self, i: usize) -> f64 {
        self.of(i).map(|x| x.stiffness).sum()
    }

    /// Softening contacts of grain `i`.
    fn of(&self, i: usize) -> impl Iterator<Item = &Fading> {
        self.fading.iter().filter(move |x| x.grain == i as u32)
    }

    /// Power of the softening contacts at the present velocities, W.
    pub fn power(&self, g: &Grains) -> f64 {
        let of = |x: &Fading| {
            let [u, v, w, _] = g.vel[x.grain as usize];
            dot(x.force, [u, v, w])
        };
        self.fading.iter().map(of).sum()
    }

    /// Follows a permutation of grains; `place[i]`: new index of what was grain `i`.
    pub fn permute(&mut self, place: &[u32]) {
        self.growing.iter_mut().for_each(|x| x.grain = place[x.grain as usize]);
        self.fading.iter_mut().for_each(|x| x.grain = place[x.grain as usize]);
    }
}

/// One step: contacts soften, radii grow, and grains that are not inside their reference spheres any more are added to `moved`.
pub fn advance(criterion: Option<&Criterion>, state: &mut State, neighbours: &Neighbours, moved: &mut Vec<u32>) {
    let State { grains: g, aftermath, pairs, wall_pairs, ledger, dt, .. } = state;
    aftermath.fading.retain_mut(|x| {
        x.left -= 1;
        x.place.iter_mut().zip(x.velocity).for_each(|(p, v)| *p += v * *dt);
        x.left > 0
    });
    aftermath.growing.retain_mut(|x| {
        let i = x.grain as usize;
        let grown = std::mem::take(&mut x.grown);
        if x.wait > 0 {
            x.wait -= 1;
            return true;
        }
        let of = |e: &Entry| if e.is_wall() { &*wall_pairs } else { &*pairs };
        let force = neighbours.contacts.of(i).fold(0.0, |sum, e| sum + of(&e).touch[e.slot()].normal_force);
        let load = criterion.map_or(0.0, |c| mean_stress::load(c, i, g.radius(i), neighbours, pairs, wall_pairs));
        let left = x.target - g.radius(i);
        if load > EASE * g.breakage_threshold[i] {
            x.wait = WAIT;
        } else {
            x.grown = x.rate.min(left);
            let (before, [u, v, w, _]) = (g.radius(i), g.spin[i]);
            // exactly the final radius at the end
            let after = if x.rate < left { before + x.rate } else { x.target };
            g.pos[i][3] = after;
            // the spin stays, so the kinetic energy changes with I = 2/5 m r²
            ledger.inertia += 0.2 * g.inertia(i) * (after * after - before * before) * (u * u + v * v + w * w);
            if neighbours.outgrown(i, g) {
                moved.push(x.grain);
            }
        }
        let grows = g.radius(i) < x.target;
        // trapezium rule; the second half of the last growth is added at once
        ledger.growth += force * if grows { 0.5 * (grown + x.grown) } else { 0.5 * grown + x.grown };
        grows
    });
}
