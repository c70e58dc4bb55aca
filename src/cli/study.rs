//! `comminute study PLAN`

use super::campaign::{Folders, Options};
use comminute::campaign::Job;
use comminute::error::{Error, Result};
use comminute::study::{Plan, write};
use std::path::PathBuf;

/// Measure what choices cost: other levels of factors against a reference, with several seeds
///
/// Runs that are done already are not made again; tables, figures and the report are made of all
/// runs of the plan that are done.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute study experiments/studies/coke_numerics.toml --jobs 2\n  comminute study experiments/studies/coke_numerics.toml --list | parallel -j 8"
)]
pub struct Args {
    /// Plan of the study (TOML)
    plan: PathBuf,

    #[command(flatten)]
    folders: Folders,

    #[command(flatten)]
    options: Options,
}

pub fn call(args: &Args) -> Result<()> {
    let plan = Plan::read(&args.plan)?;
    if plan.same_specimens && args.options.gives_specimen() {
        let message = "cannot stand beside same_specimens = true, by which each seed has a specimen of its own";
        return Err(Error::input("--specimen", "", None, message));
    }
    let out = args.folders.runs(&args.plan);
    let mut jobs: Vec<Job> = Vec::new();
    for setting in plan.settings() {
        jobs.extend(plan.jobs(&setting, &out)?);
    }
    // first those whose specimens others begin with
    let (mut jobs, mut rest): (Vec<Job>, Vec<Job>) = jobs.into_iter().partition(|job| job.specimen.is_none());
    let outcomes = args.options.run(&mut jobs, &out)?;
    rest.retain(|job| job.specimen.as_ref().is_some_and(|file| file.is_file()));
    let others = if rest.is_empty() { Some(Vec::new()) } else { args.options.run(&mut rest, &out)? };
    let (Some(mut outcomes), Some(others)) = (outcomes, others) else { return Ok(()) };
    jobs.extend(rest);
    outcomes.extend(others);
    let report = args.folders.report(&out);
    args.options.close_with_report((&jobs, &outcomes), &report, 2, || write(&plan, &out, &report))
}
