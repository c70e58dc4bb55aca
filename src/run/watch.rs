//! What ends a run that has lost its meaning.

use crate::error::{Error, Result};
use crate::step::State;

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
