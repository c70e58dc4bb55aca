//! Folders of runs: going on with one, columns of tables, figures.

use crate::error::raised;
use crate::watch::watched;
use comminute::record::dictionary::SHEETS;
use comminute::report::{Options, write};
use comminute::{ResumeOptions, figure};
use pyo3::prelude::*;
use std::path::PathBuf;

/// Draws the figures of a run that has ended and writes its page, as far as its scene asks for them.
pub fn complete(outcome: &mut comminute::Outcome) -> comminute::Result<()> {
    figure::complete(outcome)?;
    if outcome.report {
        comminute::report::write_run(&outcome.out)?;
    }
    Ok(())
}

/// Continues the run in a folder, draws its figures, and gives its summary as JSON.
#[pyfunction]
#[pyo3(signature = (folder, *, threads, backend, stop_after, tell))]
pub fn resume(
    py: Python<'_>,
    folder: PathBuf,
    threads: Option<usize>,
    backend: Option<&str>,
    stop_after: Option<u64>,
    tell: Option<Py<PyAny>>,
) -> PyResult<String> {
    let backend = backend.map(crate::scene::backend).transpose()?;
    let options = ResumeOptions { threads, quiet: false, json: false, stop_after, backend };
    let outcome = watched(py, tell.as_ref(), |_| {
        let mut outcome = comminute::resume(&folder, options)?;
        complete(&mut outcome)?;
        Ok(outcome)
    })?;
    Ok(outcome.summary.to_string())
}

/// A table: the names of its files, and name, unit and meaning of each column.
type Sheet = (Vec<&'static str>, Vec<(&'static str, &'static str, &'static str)>);

/// The tables that runs of scenes of this kind leave.
#[pyfunction]
pub fn columns(kind: &str) -> Vec<Sheet> {
    let of_kind = SHEETS.iter().filter(|sheet| sheet.of.split(", ").any(|k| k == kind));
    let sheet = |sheet: &comminute::record::dictionary::Sheet| {
        (sheet.files.split(", ").collect(), sheet.columns.iter().map(|c| (c.name, c.unit, c.what)).collect())
    };
    of_kind.map(sheet).collect()
}

/// Draws the figures of a run into its folder; gives the files.
#[pyfunction]
pub fn draw(py: Python<'_>, folder: PathBuf) -> PyResult<Vec<PathBuf>> {
    raised(py, py.detach(|| figure::draw_run(&folder).map_err(comminute::Error::from)))
}

/// Writes the page that shows a run to the file `out`; `force` overwrites a file that is no report.
#[pyfunction]
pub fn report(py: Python<'_>, folder: PathBuf, out: PathBuf, force: bool) -> PyResult<()> {
    let options = Options { force, ..Options::default() };
    raised(py, py.detach(|| write(&[folder], &out, &options).map(|_| ())))
}

/// Draws several runs and measured data into common figures; gives the files.
#[pyfunction]
pub fn overlay(py: Python<'_>, runs: Vec<PathBuf>, data: Vec<PathBuf>, out: PathBuf) -> PyResult<Vec<PathBuf>> {
    raised(py, py.detach(|| figure::overlay(&runs, &data, &out).map_err(comminute::Error::from)))
}
