//! The engines that make the steps of a test: the CPU makes one step at a time, a graphics device makes batches of steps.
//! Programme and records are the same for all of them ([`State`]).

use super::specimen::face;
use super::{Coupled, LOOK, MpmTest, Phase, State};
use crate::error::Result;
use crate::model::Model;
use crate::model::continuum::Test;
use ::engine::coupling::{Mixture, Rates};
use ::engine::mpm::{Continuum, LoadingPlate, loading_plate};

#[cfg(feature = "gpu")]
use super::device::Device;

/// An engine that makes the steps of a test.
pub enum Engine {
    /// The CPU, points alone.
    Cpu,
    /// The CPU, points and grains.
    Mixture(Box<Coupled>),
    /// A graphics device.
    #[cfg(feature = "gpu")]
    Gpu(Box<Device>),
}

#[cfg_attr(not(feature = "gpu"), allow(unused_variables))]
impl Engine {
    /// The engine of the CPU for this state, with its grains if there are some.
    pub fn of_grains(state: &mut State, model: &Model, rig: &MpmTest) -> Engine {
        match &mut state.mixture {
            Some(mixture) => Engine::Mixture(Box::new(Coupled::new(model, rig, mixture))),
            None => Engine::Cpu,
        }
    }

    /// The engine of a graphics device for this state.
    ///
    /// # Errors
    /// No graphics adapter, too little memory, or a scene that the device cannot compute.
    #[cfg(feature = "gpu")]
    pub fn on_device(state: &mut State, model: &Model, rig: &MpmTest) -> Result<Engine> {
        Ok(Engine::Gpu(Box::new(Device::new(state, model, rig, None)?)))
    }

    /// Whether a graphics device makes the steps; the state then has the points and grains of the last [`Self::read_back`].
    pub fn is_device(&self) -> bool {
        !matches!(self, Engine::Cpu | Engine::Mixture(_))
    }

    /// The device's clock for passes ([`::engine::gpu::DeviceContinuum::time_passes`]); on the CPU there are none.
    ///
    /// # Errors
    /// An adapter without timestamps.
    #[cfg(feature = "gpu")]
    pub fn time_passes(&mut self) -> Result<()> {
        if let Engine::Gpu(device) = self { device.time_passes() } else { Ok(()) }
    }

    /// What passes have taken since then.
    #[cfg(feature = "gpu")]
    pub fn pass_times(&self) -> &[::engine::gpu::PassTime] {
        if let Engine::Gpu(device) = self { device.pass_times() } else { &[] }
    }

    /// Computes the forces of all contacts, those on the loading plates among them, and adds this instant to the means of the
    /// records.
    pub(super) fn compute_forces(&mut self, state: &mut State, model: &Model, rig: &MpmTest) -> Result<()> {
        match self {
            Engine::Cpu => {
                state.press()?;
                state.collect(rig);
                state.note_start(model, rig);
            }
            Engine::Mixture(coupled) => {
                state.press()?;
                coupled.compute_forces(state, model)?;
                state.collect(rig);
                state.note_start(model, rig);
            }
            // a graphics device does both at the end of each step
            #[cfg(feature = "gpu")]
            Engine::Gpu(_) => {}
        }
        Ok(())
    }

    /// Time of a compression wave through a cell, s.
    pub(super) fn stable_step(&self, state: &State) -> f64 {
        match self {
            Engine::Cpu | Engine::Mixture(_) => state.continuum.stable_step(1.0),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.stable_step(),
        }
    }

    /// Largest stable step by the contacts between grains and walls, s; and the share of the contacts between points and grains
    /// or loading plates in the square of the highest angular frequency, 1/s².
    pub(super) fn bounds(&self, mixture: &mut Mixture, continuum: &Continuum, plates: &[LoadingPlate], slow: bool) -> (f64, f64) {
        match self {
            Engine::Cpu | Engine::Mixture(_) => mixture.bounds(continuum, plates, slow),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.bounds(plates),
        }
    }

    /// The rates of a cycle that the engine can compute instead of `found`; `None`: it can compute `found`.
    pub(super) fn rates(&self, found: Rates) -> Option<Rates> {
        match self {
            Engine::Cpu | Engine::Mixture(_) => None,
            #[cfg(feature = "gpu")]
            Engine::Gpu(_) => Some(Device::rates(found)),
        }
    }

    /// Makes one step; on a graphics device as many as it takes until the share `next` of the test is done.
    pub(super) fn steps(&mut self, state: &mut State, model: &Model, rig: &MpmTest, next: f64) -> Result<()> {
        match self {
            Engine::Cpu => state.step(rig),
            Engine::Mixture(coupled) => coupled.cycle(state, model, rig),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.steps(state, model, rig, state.ahead(rig, next)),
        }
    }

    /// Copies points and grains from a graphics device into the state. On the CPU nothing is to be done.
    ///
    /// # Errors
    /// A device that was lost; the state then holds the points of the last copy.
    pub fn read_back(&self, state: &mut State, model: &Model) -> Result<()> {
        match self {
            Engine::Cpu | Engine::Mixture(_) => Ok(()),
            #[cfg(feature = "gpu")]
            Engine::Gpu(device) => device.read_back(state, model),
        }
    }

    /// Memory for points, grid and grains, bytes.
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
    /// Computes the contact forces between loading plates and points.
    pub(super) fn press(&mut self) -> Result<()> {
        Ok(loading_plate::press(&mut self.plates, &mut self.continuum)?)
    }

    /// One step of points and loading plates on the CPU.
    fn step(&mut self, rig: &MpmTest) -> Result<()> {
        self.set_speeds(rig);
        self.continuum.step(self.dt)?;
        self.plates.iter_mut().for_each(|plate: &mut LoadingPlate| plate.advance(self.dt));
        self.time += self.dt;
        self.phase_time += self.dt;
        Ok(())
    }

    /// Sets the speed of each loading plate for the next step.
    pub(super) fn set_speeds(&mut self, rig: &MpmTest) {
        let extents = self.extents_now(rig);
        for ((plate, drive), drift) in self.plates.iter_mut().zip(&self.drives).zip(&mut self.drift) {
            let axis = plate.axis();
            plate.speed = drive.speed(0.0, plate, [extents[axis], face(rig, extents, axis)], self.dt, drift);
        }
    }

    /// Steps until the share `next` of the test is done; at most to the next search for the stable step, and in [`Phase::Settle`]
    /// at most the time of a wave through the specimen.
    #[cfg_attr(not(feature = "gpu"), allow(dead_code))]
    fn ahead(&self, rig: &MpmTest, next: f64) -> u64 {
        let steps = self.continuum.steps();
        let most = LOOK - steps % LOOK;
        let share = match &rig.test {
            Test::Free { duration: Some(duration), .. } => self.dt / duration,
            Test::Free { steps, .. } => 1.0 / steps.unwrap_or(1) as f64,
            _ if self.phase == Phase::Settle => return ((self.wave / self.dt).ceil() as u64).clamp(1, most),
            Test::Oedometer(s) | Test::Triaxial { specimen: s, .. } => self.rate * self.dt / s.axial_strain,
        };
        // rounding may have made a whole number of steps a little larger
        let wanted = (next - self.share(rig)) / share - 1e-6;
        (wanted.ceil().max(1.0) as u64).min(most)
    }
}
