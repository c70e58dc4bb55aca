//! The tables `[[calibrate]]` of a scene: keys that a calibration may change, with bounds and priors.

use super::Scene;
use crate::error::{Error, Result};
use toml::Value;

/// Prior distribution of a parameter: what is known before the calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// Uniform between the bounds.
    Uniform,
    /// Uniform in the logarithm between the bounds.
    LogUniform,
    /// Normal, cut off at the bounds.
    Normal {
        /// Mean, in the unit of the key.
        mean: f64,
        /// Standard deviation, in the unit of the key.
        sd: f64,
    },
}

/// A key that is to be calibrated. Numbers are in the unit of the key.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    /// Dotted key of the scene.
    pub key: String,
    /// Lower bound.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
    /// Prior distribution.
    pub prior: Prior,
    /// File and key where it was written, for messages.
    pub place: String,
}

impl Scene {
    /// The keys of the scene that are to be calibrated.
    ///
    /// # Errors
    /// A normal prior without mean or standard deviation.
    pub fn calibrated(&self) -> Result<Vec<Calibrated>> {
        let entries = self.layer.table.get("calibrate").and_then(Value::as_array).map(Vec::as_slice).unwrap_or_default();
        entries
            .iter()
            .enumerate()
            .map(|(i, entry)| {
                let origin = self.layer.origin(&format!("calibrate[{i}]"));
                let place = format!("{}: {}", origin.place, origin.key);
                let text = |key: &str| entry.get(key).and_then(Value::as_str).unwrap_or_default();
                let number = |key: &str| entry.get(key).and_then(Value::as_float);
                let needed = |key: &str| {
                    let missing = || Error::input(&place, key, None, "is missing: a normal prior has a mean and a sd");
                    number(key).ok_or_else(missing)
                };
                let prior = match text("prior") {
                    "log_uniform" => Prior::LogUniform,
                    "normal" => Prior::Normal { mean: needed("mean")?, sd: needed("sd")? },
                    _ => Prior::Uniform,
                };
                let bound = |key: &str| number(key).unwrap_or(f64::NAN);
                Ok(Calibrated { key: text("key").into(), lower: bound("lower"), upper: bound("upper"), prior, place })
            })
            .collect()
    }
}
