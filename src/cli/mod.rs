//! The command line: a file for each verb.

mod bench;
mod bench_features;
mod bench_mixture;
mod bench_mpm;
mod calibrate;
mod calibrate_curve;
mod calibrate_curve_study;
mod calibrate_fines;
mod calibrate_grains;
mod calibrate_study;
mod campaign;
mod check;
mod completions;
mod ensemble;
mod executor;
mod export;
mod import;
mod man;
mod new;
mod plot;
mod point_test;
mod report;
mod reproduce;
mod resume;
mod run;
mod study;
mod sweep;
mod verify;

use clap::{Args, Parser, Subcommand};
use comminute::error::{Error, Result};
use comminute::run::{MOST_THREADS, words};
use comminute::scene::{self, Scene};
use std::ffi::OsString;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Crushable-grain discrete element method: grains that break, gradations that evolve, compression curves.
#[derive(Debug, Parser)]
#[command(version, after_help = "Example:\n  comminute run experiments/petroleum_coke/h-c-2.toml")]
pub struct Cli {
    #[command(subcommand)]
    pub verb: Verb,

    /// Largest instruction set that the inner loops may use; changes no bit of the results
    #[arg(long, global = true, value_name = "SET", env = "COMMINUTE_SIMD", hide_env_values = true, default_value = "best")]
    #[arg(value_parser = comminute::math::real::ARCHS)]
    simd: String,
}

/// Does what the words of a command line ask for, the name of the program first, as the program `comminute` does: prints results, and an
/// error with advice to standard error. Gives the exit code.
pub fn command(words: impl IntoIterator<Item = OsString>) -> u8 {
    comminute::interrupt::outlive_size_limit();
    let cli = match Cli::try_parse_from(words) {
        Ok(cli) => cli,
        // help and version as well
        Err(said) => {
            let _ = said.print();
            return u8::try_from(said.exit_code()).unwrap_or(1);
        }
    };
    match cli.call() {
        Ok(()) => 0,
        Err(error) => {
            for line in error.to_string().lines() {
                eprintln!("error: {line}");
            }
            if let Some(advice) = advice(&error) {
                eprintln!("{advice}");
            }
            error.exit_code()
        }
    }
}

/// Does what the words behind the name of the program ask for as a part of the calling program, which gets the error.
///
/// # Errors
/// Words that the command does not know; the errors of the verb.
pub fn call(words: impl IntoIterator<Item = OsString>) -> Result<()> {
    let all = std::iter::once("comminute".into()).chain(words);
    let cli = Cli::try_parse_from(all).map_err(|said| {
        let text = said.to_string();
        let line = text.lines().next().unwrap_or_default();
        Error::input("comminute", "", None, line.trim_start_matches("error: "))
    })?;
    cli.call()
}

impl Cli {
    fn call(self) -> Result<()> {
        comminute::math::real::choose(&self.simd);
        self.verb.call()
    }
}

#[derive(Debug, Subcommand)]
pub enum Verb {
    /// Write a scene to begin with
    New(new::Args),
    /// Run a scene and draw its figures
    Run(run::Args),
    /// Validate a scene and say what the run would be
    Check(check::Args),
    /// Draw runs and data files into common figures
    Plot(plot::Args),
    /// Write a page that shows runs: figures, the specimen in 3D, breakages, provenance
    Report(report::Args),
    /// Write grains and bodies of a run for other programs
    Export(export::Args),
    /// Make the table of grains of a free scene from a file of another program
    Import(import::Args),
    /// Continue a run that was stopped
    Resume(resume::Args),
    /// Run a scene with several seeds; mean and band of every curve
    Ensemble(ensemble::Args),
    /// Run a table of parameters, each in a process and a folder of its own
    Sweep(sweep::Args),
    /// Measure what choices cost in accuracy and time, against a reference
    Study(study::Args),
    /// Take a continuum law through a laboratory path at a single point
    PointTest(point_test::Args),
    /// Run a paper's runs again and compare
    Reproduce(reproduce::Args),
    /// Run cases with closed forms at several resolutions: error, time, figures
    Verify(verify::Args),
    /// Measure the speed of the engine
    Bench(bench::Args),
    /// Find parameters from laboratory data
    Calibrate(calibrate::Args),
    /// Print what makes a shell complete the words of this program
    Completions(completions::Args),
    /// Print a manual page of this program
    Man(man::Args),
}

impl Verb {
    pub fn call(self) -> Result<()> {
        match self {
            Verb::New(args) => new::call(&args),
            Verb::Run(args) => run::call(args),
            Verb::Check(args) => check::call(&args),
            Verb::Plot(args) => plot::call(&args),
            Verb::Report(args) => report::call(&args),
            Verb::Export(args) => export::call(&args),
            Verb::Import(args) => import::call(&args),
            Verb::Resume(args) => resume::call(args),
            Verb::Ensemble(args) => ensemble::call(&args),
            Verb::Sweep(args) => sweep::call(&args),
            Verb::Study(args) => study::call(&args),
            Verb::PointTest(args) => point_test::call(&args),
            Verb::Reproduce(args) => reproduce::call(&args),
            Verb::Verify(args) => verify::call(&args),
            Verb::Bench(args) => bench::call(&args),
            Verb::Calibrate(args) => calibrate::call(&args),
            Verb::Completions(args) => completions::call(&args),
            Verb::Man(args) => man::call(&args),
        }
    }
}

