//! The loop of a run: makes steps until the test is done, writes records and checkpoints when they are due, and stops a run that
//! has become meaningless. No other module knows when something is due.

mod backend;
mod continuum;
mod files;
mod folder;
mod grain_crushing;
mod of_scene;
mod progress_bar;
mod simulation;
mod summary;
mod watch;
pub mod words;

use crate::error::{Error, Result};
use crate::host;
use crate::interrupt::{listen, stop_asked};
use crate::machine::peak_memory;
use crate::model::{Model, Rig};
use crate::record::{checkpoint, specimen};
use crate::rig::assembly;
use crate::rig::cylinder::{Stresses, space};
use crate::rig::preparation::{Preparation, range};
use crate::scene::Scene;
use crate::testing::Test;
pub use backend::{Backend, Chosen, choose};
use engine::boundary::CylinderSpace;
use engine::check::{self, Checked, ensure};
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use files::Files;
pub use files::{
    BLOCKS, COLLECTION, DRAWING, DRAWN, FAILED, FIGURES, FINES, GRAINS, GRAINS_FINAL, REPORT, SNAPSHOTS, SUMMARY, WALLS, occupied,
};
pub use folder::{Found, Lock, is_at, last_checkpoint, lock, look, resumable};
pub use of_scene::{SceneOptions, Word, run_scene};
use progress_bar::Bar;
pub use progress_bar::human;
use serde::{Deserialize, Serialize};
pub use simulation::{Simulation, WallNow};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A run to be made: model, output folder and options.
pub struct RunRequest {
    /// The model.
    pub model: Model,
    /// The scene with every default as TOML text ([`crate::scene::resolved`]); running it repeats the run.
    pub scene_resolved: String,
    /// Output folder; made where it does not exist.
    pub out: PathBuf,
    /// Overwrite a run that `out` holds.
    pub force: bool,
    /// Number of threads; `None`: one for each core. Results do not depend on it.
    pub threads: Option<usize>,
    /// File of a prepared specimen to start from; `None`: the specimen is made.
    pub specimen: Option<PathBuf>,
    /// Show no progress on standard error.
    pub quiet: bool,
    /// Not used by the run itself: whether the caller prints the summary as JSON.
    pub json: bool,
    /// Stop with a checkpoint after this many steps, preparation included; on a graphics device at its next record or checkpoint
    /// after them, at most 64 steps later.
    pub stop_after: Option<u64>,
    /// The backend that computes the steps, from [`choose`].
    pub backend: Chosen,
}

impl RunRequest {
    /// The run of a scene by the processor with a thread for each core, which leaves its records in the folder `out`. It shows
    /// no progress and overwrites no other run.
    ///
    /// # Errors
    /// Values of the scene that do not agree.
    pub fn of(scene: &Scene, out: impl Into<PathBuf>) -> Result<RunRequest> {
        Ok(RunRequest {
            model: crate::scene::model(scene)?,
            scene_resolved: crate::scene::resolved(scene),
            out: out.into(),
            force: false,
            threads: None,
            specimen: scene.specimen(),
            quiet: true,
            json: false,
            stop_after: None,
            backend: Chosen::default(),
        })
    }
}

/// Options of a resumed run; as in [`RunRequest`].
#[derive(Clone, Debug, Default)]
pub struct ResumeOptions {
    /// Number of threads; `None`: one for each core.
    pub threads: Option<usize>,
    /// Show no progress on standard error.
    pub quiet: bool,
    /// Not used by the run itself: whether the caller prints the summary as JSON.
    pub json: bool,
    /// Stop with a checkpoint after this many steps, those of the first part included.
    pub stop_after: Option<u64>,
    /// Backend from here on; `None`: the one that the run had.
    pub backend: Option<Backend>,
}

