//! A test that a program makes step by step, without a folder and without records: [`Simulation`]. Its walls, loading plates and driven bodies follow the
//! scene until the program drives them.

mod grains;
mod points;

use super::of_scene::settle_density;
use super::pool;
use crate::error::{Error, Result};
use crate::model::{Model, Rig};
use crate::record::contacts::Contact;
use crate::record::specimen;
use crate::rig::cylinder::inertial_time;
use crate::scene::{self, Scene};
use engine::boundary::{Drive, WallShape};
use engine::dem::State;
use engine::mpm::Points;
use engine::rigid::Blocks;
use std::time::{Duration, Instant};
use table::Row;

/// Share of the imbalance that a wall under servo removes in a step, where the scene says none: the default of `wall.gain`.
const GAIN: f64 = 0.2;
/// The stage of a test whose walls a program drives.
const DRIVEN: &str = "driven";

/// A free scene or a test, at the instant when the forces are known and nothing has moved yet: places, forces and what is measured belong together, as
/// in the records of a run. A step moves everything, breaks grains and bodies, and computes the next forces; it makes the same bits as the step of a run on the processor.
pub struct Simulation {
    model: Model,
    pool: rayon::ThreadPool,
    now: Box<dyn System>,
    /// Whether a step has failed, so that no other can follow.
    failed: bool,
}

/// A wall at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallNow {
    /// Shape and place.
    pub shape: WallShape,
    /// Way towards the material since the first instant, m; of a cylinder the decrease of its radius.
    pub displacement: f64,
    /// Velocity towards the material, m for a unit of time.
    pub velocity: f64,
    /// Normal force on it, N, compression positive; of a cylinder the sum of the radial forces.
    pub force: f64,
    /// Sum of the z components of the tangential forces of grains on it, N.
    pub shear_z: f64,
    /// Its work, J.
    pub work: f64,
    /// Area over which the force is a stress, m²; `None` for a plane of a free scene that is not under servo.
    pub area: Option<f64>,
}

/// What is simulated: all that differs between grains alone and points, mixtures and bodies. The walls that are asked for are there.
trait System: Send + Sync {
    /// One step, at whose end the forces of the next instant are known.
    fn step(&mut self, model: &Model) -> Result<()>;
    /// [`Simulation::steps`]
    fn steps(&self) -> u64;
    /// [`Simulation::time`]
    fn time(&self) -> f64;
    /// [`Simulation::dt`]
    fn dt(&self) -> f64;
    /// [`Simulation::crush_events`]
    fn crush_events(&self) -> u64;
    /// [`Simulation::stage`]
    fn stage(&self, model: &Model) -> &'static str;
    /// [`Simulation::driven`]
    fn driven(&self) -> bool;
    /// [`Simulation::is_over`]
    fn is_over(&self, model: &Model) -> bool;
    /// [`Simulation::drive`]
    fn drive(&mut self, model: &Model, wall: usize, drive: Drive) -> Result<()>;
    /// [`Simulation::drive_body`]
    fn drive_body(&mut self, _: &Model, body: usize, _: [f64; 3], _: [f64; 3]) -> Result<()> {
        wrong("body", body.to_string(), "there are no rigid bodies")
    }
    /// [`Simulation::grains`]
    fn grains(&self) -> Option<&State>;
    /// [`Simulation::points`]
    fn points(&self) -> Option<&Points>;
    /// [`Simulation::bodies`]
    fn bodies(&self) -> Option<&Blocks> {
        None
    }
    /// [`Simulation::wall_names`]
    fn wall_names(&self, model: &Model) -> Vec<String>;
    /// [`Simulation::wall`]
    fn wall(&self, model: &Model, wall: usize) -> WallNow;
    /// [`Simulation::force`]
    fn force(&self, model: &Model, grain: usize) -> [f64; 3];
    /// [`Simulation::contacts`]
    fn contacts(&self) -> Vec<Contact>;
    /// [`Simulation::volume`]
    fn volume(&self, model: &Model) -> Option<f64>;
    /// [`Simulation::breakages`]
    fn breakages(&self) -> Vec<Row>;
    /// [`Simulation::body_breakages`]
    fn body_breakages(&self) -> Vec<Row> {
        Vec::new()
    }
    /// [`Simulation::row`]
    fn row(&mut self, model: &Model) -> Result<Row>;
}

/// A stop before the first instant.
const STOPPED: Error = Error::Cut { doing: "the specimen was made" };

/// Refuses what a program has asked for.
fn wrong<T>(key: &str, value: String, message: &str) -> Result<T> {
    Err(Error::input("drive", key, Some(value), message))
}

