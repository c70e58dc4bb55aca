//! The loop of a continuum or mixture: steps, records, checkpoints, stop, and the files at the end.
//!
//! On the CPU a call of [`Moving::advance`] makes one step; on a graphics device it makes as many as possible until something is due. The
//! [`Engine`] makes the steps, and copies points and grains back from the device for records and checkpoints.

pub(super) mod step;
mod tables;

use super::backend::{Backend, Chosen, Used, choose};
use super::progress_bar::Bar;
use super::{LOOK, Outcome, files};
use crate::error::{Error, Result};
use crate::interrupt::stop_asked;
use crate::model::Model;
use crate::model::continuum::{MpmSpecimen, MpmTest, Test};
use crate::record::continuum as records;
use crate::record::continuum::{END, GRAINS_START, Recorder, START};
use crate::record::crushed::Crushed;
use crate::record::{account, blocks, checkpoint, joints, specimen, wall_rows};
use crate::rig::continuum::{Engine, Growing, Grown, Phase, State, growing};
use engine::check::{self, Checked};
use engine::coupling::Mixture;
use engine::mpm::law::Law;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::Path;
use std::time::{Duration, Instant};
use step::{Looks, Moving};
use table::Table;
use tables::Tables;

/// Everything that a restart needs; the content of the checkpoint.
#[derive(Serialize, Deserialize)]
struct Progress {
    state: State,
    /// The specimen while it grows.
    growing: Option<Box<Growing>>,
    /// The specimen after it has grown.
    grown: Option<Grown>,
    used: Used,
    recorder: Recorder,
    history: Table,
    /// Tracks of rigid bodies; a run without rigid bodies has no such file.
    blocks: Table,
    /// Surfaces of rigid bodies, with those of the pieces of bodies that have broken.
    surfaces: Table,
    /// What joints of rigid bodies bear; a run without joints has no such file.
    joints: Table,
    /// Places of the walls and forces on them, where one of them moves.
    walls: Table,
    /// Rows of the energy account; a run that keeps none has no such file.
    account: Table,
    /// Tables of breakages and gradations.
    crushed: Crushed,
    /// Time, s, and step of each snapshot.
    snapshots: Vec<files::Snapshot>,
    /// Wall-clock time of the run, s.
    seconds: f64,
    /// CPU time of the process in user mode, s.
    user_seconds: f64,
    /// What is known of earlier steps.
    #[serde(skip)]
    looks: Looks,
}

/// A run that is set up and has not written any file.
pub struct Begun {
    progress: Progress,
    /// What makes the steps of the test; while the specimen grows, which no engine does, [`Engine::Cpu`] stands for it.
    engine: Engine,
}

/// Sets up points, grains and the engine for a run. Writes nothing.
///
/// # Errors
/// A grid, step or grain that the method does not allow; a graphics device that cannot compute the scene.
pub fn begin(model: &Model, rig: &MpmTest, chosen: Chosen) -> Result<Begun> {
    let mut used = Used::default();
    used.note(chosen);
    let mut state = State::start(model, rig)?;
    let engine = if rig.growth.is_some() { Engine::Cpu } else { used.engine(&mut state, model, rig)? };
    let (history, blocks, account) = (Table::new(files::HISTORY), Table::new(blocks::TRACKS), Table::new(account::ACCOUNT));
    let (surfaces, joints) = (Table::new(blocks::SURFACES), Table::new(joints::JOINTS));
    let walls = Table::new(wall_rows::WALL_ROWS);
    let (recorder, crushed, snapshots) = (Recorder::default(), Crushed::default(), Vec::new());
    let (growing, grown, [seconds, user_seconds]) = (None, None, [0.0; 2]);
    let progress = Progress {
        state,
        growing,
        grown,
        used,
        recorder,
        history,
        blocks,
        surfaces,
        joints,
        walls,
        account,
        crushed,
        snapshots,
        seconds,
        user_seconds,
        looks: Looks::default(),
    };
    Ok(Begun { progress, engine })
}

/// What accompanies a loop of steps: progress bar, clock, wishes to stop, checkpoints.
struct Beside<'a> {
    model: &'a Model,
    out: &'a Path,
    stop_after: Option<u64>,
    bar: Bar,
    clock: Clock,
    saved: Instant,
}

