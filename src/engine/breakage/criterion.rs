//! When a grain fails: the normal force of one of its contacts exceeds the grain's limit strength times the contact
//! area, F > sigma_lim A_F (Ciantia et al. 2015, eq. 5, from Russell & Muir Wood 2009).
//!
//! - `sigma_c`, `sigma_t` — uniaxial compressive and tensile strength of the grain's substance, Pa, taken positive
//! - `kappa`, `chi` — Christensen's intrinsic strength, Pa, and microstructure parameter, -
//! - `nu` — Poisson ratio, -
//! - `sigma_lim` — limit strength, Pa; `d` — grain diameter, m; `theta0` — contact angle, rad
//! - `r_eff`, `e_eff` — r', m, and E', Pa, of the contact (eqs 10, 11)
//!
//! Valid for small contact areas and `chi` > 0 (geological materials: 10 to 170).

use crate::math::portable;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_4, PI, SQRT_2};

/// Christensen's parameters `(kappa, chi)` (eq. 2, with the misprint of chi corrected: chi = |sigma_c| / sigma_t - 1).
pub fn christensen(sigma_c: f64, sigma_t: f64) -> (f64, f64) {
    let chi = sigma_c.abs() / sigma_t - 1.0;
    let kappa = (1.0 + chi) / 3.0_f64.sqrt() * sigma_c.abs();
    (kappa, chi)
}

/// Prefactor f(chi, nu) of the mobilised strength, kappa_mob = f F / (pi R^2 sin^2 theta0) (eqs 3, 4), -.
pub fn f_chi_nu(chi: f64, nu: f64) -> f64 {
    let chi_part = 3.0_f64.sqrt() * (1.0 + chi) * (1.0 + chi) / chi;
    let nu_part = 3.0 / 32.0 + SQRT_2 / 24.0 + (SQRT_2 / 12.0 - 0.25) * nu + (0.5 - SQRT_2 / 3.0) * nu * nu;
    chi_part * nu_part / ((2.0 - SQRT_2) * (1.0 + nu))
}

/// Limit strength sigma_lim = kappa / f(chi, nu), Pa (eq. 6).
pub fn limit_strength(sigma_c: f64, sigma_t: f64, nu: f64) -> f64 {
    let (kappa, chi) = christensen(sigma_c, sigma_t);
    kappa / f_chi_nu(chi, nu)
}

/// Size hardening (d / d0)^(-3/m), - (eqs 7, 15). `d0_scaled` is the reference diameter times the scale N, m.
pub fn size_factor(d: f64, d0_scaled: f64, m: f64) -> f64 {
    portable::pow(d / d0_scaled, -3.0 / m)
}

/// How the area A_F on which a contact force acts is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum AreaModel {
    /// A contact angle that is a constant of the material, rad, 0..pi/2: A_F = pi/4 d^2 sin^2 theta0 (eq. 8).
    FixedAngle { theta0: f64 },
    /// Hertz's area of the contact itself: A_F = pi (3 F r' / (4 E'))^(2/3) (eqs 9-11).
    Hertz,
}

impl AreaModel {
    /// What a contact's load, its normal force times [`Self::load_weight`], is compared with: the grain fails where
    /// the load is larger.
    ///
    /// - fixed angle: sigma_lim A_F, N (eqs 5, 8);
    /// - Hertz: F > sigma_lim pi (3 F r' / (4 E'))^(2/3) is F (E'/r')^2 > 9/16 pi^3 sigma_lim^3 (eq. 17), N Pa^2/m^2.
    pub fn limit(&self, sigma_lim: f64, d: f64) -> f64 {
        match *self {
            Self::FixedAngle { theta0 } => sigma_lim * fixed_area(theta0, d),
            Self::Hertz => {
                let stress = sigma_lim * PI;
                stress * stress * stress * (9.0 / 16.0)
            }
        }
    }

    /// Weight of a contact's normal force in its load: 1 for a fixed angle, (E'/r')^2 for Hertz's area.
    pub fn load_weight(&self, r_eff: f64, e_eff: f64) -> f64 {
        match self {
            Self::FixedAngle { .. } => 1.0,
            Self::Hertz => {
                let ratio = e_eff / r_eff;
                ratio * ratio
            }
        }
    }

    /// Largest normal force that the contact may bear, N (eqs 5, 16, 17).
    pub fn limit_force(&self, sigma_lim: f64, d: f64, r_eff: f64, e_eff: f64) -> f64 {
        self.limit(sigma_lim, d) / self.load_weight(r_eff, e_eff)
    }

