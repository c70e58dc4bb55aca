//! Tests of a continuum of material points, with grains in it or without: free motion between the walls of the grid, an
//! oedometer, or triaxial compression between loading plates.

mod account;
#[cfg(feature = "gpu")]
mod device;
mod driven;
mod engine;
mod grains;
mod growth;
mod measure;
mod sides;
mod specimen;

pub(crate) use account::{EnergyAccount, TERMS};
#[cfg(feature = "gpu")]
pub(crate) use device::Device;
pub use engine::Engine;
pub use grains::Coupled;
pub(crate) use grains::platens;
pub(crate) use growth::{Growing, Grown, growing};
pub(crate) use measure::{GrainMeasures, Moment};
pub(crate) use sides::{Side, shape_of};

use crate::error::{Error, Result};
use crate::model::Model;
use crate::model::continuum::{MpmTest, Test};
use ::engine::boundary::Drive;
use ::engine::check::{self, Checked, ensure};
use ::engine::coupling::Mixture;
use ::engine::dem::event::Breakage;
use ::engine::mpm::{Continuum, Dimension, LoadingPlate, PlateDrive, Ramp, with_plates};
use serde::{Deserialize, Serialize};

/// Steps between two searches for the largest stable time step.
const LOOK: u64 = 64;

/// The phase of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// Triaxial test: the cell pressure rises to its value, and the specimen comes to rest. Oedometer of rigid bodies: the top platen presses them to rest.
    Settle,
    /// The axial loading plates move; in a free scene the points.
    Load,
    /// The test is done.
    Done,
}

/// A breakage with the instant of the test at which it happened.
#[derive(Clone, Debug)]
pub struct Broken {
    /// The breakage.
    pub event: Breakage,
    /// Steps of the continuum at the start of the cycle.
    pub step: u64,
    /// Time at the start of the cycle, s.
    pub time: f64,
    /// Mean stress on the axial loading plates, Pa, compression positive; NaN in a free scene.
    pub axial: f64,
}

/// The state of a test of a continuum: everything that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    /// Points and grid.
    pub continuum: Continuum,
    /// The grains among the points, and their coupling; `None`: there are none.
    pub mixture: Option<Box<Mixture>>,
    /// The loading plates: in an oedometer the top one, after the shell of a cylinder; in a triaxial test of a box x low, x high,
    /// y low, …, of a cylinder shell, bottom, top.
    pub plates: Vec<LoadingPlate>,
    /// The present phase.
    pub phase: Phase,
    /// Time since the start, s.
    pub time: f64,
    /// Time in the present phase, s.
    pub phase_time: f64,
    /// Time step, s; with grains the time of a cycle.
    pub dt: f64,
    /// Time of a compression wave through a cell, s: bounds the time step.
    bound: f64,
    /// Extents of the specimen at the start of loading, m.
    pub extents: [f64; 3],
    /// Time of a compression wave through the height of the specimen, s, with the inertia of the points.
    pub wave: f64,
    /// Axial strain rate, 1/s.
    rate: f64,
    /// Motion of each loading plate until the programme is looked at again.
    #[serde(skip)]
    drives: Vec<PlateDrive>,
    /// Mean speed of each loading plate under servo, m/s.
    drift: Vec<f64>,
    /// Breakages that have not been recorded yet.
    #[serde(skip)]
    pub broken: Vec<Broken>,
    /// Kinetic energy, potential energy, and elastic energy of the contacts of loading plates and grains, at the start, J.
    energy: Option<[f64; 3]>,
    /// Energies at the start of the energy account, if one is kept.
    opened: Option<account::Opened>,
    means: measure::Means,
}

/// Number of dimensions.
fn dimensions(rig: &MpmTest) -> usize {
    if rig.settings.dimension == Dimension::Space { 3 } else { 2 }
}

impl State {
    /// The first state: the points of the rig, with the loading plates at the places where they balance the stress of the points.
    ///
    /// # Errors
    /// Points or a grid that the material point method does not allow; a fixed time step above its bound.
    pub fn start(model: &Model, rig: &MpmTest) -> Result<State> {
        let continuum = Continuum::new(rig.settings.clone(), rig.laws.clone(), rig.moving_points())?;
        if let Some(dt) = model.physics.stepping.dt.filter(|_| !rig.above_bound) {
            continuum.check_step(dt)?;
        }
        let plates = specimen::plates(rig, &continuum);
        let mut state = State {
            mixture: None,
            plates,
            phase: if rig.settles() { Phase::Settle } else { Phase::Load },
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
            opened: None,
            means: measure::Means::default(),
        };
        state.drift = vec![0.0; state.plates.len()];
        if let Some(coarse) = &rig.coarse {
            state.mixture = Some(Box::new(grains::mixture(model, rig, coarse, &mut state.continuum, &state.plates)));
        }
        if let (Some(mixture), Some(bed)) = (&mut state.mixture, rig.specimen().and_then(|s| s.bed)) {
            mixture.grains.friction = bed.friction;
        }
        if model.records.account {
            state.open_account(rig)?;
        }
        state.press()?;
        state.continuum.clear_external_forces();
        state.extents = state.extents_now(rig);
        if let Some(specimen) = rig.specimen() {
            let speed = (rig.oedometric(specimen) / specimen.density).sqrt();
            let wave = specimen.size[dimensions(rig) - 1] / speed;
            // a rate that does not change with the inertia; what has to wait for waves waits for the slower ones
            state.rate = specimen.strain_per_wave / wave;
            state.wave = wave * rig.points_inertia.sqrt();
        }
        Ok(state)
    }

