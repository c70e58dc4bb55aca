//! A continuum under test: free between the walls of its grid, in an oedometer, or between six loading plates.

#[cfg(feature = "gpu")]
mod device;
mod engine;
mod grains;
mod growth;
mod measure;
mod specimen;

#[cfg(feature = "gpu")]
pub(crate) use device::Device;
pub use engine::Engine;
pub use grains::Coupled;
pub(crate) use growth::{Growing, Grown, growing};
pub(crate) use measure::{Coarse, Moment};

use crate::error::{Error, Result};
use crate::model::Model;
use crate::model::continuum::{Continuum as Rig, Test};
use ::engine::coupling::Mixture;
use ::engine::dem::event::Breakage;
use ::engine::mpm::{Continuum, Dimension, LoadingPlate, PlateDrive, Ramp, with_plates};
use serde::{Deserialize, Serialize};

/// Steps between two looks at what bounds the time step.
const LOOK: u64 = 64;

/// Where a test is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// The cell pressure rises to its value and the specimen comes to rest.
    Settle,
    /// The axial loading plates move, or the points by themselves.
    Load,
    Done,
}

/// A breakage, and where the test was: steps of the continuum, time, s, stress on the axial loading plates, Pa (not a number in a free scene).
#[derive(Clone, Debug)]
pub struct Broken {
    pub event: Breakage,
    pub step: u64,
    pub time: f64,
    pub axial: f64,
}

/// Everything that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    pub continuum: Continuum,
    /// Grains in it, where there are some.
    pub mixture: Option<Box<Mixture>>,
    /// In an oedometer the top one; in a triaxial test those of x low, x high, y low, …
    pub plates: Vec<LoadingPlate>,
    pub phase: Phase,
    /// Since the start, and in this phase, s.
    pub time: f64,
    pub phase_time: f64,
    /// The present step, s, and its bound by waves through a cell.
    pub dt: f64,
    bound: f64,
    /// Extents at the start of loading, m; time of a compression wave through the height, s; axial strain per second.
    pub extents: [f64; 3],
    pub wave: f64,
    rate: f64,
    /// What each loading plate does until the programme looks again, and its mean speed under servo, m/s.
    #[serde(skip)]
    drives: Vec<PlateDrive>,
    drift: Vec<f64>,
    /// Breakages that have not been recorded yet.
    #[serde(skip)]
    pub broken: Vec<Broken>,
    /// Kinetic and potential energy of the points and elastic energy of the loading plates' contacts at the start, J.
    energy: Option<[f64; 3]>,
    means: measure::Means,
}

/// Number of dimensions.
fn dimensions(rig: &Rig) -> usize {
    if rig.settings.dimension == Dimension::Space { 3 } else { 2 }
}

impl State {
    /// The points as the scene has them, loading plates where they balance the points' stress.
    ///
    /// # Errors
    /// What the method does not allow, and a time step above the bound.
    pub fn start(model: &Model, rig: &Rig) -> Result<State> {
        let continuum = Continuum::new(rig.settings.clone(), rig.laws.clone(), rig.points.clone())?;
        if let Some(dt) = model.physics.stepping.dt {
            continuum.check_step(dt)?;
        }
        let plates = specimen::plates(rig, &continuum);
        let mut state = State {
            mixture: None,
            plates,
            phase: if matches!(rig.test, Test::Triaxial { .. }) { Phase::Settle } else { Phase::Load },
            continuum,
            time: 0.0,
            phase_time: 0.0,
            dt: 0.0,
            bound: 0.0,
            extents: [0.0; 3],
            wave: 0.0,
            rate: 0.0,
            drives: Vec::new(),
            drift: Vec::new(),
            broken: Vec::new(),
            energy: None,
            means: measure::Means::default(),
        };
        state.drift = vec![0.0; state.plates.len()];
        if let Some(coarse) = &rig.coarse {
            state.mixture = Some(Box::new(grains::mixture(model, rig, coarse, &mut state.continuum, &state.plates)));
        }
        state.press()?;
        state.continuum.clear_external_forces();
        state.extents = state.extents_now(rig);
        if let Some(specimen) = rig.specimen() {
            let speed = rig.laws[usize::from(specimen.law)].wave_speed(specimen.density);
            state.wave = specimen.size[dimensions(rig) - 1] / speed;
            state.rate = specimen.strain_per_wave / state.wave;
        }
        Ok(state)
    }

