//! Limit strength of a grain from the uniaxial strengths of its substance: σ_lim = κ / f(χ, ν) (Ciantia et al. 2015, eqs 2, 4, 6, from Russell & Muir Wood 2009).
//!
//! - `sigma_c`, `sigma_t` — uniaxial compressive and tensile strength of the grain's substance, Pa, taken positive
//! - `kappa` κ, `chi` χ — Christensen's intrinsic strength, Pa, and microstructure parameter, -
//! - `nu` ν — Poisson ratio, -
//!
//! Valid for χ > 0 (geological materials: 10 to 170).

use std::f64::consts::SQRT_2;

/// Christensen's parameters kappa, Pa, and chi, -, from the uniaxial compressive and tensile strengths, Pa (eq. 2, with a misprint corrected:
/// chi = |sigma_c| / sigma_t - 1).
pub fn christensen(sigma_c: f64, sigma_t: f64) -> (f64, f64) {
    let chi = sigma_c.abs() / sigma_t - 1.0;
    let kappa = (1.0 + chi) / 3.0_f64.sqrt() * sigma_c.abs();
    (kappa, chi)
}

/// Factor f(chi, nu) of the mobilised strength kappa_mob = f F / (pi R^2 sin^2 theta0) (eqs 3, 4), -; `chi`: microstructure parameter, -; `nu`: Poisson's ratio, -.
pub fn f_chi_nu(chi: f64, nu: f64) -> f64 {
    let chi_part = 3.0_f64.sqrt() * (1.0 + chi) * (1.0 + chi) / chi;
    let nu_part = 3.0 / 32.0 + SQRT_2 / 24.0 + (SQRT_2 / 12.0 - 0.25) * nu + (0.5 - SQRT_2 / 3.0) * nu * nu;
    chi_part * nu_part / ((2.0 - SQRT_2) * (1.0 + nu))
}

/// Limit strength sigma_lim = kappa / f(chi, nu), Pa (eq. 6), from the uniaxial compressive and tensile strengths, Pa, and Poisson's ratio, -.
pub fn limit_strength(sigma_c: f64, sigma_t: f64, nu: f64) -> f64 {
    let (kappa, chi) = christensen(sigma_c, sigma_t);
    kappa / f_chi_nu(chi, nu)
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
}
