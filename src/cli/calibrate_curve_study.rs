//! `comminute calibrate curve-study`

use comminute::calibrate::curve::Request;
use comminute::calibrate::curve::study::{Plan, json, recover, table};
use comminute::calibrate::curve::target::Files;
use comminute::error::Result;
use std::path::PathBuf;

/// Test whether the calibration against a curve finds the known parameters of curves from the scene
/// itself
///
/// Runs the scene with known parameters, each with its own seeds, calibrates each curve as if it
/// had been measured, and tells how often the 95 % intervals hold the known values: recovery.csv
/// and a figure for each parameter. Goes on from what the folder holds.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute calibrate curve-study --scene experiments/calibration/coke_small.toml --truths experiments/calibration/truths.csv --out runs/curve-study"
)]
pub struct Args {
    /// Scene with [[calibrate]] tables (TOML)
    #[arg(long, value_name = "SCENE")]
    scene: PathBuf,

    /// A row for each curve, with keys as header; seeds as seed.packing and seed.strength (CSV)
    #[arg(long, value_name = "CSV")]
    truths: PathBuf,

    /// Give k0 and the gradation at the end beside each curve
    #[arg(long)]
    all_data: bool,

    /// Replace a value of the scene or its material in every run
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,

    /// Runs of each calibration
    #[arg(long, value_name = "N")]
    budget: Option<usize>,

    /// Runs of the budget that fill the space between the bounds, the same for all curves (14 for
    /// each parameter)
    #[arg(long, value_name = "N")]
    design: Option<usize>,

    /// Runs with the parameters found, besides the budget (4)
    #[arg(long, value_name = "N")]
    check: Option<u16>,

    /// Seed of everything random
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u64).range(1..1_000_000))]
    seed: u64,

    /// Runs at a time; one for each core if not given, and with a scheduler as many as it starts
    #[arg(long, value_name = "N", value_parser = super::threads())]
    jobs: Option<u16>,

    /// Threads of each run; the cores shared out if not given, and 1 with another executor than local
    #[arg(long, value_name = "N", value_parser = super::threads())]
    threads: Option<u16>,

    #[command(flatten)]
    executor: super::executor::Args,

    /// Folder of the study
    #[arg(long, value_name = "DIR", default_value = "runs/curve-study")]
    out: PathBuf,

    /// No progress and no closing table
    #[arg(long)]
    quiet: bool,

    /// Print what was found as JSON to standard output
    #[arg(long)]
    json: bool,
}

pub fn call(args: &Args) -> Result<()> {
    let request = Request {
        scene: args.scene.clone(),
        sets: args.sets.clone(),
        files: Files::default(),
        parameters: Vec::new(),
        budget: args.budget,
        design: args.design,
        batch: None,
        check: args.check.map(usize::from),
        seed: args.seed,
        specimens: 1.0,
        out: args.out.clone(),
        parallel: args.jobs.map_or(0, usize::from),
        threads: args.executor.threads(args.threads),
        executor: args.executor.of(&args.out)?,
        quiet: args.quiet,
        force: false,
    };
    let plan = Plan { request, truths: args.truths.clone(), all_data: args.all_data, out: args.out.clone() };
    let tell = |line: &str| {
        if !args.quiet {
            eprintln!("{line}");
        }
    };
    let found = recover(&plan, &tell)?;
    if args.json {
        super::print(&serde_json::to_string_pretty(&json(&found)).unwrap_or_default())?;
    }
    if !args.quiet {
        eprint!("{}", table(&found));
        eprintln!("recovery.csv and figures in {}", args.out.display());
    }
    Ok(())
}