/// What a wall is told, checked; a gain of 0 stands for `own`. `of_area`: whether a stress needs an area.
///
/// # Errors
/// Numbers that no wall can be driven by.
fn checked(drive: Drive, own: f64, of_area: bool) -> Result<Drive> {
    match drive {
        Drive::Fixed | Drive::Programme => Ok(Drive::Fixed),
        Drive::Velocity(v) if v.is_finite() => Ok(Drive::Velocity(v)),
        Drive::Velocity(v) => wrong("velocity", v.to_string(), "must be finite"),
        Drive::Stress { stress, area, gain, fastest } => {
            let gain = if gain == 0.0 { own } else { gain };
            if !stress.is_finite() {
                return wrong("stress", stress.to_string(), "must be finite");
            }
            if of_area && !(area > 0.0 && area.is_finite()) {
                return wrong("area", area.to_string(), "must be above 0: a plane of a free scene has no area of its own");
            }
            if !(gain > 0.0 && gain <= 1.0) {
                return wrong("gain", gain.to_string(), "must be above 0 and at most 1");
            }
            if let Some(v) = fastest.filter(|v| v.is_nan() || *v <= 0.0) {
                return wrong("max_velocity", v.to_string(), "must be above 0");
            }
            Ok(Drive::Stress { stress, area, gain, fastest })
        }
    }
}

impl Simulation {
    /// The simulation of a scene at its first instant: free scenes at time 0; tests on a cylindrical specimen of grains when the specimen, which is made now or
    /// read from the file that the scene names, rests under its isotropic stress and the programme begins; tests of points and mixtures where their
    /// history begins, before a triaxial specimen has settled. `threads`: `None` for one for each core; results do not depend on it.
    ///
    /// # Errors
    /// A batch of platen tests, or a scene that asks for what cannot be; a specimen that cannot be made; a wish to stop meanwhile.
    pub fn of(scene: &Scene, threads: Option<usize>) -> Result<Simulation> {
        let mut model = scene::model(scene)?;
        if let Rig::GrainCrushing(_) = model.rig {
            let message = "must be assembly, oedometer, triaxial, isotropic, continuum or mixture to be made step by step: a batch of platen tests makes each of them at once";
            return Err(Error::input(scene.name(), "kind", scene.get("kind").map(ToString::to_string), message));
        }
        settle_density(scene, &mut model, threads, &mut |_| ())?;
        let (pool, materials) = (pool(threads)?, &model.physics.materials);
        let now: Box<dyn System> = if let Rig::Continuum(rig) = &model.rig {
            let given = rig.growth.as_ref().zip(scene.specimen());
            let grown = given.map(|(growth, file)| specimen::read_grown(&file, growth, materials)).transpose()?;
            Box::new(pool.install(|| points::Continuum::begin(&model, rig, grown))?)
        } else {
            let given = scene.specimen().map(|file| specimen::read(&file, materials)).transpose()?;
            Box::new(pool.install(|| grains::Grains::begin(&model, given))?)
        };
        Ok(Simulation { model, pool, now, failed: false })
    }

    /// Makes up to `steps` steps, and no more once the time `most` is over; gives their number. Goes on beyond the end of the scene's
    /// programme. A step of a mixture is a cycle of grains and points.
    ///
    /// # Errors
    /// A step that cannot be made, or after which the state means nothing ([`Error::Unstable`]); none can follow then.
    pub fn step(&mut self, steps: u64, most: Duration) -> Result<u64> {
        let Simulation { model, pool, now, failed } = self;
        let begun = Instant::now();
        pool.install(|| {
            for made in 0..steps {
                if made > 0 && begun.elapsed() >= most {
                    return Ok(made);
                }
                if *failed {
                    return Err(Error::Failed {
                        step: now.steps(),
                        what: "a step before has failed; begin a new simulation".into(),
                    });
                }
                *failed = true;
                now.step(model)?;
                *failed = false;
            }
            Ok(steps)
        })
    }

    /// Lets the wall of this index move as told from the next step on. In a test on a specimen the program takes over with the first call:
    /// the programme of the scene is over, and the other walls stand still until they are told. The `area` of a stress counts in free
    /// scenes on planes alone; elsewhere it is the present one. A gain of 0 stands for that of the scene.
    ///
    /// # Errors
    /// A wall that there is not, or that cannot move; numbers that no wall can be driven by.
    pub fn drive(&mut self, wall: usize, drive: Drive) -> Result<()> {
        let walls = self.wall_names().len();
        if wall >= walls {
            return wrong("wall", wall.to_string(), &format!("there are {walls} walls, counted from 0"));
        }
        self.now.drive(&self.model, wall, drive)
    }

