//! The folder of a run and the files in it that grow while the run goes on.

use super::{Progress, lock, watch};
use crate::error::{Error, Result};
use crate::gradation::Gradation;
use crate::model::{Assembly, Model};
use crate::record::ancestors::Ancestors;
use crate::record::breakages::{self, OFF};
use crate::record::crushed::{BREAKAGE, GSD};
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::record::gradations::{self, At};
use crate::record::quasi_static::distance;
use crate::record::vtk::{self, Fact};
use crate::record::{assembly as assembly_records, checkpoint, contacts, specimen, walls};
use crate::rig::cylinder::{Stresses, space};
use engine::check::Checked;
use engine::dem::event::Breakage;
use engine::dem::observables;
use engine::dem::{State, Workspace};
use engine::mpm::Continuum;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use table::Table;

pub use crate::scene::SPECIMEN;
/// Rows of the state over time.
pub const HISTORY: &str = "history.csv";
/// Tracks of the grains of a free scene.
pub const TRACKS: &str = "tracks.csv";
/// What a finished run found.
pub const SUMMARY: &str = "summary.json";
/// A summary that is being written.
const SUMMARY_TEMPORARY: &str = "summary.tmp";
/// The grains at the end.
pub const GRAINS_FINAL: &str = "grains_final.csv";
/// Folder of the snapshots.
pub const SNAPSHOTS: &str = "snapshots";
/// ParaView list of the snapshots of grains, or of the points of a continuum.
pub const COLLECTION: &str = "snapshots.pvd";
/// ParaView list of the snapshots of walls.
pub const WALLS: &str = "walls.pvd";
/// ParaView list of the snapshots of the grains in a continuum.
pub const GRAINS: &str = "grains.pvd";
/// ParaView list of the snapshots of rigid bodies that are no spheres.
pub const BLOCKS: &str = "blocks.pvd";
/// ParaView list of the snapshots of points that breakages have left among grains.
pub const FINES: &str = "fines.pvd";
/// The only file of a run that failed before its test began: the reason, and the scene. The next run may use such a folder.
pub const FAILED: &str = "failed.scene.toml";
/// The files that a run leaves, besides its scene, snapshots and figures. Overwriting a run removes these and nothing else.
const OURS: [&str; 31] = [
    FAILED,
    REPORT,
    SPECIMEN,
    SUMMARY,
    SUMMARY_TEMPORARY,
    COLLECTION,
    WALLS,
    GRAINS,
    FINES,
    HISTORY,
    GSD,
    BREAKAGE,
    TRACKS,
    crate::record::grain_crushing::TESTS,
    crate::record::grain_crushing::CURVES,
    crate::record::grain_crushing::SURVIVAL,
    crate::record::grain_crushing::LIMITS,
    GRAINS_FINAL,
    "grains_start.csv",
    crate::record::continuum::START,
    crate::record::continuum::END,
    crate::record::blocks::TRACKS,
    crate::record::blocks::SURFACES,
    crate::record::joints::JOINTS,
    crate::record::wall_rows::WALL_ROWS,
    crate::record::block_breakages::BLOCK_BREAKAGE,
    BLOCKS,
    crate::record::account::ACCOUNT,
    checkpoint::FILE,
    checkpoint::PREVIOUS,
    checkpoint::TEMPORARY,
];
/// The page that shows the run, where `run --report` or the scene (`records.report`) asked for it.
pub const REPORT: &str = "report.html";
/// Folder of the figures.
pub const FIGURES: &str = "figures";
/// Folder in which figures are drawn, before they are moved to [`FIGURES`].
pub const DRAWING: &str = "figures.drawing";
/// In the folder of the figures: the names of all that were drawn, one in a line.
pub const DRAWN: &str = "drawn.txt";

/// Whether the folder holds anything but the message of a run that failed before its test began.
pub fn occupied(out: &Path) -> bool {
    out.read_dir().is_ok_and(|entries| entries.flatten().any(|e| e.file_name() != FAILED))
}

