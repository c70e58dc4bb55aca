//! The list of candidates. Far more points are near a grain than touch it: passes over contacts skip those without a history, which they know without
//! looking at them.

use super::PointContact;
use rayon::prelude::*;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ops::{Deref, DerefMut};

/// Candidates of one parallel task.
pub(super) const TASK: usize = 512;

/// Points near grains and walls, touching or not, sorted by body and then by the identity of the point.
#[derive(Clone, Debug, Default)]
pub struct Candidates {
    all: Vec<PointContact>,
    /// Whether each candidate may have a history ([`PointContact::has_history`]); empty where that is not known.
    history: Vec<bool>,
    /// Identities of grains and of points by their indices, for which the places of all candidates are right; empty where that is not known.
    located: [Vec<u32>; 2],
}

impl PointContact {
    /// Whether anything of it is left for the next step: it touches, has a face, or an overlap without force.
    pub(super) fn has_history(&self) -> bool {
        self.touch.overlap > 0.0 || self.face.is_some() || self.reference > 0.0
    }
}

impl Candidates {
    /// Candidates that touch, in the order of the list.
    pub(super) fn touching(&self) -> impl Iterator<Item = &PointContact> {
        self.with_history().filter(|c| c.touch.overlap > 0.0)
    }

    /// Candidates with a history, in the order of the list.
    pub(super) fn with_history(&self) -> impl Iterator<Item = &PointContact> {
        let may = |k: usize| self.history.get(k).copied().unwrap_or(true);
        self.all.iter().enumerate().filter(move |(k, _)| may(*k)).map(|(_, c)| c).filter(|c| c.has_history())
    }

    /// Calls `change` with each candidate that has a history, in the order of the list; it may take a history away and gives none.
    pub(super) fn change(&mut self, mut change: impl FnMut(&mut PointContact)) {
        let (all, history) = self.parts();
        all.iter_mut().zip(history).filter(|(c, may)| **may && c.has_history()).for_each(|(c, _)| change(c));
    }

    /// The same in parallel, each by itself.
    pub(super) fn change_each(&mut self, change: impl Fn(&mut PointContact) + Sync) {
        let (all, history) = self.parts();
        all.par_chunks_mut(TASK).zip(history.par_chunks(TASK)).for_each(|(part, history)| {
            part.iter_mut().zip(history).filter(|(c, may)| **may && c.has_history()).for_each(|(c, _)| change(c));
        });
    }

    /// All candidates, and for each whether it may have a history: after forces have been computed that is noted anew ([`note`]).
    pub(super) fn parts(&mut self) -> (&mut [PointContact], &mut [bool]) {
        self.history.resize(self.all.len(), true);
        (&mut self.all, &mut self.history)
    }

    /// Whether the places of all candidates are right for points, or grains, with these identities.
    pub(super) fn are_located(&self, of: Side, ids: &[u32]) -> bool {
        self.located[of as usize] == ids
    }

    /// Notes that they are.
    pub(super) fn note_located(&mut self, of: Side, ids: &[u32]) {
        self.located[of as usize].clear();
        self.located[of as usize].extend_from_slice(ids);
    }

    /// Memory in use, bytes.
    pub(super) fn bytes(&self) -> usize {
        let located: usize = self.located.iter().map(|ids| 4 * ids.capacity()).sum();
        self.all.capacity() * size_of::<PointContact>() + self.history.capacity() + located
    }

    /// Keeps those candidates only for which `keep` holds.
    pub(super) fn retain(&mut self, keep: impl FnMut(&PointContact) -> bool) {
        self.history.clear();
        self.all.retain(keep);
    }
}

/// One of the two sides of a candidate.
#[derive(Clone, Copy)]
pub(super) enum Side {
    /// Grains.
    Grains,
    /// Points.
    Points,
}

/// Notes which of these candidates have a history.
pub(super) fn note(candidates: &[PointContact], history: &mut [bool]) {
    history.iter_mut().zip(candidates).for_each(|(may, c)| *may = c.has_history());
}

impl From<Vec<PointContact>> for Candidates {
    fn from(all: Vec<PointContact>) -> Candidates {
        Candidates { all, ..Candidates::default() }
    }
}

impl Deref for Candidates {
    type Target = [PointContact];

    fn deref(&self) -> &[PointContact] {
        &self.all
    }
}

/// Whoever changes a candidate may give it a history.
impl DerefMut for Candidates {
    fn deref_mut(&mut self) -> &mut [PointContact] {
        self.history.clear();
        &mut self.all
    }
}

// only the list itself is kept in a file
impl Serialize for Candidates {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.all.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Candidates {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Candidates, D::Error> {
        Vec::deserialize(deserializer).map(Candidates::from)
    }
}
