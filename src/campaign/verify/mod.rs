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
mod silo;
mod slide;
pub mod wave;

pub use report::{TABLE, write};

use crate::bench::pool;
use laboratory::error::{Error, Result};
use laboratory::run::Backend;
use plot::Graph;
use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
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
    /// Whether its runs are scenes, which a graphics device computes too.
    scene: bool,
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
    /// Backend of the runs that are scenes.
    backend: Backend,
    /// Whether no other run shares the process, whose processor time is then that of the run.
    alone: bool,
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
pub const STUDIES: [Case; 9] = [
    impact::REFINED,
    crater::CASE,
    crater::OUTER,
    crater::MOHR_COULOMB,
    crater::NUMERICS,
    crater::CELLS,
    collapse::MOHR_COULOMB,
    rates::CASE,
    silo::CASE,
];

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

/// What to run of a case, where, and with what.
pub struct Plan<'a> {
    /// The first so many resolutions of each case.
    pub levels: usize,
    /// Folder with the scenes of the cases.
    pub scenes: &'a Path,
    /// Folder for everything; cases that are scenes leave their records in `runs` there.
    pub out: &'a Path,
    /// Whether finished runs found there are read instead of made again.
    pub keep: bool,
    /// Backend of the runs that are scenes; other cases know the CPU only.
    pub backend: Backend,
    /// Ways at a time.
    pub jobs: usize,
    /// Threads of each way.
    pub threads: usize,
}

impl Case {
    /// Refuses a graphics device for a case that does not run scenes.
    ///
    /// # Errors
    /// Such a case with a backend other than the CPU.
    pub fn runs_on(&self, backend: Backend) -> Result<()> {
        if self.scene || backend == Backend::Cpu {
            return Ok(());
        }
        let scenes: Vec<&str> = all().filter(|c| c.scene).map(|c| c.name).collect();
        let message = format!("the case {} is no scene and runs on the CPU only; scenes are {}", self.name, scenes.join(", "));
        Err(Error::input("--backend", "", Some(backend.name().into()), message))
    }

    /// Runs every way of the case at the resolutions of the plan, `plan.jobs` ways at a time and the runs of each in
    /// order; `told` is called with way and resolution before each run.
    ///
    /// # Errors
    /// Any error of a run: that of the first way that has one. No way begins after it.
    pub fn measure(&self, plan: &Plan, told: impl Fn(&str, u32) + Sync) -> Result<Vec<Row>> {
        let pools = (0..plan.jobs.min(self.ways.len())).map(|_| pool(plan.threads)).collect::<Result<Vec<_>>>()?;
        let done = Mutex::new(BTreeMap::new());
        let (next, into, told) = (&AtomicUsize::new(0), &done, &told);
        std::thread::scope(|scope| {
            for pool in pools {
                scope.spawn(move || {
                    loop {
                        let way = next.fetch_add(1, Ordering::Relaxed);
                        if way >= self.ways.len() {
                            break;
                        }
                        let rows = pool.install(|| self.measure_way(way, plan, told));
                        if rows.is_err() {
                            // no further way begins
                            next.store(self.ways.len(), Ordering::Relaxed);
                        }
                        into.lock().expect("no thread panics with it").insert(way, rows);
                    }
                });
            }
        });
        let rows: Vec<Vec<Row>> = done.into_inner().expect("no thread panicked").into_values().collect::<Result<_>>()?;
        Ok(rows.concat())
    }

    /// The runs of one way, from coarse to fine.
    fn measure_way(&self, way: usize, plan: &Plan, told: impl Fn(&str, u32)) -> Result<Vec<Row>> {
        let run = |&cells: &u32| {
            told(self.ways[way], cells);
            let out = plan.out.join("runs").join(format!("{}-{}-{cells}", self.name, way + 1));
            let begun = Instant::now();
            let seconds = Cell::new(None);
            let Plan { scenes, keep, backend, jobs, .. } = *plan;
            let task = Task { way, cells, scenes, out, keep, backend, alone: jobs == 1, seconds };
            let found = (self.run)(&task)?;
            let seconds = task.seconds.get().unwrap_or_else(|| begun.elapsed().as_secs_f64());
            Ok(Row { way, cells, found, seconds })
        };
        self.resolutions.iter().take(plan.levels).map(run).collect()
    }
}