    /// Lets the driven rigid body of this index move at a velocity, m/s, and a spin, rad/s, from the next step on; a path of the scene ends.
    ///
    /// # Errors
    /// A body that there is not, or that moves freely; a motion that it cannot have.
    pub fn drive_body(&mut self, body: usize, velocity: [f64; 3], spin: [f64; 3]) -> Result<()> {
        self.now.drive_body(&self.model, body, velocity, spin)
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Steps so far, as the column `step` of records.
    pub fn steps(&self) -> u64 {
        self.now.steps()
    }

    /// Time, s; with inertia scaling the number of steps.
    pub fn time(&self) -> f64 {
        self.now.time()
    }

    /// Present time step, s; of a mixture that of a cycle; with inertia scaling 1.
    pub fn dt(&self) -> f64 {
        self.now.dt()
    }

    /// Breakages of grains and of rigid bodies so far.
    pub fn crush_events(&self) -> u64 {
        self.now.crush_events()
    }

    /// The stage of the test, as the column `stage` of records; `driven` where the program drives the walls of a specimen.
    pub fn stage(&self) -> &'static str {
        self.now.stage(&self.model)
    }

    /// Grains, their contacts and walls at this instant; `None`: there are neither grains nor bodies.
    pub fn grains(&self) -> Option<&State> {
        self.now.grains()
    }

    /// Material points at this instant; `None`: there are none.
    pub fn points(&self) -> Option<&Points> {
        self.now.points()
    }

    /// Rigid bodies that are no spheres at this instant; `None`: there are none.
    pub fn bodies(&self) -> Option<&Blocks> {
        self.now.bodies()
    }

    /// Whether the program drives walls or bodies.
    pub fn driven(&self) -> bool {
        self.now.driven()
    }

    /// Whether the programme of the scene is over: in a free scene its steps or its duration. Never in a test whose walls the program
    /// drives.
    pub fn is_over(&self) -> bool {
        self.now.is_over(&self.model)
    }

    /// Names of the walls: `bottom`, `top`, `cylinder` of a cylindrical specimen, `x_low`, `x_high`, … of a box; in a free scene `wall_0`, `wall_1`, …, and the
    /// sides of the grid that hold points, `z_low` and so on.
    pub fn wall_names(&self) -> Vec<String> {
        self.now.wall_names(&self.model)
    }

    /// The wall of this index, which is below the number of [`Self::wall_names`].
    pub fn wall(&self, wall: usize) -> WallNow {
        self.now.wall(&self.model, wall)
    }

    /// Force, N, on the grain at an index of the arrays, from contacts, gravity, points and bodies, before damping.
    pub fn force(&self, grain: usize) -> [f64; 3] {
        self.now.force(&self.model, grain)
    }

    /// Contacts between grains, of grains with walls, and of grains with points, in the order of ids.
    pub fn contacts(&self) -> Vec<Contact> {
        self.now.contacts()
    }

    /// Volume between the walls of a specimen, m³ (m² in plane strain); `None` in a free scene.
    pub fn volume(&self) -> Option<f64> {
        self.now.volume(&self.model)
    }

    /// Time scale of grain rearrangement at the pressure `pressure`, Pa ([`inertial_time`]), s: the strain rate times this is the inertial
    /// number. Not a number without grains.
    pub fn inertial_time(&self, pressure: f64) -> f64 {
        self.grains().map_or(f64::NAN, |state| inertial_time(state, pressure))
    }

    /// All breakages of grains since the first instant, as the rows of `breakage.csv`.
    pub fn breakages(&self) -> Vec<Row> {
        self.now.breakages()
    }

    /// All breakages of rigid bodies since the first instant, as the rows of `block_breakage.csv`.
    pub fn body_breakages(&self) -> Vec<Row> {
        self.now.body_breakages()
    }

    /// The row of `history.csv` for this instant: stresses, strains, void ratios, gradation, energies. Where the program drives the walls of a specimen its stage is `driven`, without a
    /// target. Stresses and strains that a run of points records as means are means over all steps since the last row: that of the run's schedule or, in a
    /// specimen that the program drives, that for which it was last asked.
    ///
    /// # Errors
    /// [`Error::Failed`]: the gradation is coarser than at the start. A driven test that means nothing any more.
    pub fn row(&mut self) -> Result<Row> {
        let Simulation { model, now, pool, .. } = self;
        pool.install(|| now.row(model))
    }
}
