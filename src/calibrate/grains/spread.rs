//! Spread of strengths about the law of size: the distribution of y = sigma / (sigma_lim0 (d/d0)^(-s)).
//!
//! | spread | y | meaning of sigma_lim0 and var. |
//! |---|---|---|
//! | truncated normal | normal(1, var.²), drawn again below 0 | mean and coefficient of variation of the normal *before* truncation, as in scenes |
//! | normal | normal(1, var.²) | the same; strengths below 0 have a probability |
//! | log-normal | ln y normal(-w²/2, w²), var.² = exp(w²) - 1 | mean and coefficient of variation of the strengths |
//! | Weibull | P(y > t) = exp(-(t G(1 + 1/k))^k), var.² = G(1 + 2/k) / G²(1 + 1/k) - 1 | mean and coefficient of variation of the strengths |
//!
//! G is the gamma function. All functions use z = ln y and one shape parameter: var., w, or 1/k.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};
use statrs::function::erf::erfc;
use statrs::function::gamma::ln_gamma;
use std::f64::consts::{PI, SQRT_2};

/// A kind of spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spread {
    /// Normal without its negative part, as scenes draw strengths.
    TruncatedNormal,
    /// Normal.
    Normal,
    /// Log-normal.
    LogNormal,
    /// Weibull.
    Weibull,
}

impl Spread {
    /// All kinds of spread. The truncated normal, which scenes draw, is the first.
    pub const ALL: [Spread; 4] = [Spread::TruncatedNormal, Spread::Normal, Spread::LogNormal, Spread::Weibull];

    /// Name in files and figures.
    pub fn name(self) -> &'static str {
        match self {
            Spread::TruncatedNormal => "truncated-normal",
            Spread::Normal => "normal",
            Spread::LogNormal => "log-normal",
            Spread::Weibull => "weibull",
        }
    }

    /// Limits of the logarithm of the shape. With var. = 10 a truncated normal is nearly the
    /// positive half of a normal about 0.
    pub fn limits(self) -> (f64, f64) {
        let (low, high): (f64, f64) = match self {
            Spread::TruncatedNormal | Spread::Normal => (1e-4, 10.0),
            Spread::LogNormal => (1e-4, 4.0),
            Spread::Weibull => (1e-4, 8.0),
        };
        (low.ln(), high.ln())
    }

    /// Logarithm of the shape that has about this coefficient of variation; the start of a fit.
    pub fn near(self, var: f64) -> f64 {
        let shape = match self {
            Spread::TruncatedNormal | Spread::Normal => var,
            Spread::LogNormal => (1.0 + var * var).ln().sqrt(),
            Spread::Weibull => var.powf(1.0 / 1.086),
        };
        let (low, high) = self.limits();
        shape.ln().clamp(low + 0.1, high - 0.1)
    }
}

/// A spread with its shape.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    spread: Spread,
    /// var., w or 1/k
    shape: f64,
    /// Logarithm of the probability of y > 0 before truncation (truncated normal), or of G(1 + 1/k)
    /// (Weibull); else 0.
    constant: f64,
}

impl Law {
    /// `ln_shape` is the logarithm of var., w or 1/k.
    pub fn new(spread: Spread, ln_shape: f64) -> Law {
        let shape = ln_shape.exp();
        let constant = match spread {
            Spread::TruncatedNormal => ln_upper(-1.0 / shape),
            Spread::Weibull => ln_gamma(1.0 + shape),
            Spread::Normal | Spread::LogNormal => 0.0,
        };
        Law { spread, shape, constant }
    }

    /// Coefficient of variation, -, as the table above defines it for each spread.
    pub fn var(&self) -> f64 {
        match self.spread {
            Spread::TruncatedNormal | Spread::Normal => self.shape,
            Spread::LogNormal => (self.shape * self.shape).exp_m1().sqrt(),
            Spread::Weibull => (ln_gamma(1.0 + 2.0 * self.shape) - 2.0 * self.constant).exp_m1().max(0.0).sqrt(),
        }
    }

    /// Logarithm of the density of z = ln y.
    pub fn ln_density(&self, z: f64) -> f64 {
        match self.spread {
            Spread::TruncatedNormal | Spread::Normal => {
                let t = (z.exp() - 1.0) / self.shape;
                z - 0.5 * t * t - self.shape.ln() - 0.5 * (2.0 * PI).ln() - self.constant
            }
            Spread::LogNormal => {
                let t = z / self.shape + 0.5 * self.shape;
                -0.5 * t * t - self.shape.ln() - 0.5 * (2.0 * PI).ln()
            }
            Spread::Weibull => {
                let w = (z + self.constant) / self.shape;
                w - w.exp() - self.shape.ln()
            }
        }
    }

    /// Logarithm of the probability of a larger ln y.
    pub fn ln_survival(&self, z: f64) -> f64 {
        match self.spread {
            Spread::TruncatedNormal | Spread::Normal => ln_upper((z.exp() - 1.0) / self.shape) - self.constant,
            Spread::LogNormal => ln_upper(z / self.shape + 0.5 * self.shape),
            Spread::Weibull => -((z + self.constant) / self.shape).exp(),
        }
    }

