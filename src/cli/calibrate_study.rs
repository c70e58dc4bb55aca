//! `comminute calibrate grains-study`

use super::calibrate_grains::bar;
use super::list_files;
use comminute::calibrate::grains::study::{Case, recover};
use comminute::calibrate::grains::study_report;
use comminute::error::{Error, Result};
use std::path::PathBuf;

/// Test whether the calibration of grains finds the known parameters of simulated tests
///
/// Draws crushing tests from known parameters (coke and silica of Ciantia et al. 2015, both area
/// models, 1, 2, 4, 8 mm), calibrates them, and tells how often the 95 % intervals hold the truth,
/// and how wide they are beside what the Fisher information allows. The first file is kept as
/// simulated.csv.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  comminute calibrate grains-study --repeats 100 --out runs/grains-study")]
pub struct Args {
    /// Simulated data files of each case
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    repeats: u32,

    /// Grains of each data file, over four sizes
    #[arg(long, value_name = "N", default_value_t = 500, value_parser = clap::value_parser!(u32).range(20..=100_000))]
    grains: u32,

    /// Seed of the first file; each further file has the next seed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=1_000_000_000))]
    seed: u64,

    /// Folder for tables and figure
    #[arg(long, value_name = "DIR", default_value = "runs/grains-study")]
    out: PathBuf,

    /// Overwrite an older study
    #[arg(long)]
    force: bool,

    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub fn call(args: &Args) -> Result<()> {
    if args.out.join("recovery.csv").exists() && !args.force {
        return Err(Error::Exists { path: args.out.clone() });
    }
    let cases = Case::all();
    let repeats = u64::from(args.repeats);
    let bar = bar(args.quiet, cases.len() as u64 * repeats, "calibrations");
    let results: Vec<_> = cases
        .iter()
        .enumerate()
        .map(|(i, case)| recover(case, args.grains as usize, args.repeats as usize, args.seed + i as u64 * repeats, || bar.inc(1)))
        .collect();
    bar.finish_and_clear();
    let mut files = study_report::write(&results, &args.out)?;
    let example = args.out.join("simulated.csv");
    let text = study_report::simulated(&cases[0], args.grains as usize, args.seed);
    std::fs::write(&example, text).map_err(Error::write(&example))?;
    files.push(example);
    if !args.quiet {
        eprintln!("{:<22}{:<16}{:>10}{:>10}{:>14}{:>18}", "case", "parameter", "truth", "mean", "held, %", "width / Fisher");
        for r in results.iter().flat_map(|(rows, _)| rows) {
            let held = 100.0 * r.held as f64 / r.repeats as f64;
            let ratio = r.width / r.fisher_width;
            eprintln!("{:<22}{:<16}{:>10}{:>10.4}{held:>14.1}{ratio:>18.3}", r.case, r.parameter, r.truth, r.mean);
        }
        list_files(&files);
    }
    Ok(())
}
