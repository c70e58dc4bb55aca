//! What does the steps of a test: the processor one at a time, or a graphics device in batches. Everything else stands once, in [`State`].

use super::specimen::face;
use super::{Coupled, LOOK, Phase, Rig, State};
use crate::error::Result;
use crate::model::Model;
use crate::model::continuum::Test;
use ::engine::coupling::{Mixture, Rates};
use ::engine::mpm::{Continuum, LoadingPlate, loading_plate};

#[cfg(feature = "gpu")]
use super::device::Device;

/// Where the steps are done.
pub enum Engine {
    Cpu,
    /// The processor, with grains.
    Mixture(Box<Coupled>),
    #[cfg(feature = "gpu")]
    Gpu(Box<Device>),
}

#[cfg_attr(not(feature = "gpu"), allow(unused_variables))]
impl Engine {
    /// The processor, with the grains that the state has.
    pub fn of_grains(state: &mut State, model: &Model, rig: &Rig) -> Engine {
        match &mut state.mixture {
            Some(mixture) => Engine::Mixture(Box::new(Coupled::new(model, rig, mixture))),
            None => Engine::Cpu,
        }
    }

    /// The state at the instant at which its loading plates' forces are known.
    pub(super) fn compute_forces(&mut self, state: &mut State, model: &Model, rig: &Rig) -> Result<()> {
        match self {
            Engine::Cpu => {
                state.press()?;
                state.collect(rig);
            }
            Engine::Mixture(coupled) => {
                state.press()?;
                coupled.compute_forces(state, model)?;
                state.collect(rig);
            }
            // it has felt and collected at the end of each step
            #[cfg(feature = "gpu")]
            Engine::Gpu(_) => {}
        }
        Ok(())
    }

    /// The time of a wave through a cell, s.
    pub(super) fn stable_step(&self, state: &State) -> f64 {
        match self {
            Engine::Cpu | Engine::Mixture(_) => state.continuum.stable_step(1.0),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.stable_step(),
        }
    }

    /// What the grains' own contacts allow, s, and what those of points with grains and loading plates add to the square of a frequency, 1/s².
    pub(super) fn bounds(&self, mixture: &mut Mixture, continuum: &Continuum, plates: &[LoadingPlate], slow: bool) -> (f64, f64) {
        match self {
            Engine::Cpu | Engine::Mixture(_) => mixture.bounds(continuum, plates, slow),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.bounds(plates),
        }
    }

    /// The rates that it can do instead of those that were found, where they are others.
    pub(super) fn rates(&self, found: Rates) -> Option<Rates> {
        match self {
            Engine::Cpu | Engine::Mixture(_) => None,
            #[cfg(feature = "gpu")]
            Engine::Gpu(_) => Some(Device::rates(found)),
        }
    }

    /// A step, or as many as it takes until the test has the share `next`.
    pub(super) fn steps(&mut self, state: &mut State, model: &Model, rig: &Rig, next: f64) -> Result<()> {
        match self {
            Engine::Cpu => state.step(rig),
            Engine::Mixture(coupled) => coupled.cycle(state, model, rig),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.steps(state, model, rig, state.ahead(rig, next)),
        }
    }

    /// Brings the points of the state up to date.
    ///
    /// # Errors
    /// A device that was lost; the points are then those of the last time.
    pub fn read_back(&self, state: &mut State, model: &Model) -> Result<()> {
        match self {
            Engine::Cpu | Engine::Mixture(_) => Ok(()),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.read_back(state, model),
        }
    }

    /// Bytes held for the points and their grid.
    pub fn bytes(&self, state: &State) -> u64 {
        match self {
            Engine::Cpu => state.continuum.bytes() as u64,
            Engine::Mixture(coupled) => (state.continuum.bytes() + coupled.bytes(state)) as u64,
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.bytes(),
        }
    }
}

impl State {
    /// Loading plates press on the points.
    pub(super) fn press(&mut self) -> Result<()> {
        Ok(loading_plate::press(&mut self.plates, &mut self.continuum)?)
    }

    /// One step on the processor, with the loading plates' forces, and their way in it.
    fn step(&mut self, rig: &Rig) -> Result<()> {
        self.set_speeds(rig);
        self.continuum.step(self.dt)?;
        self.plates.iter_mut().for_each(|plate: &mut LoadingPlate| plate.advance(self.dt));
        self.time += self.dt;
        self.phase_time += self.dt;
        Ok(())
    }

    /// The loading plates' speeds, as their drives have it.
    pub(super) fn set_speeds(&mut self, rig: &Rig) {
        let extents = self.extents_now(rig);
        for ((plate, drive), drift) in self.plates.iter_mut().zip(&self.drives).zip(&mut self.drift) {
            let axis = plate.axis();
            plate.speed = drive.speed(0.0, plate, [extents[axis], face(rig, extents, axis)], self.dt, drift);
        }
    }

    /// Steps until the test has the share `next`, at most to the next look at what bounds the step, and while a specimen settles at most a wave's time.
    #[cfg_attr(not(feature = "gpu"), allow(dead_code))]
    fn ahead(&self, rig: &Rig, next: f64) -> u64 {
        let steps = self.continuum.steps();
        let most = LOOK - steps % LOOK;
        let share = match &rig.test {
            Test::Free { duration: Some(duration), .. } => self.dt / duration,
            Test::Free { steps, .. } => 1.0 / steps.unwrap_or(1) as f64,
            _ if self.phase == Phase::Settle => return ((self.wave / self.dt).ceil() as u64).clamp(1, most),
            Test::Oedometer(s) | Test::Triaxial { specimen: s, .. } => self.rate * self.dt / s.axial_strain,
        };
        // a whole number of steps that rounding has made a little more
        let wanted = (next - self.share(rig)) / share - 1e-6;
        (wanted.ceil().max(1.0) as u64).min(most)
    }
}