impl<'a> Beside<'a> {
    fn new(model: &'a Model, out: &'a Path, quiet: bool, stop_after: Option<u64>, progress: &Progress) -> Beside<'a> {
        Beside { model, out, stop_after, bar: Bar::new(quiet), clock: Clock::new(progress), saved: Instant::now() }
    }

    /// Writes a checkpoint if one is due. `steps` are the steps of the present loop, `before` those of the loop before it.
    ///
    /// # Errors
    /// [`Error::Interrupted`], after a checkpoint, when the run is to stop.
    fn look(&mut self, before: u64, steps: u64, progress: &mut Progress, engine: &Engine) -> Result<()> {
        let stop = stop_asked() || self.stop_after.is_some_and(|n| before + steps >= n);
        let pause = Duration::from_secs_f64(self.model.records.checkpoint_seconds);
        if stop || steps.is_multiple_of(LOOK) && self.saved.elapsed() > pause {
            self.clock.read(progress);
            progress.save(engine, self.model, self.out)?;
            self.saved = Instant::now();
        }
        if stop { Err(Error::Interrupted { step: steps, out: self.out.into() }) } else { Ok(()) }
    }
}

/// Grows the specimen, where the scene asks for it, and gives the rig with the grown points and grains, which replaces that of
/// the scene. `None`: the specimen need not grow.
///
/// # Errors
/// A specimen that does not come to rest; [`Error::Interrupted`], after a checkpoint.
fn grow(
    model: &Model,
    rig: &MpmTest,
    begun: &mut Begun,
    out: &Path,
    quiet: bool,
    stop_after: Option<u64>,
) -> Result<Option<MpmTest>> {
    let Begun { progress, engine } = begun;
    let Some(growth) = &rig.growth else { return Ok(None) };
    let mut beside = Beside::new(model, out, quiet, stop_after, progress);
    let by = growing(&model.physics);
    let mut work = progress.growing.as_mut().map(|specimen| specimen.work(&by));
    while let (Some(specimen), Some(work)) = (&mut progress.growing, &mut work) {
        if specimen.advance(&by, rig, growth, work)? {
            break;
        }
        let (steps, doing) = (specimen.steps(), specimen.doing());
        beside.look(0, steps, progress, engine)?;
        if steps.is_multiple_of(LOOK) {
            let share = steps as f64 / growth.max_steps as f64;
            beside.bar.show_share(steps, 0.0, || (share, format!("specimen: {doing}")));
        }
    }
    beside.clock.read(progress);
    if let Some(specimen) = progress.growing.take() {
        progress.grown = Some(specimen.grown());
    }
    let Some(grown) = &progress.grown else { return Ok(None) };
    specimen::write_grown(&out.join(files::SPECIMEN), grown, growth, &model.physics.materials)?;
    let own = grown.rig(model, rig, growth);
    progress.state = State::start(model, &own)?;
    *engine = progress.used.engine(&mut progress.state, model, &own)?;
    Ok(Some(own))
}

/// Measures the time spent on a run, that before the last checkpoint included.
struct Clock {
    started: Instant,
    /// Wall-clock and CPU time at the start of this process's part, s.
    before: [f64; 2],
}

impl Clock {
    fn new(progress: &Progress) -> Clock {
        Clock { started: Instant::now(), before: [progress.seconds, progress.user_seconds - user_seconds()] }
    }

    fn read(&self, progress: &mut Progress) {
        progress.seconds = self.before[0] + self.started.elapsed().as_secs_f64();
        progress.user_seconds = self.before[1] + user_seconds();
    }
}

/// Runs from the start to the end of the test; with `grown` from this specimen, where else one would grow.
///
/// # Errors
/// Any error of growth, steps or files; records and checkpoint are kept.
pub fn run(
    model: &Model,
    rig: &MpmTest,
    (mut begun, grown): (Begun, Option<Grown>),
    out: &Path,
    quiet: bool,
    stop_after: Option<u64>,
) -> Result<Outcome> {
    begun.progress.grown = grown;
    if let (Some(growth), None) = (&rig.growth, &begun.progress.grown) {
        begun.progress.growing = Some(Box::new(Growing::start(model, rig, growth)?));
    }
    prepared(model, rig, begun, out, quiet, stop_after)
}

