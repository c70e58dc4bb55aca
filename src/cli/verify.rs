//! `comminute verify`

use comminute::error::{Error, Result};
use comminute::verify::{self, Plan, TABLE};
use std::path::PathBuf;

/// Run cases with closed forms at several resolutions: error, time, figures
///
/// Writes verification.csv (a row for each error), verification.md (tables) and two figures a case: error against resolution and against time.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples, from the repository root:\n  comminute verify\n  comminute verify --only bar,disk --levels 2 --out runs/try\n  comminute verify --only crater_cells --backend gpu --out runs/craters"
)]
pub struct Args {
    /// Only these cases, by name; some take longer and are run only when named
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    only: Vec<String>,

    /// Number of resolutions, from the coarsest on
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u8).range(1..))]
    levels: u8,

    /// Folder of the cases' scenes
    #[arg(long, value_name = "DIR", default_value = "experiments/verification")]
    scenes: PathBuf,

    /// Folder for everything
    #[arg(long, value_name = "DIR", default_value = "runs/verification")]
    out: PathBuf,

    /// Threads of each run; times depend on it, errors do not
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::threads())]
    threads: u16,

    /// Ways of a case at a time; times depend on it, errors do not
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = super::threads())]
    jobs: u16,

    /// Backend of the cases that are scenes
    #[arg(long, value_enum, default_value = "cpu")]
    backend: super::Backend,

    /// Overwrite what the folder holds
    #[arg(long)]
    force: bool,

    /// Keep the runs that the folder holds, and make those that are missing
    #[arg(long = "continue", conflicts_with = "force")]
    keep: bool,

    /// List the cases and do nothing
    #[arg(long)]
    list: bool,

    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub fn call(args: &Args) -> Result<()> {
    let cases = if args.list && args.only.is_empty() { verify::all().collect() } else { verify::chosen(&args.only)? };
    if args.list {
        let lines: Vec<String> = cases.iter().map(|c| format!("{:<15} {}. Exact: {}.", c.name, c.about, c.exact)).collect();
        return super::print(&lines.join("\n"));
    }
    if !args.scenes.is_dir() {
        return Err(Error::input(
            "--scenes",
            "",
            None,
            format!("{} is no folder; start from the repository root", args.scenes.display()),
        ));
    }
    if args.out.join(TABLE).exists() && !args.force && !args.keep {
        return Err(Error::Exists { path: args.out.clone() });
    }
    let threads = usize::from(args.threads);
    let plan = Plan {
        levels: args.levels.into(),
        scenes: &args.scenes,
        out: &args.out,
        keep: args.keep,
        backend: args.backend.into(),
        jobs: args.jobs.into(),
        threads,
    };
    cases.iter().try_for_each(|case| case.runs_on(plan.backend))?;
    let mut done = Vec::new();
    for case in cases {
        let told = |way: &str, cells: u32| {
            if !args.quiet {
                eprintln!("{}: {way}, {cells} {}", case.name, case.across);
            }
        };
        done.push((case, case.measure(&plan, told)?));
    }
    let files = verify::write(&done, &plan)?;
    if !args.quiet {
        super::list_files(&files);
    }
    Ok(())
}
