//! Recovery study: runs of the scene with known parameters and their own seeds give curves, each
//! curve is calibrated as if it had been measured, and the intervals are compared with the known
//! parameters.

use super::parameter::Parameter;
use super::search::Settings;
use super::target::{Block, Files, Kind, Target};
use super::{BEYOND, Request, calibrate, log, outputs, sets};
use campaign::{self, Job};
use laboratory::error::{Error, Result};
use laboratory::model::Rig;
use laboratory::scene::{self, Prior};
use plot::{Drawn, Graph, Look, Quantity, Tone};
use serde_json::Value;
use std::path::{Path, PathBuf};
use table::number;

/// Points of a curve, evenly spread over the logarithm of stress.
const POINTS: usize = 20;
/// Sieves of a gradation over the size of the largest grain.
const SIEVES: [f64; 8] = [0.15, 0.25, 0.35, 0.5, 0.6, 0.7, 0.8, 0.9];

/// A recovery study to be made.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Settings of each calibration; its files and its folder are not used.
    pub request: Request,
    /// Table (CSV) with a row for each curve: its parameters, and seeds if wanted, under their
    /// keys.
    pub truths: PathBuf,
    /// Whether the calibrations get k₀ and the gradation at the end besides the curve.
    pub all_data: bool,
    /// Folder of the study.
    pub out: PathBuf,
}

/// Result for one parameter of one curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Recovered {
    /// Number of the curve, from 1: its row in the table of truths.
    pub target: usize,
    /// The parameter.
    pub parameter: Parameter,
    /// Value with which the curve was made, in the unit of the key.
    pub truth: f64,
    /// Calibrated value.
    pub estimate: f64,
    /// Lower 95 % limit.
    pub lower: f64,
    /// Upper 95 % limit.
    pub upper: f64,
    /// Width of the interval over that of the prior.
    pub over_prior: f64,
}

impl Recovered {
    /// Whether the 95 % interval contains the truth.
    pub fn holds(&self) -> bool {
        self.lower <= self.truth && self.truth <= self.upper
    }
}

/// Makes the curves, calibrates each, and writes `recovery.csv`, a figure for each parameter, and
/// `left_out.csv` (for each calibration, the test with its own runs left out). Continues from what
/// the folder holds. The runs of the design and in its middle are made once and copied for the
/// other curves.
///
/// # Errors
/// As [`calibrate`], and a table of truths that does not fit the scene.
pub fn recover(plan: &Plan, tell: &dyn Fn(&str)) -> Result<Vec<Recovered>> {
    let r = &plan.request;
    let given = scene::load(&r.scene, &r.sets)?.calibrated()?;
    let parameters = given.iter().map(Parameter::new).collect::<Result<Vec<_>>>()?;
    let rows = campaign::grid_table(&plan.truths)?;
    let truths = rows.iter().map(|row| truths_of(row, &parameters, &plan.truths)).collect::<Result<Vec<_>>>()?;
    let target = template(plan)?;
    let _alone = campaign::Hold::take(&plan.out)?;
    let files = make_targets(plan, &rows, &target)?;
    let settings = Settings::usual(parameters.len());
    let design = r.design.unwrap_or(settings.design) + settings.centre;
    let mut found = Vec::new();
    let mut left_out = String::from("target,parameter,curves,held,mean_interval_over_bounds\n");
    for (i, (files, truths)) in files.into_iter().zip(truths).enumerate() {
        let dir = |i: usize| plan.out.join(format!("calibration-{:02}", i + 1));
        if i > 0 {
            share(&dir(0), &dir(i), design)?;
        }
        tell(&format!("target {} of {}", i + 1, rows.len()));
        let outcome = calibrate(&Request { files, out: dir(i), ..r.clone() }, tell)?;
        for (p, truth) in parameters.iter().zip(truths) {
            let of = |name: &str| outcome.json["parameters"][&p.key][name].as_f64().unwrap_or(f64::NAN);
            found.push(Recovered {
                target: i + 1,
                parameter: p.clone(),
                truth,
                estimate: of("estimate"),
                lower: of("lower"),
                upper: of("upper"),
                over_prior: of("interval_over_prior"),
            });
        }
        let of = &outcome.json["left_out"];
        for p in parameters.iter().filter(|_| of.is_object()) {
            let width = of["mean_interval_over_bounds"][&p.key].as_f64().unwrap_or(f64::NAN);
            left_out += &format!("{},{},{},{},{width:.3}\n", i + 1, p.key, of["curves"], of["held"][&p.key]);
        }
        log::replace(&plan.out.join("left_out.csv"), left_out.as_bytes())?;
        // written after each target, so that a study that is stopped has the results so far
        write(&plan.out, &parameters, &found)?;
    }
    Ok(found)
}

