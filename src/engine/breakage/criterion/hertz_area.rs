//! Contact force over the Hertzian area of the contact at that force: F > σ_lim A_F with A_F = π (3 F r'/(4 E'))^(2/3) (Ciantia et al. 2015, eqs 5, 9-11).
//!
//! - `sigma_lim` σ_lim — limit strength, Pa ([`super::limit_strength`])
//! - `r_eff` r', m, and `e_eff` E', Pa — reduced radius and modulus of the contact (eqs 10, 11)
//!
//! That is the same as F (E'/r')² > 9/16 π³ σ_lim³ (eq. 17). The left side is the load that contacts keep, N Pa²/m²; the right side is the threshold.

use super::{FailureCriterion, Judges};
use crate::math::portable;
use crate::parameter::Values;
use std::f64::consts::PI;

/// Contact force over the Hertzian area of the contact (eq. 9).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzArea;

impl FailureCriterion for HertzArea {
    const JUDGES: Judges = Judges::Contacts;
    const WEIGHTED: bool = true;
    const POWER: u32 = 3;

    fn of(_: &Values) -> HertzArea {
        HertzArea
    }

    fn threshold(&self, sigma_lim: f64, _: f64) -> f64 {
        let stress = sigma_lim * PI;
        stress * stress * stress * (9.0 / 16.0)
    }

    fn load_weight(&self, r_eff: f64, e_eff: f64) -> f64 {
        let ratio = e_eff / r_eff;
        ratio * ratio
    }

    fn limit_force(&self, sigma_lim: f64, d: f64, r_eff: f64, e_eff: f64) -> f64 {
        self.threshold(sigma_lim, d) / self.load_weight(r_eff, e_eff)
    }

    fn area(&self, force: f64, _: f64, r_eff: f64, e_eff: f64) -> f64 {
        if force > 0.0 { PI * portable::pow(3.0 * force * r_eff / (4.0 * e_eff), 2.0 / 3.0) } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::breakage::criterion::size_factor;

    #[test]
    fn limit_forces_of_table_2() {
        for (sigma, young, force) in [(200e6, 0.866e9, 155.4), (800e6, 7.8e9, 131.21), (2200e6, 46.8e9, 106.92)] {
            let (nu, steel): (f64, f64) = (0.3, 200e9);
            let e_eff = 1.0 / ((1.0 - nu * nu) / young + (1.0 - nu * nu) / steel);
            let found = HertzArea.limit_force(sigma, 2e-3, 1e-3, e_eff);
            assert!((found / force - 1.0).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn limit_forces_grow_with_size_as_eq_17_says() {
        let force = |d: f64| HertzArea.limit_force(3e8 * size_factor(d, 2e-3, 10.0), d, 0.5 * d, 1e9);
        assert!((force(4e-3) / force(2e-3) / 2.0_f64.powf(2.0 - 0.9) - 1.0).abs() < 1e-12);
    }
}