    /// Probability of a smaller ln y. For the normal that is not truncated, strengths below zero
    /// count as smaller.
    pub fn probability(&self, z: f64) -> f64 {
        -self.ln_survival(z).exp_m1()
    }

    /// The y below which a share `p`, 0..1, of the grains lies. It may be negative for the normal
    /// that is not truncated.
    pub fn quantile(&self, p: f64) -> f64 {
        let normal = Normal::standard();
        match self.spread {
            Spread::Normal => 1.0 + self.shape * normal.inverse_cdf(p),
            Spread::TruncatedNormal => {
                // computed from the upper end, which truncation does not change
                let above = (1.0 - p) * self.constant.exp();
                (1.0 - self.shape * normal.inverse_cdf(above)).max(0.0)
            }
            Spread::LogNormal => (self.shape * normal.inverse_cdf(p) - 0.5 * self.shape * self.shape).exp(),
            Spread::Weibull => (self.shape * (-(-p).ln_1p()).ln() - self.constant).exp(),
        }
    }

    /// Mean of y and coefficient of variation after truncation. Without truncation they are 1 and
    /// var.
    pub fn realised(&self) -> (f64, f64) {
        match self.spread {
            Spread::TruncatedNormal => {
                // moments of a standard normal number above a
                let a = -1.0 / self.shape;
                let hazard = (-0.5 * a * a - 0.5 * (2.0 * PI).ln() - self.constant).exp();
                let mean = 1.0 + self.shape * hazard;
                let spread = self.shape * (1.0 + a * hazard - hazard * hazard).max(0.0).sqrt();
                (mean, spread / mean)
            }
            _ => (1.0, self.var()),
        }
    }

    /// The parameters of the distribution in textbooks, with their names. `mean`: sigma_lim0, MPa.
    pub fn natural(&self, mean: f64) -> Vec<(&'static str, f64)> {
        match self.spread {
            Spread::TruncatedNormal | Spread::Normal => vec![("mu_MPa", mean), ("sd_MPa", mean * self.shape)],
            Spread::LogNormal => vec![("median_MPa", mean * (-0.5 * self.shape * self.shape).exp()), ("sd_of_ln", self.shape)],
            Spread::Weibull => vec![("sigma_37_MPa", mean * (-self.constant).exp()), ("modulus", 1.0 / self.shape)],
        }
    }
}

/// Logarithm of the probability that a standard normal number is above t.
fn ln_upper(t: f64) -> f64 {
    if t < 30.0 {
        (0.5 * erfc(t / SQRT_2)).ln()
    } else {
        // Mills' ratio, here correct to 4e-6
        -0.5 * t * t - (t * (2.0 * PI).sqrt()).ln() - 1.0 / (t * t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn laws() -> Vec<Law> {
        let mut all = Vec::new();
        for spread in Spread::ALL {
            all.extend([0.1, 0.48, 1.0].map(|var: f64| Law::new(spread, spread.near(var))));
        }
        all
    }

    #[test]
    fn density_survival_and_quantile_agree() {
        for law in laws() {
            for p in [0.05, 0.3, 0.6, 0.95, 0.999] {
                let y = law.quantile(p);
                if y <= 0.0 {
                    assert_eq!(law.spread, Spread::Normal);
                    continue;
                }
                let z = y.ln();
                assert!((law.probability(z) - p).abs() < 1e-9, "{law:?} {p}");
                let h = 1e-5;
                let slope = (law.probability(z + h) - law.probability(z - h)) / (2.0 * h);
                assert!((slope / law.ln_density(z).exp() - 1.0).abs() < 1e-5, "{law:?} {p}");
            }
        }
    }

    #[test]
    fn mean_and_variation_are_those_of_the_quantiles() {
        for law in laws() {
            let n = 200_000;
            let y: Vec<f64> = (0..n).map(|i| law.quantile((f64::from(i) + 0.5) / f64::from(n))).collect();
            let mean = y.iter().sum::<f64>() / f64::from(n);
            let var = (y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / f64::from(n)).sqrt() / mean;
            let (mean_said, var_said) = law.realised();
            assert!((mean / mean_said - 1.0).abs() < 2e-3, "{law:?}: {mean} {mean_said}");
            assert!((var / var_said - 1.0).abs() < 1e-2, "{law:?}: {var} {var_said}");
        }
        // with var. = 1 truncation raises the mean by 28.8 % and leaves a coefficient of variation
        // of 0.616
        let (mean, var) = Law::new(Spread::TruncatedNormal, 0.0).realised();
        assert!((mean - 1.2876).abs() < 1e-4 && (var - 0.616).abs() < 1e-3);
    }

    #[test]
    fn far_tails_stay_finite() {
        for law in laws() {
            for z in [-50.0, -5.0, 3.0, 5.0] {
                assert!(law.ln_survival(z) <= 1e-12 && !law.ln_survival(z).is_nan(), "{law:?}");
                assert!(!law.ln_density(z).is_nan());
            }
        }
        assert!((ln_upper(29.999_999) - ln_upper(30.000_001)).abs() < 1e-4);
    }
}
