//! Finds parameters of a scene from a measured oedometer curve, with their uncertainty
//! ([`calibrate`]).
//!
//! A run takes seconds, its curve scatters from seed to seed, and there are few parameters.
//! Therefore an emulator, a statistical model of the runs' curves made of Gaussian processes, is
//! fitted to the runs and sampled in their place; the noise of the processes is the scatter between
//! seeds. A calibration consists of
//! - runs of a design that fills the space between the bounds (`design`),
//! - batches of further runs at parameters that agree with the curve, chosen where a run makes the
//!   emulator's predictions most certain (`search`),
//! - the posterior by Bayes' rule, with the scatter between seeds and the error of the emulator
//!   (`posterior`),
//! - the share of each parameter in the variance of the curve (`sensitivity`).
//!
//! Optimisers (Bayesian optimisation of a misfit, CMA-ES) would find the best parameters, without
//! their uncertainty, in as many runs.

pub(crate) mod design;
pub(crate) mod emulator;
pub(crate) mod failures;
pub(crate) mod findings;
pub(crate) mod gp;
pub(crate) mod left_out;
pub(crate) mod log;
mod outputs;
pub mod parameter;
pub(crate) mod posterior;
mod report;
pub(crate) mod search;
pub(crate) mod sensitivity;
pub(crate) mod simulator;
#[cfg(test)]
pub(crate) mod stand_in;
pub mod study;
pub mod target;

use findings::Findings;
use laboratory::error::{Error, Result};
use laboratory::model::Rig;
use laboratory::scene::{self, Calibrated};
use parameter::Parameter;
use posterior::{Chain, Measured, Misfit, Posterior};
use search::{LONG, Search, Settings};
use std::path::{Path, PathBuf};
use target::{Files, Kind, Target};

/// A calibration to be made: scene, measurements and settings.
#[derive(Clone, Debug)]
pub struct Request {
    /// Scene whose runs are compared with the measured curve.
    pub scene: PathBuf,
    /// Overrides `key=value` of the scene in every run.
    pub sets: Vec<String>,
    /// Files with the measurements.
    pub files: Files,
    /// Parameters to be calibrated; if empty, those of the `[[calibrate]]` tables of the scene.
    pub parameters: Vec<Calibrated>,
    /// Number of runs without those of `check`; `None`: the design, the repeats in its middle and
    /// ten runs for each parameter.
    pub budget: Option<usize>,
    /// Runs of the budget that fill the space between the bounds; `None`: 14 for each parameter, at
    /// least 16.
    pub design: Option<usize>,
    /// Runs between two updates of the results; `None`: 5.
    pub batch: Option<usize>,
    /// Runs with the parameters found, besides the budget; `None`: 4.
    pub check: Option<usize>,
    /// Seed of all random numbers; the seeds of the runs follow from it.
    pub seed: u64,
    /// Number of specimens over which the measured curve is averaged.
    pub specimens: f64,
    /// Folder of the calibration.
    pub out: PathBuf,
    /// Runs at a time; 0: one for each core.
    pub parallel: usize,
    /// Threads of each run; `None`: the cores are shared out.
    pub threads: Option<usize>,
    /// Who starts the runs.
    pub executor: campaign::Executor,
    /// Show no progress.
    pub quiet: bool,
    /// Use a folder that holds another calibration, which is deleted, or other files; without
    /// `force` that is an error.
    pub force: bool,
}

/// A calibration that is done.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Content of `calibration.json`.
    pub json: serde_json::Value,
    /// Table of the estimates in the report (Markdown).
    pub table: String,
    /// Reasons to doubt the result; empty if there are none.
    pub warnings: Vec<String>,
    /// Files written.
    pub files: Vec<PathBuf>,
}

/// Largest stress of a run over the largest stress of the curve: runs end a little beyond the last
/// point.
const BEYOND: f64 = 1.02;
/// Most runs of a calibration: emulating them takes memory with their square.
const MOST_RUNS: usize = 5000;
/// Largest number of draws in `posterior.csv`.
const DRAWS: usize = 4000;

