//! `comminute plot DIR…`

use comminute::error::{Error, Result};
use comminute::figure;
use comminute::run::words;
use std::path::{Path, PathBuf};

/// Draw runs and data files into common figures
#[derive(Debug, clap::Args)]
#[command(after_help = "Example, after the two runs:\n  comminute plot runs/h-c-2 runs/h-c-2-nc --out figures/h-c-2")]
pub struct Args {
    /// Folders of runs; the figures of one go into its own figures/ if --out is not given
    #[arg(required = true, value_name = "DIR")]
    runs: Vec<PathBuf>,

    /// Measurements to overlay, drawn as symbols (CSV)
    #[arg(long, value_name = "CSV")]
    data: Vec<PathBuf>,

    /// Draw only these figures, by the names of their files, as in crush_events,k0
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    show: Vec<String>,

    /// Folder for the figures
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Do not list the files drawn
    #[arg(long)]
    quiet: bool,

    /// Print the files drawn as JSON to standard output
    #[arg(long)]
    json: bool,
}

pub fn call(args: &Args) -> Result<()> {
    for dir in &args.runs {
        if !dir.is_dir() {
            let message = "is no folder";
            return Err(Error::input(dir.display(), "", None, message));
        }
    }
    for file in &args.data {
        std::fs::File::open(file).map_err(Error::read(file))?;
    }
    let (out, own) = match (&args.out, args.runs.as_slice()) {
        (Some(out), _) => (out.clone(), false),
        (None, [one]) => (one.join("figures"), true),
        (None, _) => {
            let message = "must name a folder for the figures of several runs";
            return Err(Error::input("--out", "", None, message));
        }
    };
    let files = if !args.show.is_empty() {
        let mut files = figure::chosen(&args.runs, &args.data, &args.show, &out)?;
        if files.is_empty() {
            let message = format!("the runs given have no {}", args.show.join(" and no "));
            return Err(Error::input("--show", "", None, message));
        }
        files.extend(figure::write_runs(&args.runs, &out)?);
        files
    } else if own && args.data.is_empty() {
        figure::draw_run(&args.runs[0])?
    } else {
        figure::overlay(&args.runs, &args.data, &out)?
    };
    if args.json {
        super::print(&serde_json::json!({ "files": files }).to_string())?;
    }
    if !args.quiet {
        for dir in &args.runs {
            print_results(dir);
        }
        super::list_files(&files);
    }
    Ok(())
}

/// Prints the results of a run in one line; nothing if the run has left no summary.
fn print_results(dir: &Path) {
    let summary = std::fs::read_to_string(dir.join("summary.json")).ok();
    let Some(summary) = summary.and_then(|text| serde_json::from_str::<serde_json::Value>(&text).ok()) else { return };
    let found = words::results(&summary);
    if !found.is_empty() {
        eprintln!("{}: {found}", dir.display());
    }
}