/// Frees the folder of a run that failed before its test began: replaces its files by one with the reason `why` and the scene. A
/// run that has records keeps all of them. Files that no run writes are not touched.
pub fn release(out: &Path, why: &Error) {
    let begun = [SPECIMEN, SUMMARY, HISTORY, crate::record::continuum::START, crate::record::grain_crushing::TESTS];
    let resolved = out.join(crate::scene::RESOLVED);
    let Ok(scene) = std::fs::read_to_string(&resolved) else { return };
    if begun.iter().any(|name| out.join(name).exists()) {
        return;
    }
    let why: String = why.to_string().lines().map(|line| format!("# {line}\n")).collect();
    let head = "# This run failed before its test began:\n";
    let tail = "# The scene with every default follows; the next run in this folder removes this file.\n\n";
    if table::write(out.join(FAILED), format!("{head}{why}{tail}{scene}")).is_ok() {
        // where a file cannot be removed, the folder stays occupied
        let _ = std::fs::remove_file(resolved);
        let _ = checkpoint::remove(out);
    }
}

/// Makes the folder `out`. With `force` the files of an old run in it are removed, the scene last: a folder that is killed halfway is
/// still one that held a run.
///
/// # Errors
/// [`Error::Busy`] while another process runs there; [`Error::Exists`] for a folder with a run, without `force`; with `force`, a folder with files that never held a run, or snapshots
/// or figures that no run has written, nothing being removed then; a folder or file that cannot be changed.
pub fn claim(out: &Path, force: bool) -> Result<()> {
    // in this order: a run that another process begins after the first line is never taken for an old one
    let occupied = occupied(out);
    let _busy = lock(out)?;
    if occupied && !force {
        return Err(Error::Exists { path: out.into() });
    }
    if occupied {
        let ours = written(out)?;
        for path in ours.iter().filter(|path| path.symlink_metadata().is_ok()) {
            std::fs::remove_file(path).map_err(Error::write(path))?;
        }
        for folder in [SNAPSHOTS, FIGURES, DRAWING].map(|name| out.join(name)).iter().filter(|folder| folder.is_dir()) {
            std::fs::remove_dir(folder).map_err(Error::write(folder))?;
        }
        remove(&out.join(crate::scene::RESOLVED))?;
    }
    remove(&out.join(FAILED))?;
    std::fs::create_dir_all(out).map_err(Error::write(out))
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(e) if !matches!(e.kind(), std::io::ErrorKind::NotFound | std::io::ErrorKind::NotADirectory) => {
            Err(Error::write(path)(e))
        }
        _ => Ok(()),
    }
}

/// Whether a run has given a file this name.
type Known<'a> = &'a dyn Fn(&str) -> bool;

/// What the run in the folder `out` may have written besides its scene.
///
/// # Errors
/// A folder that never held a run; a snapshot or figure that no run has written, by name.
fn written(out: &Path) -> Result<Vec<PathBuf>> {
    if ![crate::scene::RESOLVED, FAILED].iter().any(|name| out.join(name).exists()) {
        let message = "holds files but no run, so that nothing in it is overwritten; choose another folder";
        return Err(Error::input(out.display(), "", None, message));
    }
    let drawn = std::fs::read_to_string(out.join(FIGURES).join(DRAWN)).unwrap_or_default();
    let snapshot = |name: &str| {
        let digits = name.rsplit_once('_').and_then(|(_, rest)| rest.split_once('.'));
        digits.is_some_and(|(step, ending)| step.bytes().all(|b| b.is_ascii_digit()) && ["vtp", "csv"].contains(&ending))
    };
    let figure = |name: &str| name == DRAWN || drawn.lines().any(|line| line == name);
    let any = |_: &str| true;
    let mut ours: Vec<PathBuf> = OURS.iter().map(|name| out.join(name)).collect();
    let folders: [(&str, Known); 3] = [(SNAPSHOTS, &snapshot), (FIGURES, &figure), (DRAWING, &any)];
    for (folder, known) in folders {
        for entry in out.join(folder).read_dir().into_iter().flatten().flatten() {
            let name = entry.file_name();
            let file = entry.file_type().is_ok_and(|kind| !kind.is_dir());
            if !(file && name.to_str().is_some_and(known)) {
                let message = "was not written by a run, so that nothing here is overwritten; move it, or choose another folder";
                return Err(Error::input(entry.path().display(), "", None, message));
            }
            ours.push(entry.path());
        }
    }
    Ok(ours)
}

