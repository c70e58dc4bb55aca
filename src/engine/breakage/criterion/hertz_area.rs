//! Contact force over the Hertzian area of the contact at that force: F > σ_lim A_F with A_F = π (3 F r'/(4 E'))^(2/3) (Ciantia et al. 2015, eqs 5, 9-11).
//!
//! - `sigma_lim` σ_lim — limit strength, Pa ([`super::limit_strength`])
//! - `r_eff` r', m, and `e_eff` E', Pa — reduced radius and modulus of the contact (eqs 10, 11); with `own_radius` r' is the radius of the grain itself
//!
//! That is the same as F (E'/r')² > 9/16 π³ σ_lim³ (eq. 17). The left side is the load that contacts keep, N Pa²/m²; the right side is the threshold.

use super::{FailureCriterion, Judges};
use crate::math::portable;
use crate::parameter::Values;
use std::f64::consts::PI;

/// Contact force over the Hertzian area of the contact (eq. 9).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HertzArea {
    /// Whether the area is that of a contact with a rigid plane, r' the radius of the grain itself, instead of the reduced radius of the contact (eq. 10).
    /// Between platens both are the same.
    pub own_radius: bool,
}

impl FailureCriterion for HertzArea {
    const JUDGES: Judges = Judges::Contacts;
    const WEIGHTED: bool = true;
    const POWER: u32 = 3;

    fn of(_: &Values) -> HertzArea {
        HertzArea::default()
    }

    fn weighs_radius(&self) -> bool {
        !self.own_radius
    }

    fn threshold(&self, sigma_lim: f64, d: f64) -> f64 {
        let stress = sigma_lim * PI;
        let threshold = stress * stress * stress * (9.0 / 16.0);
        // the radius is the grain's, so that it stands on this side
        if self.own_radius { threshold * (0.25 * d * d) } else { threshold }
    }

    fn load_weight(&self, r_eff: f64, e_eff: f64) -> f64 {
        let ratio = if self.own_radius { e_eff } else { e_eff / r_eff };
        ratio * ratio
    }

    fn limit_force(&self, sigma_lim: f64, d: f64, r_eff: f64, e_eff: f64) -> f64 {
        self.threshold(sigma_lim, d) / self.load_weight(r_eff, e_eff)
    }

    fn area(&self, force: f64, d: f64, r_eff: f64, e_eff: f64) -> f64 {
        let radius = if self.own_radius { 0.5 * d } else { r_eff };
        if force > 0.0 { PI * portable::pow(3.0 * force * radius / (4.0 * e_eff), 2.0 / 3.0) } else { 0.0 }
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
            let found = HertzArea::default().limit_force(sigma, 2e-3, 1e-3, e_eff);
            assert!((found / force - 1.0).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn limit_forces_grow_with_size_as_eq_17_says() {
        let force = |d: f64| HertzArea::default().limit_force(3e8 * size_factor(d, 2e-3, 10.0), d, 0.5 * d, 1e9);
        assert!((force(4e-3) / force(2e-3) / 2.0_f64.powf(2.0 - 0.9) - 1.0).abs() < 1e-12);
    }

    /// Two equal grains in contact, r' = d/4: with its own radius a grain bears four times the force; between platens, r' = d/2, the same.
    #[test]
    fn the_own_radius_is_that_of_a_contact_with_a_plane() {
        let [pair, own] = [false, true].map(|own_radius| HertzArea { own_radius });
        let (strength, d, e_eff) = (3e8, 2e-3, 1e9);
        for (r_eff, times) in [(0.25 * d, 4.0), (0.5 * d, 1.0), (0.1 * d, 25.0)] {
            let [a, b] = [pair, own].map(|c| c.limit_force(strength, d, r_eff, e_eff));
            assert!((b / a / times - 1.0).abs() < 1e-12, "{r_eff}");
            for (criterion, force) in [(pair, a), (own, b)] {
                assert!((force / criterion.area(force, d, r_eff, e_eff) / strength - 1.0).abs() < 1e-13);
                assert!((force * criterion.load_weight(r_eff, e_eff) / criterion.threshold(strength, d) - 1.0).abs() < 1e-13);
            }
        }
        assert!(pair.weighs_radius() && !own.weighs_radius());
    }
}
