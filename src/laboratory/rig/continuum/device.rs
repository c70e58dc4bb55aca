//! A test on a graphics device. The state is copied to the device once. After each batch of steps the forces on loading plates
//! and walls are copied back; points and grains only when a record or checkpoint needs them.

use super::specimen::has_overlaps;
use super::{Coupled, MpmTest, State};
use crate::error::Result;
use crate::model::Model;
use ::engine::coupling::{Cycle, Rates};
use ::engine::gpu::{self, Adapter, Saved};
use ::engine::mpm::LoadingPlate;

/// Points, loading plates and grains of a [`State`] on the device.
pub struct Device {
    gpu: gpu::DeviceContinuum,
    /// Working memory for the grains on the CPU, which makes the steps in which grains break.
    coupled: Option<Coupled>,
}

impl Device {
    /// Copies the state to the device. With `saved` from [`Self::save`] the run goes on with the same bits.
    ///
    /// # Errors
    /// No graphics adapter, too little memory, or a scene that the device cannot compute.
    pub fn new(state: &mut State, model: &Model, rig: &MpmTest, saved: Option<&Saved>) -> Result<Device> {
        let mut coupled = state.mixture.as_deref_mut().map(|mixture| Coupled::new(model, rig, mixture));
        if saved.is_none() {
            compute_forces(state, &mut coupled, model)?;
            state.collect(rig);
        }
        let coarse = coarse(state, coupled.as_ref(), model);
        let gpu = gpu::DeviceContinuum::begin(&state.continuum, &state.plates, &state.drift, coarse.as_ref(), saved)?;
        Ok(Device { gpu, coupled })
    }

    /// The device's own state, with which a resumed run goes on with the same bits.
    ///
    /// # Errors
    /// A device that was lost.
    pub fn save(&self) -> Result<Saved> {
        Ok(self.gpu.save()?)
    }

    /// As [`gpu::DeviceContinuum::time_passes`].
    ///
    /// # Errors
    /// The adapter has no timestamps.
    pub fn time_passes(&mut self) -> Result<()> {
        Ok(self.gpu.time_passes()?)
    }

    /// As [`gpu::DeviceContinuum::pass_times`].
    pub fn pass_times(&self) -> &[gpu::PassTime] {
        self.gpu.pass_times()
    }

    /// The graphics adapter.
    pub fn adapter(&self) -> &Adapter {
        self.gpu.adapter()
    }

    /// Makes the device lost, as after a failure of its driver.
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

    /// As [`super::Engine::bounds`].
    pub(super) fn bounds(&self, plates: &[LoadingPlate]) -> (f64, f64) {
        self.gpu.bounds(plates)
    }

    /// The rates nearest to `found` that a device can compute: one step of the continuum in a cycle, and at most [`MOST`] of the
    /// grains.
    pub(super) fn rates(found: Rates) -> Rates {
        Rates { grains: found.grains.min(MOST), continuum: 1 }
    }

    pub(super) fn read_back(&self, state: &mut State, model: &Model) -> Result<()> {
        self.gpu.read_back(&mut state.continuum)?;
        if let (Some(mixture), Some(coupled)) = (&mut state.mixture, &self.coupled) {
            self.gpu.read_grains((&model.physics, coupled.table()), mixture, &mut state.continuum)?;
        }
        Ok(())
    }

    /// Makes `n` steps with the loading plates' motion that the programme has set, and copies forces and means back. A grain
    /// above its limit ends the batch early: the CPU makes the step in which it breaks.
    pub(super) fn steps(&mut self, state: &mut State, model: &Model, rig: &MpmTest, n: u64) -> Result<()> {
        for (k, drive) in state.drives.iter().enumerate() {
            self.gpu.drive(k, *drive)?;
        }
        let extents = state.material(rig);
        self.gpu.material(extents, [true, has_overlaps(rig)]);
        let (dt, safety) = match model.physics.stepping.dt {
            Some(dt) => (dt, 0.0),
            None => (model.physics.stepping.safety * state.bound, model.physics.stepping.safety),
        };
        if let Some(mixture) = &state.mixture {
            self.gpu.rates(mixture.cycle.rates.grains);
        }
        let before = self.gpu.steps_done();
        let done = self.gpu.batch(n, dt, safety);
        let steps = self.gpu.steps_done() - before;
        if steps > 0 || self.gpu.broken() {
            self.take(state, rig, steps, extents);
        }
        done?;
        if self.gpu.passed() {
            return self.remove_fines(state, model);
        }
        if self.gpu.broken() {
            return self.break_grains(state, model, rig);
        }
        if self.gpu.crowded() {
            let saved = self.gpu.save()?;
            self.read_back(state, model)?;
            let coarse = coarse(state, self.coupled.as_ref(), model);
            self.gpu.reload(&state.continuum, &state.plates, &state.drift, coarse.as_ref(), Some(&saved))?;
        }
        Ok(())
    }

