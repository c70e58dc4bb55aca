//! Verification: cases of the continuum, and of grains in it, that have closed forms, each at
//! several resolutions, with errors and times.
//!
//! Each [`Case`] has a file of its own, with a function from a way and a resolution to errors. Some
//! cases put points on a grid themselves (for what a scene cannot say: a velocity that varies from
//! place to place), others run a scene as a user would. This module measures times and makes tables
//! and figures.

pub mod bar;
pub mod block;
mod collapse;
pub mod column;
mod cones;
mod contact_box;
mod contact_slide;
mod crater;
pub mod disk;
mod impact;
mod oedometer;
pub mod patch;
mod pushed;
mod rates;
mod report;
mod scene;
mod slide;
pub mod wave;

pub use report::{TABLE, write};

use laboratory::error::{Error, Result};
use plot::Graph;
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A computation whose result is known.
pub struct Case {
    /// Name of the case on the command line and in the names of figures.
    pub name: &'static str,
    /// What is computed.
    pub about: &'static str,
    /// The closed form, and where it is from.
    pub exact: &'static str,
    /// Meaning of a resolution, such as cells along the bar.
    pub across: &'static str,
    /// The resolutions, from coarse to fine.
    pub resolutions: &'static [u32],
    /// Variants of the computation: transfers, shape functions, parameters.
    pub ways: &'static [&'static str],
    /// The quantity of each error.
    pub quantities: &'static [&'static str],
    run: fn(&Task) -> Result<Found>,
    /// Figures for this case alone, besides those of all cases.
    graphs: Option<Graphs>,
}

/// Figures from all rows of a case.
type Graphs = fn(&[Row]) -> Vec<Graph>;

/// One run of a case.
pub struct Task<'a> {
    /// Index of the way in [`Case::ways`].
    pub way: usize,
    /// Resolution, as [`Case::across`] says.
    pub cells: u32,
    /// Folder with the scenes of the cases.
    pub scenes: &'a Path,
    /// Folder of the run, for cases that leave records.
    pub out: PathBuf,
    /// Whether a run that is finished in the folder is read instead of made again.
    keep: bool,
    /// Time of the run, s, if the case measures it; `None`: the wall time counts.
    seconds: Cell<Option<f64>>,
}

impl Task<'_> {
    /// The same task with another folder.
    fn elsewhere(&self, out: PathBuf, keep: bool) -> Task<'_> {
        Task { out, keep, seconds: Cell::new(None), ..*self }
    }
}

/// Result of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Number of points.
    pub points: usize,
    /// Steps of the continuum.
    pub steps: u64,
    /// Relative errors, in the order of [`Case::quantities`]; further numbers are for the case's
    /// own figures.
    pub errors: Vec<f64>,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Index of the way in [`Case::ways`].
    pub way: usize,
    /// Resolution, as [`Case::across`] says.
    pub cells: u32,
    /// Result of the run.
    pub found: Found,
    /// Wall time, s; processor time for a scene on one thread.
    pub seconds: f64,
}

/// Cases that are run unless others are named.
pub const CASES: [Case; 15] = [
    bar::CASE,
    wave::CASE,
    column::CASE,
    patch::CASE,
    disk::CASE,
    slide::CASE,
    oedometer::CASE,
    pushed::CASE,
    cones::CASE,
    collapse::SPACE,
    collapse::PLANE,
    impact::CASE,
    contact_slide::CASE,
    contact_box::CASE,
    contact_box::SUPERQUADRIC,
];

/// Cases that take longer, and are run when they are named.
pub const STUDIES: [Case; 7] =
    [impact::REFINED, crater::CASE, crater::OUTER, crater::MOHR_COULOMB, crater::NUMERICS, collapse::MOHR_COULOMB, rates::CASE];

static USUAL: [Case; CASES.len()] = CASES;
static LONG: [Case; STUDIES.len()] = STUDIES;

/// All cases.
pub fn all() -> impl Iterator<Item = &'static Case> {
    USUAL.iter().chain(&LONG)
}

/// The cases with these names; without names, those of [`CASES`].
///
/// # Errors
/// A name that no case has.
pub fn chosen(names: &[String]) -> Result<Vec<&'static Case>> {
    if names.is_empty() {
        return Ok(USUAL.iter().collect());
    }
    let find = |name: &String| {
        all().find(|c| c.name == name).ok_or_else(|| {
            let names: Vec<&str> = all().map(|c| c.name).collect();
            Error::input("--only", "", Some(name.clone()), format!("no case is called {name:?}; there are {}", names.join(", ")))
        })
    };
    names.iter().map(find).collect()
}

impl Case {
    /// Runs every way at the first `levels` resolutions; `told` is called with way and resolution
    /// before each run. Cases that are scenes leave their records in `out/runs`; with `keep`,
    /// finished runs found there are read instead of made again.
    ///
    /// # Errors
    /// Any error of a run.
    pub fn measure(
        &self,
        levels: usize,
        scenes: &Path,
        out: &Path,
        keep: bool,
        mut told: impl FnMut(&str, u32),
    ) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        for way in 0..self.ways.len() {
            for &cells in self.resolutions.iter().take(levels) {
                told(self.ways[way], cells);
                let out = out.join("runs").join(format!("{}-{}-{cells}", self.name, way + 1));
                let begun = Instant::now();
                let task = Task { way, cells, scenes, out, keep, seconds: Cell::new(None) };
                let found = (self.run)(&task)?;
                let seconds = task.seconds.get().unwrap_or_else(|| begun.elapsed().as_secs_f64());
                rows.push(Row { way, cells, found, seconds });
            }
        }
        Ok(rows)
    }
}
