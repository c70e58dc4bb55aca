//! What ends a run that has lost its meaning, before anything in it is not a number.

use crate::error::{Error, Result};
use crate::model::Model;
use crate::record::measure;
use crate::step::{State, Work};

/// A grain is inside another one, and their contact no force any more, when they overlap by this many times the smaller radius.
const SWALLOWED: f64 = 2.0;

/// Looks after the energies of a quasi-static test.
#[derive(Debug, Default)]
pub struct Watch {
    /// Kinetic energy, J, above which the elastic energy of all contacts is summed again.
    allowance: f64,
}

impl Watch {
    /// # Errors
    /// Grains of a quasi-static test that have more kinetic energy than all contacts have elastic energy, or energy that is not a number.
    pub fn energy(&mut self, model: &Model, state: &State, work: &Work) -> Result<()> {
        let g = &state.grains;
        let of = |i: usize| {
            let [u, v, w, inverse] = g.vel[i];
            0.5 * (u * u + v * v + w * w) / inverse
        };
        let kinetic: f64 = (0..g.len()).map(of).sum();
        if kinetic <= self.allowance {
            return Ok(());
        }
        let stored = measure::sums(model, state, work).stored;
        self.allowance = 0.5 * stored;
        if kinetic <= stored {
            return Ok(());
        }
        let fastest = (0..g.len()).max_by(|&i, &j| of(i).total_cmp(&of(j))).unwrap_or(0);
        let what = format!(
            "the kinetic energy of the grains, {kinetic:.3e} J, is larger than the elastic energy of all contacts, {stored:.3e} J: a quasi-static test \
             has become unstable; try stepping.safety = 0.4, contact.unloading = \"rescale\", crushing.birth = \"gradual\", in this order. Of all grains the \
             fastest has diameter {:.3e} m",
            2.0 * g.pos[fastest][3]
        );
        Err(Error::Unstable { step: state.step, what, grain: Some(u64::from(g.id[fastest])) })
    }
}

/// After `step` steps of the run.
///
/// # Errors
/// A grain that is nowhere, has left through a wall, or is inside another one.
pub fn grains(state: &State, step: u64) -> Result<()> {
    let g = &state.grains;
    let bad = |i: usize, what: String| Err(Error::Unstable { step, what, grain: Some(u64::from(g.id[i])) });
    for (i, p) in g.pos.iter().enumerate() {
        if !(p[0] + p[1] + p[2]).is_finite() {
            return bad(i, "a grain's position is not a number: the time step is too large for the stiffness; lower stepping.safety or stepping.dt_s".into());
        }
        for (k, w) in state.walls.iter().enumerate() {
            if w.shape.towards(*p).1 < -2.0 * p[3] {
                return bad(i, format!("a grain of diameter {:.3e} m has left through wall {k}", 2.0 * p[3]));
            }
        }
    }
    for (ends, touch) in state.pairs.ends.iter().zip(&state.pairs.touch) {
        if touch.overlap <= 0.0 {
            continue;
        }
        let [i, j] = ends.map(|i| i as usize);
        let small = if g.pos[i][3] < g.pos[j][3] { i } else { j };
        // what has just been born may still have to grow out of a neighbour
        if touch.overlap > SWALLOWED * g.pos[small][3] && state.aftermath.radius(small, g) == g.pos[small][3] {
            let large = if small == i { j } else { i };
            let what = format!(
                "a grain of diameter {:.3e} m is inside one of {:.3e} m (grain {}): contacts are too soft for these forces; raise material.elastic or the \
                 comminution limit, or load to a lower stress",
                2.0 * g.pos[small][3],
                2.0 * g.pos[large][3],
                g.id[large]
            );
            return bad(small, what);
        }
    }
    Ok(())
}