/// Tables and snapshots with what is needed to continue them.
#[derive(Serialize, Deserialize)]
pub struct Files {
    history: Table,
    gsd: Table,
    breakage: Table,
    tracks: Table,
    pub recorder: Recorder,
    /// Snapshots written.
    snapshots: Vec<Snapshot>,
    ancestors: Ancestors,
    /// Gradation before loading; read again from the specimen when a run is resumed.
    #[serde(skip)]
    pub initial: Option<Gradation>,
}

impl Default for Files {
    fn default() -> Files {
        Files {
            history: Table::new(HISTORY),
            gsd: Table::new(GSD),
            breakage: Table::new(BREAKAGE),
            tracks: Table::new(TRACKS),
            recorder: Recorder::default(),
            snapshots: Vec::new(),
            ancestors: Ancestors::default(),
            initial: None,
        }
    }
}

impl Files {
    /// Goes on with the tables of a checkpoint, whose files are in `out`.
    ///
    /// # Errors
    /// A file that lacks rows which the checkpoint knows.
    pub fn reopen(&mut self, out: &Path) -> Result<()> {
        self.history.reopen(out, HISTORY)?;
        self.gsd.reopen(out, GSD)?;
        self.breakage.reopen(out, BREAKAGE)?;
        Ok(self.tracks.reopen(out, TRACKS)?)
    }