/// Grows the specimen if it has to be, writes the points and grains at the start of the test, and makes the test.
fn prepared(model: &Model, rig: &MpmTest, mut begun: Begun, out: &Path, quiet: bool, stop_after: Option<u64>) -> Result<Outcome> {
    let own = grow(model, rig, &mut begun, out, quiet, stop_after)?;
    let rig = own.as_ref().unwrap_or(rig);
    if has_points(&begun.progress.state) {
        records::write_points(&out.join(START), rig, &rig.points, None)?;
    }
    if let Some(mixture) = of_grains(&begun.progress.state) {
        specimen::write(&out.join(GRAINS_START), &mixture.grains.grains, &model.physics.materials, None)?;
    }
    let Progress { state, surfaces, .. } = &mut begun.progress;
    if let Some(theirs) = state.blocks() {
        let rows = (0..theirs.blocks.len()).flat_map(|k| blocks::surface(theirs, k));
        rows.into_iter().try_for_each(|row| surfaces.push(out, &row))?;
    }
    make_test(model, rig, out, begun, quiet, stop_after)
}

/// Takes up the run of the checkpoint in `out`, on the run's last backend unless another one is asked for.
///
/// # Errors
/// Those of [`begin`]; a folder without a checkpoint, or one that cannot be used; a table that lacks rows.
pub fn take_up(model: &Model, rig: &MpmTest, out: &Path, backend: Option<Backend>) -> Result<Begun> {
    let mut progress: Progress = super::taken_up(out, |progress: &Progress| progress.check(model, rig, out))?;
    progress.history.reopen(out, files::HISTORY)?;
    progress.blocks.reopen(out, blocks::TRACKS)?;
    progress.surfaces.reopen(out, blocks::SURFACES)?;
    progress.joints.reopen(out, joints::JOINTS)?;
    progress.walls.reopen(out, wall_rows::WALL_ROWS)?;
    progress.account.reopen(out, account::ACCOUNT)?;
    progress.crushed.reopen(out)?;
    let same = if progress.used.gpu() { Backend::Gpu } else { Backend::Cpu };
    let chosen = choose(backend.unwrap_or(same), model)?;
    progress.used.note(chosen);
    if progress.growing.is_some() {
        return Ok(Begun { progress, engine: Engine::Cpu });
    }
    let own = progress.own(model, rig);
    let engine = progress.used.engine(&mut progress.state, model, own.as_ref().unwrap_or(rig))?;
    Ok(Begun { progress, engine })
}

/// Continues a run that [`take_up`] has taken up.
///
/// # Errors
/// Those of [`run`].
pub fn go_on(model: &Model, rig: &MpmTest, begun: Begun, out: &Path, quiet: bool, stop_after: Option<u64>) -> Result<Outcome> {
    if begun.progress.growing.is_some() {
        return prepared(model, rig, begun, out, quiet, stop_after);
    }
    let own = begun.progress.own(model, rig);
    make_test(model, own.as_ref().unwrap_or(rig), out, begun, quiet, stop_after)
}

fn make_test(model: &Model, rig: &MpmTest, out: &Path, begun: Begun, quiet: bool, stop_after: Option<u64>) -> Result<Outcome> {
    let Begun { mut progress, mut engine } = begun;
    progress.crushed.open(model, rig);
    progress.looks = Looks::new(model, rig, &progress.state);
    let mut beside = Beside::new(model, out, quiet, stop_after, &progress);
    let before = progress.grown.as_ref().map_or(0, |g| g.steps);
    loop {
        let done = progress.advance(model, rig, &mut engine, out);
        beside.clock.read(&mut progress);
        match done {
            Ok(true) => break,
            Ok(false) => {}
            Err(e) => {
                // keep the records, and the points as they are now; those of a lost device are the points of the last record
                let _ = engine.read_back(&mut progress.state, model);
                progress.sync(out)?;
                // a state that cannot be written is not: what ended the run is told
                let _ = leave(model, rig, &progress.state, out);
                return Err(e);
            }
        }
        let steps = progress.state.continuum.steps();
        beside.look(before, steps, &mut progress, &engine)?;
        if steps.is_multiple_of(LOOK) {
            beside.bar.show_share(steps, progress.seconds, || describe(rig, &progress.state));
        }
    }
    beside.bar.finish();
    finish(model, rig, out, progress, &engine)
}

