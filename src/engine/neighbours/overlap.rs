//! The first overlap of given grains that is deeper than allowed, before any list is made.

use super::{CellGrid, Neighbours};
use crate::contact::sweep::difference;
use crate::math::vector::dot;

/// Two grains that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Indices of the grains, the smaller index first.
    pub grains: [usize; 2],
    /// Overlap over the smaller radius.
    pub share: f64,
}

/// Of the grains `pos` (centre and radius, m) the deepest overlap of the first one that overlaps another by more than `allowed` of the
/// smaller radius; `None`: there is none. The time does not depend on how many grains overlap: the search ends at the first.
pub fn first_deeper_than(allowed: f64, pos: &[[f64; 4]]) -> Option<Overlap> {
    let reference: Vec<_> = pos.iter().map(|p| Neighbours::reference(p, 0.0)).collect();
    let cells = CellGrid::new(&reference);
    (0..pos.len()).find_map(|i| {
        let mut deepest: Option<Overlap> = None;
        cells.for_each_near(&reference[i], |j| {
            let j = j as usize;
            let d = difference(pos[i], pos[j]);
            let share = (pos[i][3] + pos[j][3] - dot(d, d).sqrt()) / pos[i][3].min(pos[j][3]);
            if j != i && share > deepest.map_or(allowed, |o| o.share) {
                deepest = Some(Overlap { grains: [i.min(j), i.max(j)], share });
            }
        });
        deepest
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_overlap_of_the_first_grain_with_one_is_found() {
        let row = |radius: f64| (0..50).map(|k| [f64::from(k), 0.0, 0.0, radius]).collect::<Vec<_>>();
        assert_eq!(first_deeper_than(0.0, &row(0.5)), None);
        let found = first_deeper_than(0.1, &row(0.55)).expect("a tenth of the diameter");
        assert!(found.grains == [0, 1] && (found.share - 0.1 / 0.55).abs() < 1e-12, "{found:?}");
        let mut grains = row(0.4);
        grains[20][3] = 3.0;
        // its neighbours at a distance of three lie 0.4 deep, those nearer deeper
        let found = first_deeper_than(0.1, &grains).expect("a large grain over its neighbours");
        assert!(found.grains == [17, 20] && (found.share - 1.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn two_grains_at_one_place_overlap_by_both_radii() {
        let found = first_deeper_than(0.5, &[[0.0, 0.0, 0.0, 1.0], [-0.0, 0.0, 0.0, 1.0]]);
        assert_eq!(found, Some(Overlap { grains: [0, 1], share: 2.0 }));
    }
}
