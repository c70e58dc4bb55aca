//! The command line, whole: as the program of a process (`python -m comminute`), and as a call that gives its error.

use crate::watch::watched;
use comminute::campaign::Program;
use pyo3::prelude::*;
use std::ffi::OsString;
use std::path::PathBuf;

/// Does what the words of a command line ask for, as the program `comminute` does; gives the exit code. Ctrl-C is the command's from now on.
#[pyfunction]
pub fn command(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| comminute::command(std::iter::once("comminute".into()).chain(words)))
}

/// Does what the words behind the name of the command ask for; its error is raised.
#[pyfunction]
pub fn call(py: Python<'_>, words: Vec<OsString>, tell: Option<Py<PyAny>>) -> PyResult<()> {
    watched(py, tell.as_ref(), |_| comminute::call(words))
}

/// Says how the runs of a campaign are started from this program: a file, and words before the verb.
#[pyfunction]
pub fn runs_by(file: PathBuf, first: Vec<OsString>) {
    Program { file, first }.give();
}