/// A finished run.
#[derive(Debug)]
pub struct Outcome {
    /// The content of `summary.json`.
    pub summary: serde_json::Value,
    /// Output folder.
    pub out: PathBuf,
    /// Whether the scene asks for figures that have not been drawn yet. The laboratory draws none: the caller does, and says so by
    /// [`Outcome::drawn`]; until then the folder counts as a run that lacks its figures.
    pub draw: bool,
    /// Whether the scene asks for a page that shows the run ([`REPORT`]) and has none yet. The caller writes it, after the figures.
    pub report: bool,
}

impl Outcome {
    /// Writes `summary.json` at the end of a run. The seconds spent on figures stand there as null until they are drawn, so that a
    /// run that was killed while its figures were drawn is not taken for a finished one.
    fn undrawn(mut summary: serde_json::Value, out: &Path, model: &Model) -> Result<Outcome> {
        let draw = model.records.figures;
        summary["figure_seconds"] = if draw { serde_json::Value::Null } else { serde_json::json!(0.0) };
        let mut outcome = Outcome { summary, out: out.into(), draw, report: model.records.report };
        outcome.save()?;
        Ok(outcome)
    }

    /// Records that the figures have been drawn in `seconds`, s: sets `draw` to false and writes `summary.json` anew.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn drawn(&mut self, seconds: f64) -> Result<()> {
        self.draw = false;
        self.summary["figure_seconds"] = serde_json::json!(seconds);
        self.save()
    }

    /// Writes `summary.json` with the most memory that the run has taken so far.
    fn save(&mut self) -> Result<()> {
        if let Some(bytes) = peak_memory() {
            self.summary["peak_memory_MB"] = serde_json::json!(1e-6 * bytes);
        }
        files::save_summary(&self.out, &self.summary)
    }
}

/// The stage of a run, with the state of the test that makes it.
#[derive(Debug, Serialize, Deserialize)]
enum Activity {
    Preparing(Preparation),
    Testing(Test),
    Assembly,
}

impl Activity {
    /// Whether the energy ledger of `state` counts what has been done to the grains.
    fn ledger_is_open(&self, state: &State) -> bool {
        match self {
            Activity::Preparing(_) => false,
            // specimens are under stress when it is opened
            Activity::Testing(_) => state.ledger.start[0] > 0.0,
            Activity::Assembly => state.step > 0,
        }
    }
}

/// Everything that a restart needs; the content of the checkpoint.
#[derive(Serialize, Deserialize)]
struct Progress {
    activity: Activity,
    state: State,
    files: Files,
    /// Steps of the run, preparation included.
    steps: u64,
    preparation_steps: u64,
    grains_initial: usize,
    /// Porosities of the loosest and the densest specimen that can be made, where they were measured for the run.
    range: Option<range::Range>,
    /// Sum of the number of grains over all steps of the test: the speed of the run is this over the time.
    grain_steps: u64,
    /// Wall-clock time of the run, s.
    seconds: f64,
    /// Wall-clock time of the test, without the preparation, s.
    loading_seconds: f64,
}

impl Progress {
    /// Checks a progress that was read from a file: whether a run of `model` in the folder `out` can have written it.
    fn check(&self, model: &Model, out: &Path) -> Checked {
        let Progress { activity, state, files, steps, preparation_steps, grains_initial, range, grain_steps: _, seconds, .. } =
            self;
        check::counters("steps", &[*steps, *preparation_steps])?;
        check::not_negative("seconds", [*seconds, self.loading_seconds])?;
        ensure(state.step <= *steps, || format!("step {} of a run of {steps}", state.step))?;
        if let Some(range) = range {
            range.check()?;
        }
        match (activity, &model.rig) {
            (Activity::Preparing(preparation), rig) => match rig.specimen() {
                Some(specimen) => preparation.check(model, specimen, state),
                None => Err("a specimen is prepared which the scene does not have".into()),
            },
            (Activity::Testing(test), _) => test.check(model, state),
            (Activity::Assembly, Rig::Assembly(rig)) => state.check(&model.physics, &assembly::start(model, rig)),
            _ => Err("it is of another kind of run".into()),
        }?;
        files.check(model, state, *grains_initial, out)
    }
}