/// The values of the parameters in a row of the table.
fn truths_of(row: &[(String, String)], parameters: &[Parameter], path: &Path) -> Result<Vec<f64>> {
    parameters
        .iter()
        .map(|p| {
            let wrong = |value: Option<&String>, message: String| Error::input(path.display(), &p.key, value.cloned(), message);
            let cell = row.iter().find(|(key, _)| *key == p.key).map(|c| &c.1);
            let value: Option<f64> = cell.and_then(|c| c.parse().ok());
            let value = value.ok_or_else(|| wrong(cell, "every row needs a number for each calibrated key of the scene".into()))?;
            if !(p.lower..=p.upper).contains(&value) {
                return Err(wrong(cell, format!("lies outside of its bounds, {} to {}", p.lower, p.upper)));
            }
            Ok(value)
        })
        .collect()
}

/// Target with the quantities and points that are read from the runs that make the curves. Its
/// values are not known yet and 0.
fn template(plan: &Plan) -> Result<Target> {
    let model = scene::model(&scene::load(&plan.request.scene, &plan.request.sets)?)?;
    let Rig::Oedometer(rig) = &model.rig else {
        return Err(Error::input(
            plan.request.scene.display(),
            "kind",
            None,
            "must be \"oedometer\": a compression curve comes from an oedometer",
        ));
    };
    let from = rig.specimen.isotropic_stress * 1e-3;
    let end = rig.loading.stages.first().copied().unwrap_or(0.0) * 1e-3 / BEYOND;
    let place = |j: usize| j as f64 / (POINTS - 1) as f64;
    let at: Vec<f64> = (0..POINTS).map(|j| rounded(from * (end / from).powf(place(j)))).collect();
    let block = |kind, at: Vec<f64>| Block { kind, values: vec![0.0; at.len()], sd: vec![0.0; at.len()], at };
    let mut blocks = vec![block(Kind::History("void_ratio"), at.clone())];
    if plan.all_data {
        // at small stresses k0 is still that of the preparation
        blocks.push(block(Kind::History("k0"), at[POINTS / 2..].to_vec()));
        blocks.push(block(Kind::Gradation(at[POINTS - 1]), SIEVES.to_vec()));
    }
    Ok(Target { blocks, notes: Vec::new() })
}

/// The number with four significant digits.
fn rounded(x: f64) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x)
}

/// Runs the scene with the true parameters and writes the files that a laboratory would have
/// measured.
fn make_targets(plan: &Plan, rows: &[Vec<(String, String)>], target: &Target) -> Result<Vec<Files>> {
    let r = &plan.request;
    let isotropic = target.blocks[0].at[0];
    let sets = sets(r, target, isotropic)?;
    let folder = plan.out.join("targets");
    let jobs: Vec<Job> = rows
        .iter()
        .enumerate()
        .map(|(i, row)| {
            let values: Vec<String> = row.iter().map(|(k, v)| format!("{k}={v}")).collect();
            let job = Job::new(&r.scene, folder.join(format!("run-{:02}", i + 1))).with(&sets).with(&values);
            Job { threads: r.threads, ..job }
        })
        .collect();
    let options =
        campaign::Options { parallel: r.parallel, quiet: r.quiet, force: false, program: None, executor: r.executor.clone() };
    let outcomes = campaign::run(&jobs, &options)?;
    campaign::close(&jobs, &outcomes)?;
    jobs.iter().zip(rows).enumerate().map(|(i, (job, row))| write_target(&folder, i, &job.out, row, target)).collect()
}

fn write_target(folder: &Path, i: usize, run: &Path, row: &[(String, String)], target: &Target) -> Result<Files> {
    let fail = |message: String| Error::input(run.display(), "", None, message);
    let largest = outputs::largest_grain(run).map_err(fail)?;
    let mut target = target.clone();
    for block in target.blocks.iter_mut().filter(|b| matches!(b.kind, Kind::Gradation(_))) {
        block.at = SIEVES.map(|s| rounded(s * largest)).to_vec();
    }
    let values = outputs::of_run(run, &target).map_err(fail)?;
    let made: Vec<String> = row.iter().map(|(k, v)| format!("{k}={v}")).collect();
    let head = format!("# made by a run with {}\n", made.join(", "));
    let (mut names, mut first) = (Files::default(), 0);
    for block in &target.blocks {
        let (suffix, header) = match block.kind {
            Kind::History("k0") => ("-k0", "sigma_v_kPa,k0".to_string()),
            Kind::History(column) => ("", format!("sigma_v_kPa,{column}")),
            Kind::Gradation(_) => ("-gsd", "sigma_v_kPa,diameter_mm,passing_percent".to_string()),
        };
        let mut text = format!("{head}{header}\n");
        for (at, value) in block.at.iter().zip(&values[first..]) {
            let stress = if let Kind::Gradation(sigma) = block.kind { format!("{sigma},") } else { String::new() };
            text += &format!("{stress}{at},{}\n", number(format!("{value:.5e}").parse().unwrap_or(*value)));
        }
        first += block.at.len();
        let path = folder.join(format!("target-{:02}{suffix}.csv", i + 1));
        log::replace(&path, text.as_bytes())?;
        match block.kind {
            Kind::History("k0") => names.k0 = Some(path),
            Kind::History(_) => names.curve = path,
            Kind::Gradation(_) => names.gradations = Some(path),
        }
    }
    Ok(names)
}