    /// Checks what a checkpoint says of the records against its state and the tables in `out`; `grains`: number of grains at the start.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, state: &State, grains: usize, out: &Path) -> Checked {
        let tables = [(&self.history, HISTORY), (&self.gsd, GSD), (&self.breakage, BREAKAGE), (&self.tracks, TRACKS)];
        tables.into_iter().try_for_each(|(table, name)| table.check(out, name))?;
        self.ancestors.check(model, state, grains)?;
        self.recorder.check(state)
    }

    /// Prepares for records of a test. With `specimen` the mass and the gradation before loading are read from `specimen.csv`.
    ///
    /// # Errors
    /// A specimen file that cannot be read.
    pub fn open(&mut self, out: &Path, model: &Model, specimen: bool) -> Result<()> {
        if specimen {
            let (grains, _) = specimen::read(&out.join(SPECIMEN), &model.physics.materials)?;
            self.recorder.mass = grains.mass_and_volume().0;
            self.initial = Some(gradations::initial(model, &grains));
        }
        Ok(())
    }

    /// Writes a record of a specimen under test, if one is `due`: a row of the history, and for [`Due::Full`] a gradation and a
    /// snapshot. `fines` are material points among the grains; `moment` gives what only the test knows.
    ///
    /// # Errors
    /// A file that cannot be written; an energy ledger that is not finite; a specimen without voids ([`watch::voids`]).
    pub fn observe(
        &mut self,
        out: &Path,
        model: &Model,
        (state, work): (&State, &Workspace),
        fines: Option<&Continuum>,
        due: Option<Due>,
        moment: impl FnOnce() -> Moment,
    ) -> Result<()> {
        let (Some(due), Some(initial)) = (due, &self.initial) else { return Ok(()) };
        let moment = moment();
        let stage = moment.stage;
        let row = self.recorder.row(model, moment, state, work, initial)?;
        self.history.push(out, &row)?;
        let voids = watch::voids(model, state.step, &self.recorder.at_end);
        if due == Due::Full || self.ends_below_least(model) || voids.is_err() {
            let sigma_v = Stresses::of(state).vertical();
            let at = At { step: state.step, stage, sigma_v, axial_strain: self.recorder.at_end.axial_strain };
            for row in gradations::rows(model, &gradations::gradation(model, state), &at, initial) {
                self.gsd.push(out, &row)?;
            }
            let facts =
                [("step", state.step as f64), ("sigma_v_kPa", 1e-3 * sigma_v), ("axial_strain", self.recorder.at_end.axial_strain)];
            self.instant(out, model, state, work, self.snapshots.len() as f64, &facts)?;
            if let (Some(fines), true) = (fines, model.records.snapshots) {
                crate::record::continuum::write_snapshot(
                    &out.join(format!("{SNAPSHOTS}/fines_{:08}.vtp", state.step)),
                    &facts,
                    fines,
                )?;
                let failed = vtk::VtkError::at(state.step);
                vtk::write_collection(&out.join(FINES), &listed(&self.snapshots, "fines_")).map_err(failed)?;
            }
        }
        if model.records.energy && !self.recorder.energy_error.is_finite() {
            return Err(Error::Unstable { step: state.step, what: "the energy ledger is not a number".into(), grain: None });
        }
        voids
    }

    /// Whether the run is to end because the void ratio has fallen below `records.least_void_ratio`.
    pub fn ends_below_least(&self, model: &Model) -> bool {
        model.records.end_below_least && self.recorder.below_least.is_some()
    }

    /// Writes a record of a free scene, if one is due or `last`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn observe_assembly(
        &mut self,
        out: &Path,
        model: &Model,
        rig: &Assembly,
        state: &State,
        work: &Workspace,
        last: bool,
    ) -> Result<()> {
        if !last && !state.step.is_multiple_of(rig.record_every) {
            return Ok(());
        }
        self.history.push(out, &assembly_records::history_row(model, state, work))?;
        for row in assembly_records::track_rows(model, rig, state, work) {
            self.tracks.push(out, &row)?;
        }
        if last || state.step == 0 {
            self.instant(out, model, state, work, state.time, &[("step", state.step as f64), ("time_s", state.time)])?;
        }
        Ok(())
    }

    /// Writes a row for each breakage of a step. `test`: of a test on a specimen the present target of the vertical stress, Pa, if it has
    /// one; `None`: a free scene.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn breakages(&mut self, out: &Path, breakages: &[Breakage], state: &State, test: Option<Option<f64>>) -> Result<()> {
        if breakages.is_empty() {
            return Ok(());
        }
        let sigma_v = test.map_or(f64::NAN, |_| Stresses::of(state).vertical());
        let off = test.flatten().is_some_and(|target| distance(sigma_v, target) > OFF);
        for b in breakages {
            self.recorder.broken.add(b, off);
            self.ancestors.add(b);
            self.breakage.push(out, &breakages::row(b, b.step, sigma_v))?;
        }
        Ok(())
    }

    /// Writes snapshots of grains and walls, and the contacts, as far as the scene asks for them. `at` is the value on ParaView's
    /// time axis; `facts` are noted in each file.
    fn instant(&mut self, out: &Path, model: &Model, state: &State, work: &Workspace, at: f64, facts: &[Fact]) -> Result<()> {
        if !(model.records.snapshots || model.records.contacts) {
            return Ok(());
        }
        let dir = out.join(SNAPSHOTS);
        table::folder(&dir).map_err(Error::write(&dir))?;
        let touching = contacts::of_grains(state);
        if model.records.contacts {
            let names = contacts::names(&state.walls, model.rig.specimen().is_some());
            let path = dir.join(format!("contacts_{:08}.csv", state.step));
            contacts::write(&path, facts, &state.grains, &names, &touching)?;
        }
        if model.records.snapshots {
            self.snapshot(out, model, state, work, &contacts::mean_stresses(&state.grains, &touching), at, facts)?;
        }
        Ok(())
    }

    #[allow(clippy::too_many_arguments)]
    fn snapshot(
        &mut self,
        out: &Path,
        model: &Model,
        state: &State,
        work: &Workspace,
        stresses: &[f64],
        at: f64,
        facts: &[Fact],
    ) -> Result<()> {
        let name = snapshot_name("step_", state.step);
        let g = &state.grains;
        let order = g.by_id();
        let forces = observables::largest_forces(state, work);
        let pick = |f: &dyn Fn(usize) -> f64| order.iter().map(|&i| f(i as usize)).collect::<Vec<f64>>();
        let daughters = model.physics.crush.as_ref().map_or(1, |c| c.pattern.count());
        let descent = order.iter().map(|&i| self.ancestors.of(g.id[i as usize], g.next_id, daughters));
        let (mother, ancestor) = descent.map(|(m, a)| (m.map_or(-1, i64::from), i64::from(a))).unzip();
        let data = vtk::SnapshotData {
            position: order.iter().map(|&i| [g.pos[i as usize][0], g.pos[i as usize][1], g.pos[i as usize][2]]).collect(),
            radius: pick(&|i| g.radius(i)),
            generation: order.iter().map(|&i| u32::from(g.generation[i as usize])).collect(),
            strength: pick(&|i| g.strength[i]),
            force: pick(&|i| forces[i]),
            velocity: order.iter().map(|&i| [g.vel[i as usize][0], g.vel[i as usize][1], g.vel[i as usize][2]]).collect(),
            id: order.iter().map(|&i| u64::from(g.id[i as usize])).collect(),
            mean_stress: pick(&|i| stresses[i]),
            mother,
            ancestor,
        };
        let failed = vtk::VtkError::at(state.step);
        vtk::write_snapshot(&out.join(&name), facts, &data).map_err(failed)?;
        self.snapshots.push((at, state.step));
        vtk::write_collection(&out.join(COLLECTION), &listed(&self.snapshots, "step_")).map_err(failed)?;
        let loaded: Vec<walls::Loaded> = state.walls.iter().map(|w| (w.shape, w.reaction)).collect();
        write_walls(out, state.step, g.pos.iter().copied(), &loaded, facts, &self.snapshots)
    }

    /// Brings all rows to the disk.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn sync(&mut self, out: &Path) -> Result<()> {
        for table in [&mut self.history, &mut self.gsd, &mut self.breakage, &mut self.tracks] {
            table.sync(out)?;
        }
        Ok(())
    }
}

