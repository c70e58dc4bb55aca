//! `comminute report DIR…`

use comminute::error::Result;
use comminute::report::{self, Options};
use comminute::run::REPORT;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

/// Write a page that shows runs: figures, the specimen in 3D, breakages, provenance
///
/// The page is one file that needs no network. Several runs are shown together; a folder whose folders are runs, as an ensemble leaves it,
/// stands for these.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example, after the two runs:\n  comminute report runs/h-c-2 runs/h-c-2-nc --out figures/h-c-2.html --open")]
pub struct Args {
    /// Folders of runs
    #[arg(required = true, value_name = "DIR")]
    runs: Vec<PathBuf>,

    /// The page; report.html in the folder if only one is given, else in the present one, if not given
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,

    /// Largest number of snapshots of each run in the page
    #[arg(long, value_name = "N", default_value = "12")]
    snapshots: NonZeroUsize,

    /// Overwrite a file that is no report
    #[arg(long)]
    force: bool,

    /// Show the page in the system's browser
    #[arg(long)]
    open: bool,

    /// Do not say where the page is
    #[arg(long)]
    quiet: bool,

    /// Print the page's path, its length and the runs as JSON to standard output
    #[arg(long)]
    json: bool,
}

pub fn call(args: &Args) -> Result<()> {
    let out = match (&args.out, args.runs.as_slice()) {
        (Some(out), _) => out.clone(),
        (None, [one]) => one.join(REPORT),
        (None, _) => REPORT.into(),
    };
    let written = report::write(&args.runs, &out, &Options { snapshots: args.snapshots.get(), force: args.force })?;
    if args.json {
        let text =
            serde_json::json!({ "report": written.path, "bytes": written.bytes, "runs": written.runs, "notes": written.notes });
        super::print(&text.to_string())?;
    }
    if !args.quiet {
        for note in &written.notes {
            eprintln!("note: {note}");
        }
        say(&written);
    }
    if args.open {
        show(&out);
    }
    Ok(())
}

/// Writes the report of a run that has ended into its folder.
pub fn of_run(dir: &Path, quiet: bool) -> Result<()> {
    let written = report::write_run(dir)?;
    if !quiet {
        say(&written);
    }
    Ok(())
}

/// Prints where a report is, and its length.
fn say(written: &report::Written) {
    eprintln!("report in {} ({:.1} MB)", written.path.display(), 1e-6 * written.bytes as f64);
}

/// Shows a page in the browser; where there is none, says so.
fn show(page: &Path) {
    if let Err(error) = open::that_detached(page) {
        eprintln!("note: no browser could be started ({error}); open {} in one", page.display());
    }
}
