//! The oedometer: one-dimensional compression of grains in a cylinder of fixed radius. The bottom platen is fixed; the top platen
//! follows the load programme (Ciantia et al. 2015, eq. 18) under stress servo, or moves at a constant inertial number.

mod record;
mod scene;

pub use record::stage_name;

use super::SpecimenTest;
use crate::error::Error;
use crate::model::{Compression, Model, Specimen};
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::record::quasi_static::Instant;
use crate::rig::cylinder::{self, Stresses, TOP, inertial_time, space};
use crate::scene::material::Named;
use crate::scene::view::View;
use engine::boundary::CylinderSpace;
use engine::boundary::servo_speed;
use engine::check::{self, Checked};
use engine::coupling::Embedded;
use engine::dem;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use engine::mpm::Continuum;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

impl Stresses {
    /// Difference of the stress from the target `target`, Pa, over the target: the larger one of both platens. Where the cylinder
    /// has friction, that of the top platen alone, for friction carries a part of the stress. In isotropic compression the stress
    /// on the cylinder counts as well.
    pub fn target_error(&self, target: f64, rig: &Compression) -> f64 {
        let of = |stress: f64| (stress / target - 1.0).abs();
        if rig.all_sides {
            return of(self.top).max(of(self.bottom)).max(of(self.horizontal));
        }
        if rig.specimen.wall_friction.cylinder > 0.0 { of(self.top) } else { of(self.top).max(of(self.bottom)) }
    }

    /// How far the specimen is from balance at the target: the larger one of [`Stresses::target_error`] and, where the cylinder has no
    /// friction, [`Stresses::platen_difference`].
    fn imbalance(&self, target: f64, rig: &Compression) -> f64 {
        let difference = if rig.specimen.wall_friction.cylinder > 0.0 { 0.0 } else { self.platen_difference() };
        self.target_error(target, rig).max(difference)
    }
}

/// The phase of a test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Phase {
    /// The specimen rests at the isotropic stress; the cylinder is fixed.
    Settle,
    /// The stress changes towards that of stage `k`.
    Load(usize),
    /// The stress of stage `k` is held until the specimen is at rest.
    Hold(usize),
    /// All stages are done.
    Done,
}

/// The state of a load programme.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Loading {
    /// The present phase.
    pub phase: Phase,
    /// Steps in the present phase.
    pub phase_steps: u64,
    /// Target vertical stress, Pa.
    pub target: f64,
    /// Height and radius at the start of loading, m.
    pub start: (f64, f64),
    /// Largest speed of the platen, m/s.
    pub(super) limit: f64,
    /// Largest vertical stress so far, Pa.
    peak: f64,
    /// Whether the target waits until the stress has followed.
    pub waits: bool,
    /// Material points from breakages, where the lost mass becomes points.
    pub fines: Option<Box<Embedded>>,
    /// Whether the present stage has become strain controlled. It stays so when breakages let the stress fall.
    strained: bool,
    /// Steps since the programme last advanced by what it does in one undisturbed step.
    idle: u64,
    /// What it has advanced since then, over what it does in one undisturbed step.
    advanced: f64,
}

/// Steps between two updates of the platen's largest speed.
const LOOK: u64 = 64;
/// Steps in which a platen under strain control takes up its speed.
const RAMP: u64 = 1024;
/// Least stress that counts for the speed of a platen under strain control, over the largest stress so far. The speed falls with
/// the stress; without this bound the platen would stand still where breakages have taken all stress away.
const FALLEN: f64 = 0.01;
/// A stage ends when the stress differs from its target by less than this share.
const CLOSE: f64 = 0.005;