/// Writes a snapshot of the walls `loaded`, where there are some, and the list of all snapshots of walls: one for each entry of
/// `snapshots`. `bodies` (centre and radius) bound the part of an infinite plane that is drawn.
pub fn write_walls(
    out: &Path,
    step: u64,
    bodies: impl Iterator<Item = [f64; 4]>,
    loaded: &[walls::Loaded],
    facts: &[Fact],
    snapshots: &[Snapshot],
) -> Result<()> {
    if loaded.is_empty() {
        return Ok(());
    }
    let failed = vtk::VtkError::at(step);
    let path = out.join(snapshot_name("walls_", step));
    walls::write(&path, facts, loaded, walls::space(bodies, loaded)).map_err(failed)?;
    vtk::write_collection(&out.join(WALLS), &listed(snapshots, "walls_")).map_err(failed)
}

/// A snapshot: its place on ParaView's time axis (number from 0, or time, s, of a free scene), and its step. Its files follow from
/// the step: a checkpoint names no files.
pub type Snapshot = (f64, u64);

/// File of a snapshot of the kind `kind` (`step_`, `walls_`, `grains_`, `fines_`), relative to the run's folder.
pub fn snapshot_name(kind: &str, step: u64) -> String {
    format!("{SNAPSHOTS}/{kind}{step:08}.vtp")
}

/// The snapshots with their files of the kind `kind`.
pub fn listed(snapshots: &[Snapshot], kind: &str) -> Vec<(f64, String)> {
    snapshots.iter().map(|&(at, step)| (at, snapshot_name(kind, step))).collect()
}

/// Writes the grains at the end of a run.
pub fn write_final(out: &Path, model: &Model, progress: &Progress) -> Result<()> {
    let walls = model.rig.specimen().map(|_| space(&progress.state));
    specimen::write_final(&out.join(GRAINS_FINAL), &progress.state, model, walls)
}

/// The content of `summary.json` in the folder `out`; `None` where there is none that can be read.
pub fn summary(out: &Path) -> Option<serde_json::Value> {
    let text = std::fs::read_to_string(out.join(SUMMARY)).ok()?;
    serde_json::from_str(&text).ok()
}

/// Whether a summary is that of a run whose figures have not been drawn yet ([`super::Outcome::undrawn`]).
pub fn lacks_figures(summary: &serde_json::Value) -> bool {
    summary["figure_seconds"].is_null()
}

/// Writes `summary.json`, in one operation of the file system.
///
/// # Errors
/// A file that cannot be written.
pub fn save_summary(out: &Path, summary: &serde_json::Value) -> Result<()> {
    let (path, temporary) = (out.join(SUMMARY), out.join(SUMMARY_TEMPORARY));
    let text = serde_json::to_string_pretty(summary).unwrap_or_default() + "\n";
    let write = || {
        table::write(&temporary, text)?;
        std::fs::rename(&temporary, &path)
    };
    write().map_err(Error::write(&path))
}
