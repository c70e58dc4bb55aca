//! Contact force over a fixed contact area: F > σ_lim A_F with A_F = π/4 d² sin² θ0 (Ciantia et al. 2015, eqs 5, 8, from Russell & Muir Wood 2009).
//!
//! - `theta0` θ0 — angle of the contact area at failure: half the angle under which it is seen from the centre of the grain, rad, 0..π/2
//! - `sigma_lim` σ_lim — limit strength, Pa ([`super::limit_strength`]); `d` — grain diameter, m
//!
//! Valid for small contact areas. Results depend on the product σ_lim sin² θ0 only.

use super::{FailureCriterion, Judges};
use crate::math::portable;
use crate::parameter::{Parameter, Range, Values};
use std::f64::consts::FRAC_PI_4;

/// Contact force over a contact area of fixed angle (eq. 8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FixedAngle {
    /// Angle of the contact area at failure, rad.
    pub theta0: f64,
}

impl FailureCriterion for FixedAngle {
    const JUDGES: Judges = Judges::Contacts;
    const PARAMETERS: &'static [Parameter] = &[Parameter {
        key: "strength.fixed_angle.theta0_rad",
        range: Range::between(0.0, 1.57),
        default: None,
        meaning: "angle of the contact area at failure (eq. 8), half the opening seen from the grain's centre. Single-grain tests give the product sigma_lim0 sin^2 theta0 only, and so do runs: any angle will do if sigma_lim0 goes with it (with `crushing_stress_MPa` it does). Without another source take 0.35, petroleum coke's of Ciantia et al. 2015 (there: 0.13 for silica sand)",
    }];

    fn of(values: &Values) -> FixedAngle {
        FixedAngle { theta0: values[0] }
    }

    fn threshold(&self, sigma_lim: f64, d: f64) -> f64 {
        sigma_lim * self.area(0.0, d, 0.0, 0.0)
    }

    fn limit_force(&self, sigma_lim: f64, d: f64, _: f64, _: f64) -> f64 {
        self.threshold(sigma_lim, d)
    }

    fn area(&self, _: f64, d: f64, _: f64, _: f64) -> f64 {
        let sine = portable::sin(self.theta0);
        FRAC_PI_4 * d * d * (sine * sine)
    }

    /// A strip of the width d sin θ0: the contact area that is seen under the same angle.
    fn plane_area(&self, d: f64) -> Option<f64> {
        Some(d * portable::sin(self.theta0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::breakage::criterion::size_factor;
    use std::f64::consts::PI;

    #[test]
    fn limit_forces_of_table_1() {
        for (theta0, sigma, force) in [(PI / 9.0, 300e6, 110.25), (PI / 18.0, 1200e6, 113.68), (PI / 24.0, 2060e6, 110.26)] {
            let found = FixedAngle { theta0 }.limit_force(sigma, 2e-3, 1e-3, 1e9);
            assert!((found / force - 1.0).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn limit_forces_grow_with_size_as_eq_16_says() {
        let force = |d: f64| FixedAngle { theta0: 0.35 }.limit_force(3e8 * size_factor(d, 2e-3, 3.0), d, 0.5 * d, 1e9);
        assert!((force(4e-3) / force(2e-3) - 2.0).abs() < 1e-12);
    }
}