/// Numbers of threads, and of runs at a time, that a person may ask for.
pub fn threads() -> clap::builder::RangedI64ValueParser<u16> {
    clap::value_parser!(u16).range(1..=MOST_THREADS as i64)
}

/// Changes that the command line makes in a scene.
#[derive(Debug, Args)]
pub struct Overrides {
    /// Replace a value of the scene or its material, as in loading.max_stress_kPa=2000
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,

    /// Numerical keys that the scene does not set: draft, standard or reference, as the key `accuracy`
    #[arg(long, value_name = "LEVEL")]
    pub accuracy: Option<String>,

    /// Seed of both random streams
    #[arg(long, value_name = "N", conflicts_with_all = ["seed_packing", "seed_strength"])]
    pub seed: Option<u64>,

    /// Seed of the specimen
    #[arg(long, value_name = "N")]
    pub seed_packing: Option<u64>,

    /// Seed of the strengths
    #[arg(long, value_name = "N")]
    pub seed_strength: Option<u64>,
}

/// Backend that computes the steps.
#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
pub enum Backend {
    /// The processor, in double precision
    Cpu,
    /// A graphics device, in single precision with compensated sums; continuum and mixture scenes only
    Gpu,
    /// A graphics device that is hardware, if there is one and it has all that the scene asks for, else the processor
    Auto,
}

impl From<Backend> for comminute::run::Backend {
    fn from(backend: Backend) -> Self {
        match backend {
            Backend::Cpu => Self::Cpu,
            Backend::Gpu => Self::Gpu,
            Backend::Auto => Self::Auto,
        }
    }
}

impl Overrides {
    /// The scene with everything that the command line changes.
    pub fn load(&self, path: &Path) -> Result<Scene> {
        let mut sets = self.sets.clone();
        let packing = self.seed.or(self.seed_packing);
        let strength = self.seed.or(self.seed_strength);
        sets.extend(self.accuracy.iter().map(|level| format!("accuracy={level}")));
        sets.extend(packing.map(|n| format!("seed.packing={n}")));
        sets.extend(strength.map(|n| format!("seed.strength={n}")));
        scene::load(path, &sets)
    }
}

/// Advice after an error: what the user can type next, if anything helps.
pub fn advice(error: &Error) -> Option<String> {
    match error {
        Error::Several(errors) => errors.iter().find_map(advice),
        Error::Exists { .. } | Error::Other { .. } => Some("choose another folder with --out, or overwrite it with --force".into()),
        Error::Stopped { .. } => Some("the same command goes on with the rest".into()),
        Error::Interrupted { out, .. } => Some(format!("continue with: comminute resume {}", out.display())),
        Error::Device(_) => Some(
            "the CPU computes the scene with --backend cpu; a run that has begun goes on with: comminute resume RUN --backend cpu"
                .into(),
        ),
        _ => None,
    }
}

/// Prints text for other programs to standard output. No error if the reader has closed its end.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    let done = writeln!(out, "{text}").and_then(|()| out.flush());
    match done {
        // the reader has closed its end
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        done => done.map_err(Error::write("standard output")),
    }
}

/// Draws the figures of a run if the scene asks for them, prints its results, its warnings and
/// its folder, and writes its report if the scene or `report` asks for it.
pub fn close(mut outcome: comminute::run::Outcome, report: bool, quiet: bool, json: bool) -> Result<()> {
    let figures = comminute::figure::complete(&mut outcome)?;
    if json {
        let text = serde_json::to_string_pretty(&outcome.summary).unwrap_or_default();
        print(&text)?;
    }
    if !quiet {
        for line in words::closing(&outcome.summary) {
            eprintln!("{line}");
        }
        for warning in words::warnings(&outcome.summary) {
            eprintln!("warning: {warning}");
        }
        eprintln!("records in {}", outcome.out.display());
        count_figures(&outcome, &figures);
    }
    if report || outcome.report { report::of_run(&outcome.out, quiet) } else { Ok(()) }
}

/// Prints the number of figures drawn and their folder.
fn count_figures(outcome: &comminute::run::Outcome, figures: &[PathBuf]) {
    let count = figures.iter().filter(|f| f.extension().is_some_and(|e| e == "png")).count();
    if count > 0 {
        eprintln!("{count} figures in {}", outcome.out.join("figures").display());
    }
}

/// Prints the paths of files, one a line.
pub fn list_files(files: &[PathBuf]) {
    for file in files {
        eprintln!("  {}", file.display());
    }
}
