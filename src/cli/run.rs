//! `comminute run SCENE`

use super::Overrides;
use comminute::error::Result;
use comminute::run::{SceneOptions, Word, run_scene};
use std::path::PathBuf;

/// Run a scene and draw its figures
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute run experiments/petroleum_coke/h-c-2.toml --set loading.max_stress_kPa=500 --out runs/try"
)]
pub struct Args {
    /// Scene file (TOML)
    scene: PathBuf,

    /// Folder for everything the run leaves; runs/ and the name of the scene file if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    overrides: Overrides,

    /// Threads; all cores if not given. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = super::threads())]
    threads: Option<u16>,

    /// Backend that computes the steps of a continuum; cpu if not given
    #[arg(long, value_enum)]
    backend: Option<super::Backend>,

    /// Begin with a prepared specimen (specimen.csv of another run) instead of making one
    #[arg(long, value_name = "FILE")]
    specimen: Option<PathBuf>,

    /// Overwrite the run that the folder holds
    #[arg(long)]
    force: bool,

    /// Do only what is left of the run: nothing if the folder holds it finished, the rest if it
    /// holds a checkpoint, else all of it. With --force a run of another scene is overwritten
    #[arg(long = "continue")]
    left: bool,

    /// Stop after this many steps, preparation included (on a graphics device at its next look, at most 64 steps later); `comminute resume` goes on from there
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

pub fn call(mut args: Args) -> Result<()> {
    if let Some(specimen) = &args.specimen {
        args.overrides.sets.push(format!("specimen.file={:?}", specimen.display().to_string()));
    }
    let scene = args.overrides.load(&args.scene)?;
    let options = SceneOptions {
        out: args.out,
        threads: args.threads.map(usize::from),
        backend: args.backend.map(Into::into),
        force: args.force,
        left: args.left,
        stop_after: args.stop_after,
        quiet: args.quiet,
        json: args.json,
    };
    let outcome = run_scene(&scene, options, &mut |word| match word {
        Word::Note(note) => eprintln!("{note}"),
        Word::Warning(warning) => eprintln!("warning: {warning}"),
    })?;
    super::close(outcome, args.report, args.quiet, args.json)
}
