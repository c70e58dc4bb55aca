//! `comminute calibrate …`: parameters from laboratory data.

use super::{calibrate_curve, calibrate_curve_study, calibrate_fines, calibrate_grains, calibrate_study};
use comminute::error::Result;

/// Find parameters from laboratory data
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example, from the repository root:\n  comminute calibrate grains figures/calibration/grains/simulated.csv --theta0 0.1309"
)]
pub struct Args {
    #[command(subcommand)]
    of: Of,
}

#[derive(Debug, clap::Subcommand)]
enum Of {
    /// Strength of grains from the forces that crushed them between platens
    Grains(calibrate_grains::Args),
    /// Parameters of a scene from an oedometer curve
    Curve(calibrate_curve::Args),
    /// Continuum law of fine grains from their own triaxial tests
    Fines(calibrate_fines::Args),
    /// Test whether the calibration against a curve finds the known parameters of curves from the
    /// scene itself
    CurveStudy(calibrate_curve_study::Args),
    /// Test whether the calibration of grains finds the known parameters of simulated tests
    GrainsStudy(calibrate_study::Args),
}

pub fn call(args: &Args) -> Result<()> {
    match &args.of {
        Of::Grains(args) => calibrate_grains::call(args),
        Of::Curve(args) => calibrate_curve::call(args),
        Of::Fines(args) => calibrate_fines::call(args),
        Of::CurveStudy(args) => calibrate_curve_study::call(args),
        Of::GrainsStudy(args) => calibrate_study::call(args),
    }
}
