//! A free scene of grains, or a test on a cylindrical specimen of grains, between two steps.

use super::super::{CLOSE_LOOK, LOOK, multiplies, watch};
use super::{DRIVEN, GAIN, STOPPED, System, WallNow, checked};
use crate::error::Result;
use crate::gradation::Gradation;
use crate::interrupt::stop_asked;
use crate::model::{Model, Rig};
use crate::record::contacts::{self, Contact};
use crate::record::cylinder::Recorder;
use crate::record::{assembly as free, breakages, gradations, specimen};
use crate::rig::assembly;
use crate::rig::cylinder::{Stresses, space};
use crate::rig::preparation::Preparation;
use crate::testing::Test;
use engine::boundary::{Drive, Wall, WallShape};
use engine::dem::event::Breakage;
use engine::dem::{State, Workspace, observables};
use engine::mpm::Points;
use table::Row;

/// Grains and walls, with all that changes from step to step.
pub struct Grains {
    /// The test on a specimen; `None` in a free scene.
    test: Option<Test>,
    state: State,
    work: Workspace,
    /// Whether the walls follow the program and not the scene.
    driven: bool,
    /// Walls before the first step.
    walls_at_start: Vec<WallShape>,
    /// Of each breakage so far, with the vertical stress, Pa, at which it happened (NaN in a free scene).
    breakages: Vec<(Breakage, f64)>,
    /// Of a specimen: what rows need from before the test.
    recorder: Recorder,
    initial: Option<Gradation>,
    /// [`watch::first_step_of_grains`].
    first_step: f64,
    /// Number of grains at the last look at all of them.
    looked_at: usize,
}

impl Grains {
    /// The first instant.
    pub fn begin(model: &Model, given: Option<(engine::grains::Grains, engine::boundary::CylinderSpace)>) -> Result<Grains> {
        let (test, mut state, recorder, initial) = match (&model.rig, model.rig.specimen()) {
            (Rig::Assembly(rig), _) => (None, assembly::start(model, rig), Recorder::default(), None),
            (_, Some(rig)) => {
                let (grains, size) = match given {
                    Some(given) => given,
                    None => prepared(model, rig)?,
                };
                let recorder = Recorder { mass: grains.mass_and_volume().0, ..Recorder::default() };
                let initial = gradations::initial(model, &grains);
                let (test, state) = Test::start(model, grains, size)?;
                (Some(test), state, recorder, Some(initial))
            }
            _ => unreachable!("tests of grains alone are let in"),
        };
        let work = Workspace::sorted(&model.physics, &mut state);
        let mut now = Grains {
            test,
            work,
            driven: false,
            walls_at_start: Vec::new(),
            breakages: Vec::new(),
            recorder,
            initial,
            first_step: watch::first_step_of_grains(model),
            looked_at: state.grains.len(),
            state,
        };
        now.look(model)?;
        while now.test.as_ref().is_some_and(Test::settles) {
            if stop_asked() {
                return Err(STOPPED);
            }
            now.step(model)?;
        }
        now.walls_at_start = now.state.walls.iter().map(|wall| wall.shape).collect();
        Ok(now)
    }

    /// Computes the forces of this instant, and what the programme makes of them.
    fn look(&mut self, model: &Model) -> Result<()> {
        let Grains { test, state, work, driven, first_step, .. } = self;
        match (test, &model.rig) {
            (Some(test), _) => {
                test.compute_forces(model, state, work);
                if !*driven {
                    test.programme(model, state, work)?;
                }
            }
            (None, Rig::Assembly(rig)) => {
                assembly::compute_forces(model, state, work);
                watch::step(model, rig, state, work)?;
                watch::slow_grains(model, state, work, *first_step)?;
            }
            _ => {}
        }
        Ok(())
    }

    /// Moves grains and walls, breaks grains, and looks whether the state still means something, as a run does.
    fn go(&mut self, model: &Model) -> Result<()> {
        match (&mut self.test, self.driven) {
            (Some(test), false) => test.servo(&model.rig, &mut self.state),
            (Some(_), true) => {
                let size = space(&self.state);
                let area = |_: &State, wall: &Wall| of_specimen(wall, size);
                assembly::drive(model, &mut self.state, &self.work, area);
            }
            (None, _) => assembly::drive(model, &mut self.state, &self.work, assembly::area),
        }
        let Grains { test, state, work, .. } = self;
        match test {
            Some(test) => test.integrate(model, state, work)?,
            None => engine::dem::integrate(&model.physics, state, work),
        }
        let sigma_v = if test.is_some() { Stresses::of(state).vertical() } else { f64::NAN };
        self.breakages.extend(work.breakages.iter().map(|b| (b.clone(), sigma_v)));
        let many = multiplies(self.looked_at, state.grains.len());
        if many || state.step.is_multiple_of(CLOSE_LOOK) {
            self.looked_at = state.grains.len();
            // the ledger of a specimen is opened when it rests
            if test.is_none() || state.ledger.start[0] > 0.0 {
                watch::energy(state, model.physics.gravity)?;
            }
        }
        if many || state.step.is_multiple_of(LOOK) {
            watch::grains(state, model.records.stop_at_overlap, state.step)?;
        }
        Ok(())
    }