impl Progress {
    /// The rig with the grown points and grains, where the specimen has grown.
    fn own(&self, model: &Model, rig: &MpmTest) -> Option<MpmTest> {
        self.grown.as_ref().zip(rig.growth.as_ref()).map(|(grown, growth)| grown.rig(model, rig, growth))
    }

    /// Checks a progress that was read from a file: whether a run of `rig` in the folder `out` can have written it.
    fn check(&self, model: &Model, rig: &MpmTest, out: &Path) -> Checked {
        match (&self.growing, &self.grown, &rig.growth) {
            (Some(growing), None, Some(growth)) => growing.check(model, rig, growth)?,
            (None, Some(grown), Some(_)) => grown.check()?,
            (None, None, None) => {}
            _ => return Err("a specimen grows which the scene does not grow, or has not grown which it does".into()),
        }
        let own = self.own(model, rig);
        self.state.check(model, own.as_ref().unwrap_or(rig))?;
        self.crushed.check(model, &self.state, out)?;
        self.history.check(out, files::HISTORY)?;
        self.blocks.check(out, blocks::TRACKS)?;
        self.surfaces.check(out, blocks::SURFACES)?;
        self.joints.check(out, joints::JOINTS)?;
        self.walls.check(out, wall_rows::WALL_ROWS)?;
        self.account.check(out, account::ACCOUNT)?;
        self.used.check()?;
        check::not_negative("seconds", [self.seconds, self.user_seconds])
    }

    /// One step, or on a device as many as it makes until something is due, with the records that are due. True when the run is done.
    fn advance(&mut self, model: &Model, rig: &MpmTest, engine: &mut Engine, out: &Path) -> Result<bool> {
        let Progress { state, recorder, history, blocks, surfaces, joints, walls, account, crushed, snapshots, looks, .. } = self;
        let mut moving = Moving { model, rig, state, engine, recorder, crushed, looks };
        moving.advance(&mut Tables { out, history, blocks, surfaces, joints, walls, account, snapshots })
    }

    fn sync(&mut self, out: &Path) -> Result<()> {
        self.blocks.sync(out)?;
        self.surfaces.sync(out)?;
        self.joints.sync(out)?;
        self.walls.sync(out)?;
        self.account.sync(out)?;
        self.crushed.sync(out)?;
        Ok(self.history.sync(out)?)
    }

    fn save(&mut self, engine: &Engine, model: &Model, out: &Path) -> Result<()> {
        self.used.save(engine, model, &mut self.state)?;
        self.sync(out)?;
        checkpoint::save(out, self)?;
        self.used.saved = None;
        Ok(())
    }
}

/// Whether there are material points, or breakages may bring some.
fn has_points(state: &State) -> bool {
    !state.continuum.points().is_empty() || state.mixture.as_ref().is_some_and(|mixture| mixture.fines.is_some())
}

/// The mixture, if it has grains: breakages leave some.
fn of_grains(state: &State) -> Option<&Mixture> {
    state.mixture.as_deref().filter(|mixture| !mixture.grains.grains.is_empty())
}

/// Writes the points and grains at the end, as far as there are some.
fn leave(model: &Model, rig: &MpmTest, state: &State, out: &Path) -> Result<()> {
    if let Some(mixture) = of_grains(state) {
        specimen::write_final(&out.join(files::GRAINS_FINAL), &mixture.grains, model, None)?;
    }
    if !has_points(state) {
        return Ok(());
    }
    records::write_points(&out.join(END), rig, state.continuum.points(), Some(&rig.points))
}

