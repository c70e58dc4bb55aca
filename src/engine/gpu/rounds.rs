//! Rounds of the loops of one thread. Mesa's software adapter (llvmpipe) ends all loops of a thread after 65 535 rounds in total, without an error: what they had
//! still to do is not done. Seen on a floor with friction of 700 × 700 cells while one workgroup did all walls: at its far corner a sliding block had 4 % of its momentum left after
//! 60 steps. What could come to so many rounds is refused on software adapters; the other loops are bounded by sizes that are refused elsewhere.

use super::bounds::{BORDERS, GROUP, WIDE};
use super::device::refused;
use super::grains::{CoarseGrains, FURTHEST, SKIN};
use super::state::ghost_radius;
use crate::error::Error;
use crate::mpm::{GridWall, Points, Settings};

/// Rounds that a thread may make, with some to spare.
const MOST: f64 = 60_000.0;

/// Rounds for each cell that a thread has of the box around a grain (`grain_forces`): the cell and its eight points.
const AROUND: f64 = 9.0;

/// Rounds of the thread of `finish` that sums up the impulses of the walls at the most nodes.
fn of_walls(settings: &Settings) -> f64 {
    let nodes = settings.cells.map(|n| f64::from(n) + 3.0);
    let of_side = |side: usize| (nodes.iter().product::<f64>() / nodes[side / 2] / WIDE as f64).ceil();
    (0..BORDERS).filter(|side| settings.walls[*side] != GridWall::Open).map(of_side).sum()
}

/// Rounds of a thread of `grain_forces` for the largest grain.
fn of_grains(settings: &Settings, points: &Points, coarse: &CoarseGrains<'_>) -> f64 {
    let largest = coarse.mixture.grains.grains.pos.iter().map(|p| p[3]).fold(0.0, f64::max);
    let ghost = (0..points.len()).map(|i| ghost_radius(points, i)).fold(0.0, f64::max);
    let wide = 2.0 * ((largest + ghost) / settings.cell + f64::from(FURTHEST) + SKIN) + 2.0;
    AROUND * settings.cells.iter().map(|n| wide.min(f64::from(*n) + 1.0)).product::<f64>() / GROUP as f64
}

/// Refusals of what a software adapter would not finish.
pub fn too_many(settings: &Settings, points: &Points, coarse: Option<&CoarseGrains<'_>>) -> Vec<Error> {
    let told = |of: &str, rounds: f64, advice: &str| {
        let message = format!("rounds of a loop are above the {MOST:.0} of a software adapter: {advice}, or use the processor");
        (rounds > MOST).then(|| refused(of, format!("{rounds:.0}"), message))
    };
    let walls = told("sides of the grid", of_walls(settings), "use a smaller domain or larger cells");
    let grains = coarse.and_then(|coarse| told("points around a grain", of_grains(settings, points, coarse), "use larger cells"));
    walls.into_iter().chain(grains).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mpm::{Dimension, ShapeFunctions, Transfer};

    /// Every committed scene is far below the limit; a floor of 16 million cells is above it.
    #[test]
    fn a_wide_floor_has_too_many_rounds() {
        let floor = |cells: [u32; 3]| {
            let mut settings = Settings {
                dimension: Dimension::Space,
                cell: 0.01,
                lower: [0.0; 3],
                cells,
                walls: [GridWall::Open; 6],
                gravity: [0.0; 3],
                shape: ShapeFunctions::BSpline,
                transfer: Transfer::Blend { pic: 0.0 },
                damping: 0.0,
            };
            settings.walls[4] = GridWall::Friction { friction: 0.3 };
            of_walls(&settings)
        };
        assert!(floor([700, 700, 50]) < 0.1 * MOST && floor([4000, 4000, 2]) > MOST);
    }
}
