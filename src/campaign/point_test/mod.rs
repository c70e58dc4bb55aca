//! A constitutive law driven along laboratory paths at a single point, without a grid: drained
//! triaxial compression or extension at constant cell pressure, undrained at constant volume,
//! oedometer, isotropic compression, and simple shear at constant volume. Compression is positive in everything recorded.

mod drive;
mod report;

pub use drive::{Row, Test, drive};
pub use report::{FIGURES, HISTORY, MATERIAL, SUMMARY, claim, summary, write};

use laboratory::error::{Error, Result};

/// Path of strain or stress that is imposed on the point. z is the axis, x and y are lateral, shear
/// is in the x-z plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path {
    /// Axial strain at constant lateral stress.
    Triaxial,
    /// Axial strain without lateral strain.
    Oedometer,
    /// Shear strain without any other: constant volume.
    SimpleShear,
    /// The same strain along every axis.
    Isotropic,
    /// Axial strain at constant volume, lateral strains equal: an undrained triaxial test, in effective stresses.
    Undrained,
}

impl Path {
    /// Name in files.
    pub fn name(self) -> &'static str {
        match self {
            Path::Triaxial => "triaxial",
            Path::Oedometer => "oedometer",
            Path::SimpleShear => "simple_shear",
            Path::Isotropic => "isotropic",
            Path::Undrained => "undrained",
        }
    }
}

/// The place of wrong values that error messages name.
const PLACE: &str = "point test";

/// The tests to make: one for each confining stress.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Which strains and stresses are prescribed.
    pub path: Path,
    /// Isotropic stress at the start of each test, Pa: the cell pressure of a triaxial test.
    pub confining: Vec<f64>,
    /// Axial strain at the end (negative: extension), or engineering shear strain.
    pub strain: f64,
    /// Steps of equal strain.
    pub steps: u32,
}

impl Settings {
    /// Checks that a test can be made with these values.
    ///
    /// # Errors
    /// The first value with which no test can be made, by its name.
    pub fn check(&self) -> Result<()> {
        let refuse = |name: &str, value: f64, message: &str| Err(Error::input(PLACE, name, Some(value.to_string()), message));
        if let Some(bad) = self.confining.iter().find(|p| !(0.0..=1e9).contains(*p)) {
            return refuse("confining_kPa", 1e-3 * bad, "must be >= 0 and <= 1000000");
        }
        if let Some(twice) = self.confining.iter().enumerate().find(|(i, p)| self.confining[..*i].contains(p)) {
            return refuse("confining_kPa", 1e-3 * twice.1, "stands there twice");
        }
        if self.confining.is_empty() {
            return Err(Error::input(PLACE, "confining_kPa", None, "must hold at least one stress"));
        }
        if !(self.strain.abs() <= 1.0 && self.strain != 0.0) {
            return refuse("strain", self.strain, "must be between -1 and 1, and not 0");
        }
        if self.steps == 0 {
            return refuse("steps", 0.0, "must be at least 1");
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