    /// Area on which the stress of a wall acts, m²; 0 where it has none.
    fn area(&self, wall: &Wall) -> f64 {
        if self.test.is_some() { of_specimen(wall, space(&self.state)) } else { assembly::area(&self.state, wall) }
    }
}

impl System for Grains {
    fn step(&mut self, model: &Model) -> Result<()> {
        self.go(model)?;
        self.look(model)
    }

    fn steps(&self) -> u64 {
        self.state.step
    }

    fn time(&self) -> f64 {
        self.state.time
    }

    fn dt(&self) -> f64 {
        self.state.dt
    }

    fn crush_events(&self) -> u64 {
        self.state.crush_events
    }

    fn stage(&self, model: &Model) -> &'static str {
        match &self.test {
            Some(_) if self.driven => DRIVEN,
            Some(test) => test.moment(&model.rig, &self.state).stage,
            None => "load",
        }
    }

    fn driven(&self) -> bool {
        self.driven
    }

    fn is_over(&self, model: &Model) -> bool {
        match (&self.test, &model.rig) {
            (Some(test), _) => !self.driven && test.is_over(),
            (None, Rig::Assembly(rig)) => assembly::done(rig, &self.state),
            _ => false,
        }
    }

    fn drive(&mut self, model: &Model, wall: usize, drive: Drive) -> Result<()> {
        let specimen = model.rig.specimen();
        let plane = matches!(self.state.walls[wall].shape, WallShape::Plane { .. });
        let drive = checked(drive, specimen.map_or(GAIN, |rig| rig.servo_gain), specimen.is_none() && plane)?;
        if !self.driven && self.test.is_some() {
            self.state.walls.iter_mut().for_each(|w| w.drive = Drive::Fixed);
        }
        self.driven = true;
        self.state.walls[wall].drive = drive;
        Ok(())
    }

    fn grains(&self) -> Option<&State> {
        Some(&self.state)
    }

    fn points(&self) -> Option<&Points> {
        Some(self.test.as_ref()?.fines()?.points())
    }

    fn wall_names(&self, _: &Model) -> Vec<String> {
        contacts::names(&self.state.walls, self.test.is_some())
    }

    fn wall(&self, _: &Model, wall: usize) -> WallNow {
        let w = &self.state.walls[wall];
        WallNow {
            shape: w.shape,
            displacement: w.way_since(&self.walls_at_start[wall]),
            velocity: if let (Drive::Velocity(told), true) = (w.drive, self.driven) { told } else { w.speed },
            force: w.reaction,
            shear_z: w.shear_z,
            work: w.work,
            area: Some(self.area(w)).filter(|area| *area > 0.0),
        }
    }

    fn force(&self, model: &Model, grain: usize) -> [f64; 3] {
        observables::force_and_torque(grain, &model.physics, &self.state, &self.work).0
    }

    fn contacts(&self) -> Vec<Contact> {
        contacts::of_grains(&self.state)
    }

    fn volume(&self, _: &Model) -> Option<f64> {
        self.test.is_some().then(|| space(&self.state).volume())
    }

    fn breakages(&self) -> Vec<Row> {
        self.breakages.iter().map(|(b, sigma_v)| breakages::row(b, b.step, *sigma_v)).collect()
    }

    fn row(&mut self, model: &Model) -> Result<Row> {
        let (Some(test), Some(initial)) = (&self.test, &self.initial) else {
            return Ok(free::history_row(model, &self.state, &self.work));
        };
        let mut moment = test.moment(&model.rig, &self.state);
        if self.driven {
            (moment.stage, moment.target) = (DRIVEN, f64::NAN);
        }
        self.recorder.row(model, moment, &self.state, &self.work, initial)
    }
}

/// Area of a wall of a specimen, m².
fn of_specimen(wall: &Wall, size: engine::boundary::CylinderSpace) -> f64 {
    match wall.shape {
        WallShape::Plane { .. } => size.platen_area(),
        WallShape::Cylinder { .. } => size.shell_area(),
    }
}

/// A specimen as the scene asks for it: its grains at rest, and the space between its walls.
fn prepared(model: &Model, rig: &crate::model::Specimen) -> Result<(engine::grains::Grains, engine::boundary::CylinderSpace)> {
    let (mut preparation, mut state) = Preparation::start(model, rig);
    let mut work = Workspace::sorted(&model.physics, &mut state);
    while !preparation.advance(model, rig, &mut state, &mut work)? {
        if stop_asked() {
            return Err(STOPPED);
        }
    }
    Ok(specimen::at_rest(&state, &model.physics.materials))
}