/// Share of the test that is done, and a line about it for the progress bar.
fn describe(rig: &MpmTest, state: &State) -> (f64, String) {
    let share = state.share(rig);
    let of = match (state.continuum.points().len(), state.blocks()) {
        (0, Some(blocks)) => format!("{} bodies", blocks.blocks.len()),
        (points, _) => format!("{points} points"),
    };
    let line = match &rig.test {
        Test::Oedometer(_) if state.phase == Phase::Settle => format!("settling at the seating stress, {of}"),
        _ if state.phase == Phase::Settle => format!("settling at the cell pressure, {of}"),
        Test::Free { .. } => format!("t = {:.4e} s, {of}", state.time),
        Test::Oedometer(_) | Test::Triaxial { .. } => format!("ε_a {:.3} %, {of}", 100.0 * state.axial_strain(rig)),
    };
    (share, line)
}

fn finish(model: &Model, rig: &MpmTest, out: &Path, mut progress: Progress, engine: &Engine) -> Result<Outcome> {
    progress.sync(out)?;
    leave(model, rig, &progress.state, out)?;
    let outcome = Outcome::undrawn(summary(model, rig, &progress, engine), out, model)?;
    checkpoint::remove(out)?;
    Ok(outcome)
}

fn summary(model: &Model, rig: &MpmTest, progress: &Progress, engine: &Engine) -> Value {
    let (state, r) = (&progress.state, &progress.recorder);
    let (steps, points) = (state.continuum.steps(), state.continuum.points().len());
    let mut s = Map::new();
    let mut put = |key: &str, value: Value| s.insert(key.into(), value);
    put("scene", json!(model.name));
    put("kind", json!(if state.mixture.is_some() { "mixture" } else { "continuum" }));
    put("points", json!(points));
    put("steps", json!(steps));
    if let Some(grown) = &progress.grown {
        put("growth_steps", json!(grown.steps));
    }
    put("time_s", json!(state.time));
    match &rig.test {
        Test::Free { .. } => {
            put("test", json!("free"));
            if let [Some([from, high]), Some([to, low])] = r.reach {
                put("front_start_mm", json!(1e3 * from));
                put("front_mm", json!(1e3 * to));
                put("height_start_mm", json!(1e3 * high));
                put("height_mm", json!(1e3 * low));
            }
        }
        Test::Oedometer(specimen) => {
            put("test", json!("oedometer"));
            put("axial_strain", json!(r.last[0]));
            put("max_measured_stress_kPa", json!(1e-3 * r.most));
            put("k0_final", json!(r.lateral / r.last[1]));
            // an elastic specimen follows σ = M ln(1/(1 − ε)), since the law integrates strain rates
            let true_strain = (1.0 / (1.0 - r.last[0])).ln();
            let start = specimen.bed.map_or(specimen.stress, |bed| bed.stress);
            put("oedometric_modulus_MPa", json!(1e-6 * (r.last[1] - start) / true_strain));
            if let Some(law) = law(rig, specimen) {
                put("oedometric_modulus_of_the_law_MPa", json!(1e-6 * law.elastic().oedometric()));
            }
            if let Some(bed) = specimen.bed {
                put("seating_kPa", json!(1e-3 * bed.stress));
            }
        }
        Test::Triaxial { specimen, cell_pressure, .. } => {
            put("test", json!("triaxial"));
            put("cell_pressure_kPa", json!(1e-3 * cell_pressure));
            put("peak_stress_ratio", json!(r.peak[0]));
            put("peak_axial_strain", json!(r.peak[1]));
            put("peak_q_kPa", json!(1e-3 * r.peak[2]));
            put("residual_stress_ratio", json!(r.residual_ratio()));
            if let Some([peak, last]) = law(rig, specimen).and_then(|law| closed_forms(rig, law, *cell_pressure)) {
                put("peak_stress_ratio_of_the_law", json!(peak));
                put("residual_stress_ratio_of_the_law", json!(last));
            }
        }
    }
    if rig.specimen().is_some() {
        let mut held = json!({"largest_platen_difference": r.worst[0]});
        if rig.specimen().is_some_and(|s| s.bed.is_some()) {
            held["largest_inertial_number"] = json!(r.inertial[1]);
        } else {
            held["largest_kinetic_over_stress_work"] = json!(r.worst[1]);
        }
        if rig.points_inertia != 1.0 {
            let [points, coarse] = r.inertial;
            held["largest_inertial_number"] = json!(points.max(coarse));
            held["largest_inertial_number_of_points"] = json!(points);
            put("points_inertia", json!(rig.points_inertia));
        }
        put("quasi_static", held);
    }
    if let Some(mixture) = &state.mixture {
        let (coarse, _) = mixture.grains.grains.mass_and_volume();
        let (inertia, _) = mixture.mass_and_momentum(&state.continuum);
        let mass = rig.real_mass(inertia, state.continuum.totals().mass);
        put("seed", json!({ "packing": model.seeds.packing, "strength": model.seeds.strength }));
        put("grains", json!(mixture.grains.grains.len()));
        let of_blocks = mixture.blocks.as_ref().map_or(0.0, |blocks| blocks.mass_and_momentum().0);
        put("coarse_mass_fraction", json!((coarse + of_blocks) / mass));
        if let Some(blocks) = &mixture.blocks {
            put("blocks", json!(blocks.blocks.len()));
            put("block_contacts", json!(blocks.touching().count()));
            if let Some(drives) = blocks.drives() {
                if !drives.joints.is_empty() {
                    put("joints", json!(drives.joints.len()));
                    put("joints_broken", json!(drives.joints.iter().filter(|joint| joint.broken.is_some()).count()));
                }
                put("driven_work_J", json!(blocks.given()));
            }
        }
        if model.physics.crush.is_some() {
            put("crush_events", json!(mixture.crush_events()));
            for (key, value) in progress.crushed.summary(model, state) {
                put(&key, value);
            }
        }
        if let Some(fines) = &mixture.fines {
            put("fines_points", json!(fines.points));
            put("fines_mass_kg", json!(fines.entered.mass));
            put("reserve_mass_kg", json!(fines.reserve.mass));
            put("released_J", json!(fines.released));
        }
        put("point_contacts", json!(mixture.touching().points));
        put("cycles", json!(mixture.cycles));
        // steps of each side in the last cycle
        put("grain_steps", json!(mixture.cycle.rates.grains));
        put("continuum_steps", json!(mixture.cycle.rates.continuum));
        put("outside_of_the_method", json!(crate::model::validity::warnings(&model.physics, rig)));
    }
    let of_points = state.mixture.as_ref().map_or(1.0, |m| f64::from(m.cycle.rates.continuum));
    if let Some(doubt) = crate::model::validity::viscous(rig, state.dt / of_points) {
        put("viscous", json!(doubt));
    }
    put("void_ratio_final", json!(r.void_ratio));
    put("largest_plastic_strain", json!(r.plastic));
    // share of the energy given by platens, gravity and motion that damping, transfer and wall friction took; errors included
    put("dissipated_share", json!(r.dissipated));
    if let Some(error) = r.account_error {
        put("account_error", json!(error));
    }
    // the prediction is that of the processor
    if progress.used.adapter.is_none() {
        for (key, value) in crate::scene::estimate::predicted(model, false) {
            put(key, json!(value));
        }
    }
    put("wall_seconds", json!(progress.seconds));
    put("user_seconds", json!(progress.user_seconds));
    if points > 0 {
        put("point_steps_per_second", json!(steps as f64 * points as f64 / progress.seconds.max(1e-9)));
        put("bytes_per_point", json!(engine.bytes(state) as f64 / points as f64));
    }
    put("backend", json!(progress.used.names.join(", then ")));
    if let Some(why) = &progress.used.why {
        put("backend_reason", json!(why));
    }
    if let Some((name, software)) = &progress.used.adapter {
        put("adapter", json!(name));
        put("adapter_is_software", json!(software));
    }
    put("threads", json!(rayon::current_num_threads()));
    put("simd", json!(engine::math::real::name(engine::math::real::arch())));
    put("version", json!(env!("CARGO_PKG_VERSION")));
    put("host", json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)));
    if let Some(level) = model.accuracy {
        let found = r.worst[0];
        let kept = (found > 0.0).then_some(level.allows(found));
        s.insert("accuracy".into(), level.against(found, kept));
        // beside those of breakages
        if kept == Some(false)
            && let Value::Array(warnings) = s.entry("warnings").or_insert_with(|| json!([]))
        {
            warnings.push(json!(level.warning()));
        }
    }
    Value::Object(s)
}

