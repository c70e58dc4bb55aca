//! The energy account of the contacts of points with grains and walls, and of what grains and points give each other, each term by a sum of its own.
//!
//! The path work of a contact, −½ (F_old + F_new)·Δu of both ends, is elastic energy, slip and what dashpots take, as in a contact of two grains
//! ([`crate::dem::ledger`]). The part of it that the points get, ½ (F_old + F_new)·Δu with the motion of the points alone, is summed as well: the nodes get
//! the work of the same forces on their mean velocity instead ([`crate::mpm::account`]), and the difference is a term of the account, the *contact lag*.

use super::{Body, Mixture, PointContact};
use crate::check::{self, Checked};
use crate::dem::State;
use crate::dem::observables::{pair_from, tangential_energy};
use crate::dem::physics::Physics;
use crate::grains::Grains;
use crate::math::vector::{dot, plus};
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
    /// Work of the contacts on the points, on the points' path.
    pub on_points: f64,
    /// Kinetic, potential and elastic energy of points that were added and removed.
    pub inserted: [f64; 3],
    /// Identities that the next grain and point had when forces were last computed.
    known: [u32; 2],
    /// Number of grains and points then.
    alive: [usize; 2],
    /// Works and elastic energy of each candidate when forces were last computed.
    each: Vec<OfContact>,
}

/// Works of a contact in a step, and its elastic energy after it, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct OfContact {
    pub path: f64,
    pub slip: f64,
    pub viscous: f64,
    pub stored: f64,
    /// Force on the body before the step, N.
    pub before: [f64; 3],
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
        let ContactAccount { path, slip, viscous, made, removed, on_points, inserted, .. } = self;
        check::numbers("energies of point contacts", [path, slip, viscous, made, removed, on_points].into_iter().chain(inserted))
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

    /// Entries for the works of all candidates, with their forces before this step.
    pub(super) fn begin(&mut self, candidates: &[PointContact]) -> &mut [OfContact] {
        self.each.clear();
        self.each.extend(candidates.iter().map(|c| OfContact { before: c.touch.force(), ..OfContact::default() }));
        &mut self.each
    }

    /// Adds the works of all candidates over the step of `dt` seconds, in the order of the list.
    pub(super) fn end(&mut self, candidates: &[PointContact], grains: &Grains, continuum: &Continuum, dt: f64) {
        let velocities = &continuum.points().transport_velocity;
        for (c, of) in candidates.iter().zip(&self.each) {
            let forces = plus(of.before, c.touch.force());
            // forces are those on the body
            self.on_points -= 0.5 * dt * dot(forces, velocities[c.place[1] as usize]);
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

    /// Adds what points that were added or removed between two instants have brought or taken: the differences of kinetic, potential and elastic
    /// energy of all points.
    pub(super) fn add_inserted(&mut self, before: [f64; 3], after: [f64; 3]) {
        for (sum, (before, after)) in self.inserted.iter_mut().zip(before.into_iter().zip(after)) {
            *sum += after - before;
        }
    }

    /// Memory in use, bytes.
    pub(super) fn bytes(&self) -> usize {
        size_of::<OfContact>() * self.each.capacity()
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
        GrainWorks { path, slip, viscous, damping, stored }
    }
}
