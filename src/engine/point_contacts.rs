//! What contacts of material points with grains, walls and rigid bodies have in common: their parameters, what they ask of the time step, and how long a list of near pairs lasts.

use crate::boundary::Wall;
use crate::contact::ContactLaw;
use crate::contact::pair::{Pair, PairTable};
use crate::material::Material;
use serde::{Deserialize, Serialize};

/// A body and a point further apart than a skin are not looked at until one of them has gone so far. Least and most of it, in cells: a wide skin
/// brings many that do not touch, a narrow one many searches.
const SKIN: [f64; 2] = [0.02, 0.25];
/// Steps that a list should last.
const STEPS: f64 = 100.0;
/// Share of the skin that may be used up: places ahead of time are guesses.
const TRUST: f64 = 0.5;
/// Not a place.
pub const NOWHERE: u32 = u32::MAX;

/// How long a list of who is near whom stays good. What it lists beyond those in touch changes no bit of a result.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Age {
    skin: f64,
    /// Way that a body and a point may have gone towards each other since the search, m.
    travelled: f64,
    /// Bodies and points alive then.
    searched: [usize; 2],
}

impl Age {
    /// The skin, m, of the search that is due where something may have come into reach since the last one. `way`: how much nearer a body and another
    /// may have come since the last call, m.
    pub fn due(&mut self, way: f64, alive: [usize; 2], cell: f64) -> Option<f64> {
        self.travelled += way;
        // a broken grain leaves its place to a daughter, and more than one daughter comes
        if self.searched == alive && self.travelled <= TRUST * self.skin {
            return None;
        }
        let [least, most] = SKIN.map(|cells| cells * cell);
        *self = Age { skin: (STEPS / TRUST * way).clamp(least, most), travelled: 0.0, searched: alive };
        Some(self.skin)
    }

    /// A search is due.
    pub fn forget(&mut self) {
        self.searched = [usize::MAX; 2];
    }
}

/// What bounds the time step: sums of stiffness over mass, 1/s².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactRates {
    pub points: f64,
    pub grains: f64,
}

impl ContactRates {
    /// Shares of a contact's stiffness that its two ends have to be able to bear, 1 + ε and 1 + 1/ε: k (u_p − u_g)² ≤ (1 + ε) k u_p² + (1 + 1/ε) k u_g² for every ε > 0.
    /// With ε = 2, as a point's share is spread over its neighbours ([`Continuum::contact_frequency_bound`]).
    ///
    /// [`Continuum::contact_frequency_bound`]: crate::mpm::Continuum::contact_frequency_bound
    pub const END_SHARES: [f64; 2] = [3.0, 1.5];

    /// What each point by itself has of contacts with grains, in these shares, and of loading plates, whose largest rate is given, 1/s².
    pub fn isolated_bound(&self, plates: f64) -> f64 {
        Self::END_SHARES[0] * self.points + plates
    }

    /// What contacts add to the square of a frequency, 1/s². Where contacts have to be resolved, each point by itself with the best ε; else nodes feel `share` of what
    /// points have.
    pub fn frequency2(&self, plates: f64, bound_ratio: Option<f64>) -> f64 {
        match bound_ratio {
            Some(ratio) => (ratio * self.isolated_bound(plates)).max(Self::END_SHARES[1] * self.grains),
            None => self.points + self.grains + plates,
        }
    }
}

/// Contact parameters of the ghosts of each law: with each material of grains, and with each wall.
#[derive(Clone, Debug)]
pub struct PointContactTable {
    /// The law of all of them.
    pub law: ContactLaw,
    grains: Vec<Vec<Pair>>,
    /// Empty where points do not touch the grains' walls.
    walls: Vec<Vec<Pair>>,
}

impl PointContactTable {
    /// `ghosts`: the material of the fines' grains for each law of the continuum; `walls`: those that points touch.
    pub fn new(law: ContactLaw, ghosts: &[u8], materials: &[Material], walls: &[Wall]) -> PointContactTable {
        let ghost = |m: &u8| &materials[usize::from(*m)];
        let of_law = |m: &u8| materials.iter().map(|other| law.between(other, ghost(m))).collect();
        let on_wall =
            |w: &Wall| ghosts.iter().map(|m| PairTable::on_wall(law.table().coefficients, ghost(m), w, materials)).collect();
        PointContactTable { law, grains: ghosts.iter().map(of_law).collect(), walls: walls.iter().map(on_wall).collect() }
    }

    /// Walls that points touch.
    pub fn touched_walls(&self) -> usize {
        self.walls.len()
    }

    pub fn of_grain(&self, law: u8, material: u8) -> &Pair {
        &self.grains[usize::from(law)][usize::from(material)]
    }

    pub fn of_wall(&self, law: u8, wall: usize) -> &Pair {
        &self.walls[wall][usize::from(law)]
    }
}

/// Contacts that are found again keep what they remember; both lists are in the order of `key`.
pub fn remember<'a, T: 'a, K: Ord>(
    old: impl Iterator<Item = &'a T>,
    found: &mut [T],
    key: impl Fn(&T) -> K,
    keep: impl Fn(&T, &mut T),
) {
    let mut fresh = found.iter_mut().peekable();
    for old in old {
        while fresh.next_if(|new| key(new) < key(old)).is_some() {}
        if let Some(new) = fresh.next_if(|new| key(new) == key(old)) {
            keep(old, new);
        }
    }
}

/// Index of each identity.
pub fn by_id(index: &mut Vec<u32>, ids: &[u32], next: u32) {
    index.clear();
    index.resize(next as usize, NOWHERE);
    for (i, &id) in ids.iter().enumerate() {
        index[id as usize] = i as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_used_no_longer_than_it_is_good() {
        let (mut age, cell, mut gone, mut skin, mut searches) = (Age::default(), 0.1, 0.0, 0.0, 0);
        for k in 0..10_000 {
            // at rest, ever faster, and at rest again
            let way = if k < 9000 { 1e-5 * f64::from(k / 1000) } else { 0.0 };
            gone += way;
            if let Some(new) = age.due(way, [3, 5], cell) {
                (skin, gone) = (new, 0.0);
                searches += 1;
                assert!((SKIN[0] * cell..=SKIN[1] * cell).contains(&skin), "{skin}");
            }
            assert!(gone <= TRUST * skin, "{gone} of {skin}");
        }
        assert!((60..=120).contains(&searches), "{searches} searches");
        assert_eq!(age.due(0.0, [3, 5], cell), None);
        assert!(age.due(0.0, [4, 5], cell).is_some(), "somebody has come");
        age.forget();
        assert!(age.due(0.0, [4, 5], cell).is_some());
    }
}