/// CPU time of this process in user mode, s; NaN on systems that do not tell.
fn user_seconds() -> f64 {
    #[cfg(unix)]
    if let Ok(usage) = nix::sys::resource::getrusage(nix::sys::resource::UsageWho::RUSAGE_SELF) {
        let time = usage.user_time();
        return time.tv_sec() as f64 + 1e-6 * time.tv_usec() as f64;
    }
    f64::NAN
}

/// Law of the points of a specimen; `None`: it is made of rigid bodies.
fn law<'a>(rig: &'a MpmTest, specimen: &MpmSpecimen) -> Option<&'a Law> {
    rig.laws.get(usize::from(specimen.law))
}

/// σ1/σ3 in triaxial compression at cell pressure `cell`, Pa, with the largest strength of the law and with its residual
/// strength. `None` for an elastic law and for grains without points.
fn closed_forms(rig: &MpmTest, law: &Law, cell: f64) -> Option<[f64; 2]> {
    if rig.points.is_empty() {
        return None;
    }
    // the strength is searched up to a plastic strain of 20, where no law changes any more
    let (mut most, end) = (0.0_f64, 20.0);
    for k in 0..=200_000 {
        most = most.max(law.q_compression(cell, end * f64::from(k) / 200_000.0)?);
    }
    let last = law.q_compression(cell, 1e6)?;
    Some([most, last].map(|q| 1.0 + q / cell))
}

