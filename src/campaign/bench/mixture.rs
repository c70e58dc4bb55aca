//! The speed of a mixture: time for a step of the continuum with the grains' steps and the
//! coupling.

use super::pool;
use laboratory::error::{Error, Result};
use laboratory::model::{Model, Rig};
use laboratory::rig::continuum::{Engine, State};
use std::time::Instant;
use table::median;

/// Measured speed of a mixture.
#[derive(Clone, Debug)]
pub struct MixtureSpeed {
    /// Number of points.
    pub points: usize,
    /// Number of grains.
    pub grains: usize,
    /// Contacts of points with grains.
    pub contacts: u64,
    /// Number of threads.
    pub threads: usize,
    /// Milliseconds for a step of the continuum, with the grains' steps and all contacts, in each
    /// block.
    pub blocks: Vec<f64>,
}

impl MixtureSpeed {
    /// Median milliseconds.
    pub fn median(&self) -> f64 {
        median(&self.blocks)
    }
}

/// Steps a mixture on `threads` threads: `repeats` blocks of `steps` steps, after `warm_up` steps.
///
/// # Errors
/// A model that is no mixture of points and grains, or a step that fails.
pub fn mixture_speed(model: &Model, threads: usize, [warm_up, steps]: [u64; 2], repeats: usize) -> Result<MixtureSpeed> {
    let refused = |what: &str| Err(Error::input("bench mixture", "kind", None, what));
    let Rig::Continuum(rig) = &model.rig else { return refused("must be \"mixture\"") };
    if rig.growth.is_some() {
        return refused("must be a mixture without growth of its grains");
    }
    pool(threads)?.install(|| {
        let mut state = State::start(model, rig)?;
        let mut engine = Engine::of_grains(&mut state, model, rig);
        let run = |state: &mut State, engine: &mut Engine, n: u64| -> Result<f64> {
            let (since, first) = (Instant::now(), state.continuum.steps());
            while state.continuum.steps() < first + n {
                state.advance(model, rig, engine, |_, _| Ok(1.0))?;
            }
            Ok(1e3 * since.elapsed().as_secs_f64() / (state.continuum.steps() - first) as f64)
        };
        run(&mut state, &mut engine, warm_up)?;
        let blocks = (0..repeats).map(|_| run(&mut state, &mut engine, steps)).collect::<Result<Vec<f64>>>()?;
        let Some(mixture) = &state.mixture else { return refused("must be a mixture with grains") };
        let (points, grains) = (state.continuum.points().len(), mixture.grains.grains.len());
        Ok(MixtureSpeed { points, grains, contacts: mixture.touching().points, threads, blocks })
    })
}
