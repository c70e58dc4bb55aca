//! Drained triaxial compression of a cylindrical specimen of grains (Ciantia et al. 2015, Fig. 12). The cylinder holds the cell
//! pressure under servo, the bottom platen is fixed, and the top platen moves at a constant inertial number.

mod record;
mod scene;

use super::SpecimenTest;
use crate::error::Error;
use crate::model::{Model, Specimen, Triaxial};
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::record::quasi_static::Instant;
use crate::rig::cylinder::{self, Stresses, TOP, inertial_time, space};
use crate::scene::material::Named;
use crate::scene::view::View;
use engine::boundary::CylinderSpace;
use engine::boundary::servo_speed;
use engine::check::{self, Checked};
use engine::dem::observables;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// The phase of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Phase {
    /// The specimen comes to rest at the cell pressure on all sides.
    Settle,
    /// The top platen moves.
    Shear,
    /// The final axial strain is reached.
    Done,
}

/// The state of a test, besides that of its grains and walls.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shearing {
    /// The present phase.
    pub phase: Phase,
    /// Steps in the present phase.
    phase_steps: u64,
    /// Height and radius at the start of shear, m.
    pub start: (f64, f64),
    /// Axial strain rate that has the inertial number asked for, 1/s.
    rate: f64,
}

/// Steps between two updates of the strain rate.
const LOOK: u64 = 64;
/// Steps in which the platen takes up its speed.
const RAMP: u64 = 2048;
/// Largest radial strain rate of the cylinder under servo over the axial strain rate.
const SHELL: f64 = 4.0;
/// Largest difference of a stress from the cell pressure, over the cell pressure, at rest.
const STRESS_AT_REST: f64 = 0.005;
/// Unbalanced ratio below which grains count as at rest.
const UNBALANCED_AT_REST: f64 = 2e-3;
/// Steps after which settling is given up, over those of `specimen.settle_steps`.
const SETTLE_AT_MOST: u64 = 100;

impl Shearing {
    /// Axial strain since the start of shear, compression positive.
    pub fn axial_strain(&self, state: &State) -> f64 {
        1.0 - space(state).height / self.start.0
    }

    /// Sets the phase of the next step.
    fn set_phase(&mut self, model: &Model, rig: &Triaxial, state: &mut State, work: &Workspace) -> Result<(), Error> {
        match self.phase {
            Phase::Settle if self.at_rest(model, rig, state, work) => {
                cylinder::begin(model, state, work);
                let size = space(state);
                self.start = (size.height, size.radius);
                (self.phase, self.phase_steps) = (Phase::Shear, 0);
            }
            Phase::Settle if self.phase_steps > SETTLE_AT_MOST * rig.specimen.settle_steps.max(LOOK) => {
                let Stresses { top, bottom, horizontal } = Stresses::of(state);
                let what = format!(
                    "the specimen did not come to rest at the cell pressure of {:.1} kPa: platens {:.1} and {:.1} kPa, shell {:.1} kPa",
                    1e-3 * rig.specimen.isotropic_stress,
                    1e-3 * top,
                    1e-3 * bottom,
                    1e-3 * horizontal
                );
                return Err(Error::Stalled { step: state.step, what });
            }
            Phase::Shear if self.axial_strain(state) >= rig.shear.axial_strain => self.phase = Phase::Done,
            _ => {}
        }
        Ok(())
    }

    fn at_rest(&self, model: &Model, rig: &Triaxial, state: &State, work: &Workspace) -> bool {
        if self.phase_steps < rig.specimen.settle_steps || !self.phase_steps.is_multiple_of(LOOK) || self.phase_steps == 0 {
            return false;
        }
        let Stresses { top, bottom, horizontal } = Stresses::of(state);
        [top, bottom, horizontal].iter().all(|s| (s / rig.specimen.isotropic_stress - 1.0).abs() < STRESS_AT_REST)
            && observables::sums(&model.physics, state, work).unbalanced_ratio(state.grains.len()) < UNBALANCED_AT_REST
    }

