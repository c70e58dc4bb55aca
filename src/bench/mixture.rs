//! What grains cost a continuum: cycles of a mixture, and steps of its continuum alone, in turn.

use super::pool;
use super::speed::median;
use crate::error::{Error, Result};
use crate::model::{Model, Rig};
use crate::rig::continuum::{Engine, State};
use std::time::Instant;

/// What was measured.
#[derive(Clone, Debug)]
pub struct MixtureSpeed {
    pub points: usize,
    pub grains: usize,
    /// Contacts of points with grains.
    pub contacts: u64,
    pub threads: usize,
    /// Milliseconds for a step of the continuum with all that belongs to it, and for one of the same points between the same platens
    /// without grains, of each block.
    pub coupled: Vec<f64>,
    pub alone: Vec<f64>,
}

impl MixtureSpeed {
    /// Median milliseconds with grains, and without.
    pub fn medians(&self) -> [f64; 2] {
        [median(&self.coupled), median(&self.alone)]
    }

    /// What grains and their contacts add to the continuum's time, as a share of it: median over the blocks, each with its neighbour in time.
    pub fn added(&self) -> f64 {
        median(&self.coupled.iter().zip(&self.alone).map(|(with, without)| with / without - 1.0).collect::<Vec<f64>>())
    }
}

/// Steps a mixture on `threads` threads: `repeats` blocks of `steps` steps, after `warm_up` cycles, each followed by as many steps of its continuum alone.
///
/// # Errors
/// A model that is no mixture of points and grains, or a step that fails.
pub fn mixture_speed(model: &Model, threads: usize, [warm_up, steps]: [u64; 2], repeats: usize) -> Result<MixtureSpeed> {
    let refused = |what: &str| Err(Error::input("bench mixture", "kind", None, what));
    let Rig::Continuum(rig) = &model.rig else { return refused("must be \"mixture\"") };
    if rig.growth.is_some() {
        return refused("must be a mixture that need not grow first");
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
        let (mut coupled, mut alone) = (Vec::new(), Vec::new());
        for _ in 0..repeats {
            coupled.push(run(&mut state, &mut engine, steps)?);
            // a fresh copy each time: what grains have held up has no time to fall in
            let mut without = state.without_grains();
            run(&mut without, &mut Engine::Cpu, 2)?;
            alone.push(run(&mut without, &mut Engine::Cpu, steps)?);
        }
        let Some(mixture) = &state.mixture else { return refused("must be a mixture with grains") };
        let (points, grains) = (state.continuum.points().len(), mixture.grains.grains.len());
        Ok(MixtureSpeed { points, grains, contacts: mixture.touching().points, threads, coupled, alone })
    })
}