    /// Contact area A_F under a normal force, m^2 (eqs 8, 9).
    pub fn area(&self, force: f64, d: f64, r_eff: f64, e_eff: f64) -> f64 {
        match *self {
            Self::FixedAngle { theta0 } => fixed_area(theta0, d),
            Self::Hertz if force > 0.0 => PI * portable::pow(3.0 * force * r_eff / (4.0 * e_eff), 2.0 / 3.0),
            Self::Hertz => 0.0,
        }
    }
}

/// Area under a fixed contact angle, m^2 (eq. 8).
fn fixed_area(theta0: f64, d: f64) -> f64 {
    let sine = portable::sin(theta0);
    FRAC_PI_4 * d * d * (sine * sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(value: f64, expected: f64, relative: f64) {
        assert!((value / expected - 1.0).abs() <= relative, "{value} instead of {expected}");
    }

    #[test]
    fn fused_silica_of_the_paper() {
        close(f_chi_nu(22.0, 0.3), 6.3225, 1e-5);
        let (kappa, chi) = christensen(1100e6, 48e6);
        close(chi, 21.917, 2e-5);
        close(f_chi_nu(chi, 0.3), 6.3006, 1e-5);
        close(kappa / f_chi_nu(chi, 0.3), 2309.95e6, 3e-6);
        close(limit_strength(1100e6, 48e6, 0.3), 2309.95e6, 3e-6);
        // A compressive strength given negative is the same substance.
        assert_eq!(christensen(-1100e6, 48e6), (kappa, chi));
    }

    #[test]
    fn smaller_grains_are_stronger_by_the_power_of_size() {
        assert_eq!(size_factor(2e-3, 2e-3, 2.0), 1.0);
        close(size_factor(8e-3, 2e-3, 2.0), 0.125, 1e-14);
        close(size_factor(0.5e-3, 2e-3, 3.0), 4.0, 1e-14);
        // Scale N moves the reference diameter only (eq. 15).
        assert_eq!(size_factor(15e-3, 4e-3, 2.0), size_factor(7.5e-3, 2e-3, 2.0));
    }

    #[test]
    fn limit_forces_of_table_1() {
        for (theta0, sigma, force) in [(PI / 9.0, 300e6, 110.25), (PI / 18.0, 1200e6, 113.68), (PI / 24.0, 2060e6, 110.26)] {
            let area = AreaModel::FixedAngle { theta0 };
            close(area.limit_force(sigma, 2e-3, 1e-3, 1e9), force, 1e-4);
        }
    }

    #[test]
    fn limit_forces_of_table_2() {
        for (sigma, young, force) in [(200e6, 0.866e9, 155.4), (800e6, 7.8e9, 131.21), (2200e6, 46.8e9, 106.92)] {
            let (nu, steel): (f64, f64) = (0.3, 200e9);
            let e_eff = 1.0 / ((1.0 - nu * nu) / young + (1.0 - nu * nu) / steel);
            close(AreaModel::Hertz.limit_force(sigma, 2e-3, 1e-3, e_eff), force, 1e-4);
        }
    }

    #[test]
    fn at_the_limit_force_stress_is_strength() {
        for area in [AreaModel::FixedAngle { theta0: 0.35 }, AreaModel::Hertz] {
            for (d, r_eff, e_eff) in [(7.5e-3, 3.75e-3, 1e9), (2e-3, 0.4e-3, 3e10)] {
                let force = area.limit_force(3e8, d, r_eff, e_eff);
                close(force / area.area(force, d, r_eff, e_eff), 3e8, 1e-13);
                let load = force * area.load_weight(r_eff, e_eff);
                close(load, area.limit(3e8, d), 1e-14);
            }
            assert!(area.area(0.0, 1e-3, 1e-3, 1e9).is_finite());
        }
    }

    #[test]
    fn limit_forces_grow_with_size_as_eqs_16_and_17_say() {
        let force = |area: AreaModel, d: f64, m: f64| area.limit_force(3e8 * size_factor(d, 2e-3, m), d, 0.5 * d, 1e9);
        let angle = AreaModel::FixedAngle { theta0: 0.35 };
        let ratio = force(angle, 4e-3, 3.0) / force(angle, 2e-3, 3.0);
        close(ratio, 2.0, 1e-13);
        let ratio = force(AreaModel::Hertz, 4e-3, 10.0) / force(AreaModel::Hertz, 2e-3, 10.0);
        close(ratio, 2.0_f64.powf(2.0 - 0.9), 1e-13);
    }
}
