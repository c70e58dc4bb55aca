//! The energy account of the contacts of points with grains and walls, and of what grains and points give each other, each term by a sum of its own.
//!
//! The path work of a contact, −½ (F_old + F_new)·Δu of both ends, is elastic energy, slip and what dashpots take, as in a contact of two grains
//! ([`crate::dem::ledger`]). What the bodies get instead is summed beside it: grains the work of the contacts' forces on the mean of their velocities before
//! and after a step, which is the change of their kinetic energy; points that on the mean velocity of the nodes ([`crate::mpm::account`]). The difference
//! is a term of the account, the *contact lag*: the nodes' velocities are projected anew in every step, and where one side makes several steps in a
//! cycle, the other side's motion is extrapolated meanwhile, and it gets the mean of the forces.

use super::{Body, Mixture, PointContact};
use crate::check::{self, Checked};
use crate::contact::pairs::ContactForce;
use crate::dem::State;
use crate::dem::observables::{pair_from, tangential_energy};
use crate::dem::physics::Physics;
use crate::grains::Grains;
use crate::math::vector::{cross, dot, scaled};
use crate::mpm::Continuum;
use crate::point_contacts::{NOWHERE, by_id};
use serde::{Deserialize, Serialize};

/// Energies of point contacts since the account was opened, J.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ContactAccount {
    /// Work of both ends against the force of the contacts on their path.
    pub path: f64,
    /// Work of sliding against the limit of friction.
    pub slip: f64,
    /// Work of the dashpots of viscous laws.
    pub viscous: f64,
    /// Elastic energy with which contacts begin whose grain or point has just been born, less the path work of their first step.
    pub made: f64,
    /// Elastic energy of contacts whose grain broke or whose point was removed.
    pub removed: f64,
    /// Work of the points on grains, on the mean of the grains' velocities before and after each step.
    pub on_grains: f64,
    /// Work of the grains' contacts and gravity on half the difference of two steps of unequal length: a change of the step shifts the instants of velocities
    /// against those of forces.
    pub step_change: f64,
    /// Kinetic, potential and elastic energy of points that were added and removed.
    pub inserted: [f64; 3],
    /// Identities that the next grain and point had when forces were last computed.
    known: [u32; 2],
    /// Number of grains and points then.
    alive: [usize; 2],
    /// Works and elastic energy of each candidate when forces were last computed.
    each: Vec<OfContact>,
    /// Buffer: forces and torques on grains.
    #[serde(skip)]
    forces: Vec<[[f64; 4]; 2]>,
}

/// Works of a contact in a step, and its elastic energy after it, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct OfContact {
    pub path: f64,
    pub slip: f64,
    pub viscous: f64,
    pub stored: f64,
}

impl OfContact {
    /// Takes the works that the contact law gives ([`crate::contact::force`]), and the elastic energy.
    pub fn set(&mut self, work: Option<[f64; 3]>, stored: f64) {
        [self.path, self.slip, self.viscous] = work.unwrap_or_default();
        self.stored = stored;
    }
}

impl ContactAccount {
    /// Elastic energy of all contacts when forces were last computed, J.
    pub fn stored(&self) -> f64 {
        self.each.iter().map(|of| of.stored).sum()
    }

    /// An account with sums of zero.
    pub(super) fn new(grains: &Grains, continuum: &Continuum) -> ContactAccount {
        let points = continuum.points();
        ContactAccount { known: [grains.next_id, points.next_id], alive: [grains.len(), points.len()], ..Default::default() }
    }

    /// Checks that all sums are numbers.
    ///
    /// # Errors
    /// The one that is not.
    pub(super) fn check(&self) -> Checked {
        let ContactAccount { path, slip, viscous, made, removed, on_grains, step_change, inserted, .. } = self;
        check::numbers(
            "energies of point contacts",
            [path, slip, viscous, made, removed, on_grains, step_change].into_iter().chain(inserted),
        )
    }

    /// Counts the elastic energy of contacts that are no more because their grain or point is gone. To be called before the list of candidates is made anew.
    pub(super) fn note_gone(&mut self, candidates: &[PointContact], grains: &Grains, continuum: &Continuum) {
        let points = continuum.points();
        if self.known == [grains.next_id, points.next_id] && self.alive == [grains.len(), points.len()] {
            return;
        }
        let [mut grain, mut point] = [Vec::new(), Vec::new()];
        by_id(&mut grain, &grains.id, grains.next_id);
        by_id(&mut point, &points.id, points.next_id);
        let gone = |c: &PointContact| {
            point[c.point as usize] == NOWHERE || matches!(c.body, Body::Grain(id) if grain[id as usize] == NOWHERE)
        };
        self.removed += candidates.iter().zip(&self.each).filter(|(c, _)| gone(c)).map(|(_, of)| of.stored).sum::<f64>();
    }

    /// Zeros for the works of `count` candidates.
    pub(super) fn begin(&mut self, count: usize) -> &mut [OfContact] {
        self.each.clear();
        self.each.resize(count, OfContact::default());
        &mut self.each
    }

    /// Adds the works of all candidates in the order of the list.
    pub(super) fn end(&mut self, candidates: &[PointContact], grains: &Grains, continuum: &Continuum) {
        for of in &self.each {
            self.path += of.path;
            self.slip += of.slip;
            self.viscous += of.viscous;
        }
        let points = continuum.points();
        if self.known != [grains.next_id, points.next_id] {
            let [grain, point] = self.known;
            let born = |c: &PointContact| c.point >= point || matches!(c.body, Body::Grain(id) if id >= grain);
            for (_, of) in candidates.iter().zip(&self.each).filter(|(c, _)| born(c)) {
                self.made += of.stored - (of.path - of.slip - of.viscous);
            }
        }
        (self.known, self.alive) = ([grains.next_id, points.next_id], [grains.len(), points.len()]);
    }

