//! Birth without a shock: how the daughters of a broken grain enter the assembly.
//!
//! A daughter put where her mother was has her mother's overlaps with the neighbours, which a sphere a fraction as large cannot bear (NOTES.md: 0.9 to 1.2 of her own mean limit
//! at once), and the neighbours, which the mother has held until then, move into the gap within a few steps. Gradual birth takes both shocks away:
//!
//! - Daughters begin small enough to overlap no neighbour and no wall, so without force, and grow to their size. A daughter whose load comes
//!   near her limit waits with it, so none is broken by her own growth. Where the mother was pressed so deep into a wall or a neighbour that a daughter at her edge would begin inside of it, all
//!   begin in the largest sphere around her middle that overlaps nothing, in proportion.
//! - Each contact of the mother with a neighbour goes on, with the place where she was instead of her, and softens: its normal force is that of the law times the share of a number of steps that is
//!   left. She loses her strength as a cracking grain does, not at an instant, and the neighbours close in at a pace that their contacts can follow. A neighbour
//!   that moves away lets go, so nothing is thrown.
//!
//! The mass is the daughter's own from birth on; only her radius lags behind. The work of growth on contacts and of the softening contacts is counted
//! ([`crate::dem::ledger::Ledger`]). The latter push neighbours only: the mother's contacts were nearly in balance, so they bring little momentum. A neighbour that breaks drops hers.

use crate::boundary::Wall;
use crate::breakage::Criterion;
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

/// What breakages have left to do.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Aftermath {
    /// In the order of birth.
    growing: Vec<Growing>,
    fading: Vec<Fading>,
}

/// A grain on the way to its size.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Growing {
    /// Index.
    grain: u32,
    /// Radius that it shall have, m, and what it may grow in a step, m.
    target: f64,
    rate: f64,
    /// What it has grown in the last step, m.
    grown: f64,
    /// Steps until its load is looked at again.
    wait: u32,
}

/// A contact of a broken grain with a neighbour, which softens.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Fading {
    /// Index of the neighbour.
    grain: u32,
    /// Material of the broken grain.
    material: u8,
    /// Centre and radius of the broken grain, m, and her velocity, m/s, with which the centre goes on.
    place: [f64; 4],
    velocity: [f64; 3],
    /// Radius, m, that sets her stiffness.
    stiffness_radius: f64,
    /// Largest overlap of the contact, m.
    largest: f64,
    /// Steps left, of how many.
    left: u32,
    of: u32,
    /// Force on the neighbour now, N.
    force: [f64; 3],
    /// Tangent stiffness now, N/m.
    stiffness: f64,
}

/// A grain grows while the largest load on it is below this share of its limit.
const EASE: f64 = 0.9;
/// Steps that a grain waits when it is above that.
const WAIT: u32 = 16;
/// Radius at birth over the radius to come, at least.
const LEAST: f64 = 0.1;

/// Spheres (centre, radius, m) that daughters have to keep clear of at birth.
#[derive(Default)]
pub struct Obstacles(Vec<[f64; 4]>);

impl Obstacles {
    /// Those that overlap grain `m`: no daughter in her sphere can reach another one.
    pub fn around(m: usize, g: &Grains, neighbours: &Neighbours, pairs: &Pairs) -> Obstacles {
        let overlaps = |q: &[f64; 4]| {
            let (d, reach) = (sweep::difference(g.pos[m], *q), g.pos[m][3] + q[3]);
            dot(d, d) < reach * reach
        };
        Obstacles(neighbours.around(m, pairs).map(|(_, j)| g.pos[j]).filter(overlaps).collect())
    }

    /// Radius up to `radius`, m, with which a daughter at `centre` overlaps none of them and no wall; at least `LEAST` of it.
    pub fn free_radius(&self, centre: [f64; 3], radius: f64, walls: &[Wall]) -> f64 {
        self.gap(centre, walls).clamp(LEAST * radius, radius)
    }

    /// Whether a daughter of this radius, m, at `centre` would begin in the reach of one of them or of a wall, as at the edge of a grain that was pressed deep into it.
    pub fn bury(&self, centre: [f64; 3], radius: f64, walls: &[Wall]) -> bool {
        self.gap(centre, walls) < LEAST * radius
    }

