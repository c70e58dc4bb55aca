//! `comminute calibrate fines RUN…`

use super::list_files;
use comminute::calibrate::fines::{FILE, calibrate};
use comminute::calibrate::grains::report;
use comminute::error::Result;
use std::path::PathBuf;

/// Find the continuum law of fine grains from drained triaxial tests of these grains
///
/// Reads stiffness, friction against plastic strain (Li et al. 2023, eq. 43) and dilation off the
/// curves of runs with grains only, no continuum, and writes material.toml, calibration.json and
/// friction_angle.csv.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute run experiments/mixture/twin_grains.toml --set coarse.mass_fraction=0 --out runs/fines\n  \
        comminute calibrate fines runs/fines --base ../../materials/li2023_fines.toml --out runs/fines_law"
)]
pub struct Args {
    /// Folders of triaxial runs with several seeds or cell pressures
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,

    /// The grains' material, written as `base` of material.toml, relative to it
    #[arg(long, value_name = "FILE")]
    base: Option<String>,

    /// Folder for the results
    #[arg(long, value_name = "DIR", default_value = "runs/calibrate-fines")]
    out: PathBuf,

    /// Overwrite an older calibration
    #[arg(long)]
    force: bool,

    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
}

pub fn call(args: &Args) -> Result<()> {
    let found = calibrate(&args.runs)?;
    report::claim(&args.out, args.force)?;
    let files = found.write(&args.out, args.base.as_deref())?;
    if !args.quiet {
        let line = |name: &str, value: String| eprintln!("  {name:<24}{value}");
        eprintln!("{} tests", found.tests.len());
        line("E (MPa), nu", format!("{:.2}, {:.3}", found.young_mpa, found.nu));
        line("phi peak, residual (deg)", format!("{:.2}, {:.2}", found.peak_deg, found.residual_deg));
        line("plastic strain at peak", format!("{:.4}", found.peak_plastic_strain));
        line("H", format!("{:.1}", found.decay));
        line("psi (deg)", format!("{:.2}", found.dilation_deg));
        line("misfit (deg)", format!("{:.2}", found.misfit_deg));
        eprintln!("in a scene: materials.fines = \"path/to/{FILE}\"");
        list_files(&files);
    }
    Ok(())
}
