//! A test of grains that a program makes step by step, without a folder and without records: [`Simulation`]. Its walls follow the
//! programme of the scene until the program drives them.

use super::of_scene::settle_density;
use super::{CLOSE_LOOK, LOOK, fresh_work, multiplies, pool, watch};
use crate::error::{Error, Result};
use crate::gradation::Gradation;
use crate::interrupt::stop_asked;
use crate::model::{Model, Rig};
use crate::record::contacts::{self, Contact};
use crate::record::cylinder::Recorder;
use crate::record::{assembly as free, breakages, gradations, specimen};
use crate::rig::assembly;
use crate::rig::cylinder::{Stresses, inertial_time, space};
use crate::rig::preparation::Preparation;
use crate::scene::{self, Scene};
use crate::testing::Test;
use engine::boundary::{Drive, Wall, WallShape};
use engine::dem::event::Breakage;
use engine::dem::{State, Workspace, observables};
use std::time::{Duration, Instant};
use table::Row;

/// Share of the imbalance that a wall under servo removes in a step, where the scene says none: the default of `wall.gain`.
const GAIN: f64 = 0.2;

/// A free scene of grains, or a test on a specimen of grains, at the instant when the forces are known and nothing has moved yet: places,
/// forces and what is measured belong together, as in the records of a run. A step moves grains and walls, breaks grains, and computes
/// the next forces; it makes the same bits as the step of a run.
pub struct Simulation {
    model: Model,
    pool: rayon::ThreadPool,
    now: Now,
}

/// Everything that changes.
struct Now {
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
    /// Whether a step has failed, so that no other can follow.
    failed: bool,
}

impl Simulation {
    /// The simulation of a scene at its first instant: free scenes at time 0, tests on a specimen when the specimen, which is made now or
    /// read from the file that the scene names, rests under its isotropic stress and the programme begins. `threads`: `None` for one for
    /// each core; results do not depend on it.
    ///
    /// # Errors
    /// A scene that is no test of grains alone, or asks for what cannot be; a specimen that cannot be made; a wish to stop meanwhile.
    pub fn of(scene: &Scene, threads: Option<usize>) -> Result<Simulation> {
        let mut model = scene::model(scene)?;
        if let Rig::GrainCrushing(_) | Rig::Continuum(_) = model.rig {
            let message = "must be assembly (of grains alone), oedometer, triaxial or isotropic to be made step by step";
            return Err(Error::input(scene.name(), "kind", scene.get("kind").map(ToString::to_string), message));
        }
        settle_density(scene, &mut model, threads, &mut |_| ())?;
        let pool = pool(threads)?;
        let given = scene.specimen().map(|file| specimen::read(&file, &model.physics.materials)).transpose()?;
        let now = pool.install(|| Now::begin(&model, given))?;
        Ok(Simulation { model, pool, now })
    }

    /// Makes up to `steps` steps, and no more once the time `most` is over; gives their number. Goes on beyond the end of the scene's
    /// programme.
    ///
    /// # Errors
    /// A step that cannot be made, or after which the state means nothing ([`Error::Unstable`]); none can follow then.
    pub fn step(&mut self, steps: u64, most: Duration) -> Result<u64> {
        let Simulation { model, pool, now } = self;
        let begun = Instant::now();
        pool.install(|| {
            for made in 0..steps {
                if made > 0 && begun.elapsed() >= most {
                    return Ok(made);
                }
                now.step(model)?;
            }
            Ok(steps)
        })
    }

