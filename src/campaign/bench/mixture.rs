//! The speed of a mixture: time for a step of the continuum with the grains' steps and the
//! coupling.

use super::pool;
use laboratory::error::{Error, Result};
use laboratory::model::continuum::MpmTest;
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
    let rig = benched(model)?;
    pool(threads)?.install(|| {
        let mut state = State::start(model, rig)?;
        let mut engine = Engine::of_grains(&mut state, model, rig);
        let mut run = |n| milliseconds(&mut state, (model, rig), &mut engine, n);
        run(warm_up)?;
        let blocks = (0..repeats).map(|_| run(steps)).collect::<Result<Vec<f64>>>()?;
        let Some(mixture) = &state.mixture else { return Err(refused("must be a mixture with grains")) };
        let (points, grains) = (state.continuum.points().len(), mixture.grains.grains.len());
        Ok(MixtureSpeed { points, grains, contacts: mixture.touching().points, threads, blocks })
    })
}

/// Measured speed of a continuum or mixture on the graphics device.
#[cfg(feature = "gpu")]
#[derive(Clone, Debug)]
pub struct MixtureGpuSpeed {
    /// Name of the graphics adapter.
    pub adapter: String,
    /// Number of points.
    pub points: usize,
    /// Number of grains.
    pub grains: usize,
    /// Milliseconds for a step, in each block.
    pub blocks: Vec<f64>,
    /// Milliseconds for a row of the history, after each block: to copy points and grains back, and to measure them.
    pub rows: Vec<[f64; 2]>,
    /// What each pass takes in a step of `steps` further ones, by the device's clock, ms, in their order; or why that is not known.
    pub passes: std::result::Result<Vec<(&'static str, f64)>, String>,
}

#[cfg(feature = "gpu")]
impl MixtureGpuSpeed {
    /// Median milliseconds.
    pub fn median(&self) -> f64 {
        median(&self.blocks)
    }

    /// Median milliseconds for a row: to copy, and to measure.
    pub fn row(&self) -> [f64; 2] {
        [0, 1].map(|k| median(&self.rows.iter().map(|row| row[k]).collect::<Vec<f64>>()))
    }
}

/// Steps a continuum or a mixture on the graphics device: `repeats` blocks of `steps` steps after `warm_up`, each with a row of the history after it, and `steps`
/// more in which each pass is timed.
///
/// # Errors
/// No adapter, a model that the device does not take, or a step that fails.
#[cfg(feature = "gpu")]
pub fn mixture_gpu_speed(model: &Model, [warm_up, steps]: [u64; 2], repeats: usize) -> Result<MixtureGpuSpeed> {
    let rig = benched(model)?;
    let mut state = State::start(model, rig)?;
    let mut engine = Engine::on_device(&mut state, model, rig)?;
    milliseconds(&mut state, (model, rig), &mut engine, warm_up)?;
    let (mut blocks, mut rows) = (Vec::new(), Vec::new());
    for _ in 0..repeats {
        blocks.push(milliseconds(&mut state, (model, rig), &mut engine, steps)?);
        let since = Instant::now();
        engine.read_back(&mut state, model)?;
        let copied = since.elapsed();
        std::hint::black_box(state.moment(rig));
        rows.push([copied, since.elapsed() - copied].map(|time| 1e3 * time.as_secs_f64()));
    }
    let timed = engine.time_passes().map_err(|why| why.to_string());
    let first = state.continuum.steps();
    if timed.is_ok() {
        milliseconds(&mut state, (model, rig), &mut engine, steps)?;
    }
    let done = (state.continuum.steps() - first) as f64;
    let passes = timed.map(|()| engine.pass_times().iter().map(|p| (p.pass, 1e3 * p.seconds / done)).collect());
    let adapter = engine::gpu::available().map_or_else(String::new, |a| a.name);
    let grains = state.mixture.as_ref().map_or(0, |mixture| mixture.grains.grains.len());
    Ok(MixtureGpuSpeed { adapter, points: state.continuum.points().len(), grains, blocks, rows, passes })
}

/// The rig of a model that can be benched.
fn benched(model: &Model) -> Result<&MpmTest> {
    let Rig::Continuum(rig) = &model.rig else { return Err(refused("must be \"mixture\"")) };
    if rig.growth.is_some() {
        return Err(refused("must be a mixture without growth of its grains"));
    }
    Ok(rig)
}

fn refused(what: &str) -> Error {
    Error::input("bench mixture", "kind", None, what)
}

/// Milliseconds for a step, with all contacts and the steps of the grains, over at least `n` steps.
fn milliseconds(state: &mut State, (model, rig): (&Model, &MpmTest), engine: &mut Engine, n: u64) -> Result<f64> {
    let (since, first) = (Instant::now(), state.continuum.steps());
    while state.continuum.steps() < first + n {
        state.advance(model, rig, engine, |_, _| Ok(1.0))?;
    }
    Ok(1e3 * since.elapsed().as_secs_f64() / (state.continuum.steps() - first) as f64)
}
