//! `comminute reproduce PLAN`

use super::campaign::{Folders, Options};
use comminute::campaign::Job;
use comminute::error::{Error, Result};
use comminute::reproduce::{Plan, gather, write};
use std::path::Path;

/// Make the runs of a paper and compare their results with those published
///
/// Runs that are done already are not made again; tables, figures and the report are made of all
/// runs of the plan that are done.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples, from the repository root:\n  comminute reproduce ciantia2015 --only 'petroleum_coke-*-2'\n  comminute reproduce ciantia2015 --jobs 2\n  comminute reproduce li2023 --only '1:5'"
)]
pub struct Args {
    /// Plan: a TOML file, or the name of one in experiments/
    plan: String,

    /// Run only the entries whose names match, as in 'silica-*', or contain a text, as in '1:5'; may be given several times
    #[arg(long, value_name = "GLOB")]
    only: Vec<String>,

    #[command(flatten)]
    folders: Folders,

    #[command(flatten)]
    options: Options,
}

pub fn call(args: &Args) -> Result<()> {
    let plan = Plan::read(&args.plan)?;
    let out = args.folders.runs(Path::new(&args.plan));
    let ids: Vec<&str> = plan.runs.iter().map(|run| run.id.as_str()).collect();
    let patterns = patterns(&args.only, &ids)?;
    let mut jobs: Vec<Job> = Vec::new();
    for run in &plan.runs {
        if patterns.is_empty() || patterns.iter().any(|p| p.matches(&run.id)) {
            jobs.extend(plan.jobs(run, &out)?);
        }
    }
    if jobs.is_empty() {
        let names: Vec<&str> = plan.runs.iter().map(|run| run.id.as_str()).collect();
        let message = format!("matches no run of the plan: {}", names.join(", "));
        return Err(Error::input("--only", "", Some(args.only.join(" ")), message));
    }
    let Some(outcomes) = args.options.run(&mut jobs, &out)? else { return Ok(()) };
    let report = args.folders.report(&out);
    args.options.close_with_report((&jobs, &outcomes), &report, 3, || write(&plan, &gather(&plan, &out)?, &report))
}

/// What selects entries of a plan. A text without wildcards that is no entry's name selects all entries whose names contain it.
fn patterns(only: &[String], ids: &[&str]) -> Result<Vec<glob::Pattern>> {
    let pattern = |text: &String| {
        let part = !text.contains(['*', '?', '[']) && !ids.contains(&text.as_str());
        let pattern = if part { format!("*{text}*") } else { text.clone() };
        glob::Pattern::new(&pattern)
            .map_err(|e| Error::input("--only", "", Some(text.clone()), format!("is no pattern: {}", e.msg)))
    };
    only.iter().map(pattern).collect()
}
