//! The program that makes the runs of a campaign, each as a process.

use laboratory::error::{Error, Result};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;
use std::sync::OnceLock;

/// A program with the command line of `comminute`.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// Its file.
    pub file: PathBuf,
    /// Words before the verb, as `-m comminute` for a program in Python.
    pub first: Vec<OsString>,
}

/// What the running program says of itself.
static GIVEN: OnceLock<Program> = OnceLock::new();

impl Program {
    /// Says how the running program is called as the command `comminute`, where its file alone is not that command. The first call counts.
    pub fn give(self) {
        let _ = GIVEN.set(self);
    }

    /// What [`Program::give`] has said.
    pub fn given() -> Option<&'static Program> {
        GIVEN.get()
    }

    /// The running program.
    ///
    /// # Errors
    /// A system that does not tell its file.
    pub fn running() -> Result<Program> {
        match GIVEN.get() {
            Some(program) => Ok(program.clone()),
            None => Ok(Program { file: std::env::current_exe().map_err(Error::read("this program"))?, first: Vec::new() }),
        }
    }

    /// The words by which it is called, its file first.
    pub fn words(&self) -> impl Iterator<Item = &OsStr> {
        std::iter::once(self.file.as_os_str()).chain(self.first.iter().map(OsString::as_os_str))
    }
}
