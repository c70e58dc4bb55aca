//! The loop around steps: phases, records, watchdog, checkpoints, stop. Only this module knows schedules.

mod backend;
mod continuum;
mod files;
mod folder;
mod platen;
mod progress_bar;
mod summary;
mod watch;

use crate::error::{Error, Result};
use crate::interrupt::{listen, stop_asked};
use crate::model::{Model, Rig};
use crate::record::{checkpoint, specimen};
use crate::rig::assembly;
use crate::rig::cylinder::{Stresses, space};
use crate::rig::preparation::{Preparation, range};
use crate::testing::Test;
pub use backend::{Backend, Chosen, choose};
use engine::boundary::CylinderSpace;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use files::Files;
pub use files::occupied;
pub use folder::{Found, Lock, lock, look};
use progress_bar::Bar;
pub use progress_bar::human;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What to run and where to leave it.
pub struct RunRequest {
    pub model: Model,
    /// The scene with every default, as TOML; running it repeats the run.
    pub scene_resolved: String,
    pub out: PathBuf,
    /// Overwrite a run that `out` holds.
    pub force: bool,
    /// `None`: all cores.
    pub threads: Option<usize>,
    /// A prepared specimen to start from.
    pub specimen: Option<PathBuf>,
    pub quiet: bool,
    pub json: bool,
    /// Stop, resumable, after this many steps in all; on a graphics device when it is looked at next.
    pub stop_after: Option<u64>,
    /// Who does the steps.
    pub backend: Chosen,
}

/// How a resumed run behaves.
#[derive(Clone, Debug, Default)]
pub struct ResumeOptions {
    pub threads: Option<usize>,
    pub quiet: bool,
    pub json: bool,
    pub stop_after: Option<u64>,
    /// `None`: as before.
    pub backend: Option<Backend>,
}

/// A finished run.
#[derive(Debug)]
pub struct Outcome {
    /// What `summary.json` holds.
    pub summary: serde_json::Value,
    pub out: PathBuf,
    /// Whether the scene asks for figures of it, and they have not been drawn.
    pub draw: bool,
}

impl Outcome {
    /// Closes the summary, as it stands and in its file, with the time, s, that its figures took.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn drawn(&mut self, seconds: f64) -> Result<()> {
        self.draw = false;
        self.summary["figure_seconds"] = serde_json::json!(seconds);
        files::save_summary(&self.out, &self.summary)
    }
}

/// What the rig is doing.
#[derive(Debug, Serialize, Deserialize)]
enum Activity {
    Preparing(Preparation),
    Testing(Test),
    Assembly,
}

/// Everything a restart needs.
#[derive(Serialize, Deserialize)]
struct Progress {
    activity: Activity,
    state: State,
    files: Files,
    /// Steps in all, preparation included.
    steps: u64,
    preparation_steps: u64,
    grains_initial: usize,
    /// Porosities of the loosest and the densest specimen, where they have been measured for the run.
    range: Option<range::Range>,
    /// Σ grains over loading steps, for the speed.
    grain_steps: u64,
    /// Wall-clock seconds in all, and during loading.
    seconds: f64,
    loading_seconds: f64,
}

/// Turns a relative density of the model's specimen into a porosity ([`range::settle`]).
///
/// # Errors
/// A range that cannot be measured.
pub fn settle(model: &mut Model, threads: Option<usize>) -> Result<Option<range::Range>> {
    in_pool(threads, || range::settle(model))
}

/// Runs a model from the start.
///
/// # Errors
/// Whatever keeps the run from starting (nothing is written then), from being prepared (why is written, and the folder is free for the next run), or
/// from ending (records and checkpoint are kept).
pub fn run(request: RunRequest) -> Result<Outcome> {
    let RunRequest { mut model, scene_resolved, out, force, threads, specimen, quiet, stop_after, backend, .. } = request;
    if matches!(model.rig, Rig::Platen(_)) {
        never_halfway(stop_after)?;
    }
    let begun = match &model.rig {
        Rig::Continuum(rig) => Some(continuum::begin(&model, rig, backend)?),
        _ => None,
    };
    let given = specimen.map(|path| specimen::read(&path, &model.physics.materials)).transpose()?;
    if given.is_none() {
        settle(&mut model, threads)?;
    }
    lock(&out)?;
    files::claim(&out, force)?;
    let resolved = out.join(crate::scene::RESOLVED);
    std::fs::write(&resolved, scene_resolved).map_err(Error::write(&resolved))?;
    let lock = lock(&out)?;
    let folder = out.clone();
    let outcome = in_pool(threads, move || {
        if let Rig::Platen(rig) = &model.rig {
            return platen::run(&model, rig, &out, quiet);
        }
        if let (Rig::Continuum(rig), Some(begun)) = (&model.rig, begun) {
            return continuum::run(&model, rig, begun, &out, quiet, stop_after);
        }
        let (activity, state) = match (&model.rig, model.rig.specimen(), given) {
            (_, Some(_), Some((grains, walls))) => {
                specimen::write(&out.join(files::SPECIMEN), &grains, &model.physics.materials, Some(walls))?;
                test(&model, grains, walls)?
            }
            (_, Some(rig), None) => {
                let (preparation, state) = Preparation::start(&model, rig);
                (Activity::Preparing(preparation), state)
            }
            (Rig::Assembly(rig), ..) => {
                let state = assembly::start(&model, rig);
                specimen::write(&out.join(files::SPECIMEN), &state.grains, &model.physics.materials, None)?;
                (Activity::Assembly, state)
            }
            _ => unreachable!("a rig has a specimen or is an assembly"),
        };
        let grains_initial = state.grains.len();
        let range = model.rig.specimen().and_then(|rig| rig.range);
        let progress = Progress {
            activity,
            state,
            files: Files::default(),
            steps: 0,
            preparation_steps: 0,
            grains_initial,
            range,
            grain_steps: 0,
            seconds: 0.0,
            loading_seconds: 0.0,
        };
        Runner::new(&model, &out, progress, quiet)?.go(stop_after)
    });
    released(outcome, &folder, lock)
}

