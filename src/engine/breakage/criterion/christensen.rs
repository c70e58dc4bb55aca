//! Christensen's criterion with two parameters on the mean stress of a grain (Christensen 2000, Math. Mech. Solids 5: 285–300): a paraboloid about the hydrostatic
//! axis.
//!
//! ```text
//! 3 (1 + χ) J2 = σ_c (σ_c + 3 χ p)      σ_eq = [−3 χ p + √(9 χ² p² + 12 (1 + χ) J2)] / 2 > σ_lim
//! ```
//!
//! - p — mean of the normal stresses, Pa, compression positive; J2 — second invariant of the deviator, Pa²
//! - χ = σ_c/σ_t − 1 — ratio of the uniaxial compressive to the tensile strength, less 1, - (geological materials: 10 to 170); 0 is von Mises' criterion
//! - σ_lim = σ_c — strength in uniaxial compression, Pa
//!
//! Russell & Muir Wood derive the limit strength of a contact from the same criterion ([`super::limit_strength`]), but for the stress on the line between two
//! contacts; here it is applied to the mean stress of the grain.

use super::{FailureCriterion, Judges, MeanStress, sphere_area};
use crate::parameter::{Parameter, Range, Values};

/// Christensen's criterion with two parameters on the mean stress of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Christensen {
    /// χ = σ_c/σ_t − 1, -.
    pub chi: f64,
}

impl FailureCriterion for Christensen {
    const JUDGES: Judges = Judges::MeanStress;
    const PARAMETERS: &'static [Parameter] = &[Parameter {
        key: "strength.christensen.chi",
        range: Range::closed(0.0, 1000.0),
        default: None,
        meaning: "christensen: uniaxial compressive over tensile strength of the grain's substance, less 1 (eq. 2); geological materials 10 to 170, 0 is von Mises' criterion",
    }];

    fn of(values: &Values) -> Christensen {
        Christensen { chi: values[0] }
    }

    fn threshold(&self, sigma_lim: f64, _: f64) -> f64 {
        sigma_lim
    }

    fn equivalent_stress(&self, stress: &MeanStress) -> f64 {
        let push = 3.0 * self.chi * stress.p();
        let shear = 12.0 * (1.0 + self.chi) * stress.j2();
        let root = (push * push + shear).sqrt();
        // in a form that does not subtract two large, nearly equal numbers
        if push > 0.0 { 0.5 * shear / (push + root) } else { 0.5 * (root - push) }
    }

    fn limit_force(&self, sigma_lim: f64, d: f64, _: f64, _: f64) -> f64 {
        sigma_lim * sphere_area(d)
    }

    fn area(&self, _: f64, d: f64, _: f64, _: f64) -> f64 {
        sphere_area(d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniaxial_compression_and_tension_fail_at_their_strengths() {
        for chi in [0.0, 1.0, 21.9, 170.0] {
            let law = Christensen { chi };
            let uniaxial = |s: f64| law.equivalent_stress(&MeanStress([0.0, s, 0.0, 0.0, 0.0, 0.0]));
            assert!((uniaxial(80e6) / 80e6 - 1.0).abs() < 1e-12, "{chi}");
            assert!((uniaxial(-80e6 / (1.0 + chi)) / 80e6 - 1.0).abs() < 1e-12, "{chi}");
        }
    }

    /// The equivalent stress solves 3 (1 + χ) J2 = σ (σ + 3 χ p).
    #[test]
    fn the_equivalent_stress_solves_the_criterion() {
        let (law, stress) = (Christensen { chi: 12.0 }, MeanStress([3e6, -1e6, 7e6, 2e6, 0.5e6, -1e6]));
        let s = law.equivalent_stress(&stress);
        assert!((s * (s + 36.0 * stress.p()) / (39.0 * stress.j2()) - 1.0).abs() < 1e-12);
    }
}