    /// Checks a state from a checkpoint against that with which the test of `rig` starts.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, rig: &MpmTest) -> Checked {
        let made = State::start(model, rig).map_err(|e| e.to_string())?;
        match (&self.mixture, &made.mixture) {
            (Some(mixture), Some(theirs)) => {
                let walls = if rig.specimen().is_some() { 0 } else { theirs.grains.walls.len() };
                mixture.check(&self.continuum, &model.physics, (theirs, &made.continuum), walls)?;
            }
            (None, None) => self.continuum.check(&made.continuum, 0)?,
            _ => return Err("there are grains where the scene has none, or none where it has some".into()),
        }
        check::lengths("platens", made.plates.len(), [self.plates.len(), self.drift.len()])?;
        self.plates.iter().zip(&made.plates).try_for_each(|(plate, made)| plate.check(made))?;
        check::numbers("speeds of platens", &self.drift)?;
        let settles = self.phase != Phase::Settle || rig.settles();
        let same = self.wave == made.wave && self.rate == made.rate;
        ensure(settles && same, || "phase or speed of the test are not those of the scene".into())?;
        check::not_negative("times", [self.time, self.phase_time])?;
        check::all("time steps", [self.dt, self.bound], "no time step", |x| x == 0.0 || x >= f64::MIN_POSITIVE)?;
        if rig.specimen().is_some() {
            check::positive("extents", self.extents)?;
            check::positive("extents", self.extents_now(rig))?;
        }
        check::numbers("energies", self.energy.iter().flatten())?;
        self.opened.as_ref().map_or(Ok(()), account::Opened::check)?;
        self.means.check()
    }

    /// First time step of a test whose specimen need not grow, s, with the bounds by all contacts.
    ///
    /// # Errors
    /// Those of [`Self::start`]; a fixed time step above its bound.
    pub fn first_step(model: &Model, rig: &MpmTest) -> Result<f64> {
        let mut state = State::start(model, rig)?;
        let mut engine = Engine::of_grains(&mut state, model, rig);
        state.advance(model, rig, &mut engine, |_, _| Ok(0.0))?;
        engine.compute_forces(&mut state, model, rig)?;
        state.find_step(model, rig, &engine)?;
        Ok(state.dt)
    }

    /// One step on the CPU, or a batch of steps on a graphics device. `observe` is called when the forces on the loading plates
    /// are known and before the step; it gives the share of the test at which it must be called again, which ends a batch. In
    /// [`Phase::Done`] no step is made.
    ///
    /// # Errors
    /// A point that is lost, a loading plate that has passed through the points, a fixed time step above its bound, a specimen
    /// that does not come to rest; the errors of `observe`.
    pub fn advance(
        &mut self,
        model: &Model,
        rig: &MpmTest,
        engine: &mut Engine,
        observe: impl FnOnce(&mut State, &Engine) -> Result<f64>,
    ) -> Result<()> {
        self.look(model, rig, engine, None)?;
        let next = observe(self, engine)?;
        self.go(model, rig, engine, next)
    }

    /// First part of a step: computes the forces of this instant, the time step, and how the loading plates move: as the test's programme says, or as `told`, each by its index.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn look(&mut self, model: &Model, rig: &MpmTest, engine: &mut Engine, told: Option<&[Drive]>) -> Result<()> {
        engine.compute_forces(self, model, rig)?;
        self.find_step(model, rig, engine)?;
        match told {
            None => self.programme(rig),
            Some(told) => {
                self.obey(rig, told);
                Ok(())
            }
        }
    }

    /// Second part of a step, after [`Self::look`]: moves points, grains and walls, but in [`Phase::Done`]. `next`: the share of the test at which the test must be looked at again.
    ///
    /// # Errors
    /// As [`Self::advance`].
    pub fn go(&mut self, model: &Model, rig: &MpmTest, engine: &mut Engine, next: f64) -> Result<()> {
        if self.phase == Phase::Done { Ok(()) } else { engine.steps(self, model, rig, next) }
    }

    /// Sets the time step: the fixed one, or the share `stepping.safety` of the largest that waves through a cell and the
    /// contacts of the loading plates allow.
    fn find_step(&mut self, model: &Model, rig: &MpmTest, engine: &Engine) -> Result<()> {
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
            Some(dt) if rig.above_bound || dt <= bound => dt,
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

    /// Sets phase and motion of the loading plates for the next step, from the forces on them.
    fn programme(&mut self, rig: &MpmTest) -> Result<()> {
        self.drives.resize(self.plates.len(), PlateDrive::Speed(Ramp::constant(0.0)));
        match &rig.test {
            Test::Free { .. } => {
                if self.share(rig) >= 1.0 {
                    self.phase = Phase::Done;
                }
                Ok(())
            }
            Test::Oedometer(specimen) => self.compress(rig, specimen),
            Test::Triaxial { specimen, cell_pressure, drainage } => self.shear(rig, specimen, *cell_pressure, *drainage),
        }
    }

    /// Share of the test that is done, 0 to 1; 0 in [`Phase::Settle`].
    pub fn share(&self, rig: &MpmTest) -> f64 {
        match &rig.test {
            Test::Free { duration: Some(duration), .. } => (self.time / duration) * (1.0 + 1e-12),
            Test::Free { steps, .. } => self.continuum.steps() as f64 / steps.unwrap_or(1) as f64,
            Test::Oedometer(_) | Test::Triaxial { .. } if self.phase == Phase::Settle => 0.0,
            Test::Oedometer(s) | Test::Triaxial { specimen: s, .. } => self.axial_strain(rig) / s.axial_strain,
        }
    }
}

pub(crate) use specimen::contact_rate;