    /// The step with which the test of a specimen that need not grow begins, when what contacts allow is known, s.
    ///
    /// # Errors
    /// As [`Self::start`], and a step that is refused.
    pub fn first_step(model: &Model, rig: &Rig) -> Result<f64> {
        let mut state = State::start(model, rig)?;
        let mut engine = Engine::of_grains(&mut state, model, rig);
        state.advance(model, rig, &mut engine, |_, _| Ok(0.0))?;
        engine.compute_forces(&mut state, model, rig)?;
        state.find_step(model, rig, &engine)?;
        Ok(state.dt)
    }

    /// To the next look: one step, or a batch of them on a device. `observe` sees the state when the loading plates' forces are known, and says at which share of the
    /// test it has to look again. In [`Phase::Done`] nothing moves any more.
    ///
    /// # Errors
    /// A lost point, a loading plate through the points, a step above its bound, a specimen that does not come to rest; what `observe` returns.
    pub fn advance(
        &mut self,
        model: &Model,
        rig: &Rig,
        engine: &mut Engine,
        observe: impl FnOnce(&mut State, &Engine) -> Result<f64>,
    ) -> Result<()> {
        engine.compute_forces(self, model, rig)?;
        self.find_step(model, rig, engine)?;
        self.programme(rig)?;
        let next = observe(self, engine)?;
        if self.phase == Phase::Done {
            return Ok(());
        }
        engine.steps(self, model, rig, next)
    }

    /// The step: a share of what waves through a cell and the loading plates' contacts allow, or the fixed one.
    fn find_step(&mut self, model: &Model, rig: &Rig, engine: &Engine) -> Result<()> {
        let step = self.continuum.steps();
        if step.is_multiple_of(LOOK) || self.bound == 0.0 {
            self.bound = engine.stable_step(self);
        }
        if self.mixture.is_some() {
            return self.find_cycle(model, rig, self.bound, engine);
        }
        let rate = self.plates.iter().map(|p| p.rate).fold(0.0, f64::max);
        let bound = with_plates(self.bound, rate, rig.settings.transfer);
        self.dt = match model.physics.stepping.dt {
            None => model.physics.stepping.safety * bound,
            Some(dt) if dt <= bound => dt,
            Some(dt) => {
                let with = if rate > 0.0 { ", with the platens' contacts" } else { "" };
                let what = format!(
                    "stepping.dt_s = {dt:e} is above the time of a compression wave through a cell{with}, {bound:.4e} s: use a smaller one, or \"auto\""
                );
                return Err(Error::Unstable { step, what, grain: None });
            }
        };
        Ok(())
    }

    /// What is to be done next, by what the loading plates feel.
    fn programme(&mut self, rig: &Rig) -> Result<()> {
        self.drives.resize(self.plates.len(), PlateDrive::Speed(Ramp::constant(0.0)));
        match &rig.test {
            Test::Free { .. } => {
                if self.share(rig) >= 1.0 {
                    self.phase = Phase::Done;
                }
                Ok(())
            }
            Test::Oedometer(specimen) => {
                self.compress(rig, specimen);
                Ok(())
            }
            Test::Triaxial { specimen, cell_pressure, drainage } => self.shear(rig, specimen, *cell_pressure, *drainage),
        }
    }

    /// Share of the test that is done, 0 until its loading begins.
    pub fn share(&self, rig: &Rig) -> f64 {
        match &rig.test {
            Test::Free { duration: Some(duration), .. } => (self.time / duration) * (1.0 + 1e-12),
            Test::Free { steps, .. } => self.continuum.steps() as f64 / steps.unwrap_or(1) as f64,
            Test::Oedometer(_) | Test::Triaxial { .. } if self.phase == Phase::Settle => 0.0,
            Test::Oedometer(s) | Test::Triaxial { specimen: s, .. } => self.axial_strain(rig) / s.axial_strain,
        }
    }
}

pub(crate) use specimen::contact_rate;