/// Calibrates the parameters of a scene, or continues the calibration that the folder `request.out`
/// holds. `tell` receives messages about the progress.
///
/// # Errors
/// An invalid scene, parameter or data file (found before the first run), a folder that holds
/// another calibration or in which one is at work, too many runs that fail, runs that were killed, or [`Error::Stopped`] after an
/// interrupt.
pub fn calibrate(request: &Request, tell: &dyn Fn(&str)) -> Result<Outcome> {
    let scene = scene::load(&request.scene, &request.sets)?;
    let model = scene::model(&scene)?;
    let Rig::Oedometer(rig) = &model.rig else {
        return Err(Error::input(
            request.scene.display(),
            "kind",
            None,
            "must be \"oedometer\": a compression curve comes from an oedometer",
        ));
    };
    let given = if request.parameters.is_empty() { scene.calibrated()? } else { request.parameters.clone() };
    let parameters = given.iter().map(Parameter::new).collect::<Result<Vec<_>>>()?;
    let from = rig.specimen.isotropic_stress * 1e-3;
    let target = Target::read(&request.files, from)?;
    let sets = sets(request, &target, from)?;
    parameter::check(&parameters, &request.scene, &sets)?;
    let settings = settings(request, parameters.len())?;
    for note in &target.notes {
        tell(note);
    }
    if request.out.is_file() {
        return Err(Error::input(request.out.display(), "", None, "is a file; --out needs a folder"));
    }
    let _alone = campaign::Hold::take(&request.out)?;
    setup(request, &scene::resolved(&scene::load(&request.scene, &sets)?), &parameters, &target, &settings)?;
    let curve = target.measured(settings.specimens);
    let simulator = simulator::Runs {
        scene: request.scene.clone(),
        sets,
        parameters: &parameters,
        target: &target,
        dir: request.out.clone(),
        parallel: request.parallel,
        threads: request.threads,
        executor: request.executor.clone(),
        quiet: request.quiet,
    };
    let blocks = target.blocks.iter().map(|b| b.at.len()).collect();
    let mut search = Search::new(&parameters, &curve, blocks, &settings, &simulator, &request.out, tell)?;
    let emulator = search.run()?;
    let (chain, findings) = findings(&parameters, &emulator, &curve, &target, &search);
    search.note(&chain)?;
    let checks = search.check(chain.mode())?;
    report::write(
        &request.out,
        &report::Parts {
            request,
            parameters: &parameters,
            target: &target,
            curve: &curve,
            settings: &settings,
            search: &search,
            findings: &findings,
            checks: &checks,
        },
    )
}

/// Samples the posterior of the parameters and summarises it. If the scene can hardly give the
/// curve with any parameters ([`Misfit::inflation`] above 1), the covariance of scatter and
/// measurement is multiplied by that factor and the posterior is sampled again.
fn findings(
    parameters: &[Parameter],
    emulator: &emulator::Emulator,
    curve: &Measured,
    target: &Target,
    search: &Search<'_>,
) -> (Chain, Findings) {
    // the batches use the random streams numbered by the runs made, which never reach this number
    let mut rng = search.rng(1 << 32);
    let mut chain = Posterior::new(parameters, emulator, curve, 1.0).sample(LONG.0, LONG.1, LONG.2, 1.0, &mut rng);
    let misfit = Misfit::at(chain.mode(), emulator, curve);
    let inflation = misfit.inflation();
    if inflation > 1.0 {
        chain = Posterior::new(parameters, emulator, curve, inflation).sample(LONG.0, LONG.1, LONG.2, 1.0, &mut rng);
    }
    let (shares, seeds_share) = sensitivity::sobol(parameters, emulator, &mut rng);
    let correlations = findings::correlations(&chain);
    let draws = chain.thinned(DRAWS).iter().map(|u| parameters.iter().zip(u).map(|(p, u)| p.value(*u)).collect()).collect();
    let variance = emulator.outputs(&emulator.scatter).diagonal();
    let mut first = 0;
    let scatter = target.blocks.iter().map(|b| {
        let own = first..first + b.at.len();
        first = own.end;
        let square = |j: usize| (variance[j] + emulator.rest[j]) * emulator.scale()[j].powi(2);
        (own.clone().map(square).sum::<f64>() / own.len() as f64).sqrt()
    });
    let left_out = left_out::left_out(parameters, &search.runs(), emulator.scale(), &mut search.rng(1 << 33));
    let found = Findings {
        left_out,
        scatter: scatter.collect(),
        estimates: findings::estimates(parameters, &chain, &correlations, &failures::finished(parameters.len(), &search.ended())),
        correlations,
        draws,
        bands: findings::bands(emulator, &chain, curve, &mut rng),
        misfit,
        inflation,
        shares,
        seeds_share,
        components: emulator.components(),
        held: emulator.share,
    };
    (chain, found)
}

/// Overrides `key=value` of every run: those of the user, an end just beyond the curve, records at
/// the stresses of the measured gradations, and no figures, snapshots or energies. A key that the
/// user overrides keeps the user's value. `from`: isotropic stress of the specimen, kPa.
///
/// # Errors
/// An invalid scene, or a user's largest stress below the last point of the curve.
fn sets(request: &Request, target: &Target, from: f64) -> Result<Vec<String>> {
    let own = |key: &str| request.sets.iter().any(|s| s.split('=').next().is_some_and(|k| k.trim() == key));
    let end = BEYOND * target.largest_stress();
    let mut sets = request.sets.clone();
    if !own("loading.max_stress_kPa") {
        sets.push(format!("loading.max_stress_kPa={end:?}"));
    }
    let scene = scene::load(&request.scene, &sets)?;
    let model = scene::model(&scene)?;
    if let Rig::Oedometer(rig) = &model.rig {
        let reached = rig.loading.stages.first().copied().unwrap_or(0.0) * 1e-3;
        if reached < target.largest_stress() {
            let message = format!("is below the last point of the curve, {} kPa", target.largest_stress());
            return Err(Error::input("--set", "", None, format!("loading.max_stress_kPa = {reached} {message}")));
        }
    }
    let at: Vec<f64> = target.gradation_stresses().into_iter().filter(|s| *s > 1.01 * from && *s < end).collect();
    for (key, value) in [
        ("loading.stages_kPa", "[]".to_string()),
        ("records.at_kPa", format!("{at:?}")),
        ("records.figures", "false".into()),
        ("records.snapshots", "false".into()),
        ("records.energy", "false".into()),
    ] {
        if !own(key) {
            sets.push(format!("{key}={value}"));
        }
    }
    Ok(sets)
}