/// The outcome; after a failure that was no interruption the folder is free again if nothing was recorded.
fn released(outcome: Result<Outcome>, out: &Path, lock: Lock) -> Result<Outcome> {
    // the lock is on a file that may have to go
    drop(lock);
    outcome.inspect_err(|error| {
        if !matches!(error, Error::Interrupted { .. }) {
            files::release(out, error);
        }
    })
}

/// Continues the run that `dir` holds from its checkpoint.
///
/// # Errors
/// A folder without a checkpoint, or whatever ends the run.
pub fn resume(dir: &Path, options: ResumeOptions) -> Result<Outcome> {
    if dir.join(files::SUMMARY).exists() && !dir.join(checkpoint::FILE).exists() {
        return Err(Error::Checkpoint { path: dir.into(), what: "the run is finished".into() });
    }
    let scene = crate::scene::load(dir.join(crate::scene::RESOLVED), &[])?;
    let model = crate::scene::model(&scene)?;
    let lock = lock(dir)?;
    if !matches!(model.rig, Rig::Continuum(_)) {
        choose(options.backend.unwrap_or_default(), &model)?;
    }
    if let Rig::Platen(rig) = &model.rig {
        never_halfway(options.stop_after)?;
        return in_pool(options.threads, || platen::run(&model, rig, dir, options.quiet));
    }
    if let Rig::Continuum(rig) = &model.rig {
        let resume = || continuum::resume(&model, rig, dir, options.backend, options.quiet, options.stop_after);
        return released(in_pool(options.threads, resume), dir, lock);
    }
    let progress: Progress = checkpoint::load(dir)?;
    let outcome = in_pool(options.threads, || Runner::new(&model, dir, progress, options.quiet)?.go(options.stop_after));
    released(outcome, dir, lock)
}

/// A batch of platen tests has no state between its tests that could be kept.
fn never_halfway(stop_after: Option<u64>) -> Result<()> {
    match stop_after {
        None => Ok(()),
        Some(n) => {
            Err(Error::input("run", "stop_after", Some(n.to_string()), "has no meaning in a platen test: it has no checkpoint"))
        }
    }
}

/// Runs inside a pool of its own, so that the loop's thread is one of the workers.
///
/// # Errors
/// No threads, or the job's.
pub fn in_pool<T: Send>(threads: Option<usize>, job: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|e| Error::Failed { step: 0, what: format!("cannot start threads: {e}") })?;
    listen();
    pool.install(job)
}

/// The test of a prepared specimen.
fn test(model: &Model, grains: Grains, walls: CylinderSpace) -> Result<(Activity, State)> {
    let (test, state) = Test::start(model, grains, walls)?;
    Ok((Activity::Testing(test), state))
}

/// Scratch for a state, with grains near in space put near in memory.
fn fresh_work(model: &Model, state: &mut State) -> Workspace {
    let mut work = Workspace::new(&model.physics, state);
    engine::dem::reorder(state, &mut work);
    work
}

/// Steps between looks at the energies of a test: an instability takes some tens to leave the range of numbers.
const CLOSE_LOOK: u64 = 8;
/// Steps between looks at the clock, the watchdog and Ctrl-C's flag (the flag itself at every step).
const LOOK: u64 = 64;

struct Runner<'a> {
    model: &'a Model,
    out: &'a Path,
    progress: Progress,
    work: Workspace,
    bar: Bar,
    started: Instant,
    last_checkpoint: Instant,
}