    /// Lets the wall of this index move as told from the next step on. In a test on a specimen the program takes over with the first call:
    /// the programme of the scene is over, and the other walls stand still until they are told. The `area` of a stress counts in free
    /// scenes on planes alone; elsewhere it is the present one. A gain of 0 stands for that of the scene.
    ///
    /// # Errors
    /// A wall that there is not; numbers that no wall can be driven by.
    pub fn drive(&mut self, wall: usize, drive: Drive) -> Result<()> {
        let specimen = self.model.rig.specimen();
        let walls = self.now.state.walls.len();
        let wrong = |key: &str, value: String, message: &str| Err(Error::input("drive", key, Some(value), message));
        if wall >= walls {
            return wrong("wall", wall.to_string(), &format!("there are {walls} walls, counted from 0"));
        }
        let drive = match drive {
            Drive::Fixed | Drive::Programme => Drive::Fixed,
            Drive::Velocity(v) if v.is_finite() => Drive::Velocity(v),
            Drive::Velocity(v) => return wrong("velocity", v.to_string(), "must be finite"),
            Drive::Stress { stress, area, gain, fastest } => {
                let gain = if gain == 0.0 { specimen.map_or(GAIN, |rig| rig.servo_gain) } else { gain };
                let plane = matches!(self.now.state.walls[wall].shape, WallShape::Plane { .. });
                if !stress.is_finite() {
                    return wrong("stress", stress.to_string(), "must be finite");
                }
                if specimen.is_none() && plane && !(area > 0.0 && area.is_finite()) {
                    return wrong("area", area.to_string(), "must be above 0: a plane of a free scene has no area of its own");
                }
                if !(gain > 0.0 && gain <= 1.0) {
                    return wrong("gain", gain.to_string(), "must be above 0 and at most 1");
                }
                if let Some(v) = fastest.filter(|v| v.is_nan() || *v <= 0.0) {
                    return wrong("max_velocity", v.to_string(), "must be above 0");
                }
                Drive::Stress { stress, area, gain, fastest }
            }
        };
        if !self.now.driven && self.now.test.is_some() {
            self.now.state.walls.iter_mut().for_each(|w| w.drive = Drive::Fixed);
        }
        self.now.driven = true;
        self.now.state.walls[wall].drive = drive;
        Ok(())
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Grains, contacts and walls at this instant.
    pub fn state(&self) -> &State {
        &self.now.state
    }

    /// Whether the program drives walls.
    pub fn driven(&self) -> bool {
        self.now.driven
    }

    /// Whether the programme of the scene is over: in a free scene its steps or its duration. Never in a test whose walls the program
    /// drives.
    pub fn is_over(&self) -> bool {
        match (&self.now.test, &self.model.rig) {
            (Some(test), _) => !self.now.driven && test.is_over(),
            (None, Rig::Assembly(rig)) => assembly::done(rig, &self.now.state),
            _ => false,
        }
    }

    /// Names of the walls: `bottom`, `top`, `cylinder` of a specimen, `wall_0`, `wall_1`, … in a free scene.
    pub fn wall_names(&self) -> Vec<String> {
        contacts::names(&self.now.state.walls, self.now.test.is_some())
    }

    /// Way of a wall towards the grains since the first instant, m; of a cylinder the decrease of its radius.
    pub fn way(&self, wall: usize) -> f64 {
        self.now.state.walls[wall].way_since(&self.now.walls_at_start[wall])
    }

    /// Area over which the reaction of a wall is a stress, m²; `None` for a plane of a free scene that is not under servo.
    pub fn wall_area(&self, wall: usize) -> Option<f64> {
        Some(self.now.area(&self.now.state.walls[wall])).filter(|area| *area > 0.0)
    }

    /// Force, N, on the grain at an index of the arrays, from contacts, gravity and points, before damping.
    pub fn force(&self, grain: usize) -> [f64; 3] {
        observables::force_and_torque(grain, &self.model.physics, &self.now.state, &self.now.work).0
    }

    /// Contacts between grains and of grains with walls, in the order of ids.
    pub fn contacts(&self) -> Vec<Contact> {
        contacts::of_grains(&self.now.state)
    }

    /// Volume between the walls of a specimen, m³; `None` in a free scene.
    pub fn volume(&self) -> Option<f64> {
        self.now.test.is_some().then(|| space(&self.now.state).volume())
    }

    /// Time scale of grain rearrangement at the pressure `pressure`, Pa ([`inertial_time`]), s: the strain rate times this is the inertial
    /// number.
    pub fn inertial_time(&self, pressure: f64) -> f64 {
        inertial_time(&self.now.state, pressure)
    }

    /// All breakages since the first instant, as the rows of `breakage.csv`.
    pub fn breakages(&self) -> Vec<Row> {
        self.now.breakages.iter().map(|(b, sigma_v)| breakages::row(b, b.step, *sigma_v)).collect()
    }

    /// The row of `history.csv` for this instant: stresses, strains, void ratios, gradation and, where the scene keeps it, the energy
    /// ledger. Where the program drives the walls of a specimen its stage is `driven`, without a target.
    ///
    /// # Errors
    /// [`Error::Failed`]: the gradation is coarser than at the start.
    pub fn row(&mut self) -> Result<Row> {
        let Simulation { model, now, .. } = self;
        let (Some(test), Some(initial)) = (&now.test, &now.initial) else {
            return Ok(free::history_row(model, &now.state, &now.work));
        };
        let mut moment = test.moment(&model.rig, &now.state);
        if now.driven {
            (moment.stage, moment.target) = ("driven", f64::NAN);
        }
        now.recorder.row(model, moment, &now.state, &now.work, initial)
    }
}

impl Now {
    /// The first instant.
    fn begin(model: &Model, given: Option<(engine::grains::Grains, engine::boundary::CylinderSpace)>) -> Result<Now> {
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
        let work = fresh_work(model, &mut state);
        let mut now = Now {
            test,
            work,
            driven: false,
            walls_at_start: Vec::new(),
            breakages: Vec::new(),
            recorder,
            initial,
            first_step: watch::first_step_of_grains(model),
            looked_at: state.grains.len(),
            failed: false,
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
        let Now { test, state, work, driven, first_step, .. } = self;
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

    /// One step.
    fn step(&mut self, model: &Model) -> Result<()> {
        if self.failed {
            return Err(Error::Failed { step: self.state.step, what: "a step before has failed; begin a new simulation".into() });
        }
        self.failed = true;
        self.go(model)?;
        self.look(model)?;
        self.failed = false;
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
        let Now { test, state, work, .. } = self;
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
    let mut work = fresh_work(model, &mut state);
    while !preparation.advance(model, rig, &mut state, &mut work)? {
        if stop_asked() {
            return Err(STOPPED);
        }
    }
    Ok(specimen::at_rest(&state, &model.physics.materials))
}

/// A stop before the first instant.
const STOPPED: Error = Error::Cut { doing: "the specimen was made" };
