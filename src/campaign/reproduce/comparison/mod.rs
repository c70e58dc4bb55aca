//! What the runs of a plan are compared by. Each way has its own table of published numbers beside those of the runs; a plan names one of them.

mod counts;
mod crushing;
mod numbers;
mod plastic_zone;
mod runs;
mod triaxial;

pub use counts::Row;

use super::plan::Plan;
use super::results::Done;
use laboratory::error::Result;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// A way to compare runs with what was published of them.
pub trait Comparison {
    /// Writes the tables of all runs, `comparison.csv` first, into `dir`, and gives them with the part of the report between the source of the paper and the
    /// remarks.
    ///
    /// # Errors
    /// Records that cannot be read and files that cannot be written.
    fn compare(&self, plan: &Plan, done: &[Done], dir: &Path) -> Result<(Vec<PathBuf>, String)>;
}

/// The ways there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Compare {
    /// Breakages and grains of oedometers.
    #[default]
    Crushing,
    /// Strengths, volumes and times of triaxial tests.
    Triaxial,
    /// Single numbers.
    Numbers,
}

impl Compare {
    /// What does it.
    pub fn comparison(self) -> &'static dyn Comparison {
        match self {
            Compare::Crushing => &crushing::Crushing,
            Compare::Triaxial => &triaxial::Triaxial,
            Compare::Numbers => &numbers::Numbers,
        }
    }
}
