//! `[[calibrate]]`: the keys that a calibration may change, with bounds and priors.

use super::Scene;
use crate::error::{Error, Result};
use toml::Value;

/// What is known of a parameter before its calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Prior {
    /// Any value between the bounds.
    Uniform,
    /// Any order of magnitude between the bounds.
    LogUniform,
    /// Normal, cut off at the bounds.
    Normal { mean: f64, sd: f64 },
}

/// One key with bounds and prior, in the unit of the key.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibrated {
    pub key: String,
    pub lower: f64,
    pub upper: f64,
    pub prior: Prior,
    /// Where it was written, for messages.
    pub place: String,
}

impl Scene {
    /// The keys that the scene says are to be calibrated.
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
