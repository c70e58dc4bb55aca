//! Strength of grains from the forces that crushed them between platens (Ciantia et al. 2015, section "Model
//! calibration", eqs 16, 17, Figs 7, 8): sigma_lim0, m and var. by maximum likelihood.
//!
//! A grain of diameter d that breaks under the force F had the limit strength sigma = F / A_F(F, d), and
//!
//! ```text
//! sigma = sigma_lim0 (d / d0)^(-s) y,   s = 3/m,   y from a spread with the coefficient of variation var.
//! ```
//!
//! The likelihood is that of the forces (the density of sigma times d sigma / d F), so that fits with different area
//! models can be compared. A grain that did not break counts with the probability of a higher
//! strength.

pub mod area;
mod bootstrap;
pub(crate) mod classes;
pub mod data;
pub(crate) mod figures;
pub mod fit;
pub mod fragment;
pub(crate) mod goodness;
pub mod inputs;
pub(crate) mod likelihood;
mod profile;
pub mod report;
pub(crate) mod simulate;
pub mod spread;
pub mod study;
pub mod study_report;
#[cfg(test)]
mod tests;

use classes::Class;
use data::Data;
use fit::{Fit, Intervals, preferred};
use goodness::Goodness;
use inputs::Inputs;
use spread::Spread;
use statrs::distribution::{ChiSquared, ContinuousCDF};

/// Settings of a calibration.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How the 95 % limits are found.
    pub intervals: Intervals,
    /// Samples drawn for the goodness of each fit.
    pub samples: usize,
    /// Seed of these samples.
    pub seed: u64,
}

/// Every law fitted to the tests of one file, and which is preferred.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The tests.
    pub data: Data,
    /// Angle, moduli and reference diameter.
    pub inputs: Inputs,
    /// How the calibration was done.
    pub settings: Settings,
    /// Area models in the order given, each with every spread.
    pub fits: Vec<Fit>,
    /// Goodness of each fit, in the order of `fits`.
    pub goodness: Vec<Goodness>,
    /// Index of the preferred fit.
    pub best: usize,
    /// Reason for which that fit is preferred.
    pub why: String,
    /// The tests by size, each with its own Weibull fit.
    pub classes: Vec<Class>,
    /// If the file has several series: the probability that they differ as much by chance under one
    /// law.
    pub series_p_value: Option<f64>,
}

impl Calibration {
    /// The preferred fit.
    pub fn best(&self) -> &Fit {
        &self.fits[self.best]
    }

    /// The fits whose spread a scene can draw.
    pub fn drawn(&self) -> impl Iterator<Item = &Fit> {
        self.fits.iter().filter(|f| f.spread == Spread::TruncatedNormal)
    }

    /// Remarks without which the numbers would mislead: on the data, the preferred fit, and the
    /// choice of that fit.
    pub fn notes(&self) -> Vec<String> {
        let mut notes = self.data.notes.clone();
        notes.extend(self.best().notes().into_iter().filter(|n| !n.starts_with("one size: m")));
        if self.best().spread != Spread::TruncatedNormal {
            let scene = match self.drawn().any(|f| !f.at_limit()) {
                true => "material.toml has the truncated normal fitted to the same data",
                false => "the truncated normal that they draw cannot be as wide as these data",
            };
            notes.push(format!("the preferred spread ({}) is not one that scenes draw: {scene}", self.best().spread.name()));
        }
        let other = self.fits.iter().filter(|f| f.area.model != self.best().area.model).map(|f| f.criteria().aic);
        let nearest = other.fold(f64::INFINITY, f64::min);
        if nearest - self.best().criteria().aic < fit::NO_DIFFERENCE {
            notes.push(
                "the data do not tell the two area models apart (log-normal and Weibull spreads are the same law in both)".into(),
            );
        }
        if self.goodness[self.best].p_value.is_some_and(|p| p < 0.05) {
            notes.push("no law fitted may be right: the preferred one does not describe the data (p < 0.05)".into());
        }
        match self.series_p_value {
            Some(p) if p < 0.05 => {
                notes.push(format!("the series do not have one law (likelihood ratio, p = {p:.4}): calibrate them one by one"));
            }
            None if self.data.series.len() > 1 => notes.push("the series are fitted as one; some are too small to compare".into()),
            _ => {}
        }
        notes
    }
}

/// p-value of the likelihood ratio between one law for each series and one law for all. `None` for
/// one series, or if a series has too few broken grains or no spread.
fn compare_series(data: &Data, best: &Fit, d0: f64) -> Option<f64> {
    let parts: Vec<Data> = (0..data.series.len())
        .map(|n| Data { grains: data.grains.iter().filter(|g| g.series == n).copied().collect(), ..data.clone() })
        .collect();
    if parts.len() < 2 || parts.iter().any(|p| !p.has_spread()) {
        return None;
    }
    let fits: Vec<Fit> = parts.iter().map(|p| Fit::new(p, best.area, best.spread, d0)).collect();
    let more = fits.iter().map(Fit::parameters).sum::<usize>().checked_sub(best.parameters()).filter(|n| *n > 0)?;
    let ratio = 2.0 * (fits.iter().map(|f| f.ln_likelihood).sum::<f64>() - best.ln_likelihood);
    ChiSquared::new(more as f64).ok().map(|c| c.sf(ratio.max(0.0)))
}

/// Fits all spreads with all area models of `inputs`. `done` is called after each fit.
pub fn calibrate(data: Data, inputs: Inputs, settings: Settings, done: impl Fn()) -> Calibration {
    let mut fits = Vec::new();
    let mut goodness = Vec::new();
    for area in &inputs.areas {
        for spread in Spread::ALL {
            let fit = Fit::new(&data, *area, spread, inputs.d0).with_intervals(&data, settings.intervals);
            goodness.push(goodness::judge(&fit, settings.samples, settings.seed));
            fits.push(fit);
            done();
        }
    }
    let (best, why) = preferred(&fits).unwrap_or((0, String::new()));
    let classes = classes::classes(&data);
    let series_p_value = fits.get(best).and_then(|f| compare_series(&data, f, inputs.d0));
    Calibration { series_p_value, data, inputs, settings, fits, goodness, best, why, classes }
}
