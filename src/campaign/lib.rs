//! Many runs, each a process of its own in a folder of its own: ensembles of seeds, tables of parameters, evaluations of a calibration.
//!
//! A [`Job`] is one run with everything that changes its scene. A job gives its command line, which
//! can also be run by other means (a second call does only what is left), and tells what its folder
//! holds. [`run`] works through a list of jobs; an [`Executor`] starts them. Reproductions of papers, point tests, verification
//! and the bench have modules of their own.

#![deny(missing_docs)]

pub mod bench;
mod executor;
mod grid;
mod hold;
mod job;
mod memory;
pub mod point_test;
mod program;
mod progress;
pub mod reproduce;
mod runner;
mod scheduler;
mod seeds;
pub mod study;
pub mod verify;

pub use executor::{Executor, Template};
pub use grid::{Point, points as grid_points, table as grid_table};
pub use hold::Hold;
pub use job::{Job, shell_word};
pub use program::Program;
pub use runner::{Options, Outcome, close, run};
pub use scheduler::Scheduler;
pub use seeds::{Vary, parse as parse_seeds};