#[cfg(all(test, feature = "gpu"))]
use engine::gpu;

#[cfg(all(test, feature = "gpu"))]
#[path = "../../engine/gpu/tests/adapter.rs"]
mod adapter;

#[cfg(all(test, feature = "gpu"))]
mod tests {
    use super::adapter::adapter;
    use super::*;
    use crate::model;

    /// All records and the points of the last record are kept, and the last checkpoint can be resumed on the CPU.
    #[test]
    fn a_device_that_goes_away_ends_the_run_with_what_it_has_left() {
        if !adapter("a_device_that_goes_away_ends_the_run_with_what_it_has_left") {
            return;
        }
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/mpm/triaxial_fine_small.toml");
        let sets = ["grid.cell_mm=25.0", "records.rows=1000", "records.snapshots=false"].map(String::from);
        let model = crate::scene::model(&crate::scene::load(path, &sets).expect("a scene")).expect("a model");
        let model::Rig::Continuum(rig) = &model.rig else { panic!("a continuum") };
        let out = tempfile::tempdir().expect("folder");
        // a checkpoint belongs to the scene in its folder
        std::fs::write(out.path().join(crate::scene::RESOLVED), "").expect("scene");
        let chosen = Chosen { gpu: true, why: None };
        let mut begun = begin(&model, rig, chosen).expect("set up");
        while begun.progress.state.continuum.steps() < 300 {
            begun.progress.advance(&model, rig, &mut begun.engine, out.path()).expect("steps");
        }
        begun.progress.save(&begun.engine, &model, out.path()).expect("a checkpoint");
        let Engine::Gpu(device) = &begun.engine else { panic!("a device") };
        device.lose();
        let told = make_test(&model, rig, out.path(), begun, true, None).expect_err("lost");
        assert!(told.exit_code() == 1 && told.to_string().contains("the graphics device"), "{told}");
        assert!(told.to_string().contains("the state of the last record is kept"), "{told}");
        let lines = |file: &str| std::fs::read_to_string(out.path().join(file)).expect(file).lines().count();
        assert!(lines("history.csv") > 20 && lines(END) == 2 + rig.points.len());
        let begun = take_up(&model, rig, out.path(), Some(Backend::Cpu)).expect("taken up");
        let rest = go_on(&model, rig, begun, out.path(), true, Some(400)).expect_err("stopped");
        assert!(matches!(rest, Error::Interrupted { step: 400, .. }), "{rest}");
    }
}
