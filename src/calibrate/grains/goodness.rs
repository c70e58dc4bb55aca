//! Goodness of fit: Anderson and Darling's statistic A² of the probabilities of the strengths under
//! the fitted law, and a p-value: samples are drawn from that law and fitted again, and those whose
//! A² is at least as large are counted.

use super::fit::Fit;
use super::likelihood::{Held, Params, Sample};
use super::simulate::{generator, unit};
use super::spread::{Law, Spread};
use rayon::prelude::*;
use serde::Serialize;

/// Least strength of a draw, over the mean: smaller and negative draws of an untruncated normal are
/// raised to it, because forces are positive.
const LEAST: f64 = 1e-9;

#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Goodness {
    /// A², -
    pub anderson_darling: f64,
    /// Share of the samples of the fitted law whose A² is at least as large, the data counted as
    /// one; below 0.05 the law does not describe the data.
    pub p_value: Option<f64>,
    pub samples: usize,
}

/// Judges a fit with `samples` random samples (0: only the statistic).
pub fn judge(fit: &Fit, samples: usize, seed: u64) -> Goodness {
    let measured = statistic(&fit.sample, fit.spread, &fit.at, seed, u64::MAX);
    let (_, step) = fit.sample.start(fit.spread);
    let step = Params { a: 0.5 * step.a, s: 0.5 * step.s, t: 0.5 * step.t };
    let larger: usize = (0..samples as u64)
        .into_par_iter()
        .map(|index| {
            let drawn = draw(fit, seed, index);
            let (at, _) = drawn.maximise(fit.spread, Held::Nothing, &fit.at, &step);
            usize::from(statistic(&drawn, fit.spread, &at, seed, index) >= measured)
        })
        .sum();
    let p_value = (samples > 0).then(|| (1 + larger) as f64 / (1 + samples) as f64);
    Goodness { anderson_darling: measured, p_value, samples }
}

/// Random sample of the fitted law, with the sizes of the data. The test of a grain that did not
/// break ends at the same force as in the data.
fn draw(fit: &Fit, seed: u64, index: u64) -> Sample {
    let (law, sample) = (fit.law(), &fit.sample);
    let mut rng = generator(seed, 2 * index);
    let drawn = (0..sample.len()).map(|i| {
        let z = law.quantile(unit(&mut rng)).max(LEAST).ln();
        let bound = sample.ratio(i, &fit.at);
        let censored = sample.censored[i] && z > bound;
        let z = if censored { bound } else { z };
        (z + fit.at.a - fit.at.s * sample.x[i], censored)
    });
    let (strengths, censored) = drawn.unzip();
    sample.with(strengths, censored)
}

/// A² of the probabilities of the strengths. A grain that did not break gets a random probability
/// above that of the force at which its test ended.
fn statistic(sample: &Sample, spread: Spread, at: &Params, seed: u64, index: u64) -> f64 {
    let law = Law::new(spread, at.t);
    let mut rng = generator(seed, index.wrapping_mul(2).wrapping_add(1));
    let mut u: Vec<f64> = (0..sample.len())
        .map(|i| {
            let p = law.probability(sample.ratio(i, at));
            if sample.censored[i] { p + (1.0 - p) * unit(&mut rng) } else { p }
        })
        .collect();
    u.sort_by(f64::total_cmp);
    anderson_darling(&u)
}

/// A² of sorted probabilities.
fn anderson_darling(u: &[f64]) -> f64 {
    let n = u.len();
    let inside = |v: f64| v.clamp(1e-15, 1.0 - 1e-15);
    let sum: f64 = (0..n).map(|i| (2 * i + 1) as f64 * (inside(u[i]).ln() + (-inside(u[n - 1 - i])).ln_1p())).sum();
    -(n as f64) - sum / n as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn even_probabilities_lie_closest() {
        let even: Vec<f64> = (0..100).map(|i| (f64::from(i) + 0.5) / 100.0).collect();
        let bent: Vec<f64> = even.iter().map(|u| u * u).collect();
        assert!(anderson_darling(&even) < 0.05, "{}", anderson_darling(&even));
        assert!(anderson_darling(&bent) > 5.0);
        // one value: A² = -1 - ln u - ln(1 - u)
        assert!((anderson_darling(&[0.3]) + 1.0 + 0.3_f64.ln() + 0.7_f64.ln()).abs() < 1e-12);
    }
}
