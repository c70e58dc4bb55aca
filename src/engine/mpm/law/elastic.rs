//! Linear isotropic elasticity: dsigma = K tr(de) I + 2 G dev(de), with the bulk modulus K and the shear modulus G, Pa. Strain increments de must be small.

use super::super::stress::work;
use super::{ConstitutiveLaw, InternalVariables, Parameters, Sym};
use serde::{Deserialize, Serialize};

/// Linear elasticity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Elastic {
    /// Bulk modulus K, Pa
    pub bulk: f64,
    /// Shear modulus G, Pa
    pub shear: f64,
}

impl Elastic {
    /// From Young's modulus, Pa, and Poisson's ratio, between -1 and 0.5.
    pub fn of_young(young: f64, poisson: f64) -> Elastic {
        Elastic { bulk: young / (3.0 * (1.0 - 2.0 * poisson)), shear: young / (2.0 * (1.0 + poisson)) }
    }

    /// From the shear modulus, Pa, and Poisson's ratio, between -1 and 0.5.
    pub fn of_shear(shear: f64, poisson: f64) -> Elastic {
        Elastic::of_young(2.0 * shear * (1.0 + poisson), poisson)
    }

    /// Young's modulus E, Pa.
    pub fn young(&self) -> f64 {
        9.0 * self.bulk * self.shear / (3.0 * self.bulk + self.shear)
    }

    /// Poisson's ratio, -.
    pub fn poisson(&self) -> f64 {
        (3.0 * self.bulk - 2.0 * self.shear) / (2.0 * (3.0 * self.bulk + self.shear))
    }

    /// Oedometric modulus K + 4/3 G, Pa: that of compression without lateral strain.
    pub fn oedometric(&self) -> f64 {
        self.bulk + 4.0 / 3.0 * self.shear
    }

    /// Elastic energy per volume of a stress, J/m³: p²/(2K) + s:s/(4G), with the mean stress p and the deviator s.
    pub fn energy(&self, stress: &Sym) -> f64 {
        let p = (stress[0] + stress[1] + stress[2]) / 3.0;
        let shear: f64 =
            stress[..3].iter().map(|x| (x - p) * (x - p)).sum::<f64>() + 2.0 * stress[3..].iter().map(|x| x * x).sum::<f64>();
        p * p / (2.0 * self.bulk) + shear / (4.0 * self.shear)
    }

    /// Plastic work per volume of a step, J/m³: the mean of the stress `before` (rotated) and `after` times the plastic strain, which is the strain of the
    /// stress that the law has taken away from the elastic trial, C⁻¹ (σ_trial − σ).
    pub fn plastic_work(&self, before: &Sym, strain: Sym, after: &Sym) -> f64 {
        let trial = self.update(*before, strain);
        let taken: Sym = std::array::from_fn(|k| trial[k] - after[k]);
        let p = (taken[0] + taken[1] + taken[2]) / 3.0;
        let volume = p / (3.0 * self.bulk);
        let over = 1.0 / (2.0 * self.shear);
        let plastic: Sym = std::array::from_fn(|k| if k < 3 { volume + (taken[k] - p) * over } else { taken[k] * over });
        let mean: Sym = std::array::from_fn(|k| 0.5 * (before[k] + after[k]));
        work(mean, plastic)
    }

    /// Stress, Pa, after a strain increment.
    #[inline]
    pub fn update(&self, stress: Sym, dstrain: Sym) -> Sym {
        let two_g = 2.0 * self.shear;
        let lame = self.bulk - two_g * (1.0 / 3.0);
        let volume = lame * (dstrain[0] + dstrain[1] + dstrain[2]);
        [
            stress[0] + (volume + two_g * dstrain[0]),
            stress[1] + (volume + two_g * dstrain[1]),
            stress[2] + (volume + two_g * dstrain[2]),
            stress[3] + two_g * dstrain[3],
            stress[4] + two_g * dstrain[4],
            stress[5] + two_g * dstrain[5],
        ]
    }
}

impl ConstitutiveLaw for Elastic {
    const KEYS: &'static [&'static str] = &[];

    fn of(parameters: &Parameters) -> Elastic {
        parameters.elastic
    }

    #[inline]
    fn update_closed(&self, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
        (Elastic::update(self, stress, dstrain), internal)
    }

    fn elastic(&self) -> Elastic {
        *self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_moduli_come_back_from_strained_points() {
        for (young, nu) in [(4.6e6, 0.12), (1e9, 0.49), (2e7, 0.0), (3e6, -0.3)] {
            let law = Elastic::of_young(young, nu);
            let is = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "E = {young}, nu = {nu}: {a} for {b}");
            is(law.young(), young);
            assert!((law.poisson() - nu).abs() < 1e-13);
            is(Elastic::of_shear(law.shear, nu).bulk, law.bulk);
            let e = -1e-3;
            let uniaxial = law.update([0.0; 6], [-nu * e, -nu * e, e, 0.0, 0.0, 0.0]);
            is(uniaxial[2], young * e);
            assert!(uniaxial[0].abs() < 1e-9 * young && uniaxial[1].abs() < 1e-9 * young);
            let oedometer = law.update([0.0; 6], [0.0, 0.0, e, 0.0, 0.0, 0.0]);
            is(oedometer[2], e * young * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu)));
            let shear = law.update([0.0; 6], [0.0, 0.0, 0.0, e, 0.0, 0.0]);
            is(shear[3], 2.0 * e * young / (2.0 * (1.0 + nu)));
            let all = law.update([0.0; 6], [e, e, e, 0.0, 0.0, 0.0]);
            is(all[0], 3.0 * e * young / (3.0 * (1.0 - 2.0 * nu)));
        }
    }
}
