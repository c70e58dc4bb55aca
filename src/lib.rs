//! Crushable grains in laboratory tests: discrete elements, a continuum of material points, and both together.
//!
//! The command `comminute` is written with this crate. A program can use it at three depths: make whole runs, step a test by
//! itself, or use the engine alone. Quantities are in SI units.
//!
//! # Making a run
//! A scene says what is tested; the run leaves tables, a summary and a specimen in a folder, as `comminute run` does. Here grains
//! of petroleum coke are crushed one by one between steel platens.
//!
//! ```
//! use comminute::{RunRequest, scene};
//!
//! // as `--set` on the command line
//! let changes = ["batch.grains=5".to_string()];
//! let scene = scene::load("experiments/platen/petroleum_coke.toml", &changes)?;
//! # let folder = tempfile::tempdir().expect("a folder");
//! # let out = folder.path().join("coke");
//! # /*
//! let out = "runs/coke";
//! # */
//! let outcome = comminute::run(RunRequest::of(&scene, &out)?)?;
//! assert_eq!(outcome.summary["tests"], 20); // five grains of each of four sizes
//! assert!(outcome.out.join("platen.csv").exists());
//! # Ok::<(), comminute::Error>(())
//! ```
//!
//! # Stepping a test
//! A [`Model`] is what a scene comes to: SI units, values that agree. A [`State`] is everything that changes, a [`Workspace`]
//! scratch memory. A ball falls on a floor and leaves with its coefficient of restitution:
//!
//! ```
//! use comminute::{Rig, Workspace, rig::assembly, scene};
//!
//! let text = r#"
//!     kind = "assembly"
//!     duration_s = 0.12
//!     gravity_m_s2 = [0.0, 0.0, -9.81]
//!     contact.law = "hertz_viscous"
//!     grain = [{ position_m = [0.0, 0.0, 0.03], radius_m = 0.01 }]
//!     wall = [{ kind = "plane", point_m = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }]
//!     [material]
//!     name = "soft rubber"
//!     grain.density_kg_m3 = 1100.0
//!     elastic = { E_GPa = 0.01, nu = 0.45 }
//!     contact = { friction = 0.5, restitution = 0.7 }
//! "#;
//! let model = scene::model(&scene::from_text(text, ".", &[])?)?;
//! let Rig::Assembly(rig) = &model.rig else { unreachable!() };
//! let mut state = assembly::start(&model, rig);
//! let mut work = Workspace::new(&model.physics, &mut state);
//! let mut highest = 0.0_f64;
//! while !assembly::done(rig, &state) {
//!     // the closure sees the state when the forces of this instant are known
//!     assembly::advance(&model, &mut state, &mut work, |state, _| {
//!         if state.grains.vel[0][2] > 0.0 {
//!             highest = highest.max(state.grains.pos[0][2]);
//!         }
//!         Ok(())
//!     })?;
//! }
//! // from a height h over the floor back to e² h
//! assert!(((highest - 0.01) / 0.02 - 0.7 * 0.7).abs() < 0.01, "{highest}");
//! # Ok::<(), comminute::Error>(())
//! ```
//!
//! [`run::Simulation`] does the same for any test but platen tests, specimen and programme included, and lets the program drive its walls and bodies.
//! Specimens are made by [`rig::preparation`] and tested by [`testing`]; a continuum with or without grains by [`rig::continuum`].
//! The folder `examples` of the repository has a short program for each.
//!
//! # The engine
//! [`step`] needs a [`Physics`] and a [`State`] made of [`Grains`] and walls, and no scene; [`Continuum`] is the same for
//! material points. A contact law of the calling program is a type that implements [`contact::law::Law`].
//!
//! # What is where
//! | module | what it holds |
//! |---|---|
//! | [`scene`], [`mod@model`] | what the user wrote; what it means, in SI units |
//! | [`mod@run`], [`record`] | whole runs: folder, records, checkpoints, summary |
//! | [`rig`], [`testing`], [`packing`], [`gradation`] | laboratory tests step by step, and their specimens |
//! | [`dem`], [`grains`], [`boundary`], [`material`] | grains: one time step, arrays, walls, constants |
//! | [`contact`], [`breakage`], [`parameter`] | laws of contact and of breakage |
//! | [`mpm`], [`coupling`], [`point_contacts`] | material points, grains in them |
//! | [`rigid`], [`shape`] | bodies that are no spheres |
//! | `gpu` | material points and grains in them on a graphics device (feature `gpu`) |
//! | [`calibrate`] | parameters from laboratory data |
//! | [`campaign`], [`reproduce`], [`study`] | many runs; a paper's runs beside what was published; what a choice costs |
//! | [`verify`], [`mod@bench`], [`point_test`] | closed forms, speed, a law at one material point |
//! | [`figure`], [`report`], [`table`] | figures from records; a page that shows runs; tables |
//! | [`exchange`], [`columns`], [`expression`] | grains and bodies for other programs and from them; tables of others; arithmetic that users write |
//! | [`command()`], [`call`] | the command line, as a program and as a call |
//! | [`host`], [`interrupt`] | how a program that makes runs inside itself stops them and is told their progress; Ctrl-C |
//!
//! Whole runs install a handler for Ctrl-C ([`interrupt`]) and use a thread pool of their own ([`in_pool`](run::in_pool));
//! stepping does neither. Results do not depend on threads, to the bit.

mod cli;

// the command line names the library as any program does
extern crate self as comminute;

pub use cli::{call, command};

pub use calibrate;
pub use campaign;
pub use campaign::{bench, point_test, reproduce, study, verify};
#[cfg(feature = "gpu")]
pub use engine::gpu;
pub use engine::{
    boundary, breakage, contact, coupling, dem, grains, material, math, mpm, neighbours, parameter, point_contacts, rigid, shape,
};
pub use laboratory::{
    columns, error, exchange, expression, gradation, host, interrupt, machine, model, packing, record, rig, run, scene, testing,
};
pub use plot as figure;
pub use report;
pub use table;

pub use breakage::Criterion;
pub use contact::{ContactLaw, ContactModel};
pub use dem::physics::{Physics, Stepping};
pub use dem::{State, Workspace, step};
pub use error::{Error, Result};
pub use grains::Grains;
pub use material::Material;
pub use model::{Model, Rig};
pub use mpm::Continuum;
pub use mpm::law::Law as ContinuumLaw;
pub use run::{Outcome, ResumeOptions, RunRequest, resume, run};
pub use scene::Scene;