    /// Takes the results of a batch into the state, but for points and contacts.
    fn take(&self, state: &mut State, rig: &MpmTest, steps: u64, extents: [f64; 3]) {
        let c = &mut state.continuum;
        c.set_counters(self.gpu.steps_done(), c.stress_work(), self.gpu.wall_force());
        state.plates.clone_from_slice(self.gpu.plates());
        for (k, drift) in state.drift.iter_mut().enumerate() {
            *drift = self.gpu.drift(k);
        }
        let means = self.gpu.means();
        state.time += means.time;
        state.phase_time += means.time;
        if let Some(mixture) = &mut state.mixture {
            if let Some(fines) = &mut mixture.fines {
                fines.released += self.gpu.released();
            }
            self.gpu.walls_of(c, mixture);
            for (plate, wall) in state.plates.iter_mut().rev().zip(mixture.grains.walls.iter().rev()) {
                plate.others = [wall.reaction, wall.stiffness];
            }
            mixture.cycles += steps;
            mixture.grains.step += steps * u64::from(mixture.cycle.rates.grains);
            mixture.grains.time += means.time;
        }
        state.add(rig, &means, extents);
    }

    /// Makes the step in which grains break on the CPU, and copies the state with the daughters to the device.
    fn break_grains(&mut self, state: &mut State, model: &Model, rig: &MpmTest) -> Result<()> {
        self.read_back(state, model)?;
        let (Some(coupled), Some(mixture)) = (&mut self.coupled, &mut state.mixture) else { return Ok(()) };
        match self.gpu.within() {
            None => {
                coupled.renew(state, model);
                state.press()?;
                coupled.cycle(state, model, rig)?;
            }
            // the grain broke between two steps of the grains: the loading plates have made the whole step already
            Some((done, time)) => {
                let cycle = Cycle { time, rates: mixture.cycle.rates };
                mixture.grains.step += u64::from(done);
                mixture.grains.time += time * f64::from(done) / f64::from(cycle.rates.grains);
                coupled.renew(state, model);
                state.plates.iter_mut().for_each(LoadingPlate::withdraw);
                state.press()?;
                self.gpu.apply_point_forces(&mut state.continuum)?;
                coupled.finish_cycle(state, model, rig, cycle, done)?;
            }
        }
        compute_forces(state, &mut self.coupled, model)?;
        state.collect(rig);
        self.reload(state, model)
    }

    /// Takes out points from breakages that a grain has pushed through a loading plate, and copies the state without them to the
    /// device.
    fn remove_fines(&mut self, state: &mut State, model: &Model) -> Result<()> {
        self.read_back(state, model)?;
        if let Some(mixture) = &mut state.mixture {
            mixture.remove_fines_behind(&state.plates, &mut state.continuum);
        }
        state.press()?;
        state.continuum.clear_external_forces();
        self.reload(state, model)
    }

    /// Copies the state, whose forces are known, to the device.
    fn reload(&mut self, state: &State, model: &Model) -> Result<()> {
        let coarse = coarse(state, self.coupled.as_ref(), model);
        Ok(self.gpu.reload(&state.continuum, &state.plates, &state.drift, coarse.as_ref(), None)?)
    }
}

/// Most steps of the grains in one step of the continuum on a device.
const MOST: u32 = 64;

/// Computes the forces of all contacts on the CPU, as the device does at the end of a step.
fn compute_forces(state: &mut State, coupled: &mut Option<Coupled>, model: &Model) -> Result<()> {
    state.press()?;
    if let Some(coupled) = coupled {
        coupled.compute_forces(state, model)?;
    }
    state.continuum.clear_external_forces();
    Ok(())
}

fn coarse<'a>(state: &'a State, coupled: Option<&'a Coupled>, model: &'a Model) -> Option<gpu::CoarseGrains<'a>> {
    let (mixture, coupled) = (state.mixture.as_deref()?, coupled?);
    Some(gpu::CoarseGrains { physics: &model.physics, mixture, table: coupled.table() })
}
