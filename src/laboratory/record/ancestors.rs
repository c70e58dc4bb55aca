//! Who a grain comes from: daughters get the next numbers in the order of the breakages, so that a list of mothers tells the whole descent.

use engine::dem::event::Breakage;
use serde::{Deserialize, Serialize};

/// The mother of each breakage, in their order; part of the checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ancestors(Vec<u32>);

impl Ancestors {
    pub fn add(&mut self, b: &Breakage) {
        self.0.push(b.mother);
    }

    /// Mother of the grain with this number, and the grain of the start that it comes from (itself without a mother). `next` is the number that the
    /// next grain will have, `daughters` how many a breakage makes.
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
