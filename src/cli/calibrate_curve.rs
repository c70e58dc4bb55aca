//! `comminute calibrate curve CURVE.csv --scene SCENE`

use comminute::calibrate::curve::parameter::Parameter;
use comminute::calibrate::curve::target::Files;
use comminute::calibrate::curve::{Request, calibrate, default_out};
use comminute::error::Result;
use std::path::PathBuf;

/// Find parameters of a scene from an oedometer curve, with what the curve leaves open
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute calibrate curve experiments/calibration/targets/target-05.csv --scene experiments/calibration/coke_small.toml --budget 60 --out runs/calibration"
)]
pub struct Args {
    /// Curve: sigma_v_kPa or sigma_v_MPa with void_ratio, porosity, axial_strain or axial_strain_percent (of all dry mass, as the laboratory has them; void_ratio_grains, porosity_grains: of what is left in grains), and sd, k0, k0_sd if known (CSV)
    curve: PathBuf,

    /// Scene whose runs are to give the curve, as small as it can be (TOML); its [[calibrate]] tables say what may change
    #[arg(long, value_name = "SCENE")]
    scene: PathBuf,

    /// Parameter to be found, with its bounds, and :log or :normal(MEAN,SD) for its prior; replaces
    /// the [[calibrate]] tables of the scene
    #[arg(long = "parameter", value_name = "KEY=LOW..HIGH[:PRIOR]")]
    parameters: Vec<String>,

    /// Stress ratios to be met as well: sigma_v_… and k0 (CSV)
    #[arg(long, value_name = "CSV")]
    k0: Option<PathBuf>,

    /// Gradations to be met as well: sigma_v_…, diameter_mm and passing_percent (CSV)
    #[arg(long, value_name = "CSV")]
    gsd: Option<PathBuf>,

    /// Replace a value of the scene or its material in every run
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,

    /// Runs in all; a later call with a larger number goes on
    #[arg(long, value_name = "N")]
    budget: Option<usize>,

    /// Runs of the budget that fill the space between the bounds (14 for each parameter)
    #[arg(long, value_name = "N")]
    design: Option<usize>,

    /// Runs between two updates of the results (5)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    batch: Option<u16>,

    /// Runs with the parameters found, besides the budget (4)
    #[arg(long, value_name = "N")]
    check: Option<u16>,

    /// Number of specimens over which the curve is averaged; each scatters like a run
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u16).range(1..))]
    specimens: u16,

    /// Seed of everything random; the seeds of the runs follow from it
    #[arg(long, value_name = "N", default_value = "1", value_parser = clap::value_parser!(u64).range(1..1_000_000))]
    seed: u64,

    /// Runs at a time; one for each core if not given, and with a scheduler as many as it starts. Results do not depend on it
    #[arg(long, value_name = "N", value_parser = super::threads())]
    jobs: Option<u16>,

    /// Threads of each run; the cores shared out if not given, and 1 with another executor than local
    #[arg(long, value_name = "N", value_parser = super::threads())]
    threads: Option<u16>,

    #[command(flatten)]
    executor: super::executor::Args,

    /// Folder of the calibration and its runs; runs/ and the name of the curve with -calibration if not given
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    /// Begin again in a folder that holds another calibration
    #[arg(long)]
    force: bool,

    /// No progress and no closing table
    #[arg(long)]
    quiet: bool,

    /// Print calibration.json to standard output
    #[arg(long)]
    json: bool,
}

pub fn call(args: &Args) -> Result<()> {
    let out = args.out.clone().unwrap_or_else(|| default_out(&args.curve));
    let request = Request {
        scene: args.scene.clone(),
        sets: args.sets.clone(),
        files: Files { curve: args.curve.clone(), k0: args.k0.clone(), gradations: args.gsd.clone() },
        parameters: args.parameters.iter().map(|text| Parameter::parse(text)).collect::<Result<_>>()?,
        budget: args.budget,
        design: args.design,
        batch: args.batch.map(usize::from),
        check: args.check.map(usize::from),
        seed: args.seed,
        specimens: f64::from(args.specimens),
        executor: args.executor.of(&out)?,
        out,
        parallel: args.jobs.map_or(0, usize::from),
        threads: args.executor.threads(args.threads),
        quiet: args.quiet,
        force: args.force,
    };
    let tell = |line: &str| {
        if !args.quiet {
            eprintln!("{line}");
        }
    };
    let outcome = calibrate(&request, &tell)?;
    if args.json {
        super::print(&serde_json::to_string_pretty(&outcome.json).unwrap_or_default())?;
    }
    if !args.quiet {
        eprint!("{}", outcome.table);
        for warning in &outcome.warnings {
            eprintln!("warning: {warning}");
        }
        eprintln!("report and figures in {}", request.out.display());
    }
    Ok(())
}
