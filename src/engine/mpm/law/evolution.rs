//! Hardening and softening: friction angle and cohesion as functions of the accumulated plastic strain. Li et al. (2023), Computers and Geotechnics 160, 105508:
//! eq. 43 (cubic hardening, then exponential softening; angles in rad) and Table 8 (linear hardening).

use crate::math::portable::exp;
use serde::{Deserialize, Serialize};

/// Exponent x beyond which exp(-x) no longer changes a sum with values of order 1.
const SETTLED: f64 = 40.0;

/// An angle, rad, or a cohesion, Pa, as a function of the accumulated plastic strain e, -.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Evolution {
    /// This value at any e.
    Constant(f64),
    /// Linear in e up to `strain`, then constant.
    Linear {
        /// Value at e = 0.
        initial: f64,
        /// Value from `strain` on.
        last: f64,
        /// Plastic strain at which the change ends, above 0.
        strain: f64,
    },
    /// Eq. 43: `initial` at e = 0; a e³ + b e² + c e + d up to `peak_strain`; then residual + (peak - residual) exp(-H (e - peak_strain)). The value may jump
    /// between the parts: with the coefficients of the paper it does so by 1 % at e = 0 and at `peak_strain`.
    CubicExponential {
        /// Value at e = 0.
        initial: f64,
        /// Coefficients a, b, c, d of the cubic.
        cubic: [f64; 4],
        /// Plastic strain at which the cubic ends.
        peak_strain: f64,
        /// Value at which the softening begins.
        peak: f64,
        /// Value towards which the softening goes.
        residual: f64,
        /// Rate H of the softening, -.
        decay: f64,
    },
}

impl Evolution {
    /// The value and its first and second derivatives with respect to e, at the plastic strain `e`.
    #[inline]
    pub fn at(&self, e: f64) -> (f64, f64, f64) {
        match *self {
            Evolution::Constant(value) => (value, 0.0, 0.0),
            Evolution::Linear { initial, last, strain } => {
                if e < strain {
                    let slope = (last - initial) / strain;
                    (initial + slope * e, slope, 0.0)
                } else {
                    (last, 0.0, 0.0)
                }
            }
            Evolution::CubicExponential { initial, cubic: [a, b, c, d], peak_strain, peak, residual, decay: rate } => {
                if e <= 0.0 {
                    (initial, c, 2.0 * b)
                } else if e <= peak_strain {
                    (((a * e + b) * e + c) * e + d, (3.0 * a * e + 2.0 * b) * e + c, 6.0 * a * e + 2.0 * b)
                } else {
                    let left = (peak - residual) * exp(-rate * (e - peak_strain));
                    (residual + left, -rate * left, rate * rate * left)
                }
            }
        }
    }

    /// The plastic strains at which the value jumps or has a kink, in ascending order, the last one where it stops changing. Between two of them, the upper one
    /// included, the value is smooth.
    pub fn ends(&self) -> impl Iterator<Item = f64> {
        let (bend, settled) = match *self {
            Evolution::Constant(_) => (None, None),
            Evolution::Linear { strain, .. } => (None, Some(strain)),
            Evolution::CubicExponential { peak_strain, decay, .. } => (Some(peak_strain), Some(peak_strain + SETTLED / decay)),
        };
        bend.into_iter().chain(settled)
    }

    /// Plastic strain from which on the value is constant.
    pub fn settled(&self) -> f64 {
        self.ends().last().unwrap_or(0.0)
    }

    /// The final value.
    pub fn last(&self) -> f64 {
        match *self {
            Evolution::Constant(value) | Evolution::Linear { last: value, .. } => value,
            Evolution::CubicExponential { residual, .. } => residual,
        }
    }