impl<'a> Runner<'a> {
    fn new(model: &'a Model, out: &'a Path, mut progress: Progress, quiet: bool) -> Result<Runner<'a>> {
        let specimen = matches!(progress.activity, Activity::Testing(_));
        progress.files.open(out, model, specimen)?;
        let work = fresh_work(model, &mut progress.state);
        let now = Instant::now();
        Ok(Runner { model, out, progress, work, bar: Bar::new(quiet), started: now, last_checkpoint: now })
    }

    fn go(mut self, stop_after: Option<u64>) -> Result<Outcome> {
        let before = self.progress.seconds;
        let loading_before = self.progress.loading_seconds;
        let mut loading_since = (!matches!(self.progress.activity, Activity::Preparing(_))).then(Instant::now);
        let mut below_least = self.progress.files.recorder.below_least;
        loop {
            let step = self.advance();
            let p = &mut self.progress;
            if let (None, Some(below)) = (below_least, p.files.recorder.below_least) {
                below_least = Some(below);
                self.bar.warn(&below.in_words(self.model.records.least_void_ratio));
            }
            p.seconds = before + self.started.elapsed().as_secs_f64();
            if loading_since.is_none() && !matches!(p.activity, Activity::Preparing(_)) {
                loading_since = Some(Instant::now());
            }
            p.loading_seconds = loading_before + loading_since.map_or(0.0, |t| t.elapsed().as_secs_f64());
            match step {
                Ok(false) => {}
                Ok(true) => break,
                Err(e) => {
                    // keep what there is
                    self.progress.files.flush(self.out)?;
                    return Err(e);
                }
            }
            if stop_asked() || stop_after.is_some_and(|n| self.progress.steps >= n) {
                self.checkpoint()?;
                return Err(Error::Interrupted { step: self.progress.steps, out: self.out.into() });
            }
            if self.progress.steps.is_multiple_of(CLOSE_LOOK) {
                self.watch(false)?;
            }
            if self.progress.steps.is_multiple_of(LOOK) {
                self.bar.show(self.model, &self.progress);
                if self.last_checkpoint.elapsed() > Duration::from_secs_f64(self.model.records.checkpoint_seconds) {
                    self.checkpoint()?;
                }
            }
        }
        self.watch(true)?;
        self.bar.finish();
        summary::finish(self.model, self.out, &mut self.progress, &self.work)
    }

    /// One step of whatever the rig is doing. True when the run is done.
    fn advance(&mut self) -> Result<bool> {
        let Runner { model, out, progress, work, .. } = self;
        let Progress { activity, state, files, .. } = progress;
        progress.steps += 1;
        match (activity, &model.rig) {
            (Activity::Preparing(preparation), rig) => {
                progress.preparation_steps += 1;
                let Some(specimen) = rig.specimen() else { unreachable!("only a specimen is prepared") };
                if preparation.advance(model, specimen, state, work)? {
                    self.load()?;
                }
                Ok(false)
            }
            (Activity::Testing(test), _) => {
                progress.grain_steps += state.grains.len() as u64;
                test.advance(model, state, work, &mut |test, state, work| {
                    if let Some(now) = test.held(state) {
                        files.recorder.held.look(&now, &Stresses::of(state));
                    }
                    let due = test.due(model, &mut files.recorder, state);
                    files.observe(out, model, (state, work), test.fines(), due, || test.moment(state))
                })?;
                files.breakages(out, &work.breakages, state, test.target())?;
                Ok(test.is_over() || files.ends_below_least(model))
            }
            (_, Rig::Assembly(rig)) => {
                progress.grain_steps += state.grains.len() as u64;
                let last = assembly::done(rig, state);
                assembly::advance(model, state, work, |state, work| files.observe_assembly(out, model, rig, state, work, last))?;
                files.breakages(out, &work.breakages, state, None)?;
                Ok(last)
            }
            _ => unreachable!("a test belongs to its rig"),
        }
    }

    /// From a prepared specimen to its test: what is kept is what `specimen.csv` holds.
    fn load(&mut self) -> Result<()> {
        let path = self.out.join(files::SPECIMEN);
        let state = &self.progress.state;
        specimen::write(&path, &state.grains, &self.model.physics.materials, Some(space(state)))?;
        let (grains, walls) = specimen::read(&path, &self.model.physics.materials)?;
        (self.progress.activity, self.progress.state) = test(self.model, grains, walls)?;
        self.progress.files.open(self.out, self.model, true)?;
        self.work = fresh_work(self.model, &mut self.progress.state);
        // whatever may come, the specimen's test can begin again from here
        self.checkpoint()
    }

    /// Stops a run that has lost its meaning, with what there is.
    fn watch(&mut self, last: bool) -> Result<()> {
        let Runner { model, progress, .. } = self;
        let state = &progress.state;
        let mut lost = Ok(());
        if matches!(progress.activity, Activity::Testing(_)) {
            lost = watch::energy(state);
        }
        if last || progress.steps.is_multiple_of(LOOK) {
            lost = lost.and_then(|()| watch::grains(state, model.records.stop_at_overlap, state.step));
        }
        if lost.is_err() {
            self.progress.files.flush(self.out)?;
        }
        lost
    }

    fn checkpoint(&mut self) -> Result<()> {
        self.progress.files.flush(self.out)?;
        checkpoint::save(self.out, &self.progress)?;
        self.last_checkpoint = Instant::now();
        Ok(())
    }
}
