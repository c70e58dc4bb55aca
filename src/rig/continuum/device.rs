//! A test on a graphics device: the state goes there once; a look brings back what platens feel, and points come when they are asked for.

use super::{Rig, State};
use crate::error::Result;
use crate::gpu::{self, Adapter, Saved};
use crate::model::Model;

/// The points and platens of a [`State`] on the device.
pub struct Device {
    gpu: gpu::Continuum,
}

impl Device {
    /// Takes the state over; with what [`Self::save`] gave, to the bit.
    ///
    /// # Errors
    /// No adapter, one without room, what the device lacks.
    pub fn new(state: &mut State, rig: &Rig, saved: Option<&Saved>) -> Result<Device> {
        if saved.is_none() {
            // as after a step there: platens have felt, and the instant counts
            state.press()?;
            state.continuum.drop_forces();
            state.collect(rig);
        }
        Ok(Device { gpu: gpu::Continuum::begin(&state.continuum, &state.platens, &state.drift, saved)? })
    }

    /// What it needs to go on with the same bits.
    ///
    /// # Errors
    /// A device that was lost.
    pub fn save(&self) -> Result<Saved> {
        self.gpu.save()
    }

    pub fn adapter(&self) -> &Adapter {
        self.gpu.adapter()
    }

    /// What happens when a device goes away.
    #[cfg(test)]
    pub(crate) fn lose(&self) {
        self.gpu.lose();
    }

    pub(super) fn bytes(&self) -> u64 {
        self.gpu.bytes()
    }

    pub(super) fn stable_step(&self) -> f64 {
        self.gpu.stable_step()
    }

    pub(super) fn read_back(&self, state: &mut State) -> Result<()> {
        self.gpu.read_back(&mut state.continuum)
    }

    /// `n` steps with the drives that the programme has set, and what they leave.
    pub(super) fn steps(&mut self, state: &mut State, model: &Model, rig: &Rig, n: u64) -> Result<()> {
        for (k, drive) in state.drives.iter().enumerate() {
            self.gpu.drive(k, *drive)?;
        }
        let (extents, scale) = state.material(rig);
        self.gpu.material(extents, scale);
        let (dt, safety) = match model.stepping.dt {
            Some(dt) => (dt, 0.0),
            None => (model.stepping.safety * state.bound, model.stepping.safety),
        };
        let before = self.gpu.steps_done();
        let done = self.gpu.batch(n, dt, safety);
        if self.gpu.steps_done() == before {
            return done;
        }
        let c = &mut state.continuum;
        c.set_counters(self.gpu.steps_done(), c.stress_work(), self.gpu.wall_force());
        state.platens.clone_from_slice(self.gpu.platens());
        for (k, drift) in state.drift.iter_mut().enumerate() {
            *drift = self.gpu.drift(k);
        }
        let means = self.gpu.means();
        state.time += means.time;
        state.phase_time += means.time;
        state.add(rig, &means, extents, scale);
        done
    }
}
