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
//! models can be compared. A grain that bore its force counts with the probability of a higher strength.

pub mod area;
mod bootstrap;
pub mod classes;
pub mod data;
pub mod figures;
pub mod fit;
pub mod fragment;
pub mod goodness;
pub mod inputs;
pub mod likelihood;
mod profile;
pub mod report;
pub mod simulate;
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

/// How a calibration is done.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    pub intervals: Intervals,
    /// Samples drawn for the goodness of each fit.
    pub samples: usize,
    pub seed: u64,
}

/// Every law fitted to the tests of one file, and which is preferred.
#[derive(Clone, Debug)]
pub struct Calibration {
    pub data: Data,
    pub inputs: Inputs,
    pub settings: Settings,
    /// Area models in the order given, each with every spread.
    pub fits: Vec<Fit>,
    pub goodness: Vec<Goodness>,
    /// Index of the preferred fit.
    pub best: usize,
    /// Why it is preferred.
    pub why: String,
    pub classes: Vec<Class>,
}

impl Calibration {
    pub fn best(&self) -> &Fit {
        &self.fits[self.best]
    }

    /// The fits whose spread a scene can draw.
    pub fn drawn(&self) -> impl Iterator<Item = &Fit> {
        self.fits.iter().filter(|f| f.spread == Spread::TruncatedNormal)
    }

    /// Everything that has to be said with the numbers: of the data, then of the preferred fit, then of the choice.
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
        notes
    }
}

/// Fits all spreads with all area models of `inputs`. `done` is called after each.
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
    Calibration { data, inputs, settings, fits, goodness, best, why, classes }
}