    /// Distance of the next surface, m; below zero behind it.
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
    /// Whether nothing is left to do.
    pub fn is_empty(&self) -> bool {
        self.growing.is_empty() && self.fading.is_empty()
    }

    /// What a grain grows in one step at most, m.
    pub fn fastest_growth(&self) -> f64 {
        self.growing.iter().map(|x| x.rate).fold(0.0, f64::max)
    }

    /// Lets grain `grain` grow to the radius `target`, m, by `rate`, m, in a step.
    pub fn grow(&mut self, grain: usize, target: f64, rate: f64) {
        self.growing.push(Growing { grain: grain as u32, target, rate, grown: 0.0, wait: 0 });
    }

    /// Radius, m, that grain `i` is growing to, or has.
    pub fn radius(&self, i: usize, g: &Grains) -> f64 {
        self.growing.iter().find(|x| x.grain == i as u32).map_or(g.pos[i][3], |x| x.target)
    }

    /// The contacts of grain `m` with its neighbours begin to soften.
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

    /// Forces of the softening contacts at the present positions.
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

    /// Radii of all grains, m, as if those that grow had their size already.
    pub fn radii(&self, g: &Grains) -> Vec<f64> {
        let mut radii: Vec<f64> = g.pos.iter().map(|p| p[3]).collect();
        for x in &self.growing {
            radii[x.grain as usize] = x.target;
        }
        radii
    }

    /// Grain `m` is no more.
    pub fn forget(&mut self, m: usize) {
        self.growing.retain(|x| x.grain != m as u32);
        self.fading.retain(|x| x.grain != m as u32);
    }

    /// Grains whose contacts change fast: those that grow or are let go.
    pub fn restless(&self) -> impl Iterator<Item = usize> + '_ {
        let growing = self.growing.iter().filter(|x| x.wait == 0).map(|x| x.grain as usize);
        growing.chain(self.fading.iter().map(|x| x.grain as usize))
    }

    /// Adds the forces of softening contacts, N, to those on the grains from elsewhere.
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

    /// Force, N, on grain `i` from broken neighbours.
    pub fn on(&self, i: usize) -> [f64; 3] {
        self.of(i).fold([0.0; 3], |sum, x| plus(sum, x.force))
    }

    /// Stiffness, N/m, of what is left of the contacts of grain `i` with broken neighbours.
    pub fn stiffness(&self, i: usize) -> f64 {
        self.of(i).map(|x| x.stiffness).sum()
    }

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

    /// After grains were permuted: the new index of each is in `place`.
    pub fn permute(&mut self, place: &[u32]) {
        self.growing.iter_mut().for_each(|x| x.grain = place[x.grain as usize]);
        self.fading.iter_mut().for_each(|x| x.grain = place[x.grain as usize]);
    }
}

/// One step: contacts soften, radii grow, and what has grown out of its neighbourhood is listed in `moved`.
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
        let load = criterion.map_or(0.0, |c| mean_stress::load(c, i, g.pos[i][3], neighbours, pairs, wall_pairs));
        let left = x.target - g.pos[i][3];
        if load > EASE * g.breakage_threshold[i] {
            x.wait = WAIT;
        } else {
            x.grown = x.rate.min(left);
            let (before, [u, v, w, _]) = (g.pos[i][3], g.spin[i]);
            // to the last bit at the end
            let after = if x.rate < left { before + x.rate } else { x.target };
            g.pos[i][3] = after;
            // the spin stays: I = 2/5 m r²
            ledger.inertia += 0.2 * g.inertia(i) * (after * after - before * before) * (u * u + v * v + w * w);
            if neighbours.outgrown(i, g) {
                moved.push(x.grain);
            }
        }
        let grows = g.pos[i][3] < x.target;
        // trapezium; the last step's second half is taken at once
        ledger.growth += force * if grows { 0.5 * (grown + x.grown) } else { 0.5 * grown + x.grown };
        grows
    });
}
