//! `comminute calibrate`: parameters from laboratory data.

use super::calibrate_curve as curve;
use comminute::error::Result;

/// Find parameters from laboratory data
#[derive(Debug, clap::Subcommand)]
pub enum Calibrate {
    /// Parameters of a scene from an oedometer curve
    Curve(curve::Args),
}

pub fn call(what: &Calibrate) -> Result<()> {
    match what {
        Calibrate::Curve(args) => curve::call(args),
    }
}
