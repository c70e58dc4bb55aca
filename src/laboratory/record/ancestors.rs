//! The descent of grains. Daughters get the next free numbers in the order of the breakages, so the list of all mothers gives
//! mother and first ancestor of every grain.

use crate::model::Model;
use engine::check::{Checked, below, ensure, lengths};
use engine::dem::State;
use engine::dem::event::Breakage;
use serde::{Deserialize, Serialize};

/// The grain that broke in each breakage, in the order of the breakages; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ancestors(Vec<u32>);

impl Ancestors {
    /// Adds a breakage; they must come in their order.
    pub fn add(&mut self, b: &Breakage) {
        self.0.push(b.mother);
    }

    /// Checks the list of a checkpoint against the state of the grains; `first`: number of grains at the start.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, state: &State, first: usize) -> Checked {
        let daughters = model.physics.crush.as_ref().map_or(1, |c| c.pattern.count());
        lengths("breakages", state.crush_events as usize, [self.0.len()])?;
        let all = first.saturating_add(self.0.len().saturating_mul(daughters));
        ensure(state.grains.next_id as usize == all, || format!("{} grains have been, not {all}", state.grains.next_id))?;
        let mut mothers = self.0.iter().enumerate();
        mothers.try_for_each(|(k, mother)| below(format_args!("breakage {k} of grain"), *mother, first + k * daughters))
    }

    /// Mother of grain `id` (`None` for a grain of the start), and the grain of the start from which it descends (the grain
    /// itself, if it has no mother). `next` is the number that the next grain will get, `daughters` the number of daughters of a
    /// breakage.
    pub fn of(&self, id: u32, next: u32, daughters: usize) -> (Option<u32>, u32) {
        let first = next as usize - self.0.len() * daughters;
        let mother = |id: u32| (id as usize).checked_sub(first).and_then(|k| self.0.get(k / daughters)).copied();
        let mut ancestor = id;
        while let Some(mother) = mother(ancestor) {
            ancestor = mother;
        }
        (mother(id), ancestor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_granddaughter_knows_her_mother_and_her_first_ancestor() {
        // five grains; 3 breaks into 5 and 6, then 6 into 7 and 8, then 0 into 9 and 10
        let all = Ancestors(vec![3, 6, 0]);
        let of = |id| all.of(id, 11, 2);
        assert_eq!([2, 5, 6, 8, 9].map(of), [(None, 2), (Some(3), 3), (Some(3), 3), (Some(6), 3), (Some(0), 0)]);
        assert_eq!(Ancestors::default().of(4, 5, 1), (None, 4));
    }
}