    /// Smallest and largest value at any plastic strain.
    pub fn range(&self) -> (f64, f64) {
        let of = |values: &[f64]| values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (v.min(a), v.max(b)));
        match *self {
            Evolution::Constant(value) => (value, value),
            Evolution::Linear { initial, last, .. } => of(&[initial, last]),
            Evolution::CubicExponential { initial, cubic: [a, b, c, d], peak_strain, peak, residual, .. } => {
                let mut values = vec![initial, peak, residual, d, self.at(peak_strain).0];
                // extrema of the cubic: the roots of 3 a e² + 2 b e + c, in the form that also holds for a = 0
                let root = (b * b - 3.0 * a * c).sqrt();
                let half = -(b + root.copysign(b));
                let turns = [half / (3.0 * a), c / half];
                values.extend(turns.iter().filter(|e| **e > 0.0 && **e < peak_strain).map(|e| self.at(*e).0));
                of(&values)
            }
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Eq. 43 with the coefficients in the text below it and Table 3.
    pub const LI: Evolution = Evolution::CubicExponential {
        initial: 18.6 * DEGREE,
        cubic: [1075.64, -407.93, 16.39, 0.32],
        peak_strain: 0.022,
        peak: 28.6 * DEGREE,
        residual: 18.6 * DEGREE,
        decay: 50.0,
    };
    const DEGREE: f64 = std::f64::consts::PI / 180.0;

    #[test]
    fn li_eq_43_meets_its_ends_within_two_per_cent() {
        let degrees = |e: f64| LI.at(e).0 / DEGREE;
        assert_eq!(degrees(0.0), 18.6);
        assert!((degrees(1e-12) - 18.335).abs() < 1e-3, "d = 0.32 rad");
        assert!((degrees(0.022) - 28.338).abs() < 1e-3);
        assert!((degrees(0.022 + 1e-12) - 28.6).abs() < 1e-6);
        assert!((degrees(0.022 + 0.02) - (18.6 + 10.0 * (-1.0f64).exp())).abs() < 1e-9);
        assert_eq!(degrees(LI.settled() + 1e-3), 18.6);
        let (low, high) = LI.range();
        assert!((low / DEGREE - 18.335).abs() < 1e-3 && high == 28.6 * DEGREE);
    }

    #[test]
    fn slopes_and_ranges_are_those_of_the_values() {
        let hump = Evolution::CubicExponential {
            initial: 0.2,
            cubic: [0.0, -400.0, 20.0, 0.2],
            peak_strain: 0.04,
            peak: 0.36,
            residual: 0.3,
            decay: 20.0,
        };
        let linear = Evolution::Linear { initial: 2.0, last: 3.0, strain: 0.1 };
        for law in [LI, hump, linear, Evolution::Constant(0.5)] {
            let (low, high) = law.range();
            let mut seen = (f64::INFINITY, f64::NEG_INFINITY);
            for i in 1..4000 {
                let e = 5e-5 * f64::from(i) + 1e-6;
                let (value, slope, curvature) = law.at(e);
                let h = 1e-8;
                let numeric = (law.at(e + h).0 - law.at(e - h).0) / (2.0 * h);
                assert!((slope - numeric).abs() < 1e-5 * (1.0 + slope.abs()), "{law:?} at {e}: {slope} {numeric}");
                if !law.ends().any(|end| end > e - h && end <= e + h) {
                    let numeric = (law.at(e + h).1 - law.at(e - h).1) / (2.0 * h);
                    assert!((curvature - numeric).abs() < 1e-5 * (1.0 + curvature.abs()), "{law:?} at {e}: {curvature} {numeric}");
                }
                seen = (value.min(seen.0), value.max(seen.1));
            }
            assert!(seen.0 >= low - 1e-12 && seen.1 <= high + 1e-12, "{law:?}: {seen:?} in {:?}", (low, high));
            assert!(high - seen.1 < 0.01 * high, "{law:?}: the largest value is reached");
            assert_eq!(law.at(law.settled() + 1.0).0, law.last());
        }
        assert!((hump.range().1 - 0.45).abs() < 1e-12, "the turning point of a parabola");
    }
}