impl Loading {
    /// Starts the test with grains at rest in the space `size`.
    ///
    /// # Errors
    /// A grid for the points from breakages that the material point method does not allow.
    fn begin(model: &Model, rig: &Compression, grains: Grains, size: CylinderSpace) -> Result<(Loading, State), Error> {
        let state = cylinder::start(model, &rig.specimen, grains, size);
        let fines = rig.fines.as_ref().map(|embedding| Embedded::new(&model.physics, embedding, size).map(Box::new)).transpose()?;
        let loading = Loading {
            phase: Phase::Settle,
            phase_steps: 0,
            target: rig.specimen.isotropic_stress,
            start: (size.height, size.radius),
            limit: 0.0,
            peak: rig.specimen.isotropic_stress,
            waits: false,
            fines,
            strained: false,
            idle: 0,
            advanced: 0.0,
        };
        Ok((loading, state))
    }

    /// Sets target and phase of the next step.
    ///
    /// # Errors
    /// [`Error::Stalled`] where the stress has not followed its target for `loading.max_wait_steps` steps.
    fn set_target(&mut self, model: &Model, rig: &Compression, state: &mut State, work: &Workspace) -> Result<(), Error> {
        let stages = &rig.loading.stages;
        match self.phase {
            Phase::Settle if self.phase_steps >= rig.specimen.settle_steps => {
                cylinder::begin(model, state, work);
                self.start = (space(state).height, space(state).radius);
                self.enter(Phase::Load(0));
            }
            Phase::Load(k) => {
                let stresses = Stresses::of(state);
                self.peak = self.peak.max(stresses.vertical());
                self.strained = self.strained(k, rig);
                if self.strained {
                    // under strain control the stress is a result, and the target follows it
                    self.target = stresses.vertical();
                    state.reference_stress = state.reference_stress.max(self.target);
                    if self.target >= stages[k] {
                        self.target = stages[k];
                        self.enter(Phase::Hold(k));
                    }
                    return Ok(());
                }
                self.waits = stresses.target_error(self.target, rig) > rig.loading.max_lag;
                let freedom = if self.waits { 0.0 } else { self.freedom(&stresses, rig) };
                self.advance_by(freedom, k, rig, state)?;
                if self.waits {
                    return Ok(());
                }
                let (increment, end) = (self.increment(rig) * freedom, stages[k]);
                if self.rising(k, rig) {
                    self.target = (self.target + increment).min(end);
                } else {
                    self.target = (self.target - increment).max(end);
                }
                state.reference_stress = state.reference_stress.max(self.target);
                if self.target == end {
                    self.enter(Phase::Hold(k));
                }
            }
            Phase::Hold(k) => {
                let close = Stresses::of(state).target_error(self.target, rig) < CLOSE;
                if close && self.phase_steps > LOOK {
                    self.enter(if k + 1 < stages.len() { Phase::Load(k + 1) } else { Phase::Done });
                } else {
                    self.advance_by(0.0, k, rig, state)?;
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Change of the target in one undisturbed step, Pa: eq. (18), or with the adaptive programme the share `load_increment` of the target.
    fn increment(&self, rig: &Compression) -> f64 {
        let asked = &rig.loading;
        match asked.load_increment {
            None => asked.rate * asked.sigma_ref * (1.0 + (self.target / asked.sigma_ref).max(1.0).ln()),
            Some(load_increment) => load_increment * self.target,
        }
    }

    /// Share of [`Self::increment`] by which the target changes: 1, or with the adaptive programme the less the further the specimen is from
    /// balance. So that programme is fast while the specimen is elastic and slow while grains break.
    fn freedom(&self, stresses: &Stresses, rig: &Compression) -> f64 {
        match rig.loading.load_increment {
            None => 1.0,
            Some(_) => (1.0 - stresses.imbalance(self.target, rig) / rig.loading.max_lag).max(0.0),
        }
    }

    /// Counts a step of stage `k` in which the programme has advanced by the share `freedom` of an undisturbed step.
    ///
    /// # Errors
    /// [`Error::Stalled`] after `loading.max_wait_steps` steps in which these shares do not make one undisturbed step.
    fn advance_by(&mut self, freedom: f64, k: usize, rig: &Compression, state: &State) -> Result<(), Error> {
        self.advanced += freedom;
        if self.advanced >= 1.0 {
            (self.idle, self.advanced) = (0, 0.0);
        }
        self.idle += 1;
        if self.idle <= rig.loading.max_wait {
            return Ok(());
        }
        let Stresses { top, bottom, horizontal } = Stresses::of(state);
        let what = format!(
            "loading stands still: in {} steps (loading.max_wait_steps) the stress has not come to its target of {:.4} kPa in stage {} (to {:.4} kPa): the platens show {:.4} \
             and {:.4} kPa, the cylinder {:.4} kPa. {}",
            rig.loading.max_wait,
            1e-3 * self.target,
            k + 1,
            1e-3 * rig.loading.stages[k],
            1e-3 * top,
            1e-3 * bottom,
            1e-3 * horizontal,
            if top < 0.5 * self.target {
                "The specimen bears less than half of it: grains may not touch the platen, or crush faster than it moves; raise loading.max_inertial_number, \
                 make the specimen denser, or unload to a higher stress"
            } else {
                "Raise loading.max_lag (the largest difference from the target that is no reason to wait) or damping.local"
            }
        );
        Err(Error::Stalled { step: state.step, what })
    }

    fn enter(&mut self, phase: Phase) {
        self.phase = phase;
        self.phase_steps = 0;
        self.strained = false;
        (self.idle, self.advanced) = (0, 0.0);
    }

    /// Whether stage `k` raises the stress.
    pub fn rising(&self, k: usize, rig: &Compression) -> bool {
        let before = if k == 0 { rig.specimen.isotropic_stress } else { rig.loading.stages[k - 1] };
        rig.loading.stages[k] > before
    }

    /// Whether the present step of stage `k` is first loading under strain control.
    fn strained(&self, k: usize, rig: &Compression) -> bool {
        // reloading becomes first loading when the target has reached the largest stress of the stages before; `strained` keeps
        // it so when breakages let the stress fall again
        rig.loading.strain_controlled.is_some() && self.rising(k, rig) && (self.strained || self.target >= rig.loading.before(k))
    }

    /// Inertial number of the top platen's motion, -.
    pub fn inertial_number(&self, rig: &Compression, state: &State) -> f64 {
        if self.limit > 0.0 { state.walls[TOP].speed.abs() / self.limit * rig.loading.max_inertial_number } else { 0.0 }
    }

    fn set_speed(&mut self, rig: &Compression, state: &mut State) {
        let size = space(state);
        if state.step.is_multiple_of(LOOK) || self.limit == 0.0 {
            let pressure = if self.strained { self.target.max(FALLEN * self.peak) } else { self.target };
            self.limit = rig.loading.max_inertial_number * size.height / inertial_time(state, pressure);
        }
        if let (Phase::Load(k), Some(inertial)) = (&self.phase, rig.loading.strain_controlled)
            && self.strained(*k, rig)
        {
            let ramp = (self.phase_steps as f64 / RAMP as f64).min(1.0);
            state.walls[TOP].speed = ramp * self.limit * inertial / rig.loading.max_inertial_number;
            return;
        }
        let force = self.target * size.platen_area();
        let w = &mut state.walls[TOP];
        w.speed = servo_speed(force, w.reaction, w.stiffness, rig.specimen.servo_gain, state.dt, self.limit);
    }
}

impl SpecimenTest for Loading {
    type Rig = Compression;

    fn start(model: &Model, rig: &Compression, grains: Grains, size: CylinderSpace) -> Result<(Loading, State), Error> {
        Loading::begin(model, rig, grains, size)
    }

    fn compute_forces(&mut self, model: &Model, state: &mut State, work: &mut Workspace) {
        dem::compute_forces(&model.physics, state, work);
        if let Some(fines) = &mut self.fines {
            fines.compute_forces(&model.physics, state, work);
        }
    }

    fn programme(&mut self, model: &Model, rig: &Compression, state: &mut State, work: &Workspace) -> Result<(), Error> {
        self.set_target(model, rig, state, work)
    }

    fn servo(&mut self, rig: &Compression, state: &mut State) {
        self.set_speed(rig, state);
        self.phase_steps += 1;
    }

    fn integrate(&mut self, model: &Model, state: &mut State, work: &mut Workspace) -> Result<(), Error> {
        match &mut self.fines {
            None => dem::integrate(&model.physics, state, work),
            Some(fines) => fines.advance(&model.physics, state, work)?,
        }
        Ok(())
    }

    fn settles(&self) -> bool {
        self.phase == Phase::Settle
    }

    fn check(&self, model: &Model, rig: &Compression, state: &State) -> Checked {
        cylinder::check(&model.physics, &rig.specimen, state, model.records.energy)?;
        check::counters("steps", &[self.phase_steps])?;
        if let Phase::Load(k) | Phase::Hold(k) = self.phase {
            check::below("stage", k as u64, rig.loading.stages.len())?;
        }
        check::positive("stresses of the programme", [self.target, self.peak])?;
        check::positive("sizes at the start", [self.start.0, self.start.1])?;
        check::not_negative("speed of the platen", [self.limit])?;
        match (&self.fines, &rig.fines) {
            (Some(fines), Some(embedding)) => fines.check(&model.physics, embedding, state),
            (None, None) => Ok(()),
            _ => Err("lost mass becomes points in another way than in the scene".into()),
        }
    }

    fn is_over(&self) -> bool {
        self.phase == Phase::Done
    }

    fn due(&self, model: &Model, rig: &Compression, recorder: &mut Recorder, state: &State) -> Option<Due> {
        let due = recorder.due(model, rig, self, state);
        if recorder.stage_end(rig, self) { Some(Due::Full) } else { due }
    }

    fn held(&self, rig: &Compression, state: &State) -> Option<Instant> {
        matches!(self.phase, Phase::Load(_) | Phase::Hold(_)).then(|| Instant {
            target: self.target,
            held: Stresses::of(state).vertical(),
            inertial_number: self.inertial_number(rig, state),
            waits: self.waits,
        })
    }

    fn moment(&self, rig: &Compression, state: &State) -> Moment {
        record::moment(rig, self, state)
    }

    fn target(&self) -> Option<f64> {
        Some(self.target)
    }

    fn fines(&self) -> Option<&Continuum> {
        self.fines.as_deref().map(Embedded::continuum)
    }

    fn describe(&self, rig: &Compression, state: &State) -> (f64, String) {
        // eq. (18) makes steps grow nearly in proportion to stress
        let end = rig.loading.stages.iter().copied().fold(0.0, f64::max);
        let (v, n) = (Stresses::of(state).vertical(), state.grains.len());
        let share = (self.target / end).clamp(0.0, 1.0);
        (share, format!("σ_v {:.1} kPa of {:.0}, {n} grains, {} events", v * 1e-3, end * 1e-3, state.crush_events))
    }

    fn summary(&self, rig: &Compression, recorder: &Recorder, put: &mut dyn FnMut(&str, Value)) {
        let largest = rig.loading.stages.iter().copied().fold(rig.specimen.isotropic_stress, f64::max);
        put("max_stress_kPa", json!(largest * 1e-3));
        put("diameter_mm", json!(2e3 * self.start.1));
        put("height_mm", json!(1e3 * self.start.0));
        put("k0_final", json!(recorder.k0));
    }

    fn specimen(rig: &Compression) -> &Specimen {
        &rig.specimen
    }

    fn specimen_mut(rig: &mut Compression) -> &mut Specimen {
        &mut rig.specimen
    }

    fn largest_stress(rig: &Compression) -> f64 {
        rig.loading.stages.iter().copied().fold(0.0, f64::max)
    }

    fn of_scene(view: &View<'_>, named: &[Named]) -> Option<Compression> {
        view.oedometer(named)
    }
}