/// Turns a relative density of the model's specimen into a porosity ([`range::settle`]), in a pool of `threads` threads. Gives
/// the range of porosities that was used, `None` where the model has no relative density.
///
/// # Errors
/// A range that cannot be measured.
pub fn settle(model: &mut Model, threads: Option<usize>) -> Result<Option<range::Range>> {
    in_pool(threads, || range::settle(model))
}

/// Runs a model from the start to the end of its test.
///
/// # Errors
/// - before the start: nothing is written;
/// - during preparation: the reason is written into the folder, which the next run may use;
/// - during the test: records and checkpoint are kept.
pub fn run(request: RunRequest) -> Result<Outcome> {
    let RunRequest { mut model, scene_resolved, out, force, threads, specimen, quiet, stop_after, backend, .. } = request;
    if matches!(model.rig, Rig::GrainCrushing(_)) {
        never_halfway(stop_after)?;
    }
    let begun = match &model.rig {
        Rig::Continuum(rig) => Some(continuum::begin(&model, rig, backend)?),
        _ => None,
    };
    let materials = &model.physics.materials;
    let (given, grown) = match (model.rig.growth(), specimen) {
        (_, None) => (None, None),
        (Some(growth), Some(path)) => (None, Some(specimen::read_grown(&path, growth, materials)?)),
        (None, Some(path)) => (Some(specimen::read(&path, materials)?), None),
    };
    if given.is_none() {
        settle(&mut model, threads)?;
    }
    files::claim(&out, force)?;
    let lock = folder::begin(&out, &scene_resolved)?;
    let folder = out.clone();
    let outcome = in_pool(threads, move || {
        if let Rig::GrainCrushing(rig) = &model.rig {
            return grain_crushing::run(&model, rig, &out, quiet);
        }
        if let (Rig::Continuum(rig), Some(begun)) = (&model.rig, begun) {
            return continuum::run(&model, rig, (begun, grown), &out, quiet, stop_after);
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
        Runner::new(&model, &out, progress, quiet)?.run_to_end(stop_after)
    });
    released(outcome, &folder, lock)
}

/// Passes the outcome on. After an error other than an interruption the folder is freed for the next run if it holds no records
/// yet.
fn released(outcome: Result<Outcome>, out: &Path, lock: Lock) -> Result<Outcome> {
    // the locked file may be removed below
    drop(lock);
    outcome.inspect_err(|error| {
        if !matches!(error, Error::Interrupted { .. }) {
            files::release(out, error);
        }
    })
}

/// Continues the run in the folder `dir` from its checkpoint. The records end with the same bytes as without the stop. Of a run
/// that lacks nothing but its figures the outcome is given back, for the caller to draw them.
///
/// # Errors
/// [`Error::Checkpoint`] for a folder without a checkpoint; the errors of [`run`].
pub fn resume(dir: &Path, options: ResumeOptions) -> Result<Outcome> {
    let ended = files::summary(dir).filter(|_| !checkpoint::exists(dir));
    if ended.as_ref().is_some_and(|summary| !files::lacks_figures(summary)) {
        return Err(Error::Checkpoint { path: dir.into(), what: "the run is finished".into() });
    }
    let scene = crate::scene::load(dir.join(crate::scene::RESOLVED), &[])?;
    let model = crate::scene::model(&scene)?;
    if let Some(summary) = ended {
        return Ok(Outcome { summary, out: dir.into(), draw: true, report: model.records.report });
    }
    let lock = lock(dir)?;
    if !matches!(model.rig, Rig::Continuum(_)) {
        choose(options.backend.unwrap_or_default(), &model)?;
    }
    if let Rig::GrainCrushing(rig) = &model.rig {
        never_halfway(options.stop_after)?;
        return in_pool(options.threads, || grain_crushing::run(&model, rig, dir, options.quiet));
    }
    if let Rig::Continuum(rig) = &model.rig {
        // a checkpoint that is refused frees no folder
        let begun = in_pool(options.threads, || continuum::take_up(&model, rig, dir, options.backend))?;
        let go_on = || continuum::go_on(&model, rig, begun, dir, options.quiet, options.stop_after);
        return released(in_pool(options.threads, go_on), dir, lock);
    }
    let mut progress: Progress = taken_up(dir, |progress: &Progress| progress.check(&model, dir))?;
    progress.files.reopen(dir)?;
    let outcome = in_pool(options.threads, || Runner::new(&model, dir, progress, options.quiet)?.run_to_end(options.stop_after));
    released(outcome, dir, lock)
}

/// The progress of the newest checkpoint in `dir` that is whole and stands the `check`; says so where this is not the newest one.
fn taken_up<T: serde::de::DeserializeOwned>(dir: &Path, check: impl Fn(&T) -> Checked) -> Result<T> {
    let (progress, why) = checkpoint::load(dir, check)?;
    if let Some(why) = why {
        host::warn(&format!("{why}; the run goes on from the checkpoint before it"));
    }
    Ok(progress)
}

/// Refuses to stop a batch of platen tests after some steps: the batch has no checkpoint.
fn never_halfway(stop_after: Option<u64>) -> Result<()> {
    match stop_after {
        None => Ok(()),
        Some(n) => {
            Err(Error::input("run", "stop_after", Some(n.to_string()), "has no meaning in a platen test: it has no checkpoint"))
        }
    }
}

/// Most threads of a run.
pub const MOST_THREADS: usize = 1024;

/// Runs `job` inside a thread pool of its own with `threads` threads (`None`: one for each core), and makes Ctrl-C a wish to stop
/// ([`listen`]). The thread that runs `job` is one of the pool's, and all of them belong to the [`host`] of the calling one.
///
/// # Errors
/// More than [`MOST_THREADS`] threads, or threads that cannot be started; the errors of `job`.
pub fn in_pool<T: Send>(threads: Option<usize>, job: impl FnOnce() -> Result<T> + Send) -> Result<T> {
    let pool = pool(threads)?;
    listen();
    pool.install(job)
}

/// A pool of `threads` threads (`None`: one for each core), all of which belong to the [`host`] of the calling one.
///
/// # Errors
/// More than [`MOST_THREADS`] threads, or threads that cannot be started.
fn pool(threads: Option<usize>) -> Result<rayon::ThreadPool> {
    if let Some(many) = threads.filter(|n| *n > MOST_THREADS) {
        return Err(Error::input("run", "threads", Some(many.to_string()), format!("must be at most {MOST_THREADS}")));
    }
    let host = host::current();
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .start_handler(move |_| drop(host::enter(host.clone())))
        .build()
        .map_err(|e| Error::Failed { step: 0, what: format!("cannot start threads: {e}") })
}

/// Starts the model's test with a prepared specimen.
fn test(model: &Model, grains: Grains, walls: CylinderSpace) -> Result<(Activity, State)> {
    let (test, state) = Test::start(model, grains, walls)?;
    Ok((Activity::Testing(test), state))
}

/// Steps between two checks of the kinetic energy: an instability grows beyond all numbers within some tens of steps.
const CLOSE_LOOK: u64 = 8;
/// Steps between two checks of the grains' positions and overlaps, two updates of the progress bar, and two looks at the clock.
const LOOK: u64 = 64;

/// Whether the number of grains has risen so much since it was `before` that the state is looked at now: where numbers have become meaningless, all grains break
/// at every step, and memory is full before the next look.
fn multiplies(before: usize, now: usize) -> bool {
    now > 2 * before + 1000
}

struct Runner<'a> {
    model: &'a Model,
    out: &'a Path,
    progress: Progress,
    work: Workspace,
    bar: Bar,
    started: Instant,
    last_checkpoint: Instant,
    /// [`watch::first_step_of_grains`].
    first_step: f64,
}