fn settings(request: &Request, parameters: usize) -> Result<Settings> {
    let mut s = Settings::usual(parameters);
    s.seed = request.seed;
    s.specimens = request.specimens;
    s.design = request.design.unwrap_or(s.design);
    s.batch = request.batch.unwrap_or(s.batch);
    s.check = request.check.unwrap_or(s.check);
    s.budget = request.budget.unwrap_or(s.design.saturating_add(s.centre + 10 * parameters));
    for (option, count) in [("--budget", s.budget), ("--design", s.design)] {
        if count > MOST_RUNS {
            return Err(Error::input(format!("{option} {count}"), "", None, format!("is more than {MOST_RUNS} runs")));
        }
    }
    let least = s.design + s.centre;
    if s.budget < least {
        let message = format!("is less than the {} runs of the design and the {} in its middle; see --design", s.design, s.centre);
        return Err(Error::input(format!("--budget {}", s.budget), "", None, message));
    }
    if s.design < 3 * parameters + 2 {
        let message = format!("is too few to emulate {parameters} parameters: at least {}", 3 * parameters + 2);
        return Err(Error::input(format!("--design {}", s.design), "", None, message));
    }
    Ok(s)
}

/// Name of the file that says which calibration a folder holds.
const SETUP: &str = "setup.json";

/// Checks that the folder, which is there, holds this calibration or none, and writes [`SETUP`] into it. With
/// `force`, log, trace and runs of another calibration are deleted.
fn setup(request: &Request, resolved: &str, parameters: &[Parameter], target: &Target, settings: &Settings) -> Result<()> {
    let out = &request.out;
    let setup = serde_json::json!({
        "scene": format!("{:016x}", laboratory::record::specimen::checksum(resolved)),
        "parameters": parameters.iter().map(|p| format!("{p:?}")).collect::<Vec<_>>(),
        "curve": format!("{:016x}", laboratory::record::specimen::checksum(&format!("{:?}", target.blocks))),
        "seed": settings.seed,
        "design": settings.design,
        "centre": settings.centre,
        "batch": settings.batch,
        "specimens": settings.specimens,
    });
    let path = out.join(SETUP);
    match std::fs::read_to_string(&path) {
        Ok(text) => {
            let there: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
            let keys = setup.as_object().into_iter().flatten();
            let differs: Vec<&str> = keys.filter(|(k, v)| there.get(k) != Some(v)).map(|(k, _)| k.as_str()).collect();
            if differs.is_empty() {
                return Ok(());
            }
            if !request.force {
                let what = format!("it is a calibration with another {}", differs.join(" and "));
                return Err(Error::Other { path: out.clone(), what });
            }
            let runs = out.join("runs");
            for run in runs.read_dir().into_iter().flatten().flatten() {
                // one that has outlived its campaign
                drop(laboratory::run::lock(&run.path())?);
            }
            for old in [out.join(log::FILE), out.join("convergence.csv")] {
                if old.exists() {
                    std::fs::remove_file(&old).map_err(Error::write(&old))?;
                }
            }
            if runs.is_dir() {
                std::fs::remove_dir_all(&runs).map_err(Error::write(&runs))?;
            }
        }
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            // a call that was killed here leaves a setup that is not yet whole
            let own = ["runs".into(), log::aside(&path).file_name().unwrap_or_default().to_owned()];
            let occupied = out.read_dir().is_ok_and(|entries| entries.flatten().any(|e| !own.contains(&e.file_name())));
            if occupied && !request.force {
                return Err(Error::Exists { path: out.clone() });
            }
        }
        Err(source) => return Err(Error::Read { path, source }),
    }
    let text = crate::json_text(&setup);
    log::replace(&path, text.as_bytes())
}

/// Name of a block of measurements in messages and files.
fn block_name(kind: &Kind) -> String {
    match kind {
        Kind::History(column) => (*column).to_string(),
        Kind::Gradation(sigma) => format!("gradation at {sigma} kPa"),
    }
}

/// Folder of a calibration if the user names none: `runs/`, the name of the curve file,
/// `-calibration`.
pub fn default_out(curve: &Path) -> PathBuf {
    let stem = curve.file_stem().map_or_else(|| "curve".into(), |s| s.to_string_lossy());
    Path::new("runs").join(format!("{stem}-calibration"))
}
