//! Continua as rigs and from the command line: platens against closed forms, tests, records, resume, refusals.

mod command_line;
#[path = "../common/mod.rs"]
mod common;
mod cubes;
mod watch;