    /// Notes the forces, N, and torques, N m, on grains by index, and adds their work over half a step of `dt` seconds at the present velocities.
    pub(super) fn before_grains(&mut self, forces: &[[[f64; 4]; 2]], grains: &Grains, dt: f64) {
        self.forces.clear();
        self.forces.extend_from_slice(forces);
        self.add_half_step(grains, dt);
    }

    /// Adds the work of the forces noted over half a step of `dt` seconds at the present velocities.
    pub(super) fn add_half_step(&mut self, grains: &Grains, dt: f64) {
        let of = |(i, [f, t]): (usize, &[[f64; 4]; 2])| {
            let ([u, v, w, _], [a, b, c, _]) = (grains.vel[i], grains.spin[i]);
            dot([f[0], f[1], f[2]], [u, v, w]) + dot([t[0], t[1], t[2]], [a, b, c])
        };
        self.on_grains += 0.5 * dt * self.forces.iter().enumerate().map(of).sum::<f64>();
    }

    /// Adds what points that were added or removed between two instants have brought or taken: the differences of kinetic, potential and elastic
    /// energy of all points.
    pub(super) fn add_inserted(&mut self, before: [f64; 3], after: [f64; 3]) {
        for (sum, (before, after)) in self.inserted.iter_mut().zip(before.into_iter().zip(after)) {
            *sum += after - before;
        }
    }

    /// Memory in use, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of::<OfContact>() * self.each.capacity() + 64 * self.forces.capacity()
    }
}

/// Kinetic, potential and elastic energy of all points, J.
pub(super) fn of_points(continuum: &Continuum) -> [f64; 3] {
    let totals = continuum.totals();
    [totals.kinetic, totals.potential, continuum.elastic_energy()]
}

/// Works of the contacts of grains with each other and with walls, and of local damping, since the account was opened, and their elastic energy now, J.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GrainWorks {
    /// Work against contact forces on their path.
    pub path: f64,
    /// Work of sliding against the limit of friction.
    pub slip: f64,
    /// Work of dashpots, or of yielding.
    pub viscous: f64,
    /// Work of local damping.
    pub damping: f64,
    /// Elastic energy of the contacts.
    pub stored: f64,
    /// Kinetic energy of the grains by their own contacts and gravity in the half step from the velocities' instant to this one.
    pub half_step: f64,
}

impl Mixture {
    /// The works of the grains' own contacts ([`crate::dem::ledger`]), summed in the order of identities. To be called when forces are known; all but `stored`
    /// are zero where contacts keep no account of their work.
    pub fn grain_works(&self, physics: &Physics) -> GrainWorks {
        let State { grains, pairs, wall_pairs, walls, friction, ledger, .. } = &self.grains;
        let table = physics.contact.law.pairs(&physics.materials, walls, *friction);
        let mut sums = ledger.gone;
        let mut add = |work: &[f64]| sums.iter_mut().zip(work).for_each(|(sum, w)| *sum += w);
        for i in grains.by_id() {
            add(&grains.work[i as usize]);
        }
        let id = |i: u32| grains.id[i as usize];
        let mut stored = 0.0;
        for (pool, wall) in [(pairs, false), (wall_pairs, true)] {
            for slot in pool.touching(|[i, j]| if wall { [j, id(i)] } else { [id(i), id(j)] }) {
                // what the step that leads to this instant has not added to the grains yet
                if !pool.work.is_empty() {
                    add(&pool.work[slot][..3]);
                }
                let (r_eff, pair) = pair_from(&self.grains, &table, slot, wall);
                let overlap = pool.touch[slot].overlap;
                let e = physics.contact.law.elastic(overlap, pool.largest(slot, overlap), r_eff, pair);
                stored += e.energy + tangential_energy(pool.spring(slot), e.k_t);
            }
        }
        let [path, slip, viscous, damping] = sums;
        GrainWorks { path, slip, viscous, damping, stored, half_step: 0.5 * self.last * self.power_on_grains(physics.gravity) }
    }

    /// Power of the grains' own contacts and of gravity on the grains, W, at their present velocities, summed in the order of identities.
    pub(super) fn power_on_grains(&self, gravity: [f64; 3]) -> f64 {
        let State { grains, pairs, wall_pairs, .. } = &self.grains;
        let id = |i: u32| grains.id[i as usize];
        let mut power = 0.0;
        for (pool, wall) in [(pairs, false), (wall_pairs, true)] {
            for slot in pool.touching(|[i, j]| if wall { [j, id(i)] } else { [id(i), id(j)] }) {
                power += self.power(pool.ends[slot], &pool.touch[slot], wall);
            }
        }
        for i in grains.by_id().into_iter().map(|i| i as usize) {
            let [u, v, w, _] = grains.vel[i];
            power += grains.mass[i] * dot(gravity, [u, v, w]);
        }
        power
    }

    /// Power of a contact of grains, or of a grain with a wall, on the grains, W, at their present velocities.
    fn power(&self, [i, j]: [u32; 2], touch: &ContactForce, wall: bool) -> f64 {
        let grains = &self.grains.grains;
        let torque = |arm: f64| scaled(cross(touch.normal, touch.tangential), arm);
        let of = |i: u32, force: [f64; 3], short: f64| {
            let i = i as usize;
            let ([u, v, w, _], [a, b, c, _]) = (grains.vel[i], grains.spin[i]);
            dot(force, [u, v, w]) + dot(torque(grains.radius(i) - short), [a, b, c])
        };
        let force = touch.force();
        if wall {
            return of(i, force, touch.overlap);
        }
        of(i, force, 0.5 * touch.overlap) + of(j, scaled(force, -1.0), 0.5 * touch.overlap)
    }
}
