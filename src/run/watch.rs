//! What ends a run that has lost its meaning.

use crate::error::{Error, Result};
use crate::model::continuum::Continuum as Rig;
use crate::record::continuum::Recorder;
use crate::rig::continuum;
use crate::step::State;

/// Energy that appears from nothing, as a share of all given. Measured: the scenes' least shares are above -0.001, those of elastic cubes of 8 cells without damping
/// and PIC, at a strain of 2 % and steps far below the contacts' bound, above -0.033.
const CREATED: f64 = 0.05;
/// Opposite platens whose forces differ by more than their mean: the rest would accelerate the specimen as if one of them were not there.
const APART: f64 = 1.0;

/// The last row of a continuum between platens.
///
/// # Errors
/// Pores of negative volume; in a test without grains that is under way, energy from nothing and opposite platens that do not balance.
pub fn continuum(rig: &Rig, state: &continuum::State, row: &Recorder) -> Result<()> {
    if rig.specimen().is_none() {
        return Ok(());
    }
    let impossible = |what: String| Err(Error::Impossible { step: state.continuum.steps(), what });
    // of grains alone it is that of the whole, which their overlaps may fill
    if !state.continuum.points().is_empty() && (row.void_ratio.is_nan() || row.void_ratio < 0.0) {
        return impossible(format!(
            "the void ratio is {:.4}, at an axial strain of {:.4}: the solids fill more than the whole volume, which the law does not know; \
             lower test.axial_strain or use a stiffer law; if strains are small, lower stepping.safety or raise damping.local",
            row.void_ratio, row.last[0]
        ));
    }
    if state.mixture.is_some() || !row.under_way(rig, state.phase) {
        return Ok(());
    }
    let change = "lower stepping.safety, raise damping.local (0.1) or grid.pic (0.1)";
    if row.dissipated.is_nan() || row.dissipated < -CREATED {
        return impossible(format!(
            "dissipated_share is {:.4}, below {:.2}: energy comes from nothing, an oscillation that the platens' contacts and the time step feed; {change}",
            row.dissipated, -CREATED
        ));
    }
    if row.difference.is_nan() || row.difference > APART {
        return impossible(format!(
            "forces of opposite platens differ by {:.2} of their mean (platen_difference), above {APART}: the test is not quasi-static; {change}, or lower test.strain_per_wave",
            row.difference
        ));
    }
    Ok(())
}

/// After `step` steps of the run.
///
/// # Errors
/// A grain that is nowhere, or has left through a wall.
pub fn grains(state: &State, step: u64) -> Result<()> {
    let bad = |i: usize, what: String| Err(Error::Unstable { step, what, grain: Some(u64::from(state.grains.id[i])) });
    for (i, p) in state.grains.pos.iter().enumerate() {
        if !(p[0] + p[1] + p[2]).is_finite() {
            return bad(i, "a grain's position is not a number: the time step is too large for the stiffness; lower stepping.safety or stepping.dt_s".into());
        }
        for (k, w) in state.walls.iter().enumerate() {
            if w.shape.towards(*p).1 < -2.0 * p[3] {
                return bad(i, format!("a grain of diameter {:.3e} m has left through wall {k}", 2.0 * p[3]));
            }
        }
    }
    Ok(())
}
