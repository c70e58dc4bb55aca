//! Cases of the continuum, and of grains in it, with closed forms, each at several resolutions: how far off, after how long.
//!
//! A [`Case`] is a file of its own: it takes a way of doing it and a resolution to errors. Some put points on a grid themselves (what a scene cannot
//! say: a velocity that varies from place to place), others run a scene as a user would. Here times are measured, tables and figures made.

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

/// What is verified.
pub struct Case {
    /// Name on the command line and of its figures.
    pub name: &'static str,
    /// What is done.
    pub about: &'static str,
    /// The closed form, and where it is from.
    pub exact: &'static str,
    /// What a resolution counts.
    pub across: &'static str,
    /// Coarse to fine.
    pub resolutions: &'static [u32],
    /// Ways of doing it: transfers, shape functions, parameters.
    pub ways: &'static [&'static str],
    /// What each error is of.
    pub quantities: &'static [&'static str],
    run: fn(&Task) -> Result<Found>,
    /// Figures of its own, beside those of all cases.
    graphs: Option<Graphs>,
}

/// Figures from all rows of a case.
type Graphs = fn(&[Row]) -> Vec<Graph>;

/// One run of a case.
pub struct Task<'a> {
    /// Index of the way.
    pub way: usize,
    /// Cells, as [`Case::across`] says.
    pub cells: u32,
    /// Folder with the scenes of the cases.
    pub scenes: &'a Path,
    /// Folder of this run, for those that leave records.
    pub out: PathBuf,
    /// Runs that the folder holds already are not run again.
    keep: bool,
    /// What it took, s, where that is not the time that has passed.
    seconds: Cell<Option<f64>>,
}

impl Task<'_> {
    /// The same with another folder.
    fn elsewhere(&self, out: PathBuf, keep: bool) -> Task<'_> {
        Task { out, keep, seconds: Cell::new(None), ..*self }
    }
}

/// What one run gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Number of points.
    pub points: usize,
    /// Steps of the continuum.
    pub steps: u64,
    /// Relative errors, in the order of [`Case::quantities`]; what follows them is the case's own.
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
    /// Wall time, or the processor's of a scene on one thread, s.
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
pub const STUDIES: [Case; 5] = [impact::REFINED, crater::CASE, crater::OUTER, crater::NUMERICS, rates::CASE];

static USUAL: [Case; CASES.len()] = CASES;
static LONG: [Case; STUDIES.len()] = STUDIES;

/// All there are.
pub fn all() -> impl Iterator<Item = &'static Case> {
    USUAL.iter().chain(&LONG)
}

/// The cases of these names; without any those of [`CASES`].
///
/// # Errors
/// A name that is none.
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
    /// Every way at the first `levels` resolutions; `told` hears of each before it begins. Records of the cases that are scenes go into `out/runs`; with `keep` those that
    /// are there are read instead of made again.
    ///
    /// # Errors
    /// What keeps a run from starting or ending.
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