impl<'a> Runner<'a> {
    fn new(model: &'a Model, out: &'a Path, mut progress: Progress, quiet: bool) -> Result<Runner<'a>> {
        let specimen = matches!(progress.activity, Activity::Testing(_));
        progress.files.open(out, model, specimen)?;
        let work = Workspace::sorted(&model.physics, &mut progress.state);
        let now = Instant::now();
        Ok(Runner {
            model,
            out,
            progress,
            work,
            bar: Bar::new(quiet),
            started: now,
            last_checkpoint: now,
            first_step: watch::first_step_of_grains(model),
        })
    }

    fn run_to_end(mut self, stop_after: Option<u64>) -> Result<Outcome> {
        let before = self.progress.seconds;
        let loading_before = self.progress.loading_seconds;
        let mut loading_since = (!matches!(self.progress.activity, Activity::Preparing(_))).then(Instant::now);
        let mut below_least = self.progress.files.recorder.below_least;
        let mut grains = self.progress.state.grains.len();
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
                    // the records so far are kept
                    self.progress.files.sync(self.out)?;
                    return Err(e);
                }
            }
            if stop_asked() || stop_after.is_some_and(|n| self.progress.steps >= n) {
                self.checkpoint()?;
                return Err(Error::Interrupted { step: self.progress.steps, out: self.out.into() });
            }
            let many = multiplies(grains, self.progress.state.grains.len());
            if many || self.progress.steps.is_multiple_of(CLOSE_LOOK) {
                self.watch(many)?;
                grains = self.progress.state.grains.len();
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

    /// One step of the present stage. True when the run is done.
    fn advance(&mut self) -> Result<bool> {
        let Runner { model, out, progress, work, first_step, .. } = self;
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
                files.breakages(out, &work.breakages, state, Some(test.target()))?;
                Ok(test.is_over() || files.ends_below_least(model))
            }
            (_, Rig::Assembly(rig)) => {
                progress.grain_steps += state.grains.len() as u64;
                let last = assembly::done(rig, state);
                assembly::advance(model, state, work, |state, work| {
                    watch::step(model, rig, state, work)?;
                    watch::slow_grains(model, state, work, *first_step)?;
                    files.observe_assembly(out, model, rig, state, work, last)
                })?;
                files.breakages(out, &work.breakages, state, None)?;
                Ok(last)
            }
            _ => unreachable!("a test belongs to its rig"),
        }
    }

    /// Writes the prepared specimen to `specimen.csv` and starts the test from this file: a later run that begins with the file
    /// starts from the same bits.
    fn load(&mut self) -> Result<()> {
        let path = self.out.join(files::SPECIMEN);
        let state = &self.progress.state;
        specimen::write(&path, &state.grains, &self.model.physics.materials, Some(space(state)))?;
        let (grains, walls) = specimen::read(&path, &self.model.physics.materials)?;
        (self.progress.activity, self.progress.state) = test(self.model, grains, walls)?;
        self.progress.files.open(self.out, self.model, true)?;
        self.work = Workspace::sorted(&self.model.physics, &mut self.progress.state);
        // a run that is killed from here on need not prepare its specimen again
        self.checkpoint()
    }

    /// Fails, with all records written, when the state is no longer meaningful ([`watch`]). `whole`: places and overlaps are looked at in any case.
    fn watch(&mut self, whole: bool) -> Result<()> {
        let Runner { model, progress, .. } = self;
        let state = &progress.state;
        let mut lost = Ok(());
        if progress.activity.ledger_is_open(state) {
            lost = watch::energy(state, model.physics.gravity);
        }
        if whole || progress.steps.is_multiple_of(LOOK) {
            lost = lost.and_then(|()| watch::grains(state, model.records.stop_at_overlap, state.step));
        }
        if lost.is_err() {
            self.progress.files.sync(self.out)?;
        }
        lost
    }

    fn checkpoint(&mut self) -> Result<()> {
        self.progress.files.sync(self.out)?;
        checkpoint::save(self.out, &self.progress)?;
        self.last_checkpoint = Instant::now();
        Ok(())
    }
}
