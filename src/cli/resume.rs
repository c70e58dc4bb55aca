//! `comminute resume DIR`

use comminute::error::Result;
use comminute::run::{ResumeOptions, resume};
use std::path::PathBuf;

/// Continue a run that was stopped
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  comminute resume runs/h-c-2")]
pub struct Args {
    /// Folder of the run
    dir: PathBuf,

    /// Threads; all cores if not given. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = super::threads())]
    threads: Option<u16>,

    /// Backend that computes the steps of a continuum from here on; as before if not given
    #[arg(long, value_enum)]
    backend: Option<super::Backend>,

    /// Stop again after this many steps, those of the first part included
    #[arg(long, value_name = "STEPS")]
    stop_after: Option<u64>,

    /// Write a page that shows the run, report.html, into its folder
    #[arg(long)]
    report: bool,

    /// No progress and no closing summary
    #[arg(long)]
    quiet: bool,

    /// Print the summary as JSON to standard output
    #[arg(long)]
    json: bool,
}

pub fn call(args: Args) -> Result<()> {
    let options = ResumeOptions {
        threads: args.threads.map(usize::from),
        quiet: args.quiet,
        json: args.json,
        stop_after: args.stop_after,
        backend: args.backend.map(Into::into),
    };
    let outcome = resume(&args.dir, options)?;
    super::close(outcome, args.report, args.quiet, args.json)
}