/// Copies the first `count` runs, which are the same for every target, from one calibration into
/// another.
fn share(from: &Path, to: &Path, count: usize) -> Result<()> {
    for n in 1..=count {
        let name = Path::new("runs").join(format!("run-{n:03}"));
        let (source, copy) = (from.join(&name), to.join(&name));
        if copy.exists() || !source.join("summary.json").exists() {
            continue;
        }
        let temporary = copy.with_extension("tmp");
        std::fs::create_dir_all(&temporary).map_err(Error::write(&temporary))?;
        for file in source.read_dir().map_err(Error::read(&source))?.flatten() {
            if file.path().is_file() {
                std::fs::copy(file.path(), temporary.join(file.file_name())).map_err(Error::write(&temporary))?;
            }
        }
        std::fs::rename(&temporary, &copy).map_err(Error::write(&copy))?;
    }
    Ok(())
}

fn write(out: &Path, parameters: &[Parameter], all: &[Recovered]) -> Result<()> {
    let mut text = String::from("target,parameter,truth,estimate,lower,upper,held,interval_over_prior\n");
    for r in all {
        let cells = [r.truth, r.estimate, r.lower, r.upper].map(|v| number(rounded(v))).join(",");
        text += &format!("{},{},{cells},{},{:.3}\n", r.target, r.parameter.key, u8::from(r.holds()), r.over_prior);
    }
    log::replace(&out.join("recovery.csv"), text.as_bytes())?;
    for p in parameters {
        let own: Vec<&Recovered> = all.iter().filter(|r| r.parameter.key == p.key).collect();
        graph(p, &own).draw(out)?;
    }
    Ok(())
}

/// Figure of one parameter: estimates and intervals against the known values.
fn graph(p: &Parameter, own: &[&Recovered]) -> Graph {
    let ends = [p.lower, p.upper];
    let drawn = |label: Option<&str>, name: &str, tone, look, points| Drawn {
        label: label.map(str::to_string),
        name: name.into(),
        tone,
        look,
        points,
    };
    let mut series = vec![drawn(Some("as made"), "as made", Tone::Grey, Look::Line(1), ends.iter().map(|v| (*v, *v)).collect())];
    for (i, r) in own.iter().enumerate() {
        let label = (i == 0).then_some("95 % interval");
        series.push(drawn(label, "interval", Tone::Kind(0), Look::Line(0), vec![(r.truth, r.lower), (r.truth, r.upper)]));
    }
    let points = own.iter().map(|r| (r.truth, r.estimate)).collect();
    series.push(drawn(Some("estimate"), "estimate", Tone::Ink, Look::Symbols(0), points));
    let name = p.short();
    let axis = |what: &str, column: &str| {
        let label = format!("{name}, {what}");
        if p.prior == Prior::LogUniform { Quantity::log(&label, column) } else { Quantity::linear(&label, column, &[]) }
    };
    let held = own.iter().filter(|r| r.holds()).count();
    Graph {
        name: format!("recovery_{}", name.replace('.', "_")),
        title: vec![format!("{held} of {} intervals hold", own.len())],
        legend_title: None,
        x: axis("as made", "truth"),
        y: axis("found", "found"),
        series,
    }
}

/// Table (Markdown) with a line for each parameter: intervals that hold the known value, and their
/// mean width.
pub fn table(all: &[Recovered]) -> String {
    let mut keys: Vec<&str> = Vec::new();
    for r in all {
        if !keys.contains(&r.parameter.key.as_str()) {
            keys.push(&r.parameter.key);
        }
    }
    let mut text = String::from("| parameter | 95 % intervals that hold | mean width over the prior's |\n|---|---|---|\n");
    for key in keys {
        let own: Vec<&Recovered> = all.iter().filter(|r| r.parameter.key == key).collect();
        let held = own.iter().filter(|r| r.holds()).count();
        let width = own.iter().map(|r| r.over_prior).sum::<f64>() / own.len() as f64;
        text += &format!("| `{key}` | {held} of {} | {width:.2} |\n", own.len());
    }
    text
}

/// All results as JSON, an object for each parameter of each curve.
pub fn json(all: &[Recovered]) -> Value {
    all.iter()
        .map(|r| {
            serde_json::json!({
                "target": r.target, "parameter": r.parameter.key, "truth": r.truth, "estimate": r.estimate,
                "lower": r.lower, "upper": r.upper, "held": r.holds(), "interval_over_prior": r.over_prior,
            })
        })
        .collect()
}