    fn set_speeds(&mut self, rig: &Triaxial, state: &mut State) {
        let (size, stresses) = (space(state), Stresses::of(state));
        let cell = rig.specimen.isotropic_stress;
        if self.phase_steps.is_multiple_of(LOOK) || self.rate == 0.0 {
            let mean = (stresses.vertical() + 2.0 * stresses.horizontal) / 3.0;
            self.rate = rig.shear.inertial_number / inertial_time(state, mean.max(0.1 * cell));
        }
        let (gain, dt) = (rig.specimen.servo_gain, state.dt);
        let limit = SHELL * self.rate;
        let shell = &mut state.walls[cylinder::CYLINDER];
        shell.speed = servo_speed(cell * size.shell_area(), shell.reaction, shell.stiffness, gain, dt, limit * size.radius);
        let top = &mut state.walls[TOP];
        top.speed = match self.phase {
            Phase::Settle => servo_speed(cell * size.platen_area(), top.reaction, top.stiffness, gain, dt, limit * size.height),
            Phase::Shear => self.rate * size.height * (self.phase_steps as f64 / RAMP as f64).min(1.0),
            Phase::Done => 0.0,
        };
    }
}

impl SpecimenTest for Shearing {
    type Rig = Triaxial;

    fn start(model: &Model, rig: &Triaxial, grains: Grains, size: CylinderSpace) -> Result<(Shearing, State), Error> {
        let state = cylinder::start(model, &rig.specimen, grains, size);
        Ok((Shearing { phase: Phase::Settle, phase_steps: 0, start: (size.height, size.radius), rate: 0.0 }, state))
    }

    fn programme(&mut self, model: &Model, rig: &Triaxial, state: &mut State, work: &Workspace) -> Result<(), Error> {
        self.set_phase(model, rig, state, work)
    }

    fn servo(&mut self, rig: &Triaxial, state: &mut State) {
        self.set_speeds(rig, state);
        self.phase_steps += 1;
    }

    fn settles(&self) -> bool {
        self.phase == Phase::Settle
    }

    fn check(&self, model: &Model, rig: &Triaxial, state: &State) -> Checked {
        cylinder::check(&model.physics, &rig.specimen, state, model.records.energy)?;
        check::counters("steps", &[self.phase_steps])?;
        check::positive("sizes at the start", [self.start.0, self.start.1])?;
        check::not_negative("strain rate", [self.rate])
    }

    fn is_over(&self) -> bool {
        self.phase == Phase::Done
    }

    fn due(&self, _: &Model, rig: &Triaxial, recorder: &mut Recorder, state: &State) -> Option<Due> {
        recorder.due_in_shear(rig, self, state)
    }

    /// In shear the shell holds the cell pressure.
    fn held(&self, rig: &Triaxial, state: &State) -> Option<Instant> {
        (self.phase == Phase::Shear).then(|| Instant {
            target: rig.specimen.isotropic_stress,
            held: Stresses::of(state).horizontal,
            inertial_number: rig.shear.inertial_number,
            waits: false,
        })
    }

    fn moment(&self, rig: &Triaxial, state: &State) -> Moment {
        record::moment(rig, self, state)
    }

    fn describe(&self, rig: &Triaxial, state: &State) -> (f64, String) {
        let (strain, s, n) = (self.axial_strain(state), Stresses::of(state), state.grains.len());
        let share = (strain / rig.shear.axial_strain).clamp(0.0, 1.0);
        let q = 1e-3 * (s.vertical() - s.horizontal);
        (share, format!("ε_a {:.2} % of {:.0}, q {q:.1} kPa, {n} grains", 100.0 * strain, 100.0 * rig.shear.axial_strain))
    }

    fn summary(&self, rig: &Triaxial, _: &Recorder, put: &mut dyn FnMut(&str, Value)) {
        put("cell_pressure_kPa", json!(rig.specimen.isotropic_stress * 1e-3));
        put("diameter_mm", json!(2e3 * self.start.1));
        put("height_mm", json!(1e3 * self.start.0));
    }

    fn specimen(rig: &Triaxial) -> &Specimen {
        &rig.specimen
    }

    fn specimen_mut(rig: &mut Triaxial) -> &mut Specimen {
        &mut rig.specimen
    }

    /// Dense sand bears some four times the cell pressure.
    fn largest_stress(rig: &Triaxial) -> f64 {
        4.0 * rig.specimen.isotropic_stress
    }

    fn of_scene(view: &View<'_>, named: &[Named]) -> Option<Triaxial> {
        Some(Triaxial { specimen: view.specimen(&named[0])?, shear: view.shear() })
    }
}
