//! Von Mises' criterion: a grain fails where the deviatoric part of its mean stress exceeds its strength, q = √(3 J2) > σ_lim.
//!
//! Between two platens q = 6 F/(π d²) = 1.91 F/d². McDowell & de Bono (2013, Géotechnique 63: 895–908) compare the octahedral shear stress with the strength, √2/3 q =
//! 0.90 F/d² between platens: the same criterion with another strength. The mean stress p has no influence: a grain loaded from all sides fails at the same q.

use super::{FailureCriterion, Judges, MeanStress, sphere_area};
use crate::parameter::Values;

/// Von Mises' criterion on the mean stress of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VonMises;

impl FailureCriterion for VonMises {
    const JUDGES: Judges = Judges::MeanStress;

    fn of(_: &Values) -> VonMises {
        VonMises
    }

    fn threshold(&self, sigma_lim: f64, _: f64) -> f64 {
        sigma_lim
    }

    fn equivalent_stress(&self, stress: &MeanStress) -> f64 {
        (3.0 * stress.j2()).sqrt()
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
    fn pure_shear_counts_root_three() {
        let q = VonMises.equivalent_stress(&MeanStress([0.0, 0.0, 0.0, 0.0, 7e6, 0.0]));
        assert!((q / 7e6 - 3f64.sqrt()).abs() < 1e-15);
        let triaxial = VonMises.equivalent_stress(&MeanStress([2e6, 2e6, 5e6, 0.0, 0.0, 0.0]));
        assert!((triaxial / 3e6 - 1.0).abs() < 1e-15);
    }
}
