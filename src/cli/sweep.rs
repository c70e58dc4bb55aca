//! `comminute sweep SCENE`

use super::campaign::{self, Options};
use comminute::campaign::{Hold, Job, Outcome, Point, Vary, grid_points, grid_table, parse_seeds};
use comminute::error::{Error, Result};
use comminute::figure;
use std::path::{Path, PathBuf};

/// Run a table of parameters
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute sweep experiments/petroleum_coke/h-c-2.toml --grid material.strength.fixed_angle.m=2,3,5 --grid loading.rate=0.01,0.005 --set loading.max_stress_kPa=100 --out runs/sweep\n  comminute sweep … --list | parallel -j 8"
)]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,

    /// Values of a key; several grids give every combination
    #[arg(long, value_name = "KEY=VALUE,VALUE,…")]
    grid: Vec<String>,

    /// Rows of values, with keys as the header (CSV); an empty cell leaves the scene's value
    #[arg(long, value_name = "CSV")]
    table: Vec<PathBuf>,

    /// Seeds of each point, as 1..8 (both included) or 1,2,5; the scene's own if not given
    #[arg(long, value_name = "LIST")]
    seeds: Option<String>,

    /// What the seeds choose
    #[arg(long, value_enum, default_value = "both", requires = "seeds")]
    vary: super::ensemble::What,

    /// Replace a value of the scene or its material in every run
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,

    /// Folder of the runs, named by their values, and of sweep.csv; runs/ and the name of the scene file with -sweep if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    options: Options,
}

/// Largest number of points that are drawn into common figures: a colour for each.
const DRAWN: usize = 7;
/// Most runs of a sweep.
const MOST_RUNS: usize = 100_000;

pub fn call(args: &Args) -> Result<()> {
    if args.grid.is_empty() && args.table.is_empty() {
        return Err(Error::input("sweep", "", None, "needs at least one --grid KEY=VALUE,VALUE,… or --table CSV"));
    }
    let tables: Result<Vec<_>> = args.table.iter().map(|path| grid_table(path)).collect();
    let points = grid_points(&args.grid, tables?)?;
    args.options.may_vary(args.vary.into())?;
    let seeds = args.seeds.as_deref().map(parse_seeds).transpose()?;
    let runs = points.len() * seeds.as_ref().map_or(1, Vec::len);
    if runs > MOST_RUNS {
        let message = format!("makes {runs} runs with {} values of the grid; at most {MOST_RUNS} are made", points.len());
        return Err(Error::input("--seeds", "", args.seeds.clone(), message));
    }
    let out = args.out.clone().unwrap_or_else(|| campaign::default_out(&args.scene, "sweep"));
    let mut jobs = Vec::new();
    let mut rows: Vec<&Point> = Vec::new();
    for point in &points {
        let job = Job::new(&args.scene, out.join(&point.name)).with(&args.sets).with(&point.sets());
        let job = named(job, point)?;
        match &seeds {
            None => jobs.push(job),
            Some(seeds) => jobs.extend(seeds.iter().map(|&seed| {
                let out = job.out.join(format!("seed-{seed}"));
                Job { out, ..job.clone() }.seeded(Vary::from(args.vary), seed)
            })),
        }
        rows.resize(jobs.len(), point);
    }
    let Some(outcomes) = args.options.run(&mut jobs, &out)? else { return Ok(()) };
    // tables and figures of two campaigns at once would be written into each other
    let _alone = Hold::wait_for(&out)?;
    let mut files = vec![table(&out, &jobs, &rows, &outcomes)?];
    let done = campaign::done(&jobs, &outcomes);
    if points.len() <= DRAWN && !done.is_empty() {
        files.extend(figure::overlay(&done, &args.options.data, &out.join("figures"))?);
    }
    args.options.close(&jobs, &outcomes, &files)
}

/// Names the scene of a job after its point, so that figures tell the points apart. A name that the
/// user has set is kept.
fn named(job: Job, point: &Point) -> Result<Job> {
    if job.sets.iter().any(|set| set.split('=').next().is_some_and(|key| key.trim() == "name")) {
        return Ok(job);
    }
    let name: String = format!("{}_{}", job.load()?.0.name(), point.name).chars().take(100).collect();
    Ok(job.with(&[format!("name={name:?}")]))
}

/// Columns of `sweep.csv` after the parameters, each with its place (JSON pointer) in the summary
/// of a run.
const RESULTS: [(&str, &str); 16] = [
    ("seed_packing", "/seed/packing"),
    ("seed_strength", "/seed/strength"),
    ("crush_events", "/crush_events"),
    ("grains_final", "/grains_final"),
    ("max_measured_stress_kPa", "/max_measured_stress_kPa"),
    ("porosity_final", "/porosity_final"),
    ("void_ratio_final", "/void_ratio_final"),
    ("void_ratio_grains_final", "/void_ratio_grains_final"),
    ("axial_strain_final", "/axial_strain_final"),
    ("below_least_void_ratio_kPa", "/below_least_void_ratio/sigma_v_kPa"),
    ("hardin_br", "/hardin_br"),
    ("einav_br", "/einav_br"),
    ("energy_error", "/energy_error"),
    ("k0_final", "/k0_final"),
    ("steps", "/steps"),
    ("wall_seconds", "/wall_seconds"),
];

/// Writes `sweep.csv`: a row for each run, done or not.
fn table(out: &Path, jobs: &[Job], rows: &[&Point], outcomes: &[Outcome]) -> Result<PathBuf> {
    let mut keys: Vec<&str> = Vec::new();
    for (key, _) in rows.iter().flat_map(|p| &p.values) {
        if !keys.contains(&key.as_str()) {
            keys.push(key);
        }
    }
    let path = out.join("sweep.csv");
    let failed = |e: csv::Error| Error::Write { path: path.clone(), source: e.into() };
    let mut file = csv::Writer::from_path(&path).map_err(failed)?;
    let header = ["folder", "status"].into_iter().chain(keys.iter().copied()).chain(RESULTS.map(|r| r.0)).chain(["reason"]);
    file.write_record(header).map_err(failed)?;
    for ((job, point), outcome) in jobs.iter().zip(rows).zip(outcomes) {
        let (status, reason) = campaign::status(outcome);
        let folder = job.out.strip_prefix(out).unwrap_or(&job.out).display().to_string();
        let value = |key: &str| point.values.iter().find(|(k, _)| k == key).map_or("", |(_, v)| v.as_str()).to_string();
        let mut row = vec![folder, status.to_string()];
        row.extend(keys.iter().map(|key| value(key)));
        row.extend(RESULTS.map(|(_, at)| result(outcome, at)));
        row.push(reason.unwrap_or("").to_string());
        file.write_record(row).map_err(failed)?;
    }
    file.flush().map_err(Error::write(&path))?;
    drop(file);
    Ok(path)
}

fn result(outcome: &Outcome, at: &str) -> String {
    let Some(summary) = outcome.summary() else { return String::new() };
    let number = |at: &str| summary.pointer(at).and_then(serde_json::Value::as_f64);
    number(at).map_or(String::new(), comminute::table::number)
}
