//! Rounds of the loops of one thread. Mesa's software adapter (llvmpipe) ends all loops of a thread after 65 535 rounds in total, without an error: what they had
//! still to do is not done (seen in loops over the nodes of a wall). What could come to so many rounds around a grain is refused on software adapters; the other loops are
//! bounded by sizes that are refused elsewhere.

use super::bounds::GROUP;
use super::device::refused;
use super::grains::{CoarseGrains, FURTHEST, SKIN};
use super::state::ghost_radius;
use crate::error::Result;
use crate::mpm::{Points, Settings};

/// Rounds that a thread may make, with some to spare.
const MOST: f64 = 60_000.0;

/// Rounds for each cell that a thread has of the box around a grain (`grain_forces`): the cell and its eight points.
const AROUND: f64 = 9.0;

/// Rounds of a thread of `grain_forces` for a grain in a domain of so many cells; `radius`: of the grain with the ghost of a point, cells.
fn of_grain(cells: [u32; 3], radius: f64) -> f64 {
    let wide = 2.0 * (radius + f64::from(FURTHEST) + SKIN) + 2.0;
    AROUND * cells.iter().map(|n| wide.min(f64::from(*n) + 1.0)).product::<f64>() / GROUP as f64
}

/// Refuses grains with whose points a software adapter would not finish.
///
/// # Errors
/// The largest grain has too many cells around it.
pub fn few_enough(settings: &Settings, points: &Points, coarse: Option<&CoarseGrains<'_>>) -> Result<()> {
    let Some(coarse) = coarse else { return Ok(()) };
    let largest = coarse.mixture.grains.grains.pos.iter().map(|p| p[3]).fold(0.0, f64::max);
    let ghost = (0..points.len()).map(|i| ghost_radius(points, i)).fold(0.0, f64::max);
    let rounds = of_grain(settings.cells, (largest + ghost) / settings.cell);
    let message = format!("rounds of a loop are above the {MOST:.0} of a software adapter: use larger cells, or use the processor");
    if rounds > MOST { Err(refused("points around a grain", format!("{rounds:.0}"), message)) } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grain of 30 cells of radius is allowed, one of 40 is not, unless the domain is small.
    #[test]
    fn a_large_grain_has_too_many_rounds() {
        let [allowed, refused, inside] = [(200, 30.0), (200, 40.0), (50, 40.0)].map(|(n, r)| of_grain([n; 3], r));
        assert!(allowed < MOST && refused > MOST && inside < MOST, "{allowed} {refused} {inside}");
    }
}
