//! Mohr–Coulomb's criterion on the mean stress of a grain, which fails where σ1 − N σ3 > σ_lim, with N = (1 + sin φ)/(1 − sin φ).
//!
//! - σ1, σ3 — largest and smallest principal mean stress, Pa, compression positive
//! - φ — angle of internal friction of the grain's substance, rad; 0 is Tresca's criterion
//! - σ_lim — strength in uniaxial compression, 2 c cos φ/(1 − sin φ), Pa

use super::{FailureCriterion, Judges, MeanStress, sphere_area};
use crate::math::portable;
use crate::parameter::{Parameter, Range, Values};

/// Mohr–Coulomb's criterion on the mean stress of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MohrCoulomb {
    /// N = (1 + sin φ)/(1 − sin φ), -: by how much the largest principal stress at failure grows with the smallest one.
    pub support: f64,
}

impl FailureCriterion for MohrCoulomb {
    const JUDGES: Judges = Judges::MeanStress;
    const PARAMETERS: &'static [Parameter] = &[Parameter {
        key: "strength.mohr_coulomb.friction_angle_deg",
        range: Range::below(0.0, 89.0),
        default: None,
        meaning: "mohr_coulomb: angle of internal friction of the grain's substance; 0 is Tresca's criterion",
    }];

    fn of(values: &Values) -> MohrCoulomb {
        let sine = portable::sin(values[0]);
        MohrCoulomb { support: (1.0 + sine) / (1.0 - sine) }
    }

    fn threshold(&self, sigma_lim: f64, _: f64) -> f64 {
        sigma_lim
    }

    fn equivalent_stress(&self, stress: &MeanStress) -> f64 {
        let [largest, _, smallest] = stress.principal();
        largest - self.support * smallest
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

    /// c = 1 MPa and φ = 30° fail at σ1 = 3 σ3 + 2 c √3, and in tension at σ_lim/3.
    #[test]
    fn follows_the_closed_form() {
        let law = MohrCoulomb::of(&[30f64.to_radians(), 0.0, 0.0, 0.0]);
        let sigma_lim = 2e6 * 3f64.sqrt();
        for side in [0.0, 1e6, 5e6] {
            let stress = MeanStress([side, 3.0 * side + sigma_lim, 2.0 * side, 0.0, 0.0, 0.0]);
            assert!((law.equivalent_stress(&stress) / sigma_lim - 1.0).abs() < 1e-12);
        }
        let tension = MeanStress([-sigma_lim / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((law.equivalent_stress(&tension) / sigma_lim - 1.0).abs() < 1e-12);
    }
}
