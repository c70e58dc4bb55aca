//! Isotropic linear elasticity: Δσ = λ tr(Δε) 1 + 2 G Δε.

use super::Sym;
use serde::{Deserialize, Serialize};

/// Isotropic linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elastic {
    /// Lamé's λ and the shear modulus G, Pa.
    lambda: f64,
    shear: f64,
}

impl Elastic {
    /// From Young's modulus, Pa (> 0), and Poisson's ratio (−1 < ν < ½).
    pub fn new(young: f64, poisson: f64) -> Elastic {
        let lambda = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        Elastic { lambda, shear: 0.5 * young / (1.0 + poisson) }
    }

    /// M = λ + 2 G, Pa.
    pub fn constrained_modulus(&self) -> f64 {
        self.lambda + 2.0 * self.shear
    }

    #[inline(always)]
    pub fn update(&self, stress: Sym, dstrain: Sym) -> Sym {
        let volumetric = self.lambda * (dstrain[0] + dstrain[1] + dstrain[2]);
        let two_g = 2.0 * self.shear;
        let mut out = stress;
        for k in 0..3 {
            out[k] += volumetric + two_g * dstrain[k];
        }
        for k in 3..6 {
            out[k] += two_g * dstrain[k];
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::Elastic;

    #[test]
    fn confined_compression_has_the_constrained_modulus() {
        // E = 10 MPa, ν = 0.3: M = E (1 − ν)/((1 + ν)(1 − 2ν)) = 13.461538 MPa, K0 = ν/(1 − ν) = 0.42857143
        let law = Elastic::new(10e6, 0.3);
        let s = law.update([0.0; 6], [-1e-3, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert!((s[0] + 13_461.538_46).abs() < 1e-4, "{s:?}");
        assert!((s[1] / s[0] - 3.0 / 7.0).abs() < 1e-14 && s[1] == s[2]);
    }
}
