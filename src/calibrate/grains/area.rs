//! Strength from a crushing force and back (Ciantia et al. 2015, eqs 16, 17), by one of two models
//! of the contact area.

use engine::breakage::Criterion;
use engine::breakage::criterion::{FixedAngle, HertzArea};
use serde::Serialize;

/// An area model by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Model {
    /// A_F = pi/4 d² sin² theta0 (eq. 8).
    FixedAngle,
    /// Hertz's area between grain and platen (eq. 9), r' = d/2.
    Hertz,
}

impl Model {
    /// Name in options and files.
    pub fn name(self) -> &'static str {
        match self {
            Model::FixedAngle => "fixed-angle",
            Model::Hertz => "hertz",
        }
    }
}

/// Relation between crushing force and strength. If theta0 (or E') is not known, forces determine
/// only a product of strength and angle (or E'). Strengths are then those for sin theta0 = 1 (or
/// for E' = 1 Pa).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Area {
    /// The area model.
    pub model: Model,
    law: Criterion,
    /// Effective modulus E' of grain and platen, Pa.
    e_eff: f64,
    /// Whether theta0, or E', is given.
    pub known: bool,
}

impl Area {
    /// The model of a fixed angle; `theta0`, rad, above 0 and below pi/2, if it is known.
    pub fn fixed_angle(theta0: Option<f64>) -> Area {
        let angle = theta0.unwrap_or(std::f64::consts::FRAC_PI_2);
        Area {
            model: Model::FixedAngle,
            law: Criterion::FixedAngle(FixedAngle { theta0: angle }),
            e_eff: 1.0,
            known: theta0.is_some(),
        }
    }

    /// The model of Hertz; `e_eff`: E' of eq. 11, Pa, if it is known.
    pub fn hertz(e_eff: Option<f64>) -> Area {
        Area {
            model: Model::Hertz,
            law: Criterion::HertzArea(HertzArea::default()),
            e_eff: e_eff.unwrap_or(1.0),
            known: e_eff.is_some(),
        }
    }

    /// Logarithm of the strength, Pa, of a grain of diameter `d`, m, that breaks at `force`, N: sigma = F / A_F(F).
    pub fn ln_strength(&self, d: f64, force: f64) -> f64 {
        (force / self.law.area(force, d, 0.5 * d, self.e_eff)).ln()
    }

    /// Force, N, that breaks a grain of the strength, Pa (eq. 16 or 17).
    pub fn force(&self, strength: f64, d: f64) -> f64 {
        self.law.limit_force(strength.max(0.0), d, 0.5 * d, self.e_eff)
    }

    /// d ln F / d ln sigma: the force is proportional to the strength (eq. 16) or to its cube (eq.
    /// 17).
    pub fn power(&self) -> f64 {
        match self.model {
            Model::FixedAngle => 1.0,
            Model::Hertz => 3.0,
        }
    }

    /// Quantity that forces alone determine, MPa, for a `strength`, Pa: sigma_lim0 sin² theta0, or
    /// sigma_lim0³ / E'².
    pub fn identified_mpa(&self, strength: f64) -> f64 {
        1e-6 * match self.law {
            Criterion::FixedAngle(FixedAngle { theta0 }) => strength * theta0.sin().powi(2),
            _ => strength * (strength / self.e_eff).powi(2),
        }
    }

    /// Name of [`Self::identified_mpa`].
    pub fn identified_name(&self) -> &'static str {
        match self.model {
            Model::FixedAngle => "sigma_lim0 sin²(theta0)",
            Model::Hertz => "sigma_lim0³ / E'²",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use engine::material::effective_modulus;
    use std::f64::consts::PI;

    #[test]
    fn limit_forces_of_tables_1_and_2_give_back_their_strengths() {
        // Ciantia et al. 2015: d0 = 2 mm, forces derived from eqs 16, 17
        for (theta0, sigma, force) in [(PI / 9.0, 300.0, 110.25), (PI / 18.0, 1200.0, 113.68), (PI / 24.0, 2060.0, 110.26)] {
            let found = 1e-6 * Area::fixed_angle(Some(theta0)).ln_strength(2e-3, force).exp();
            assert!((found / sigma - 1.0).abs() < 1e-4, "{found}");
        }
        for (sigma, young, force) in [(200.0, 0.866e9, 155.4), (800.0, 7.8e9, 131.21), (2200.0, 46.8e9, 106.92)] {
            let area = Area::hertz(Some(effective_modulus((young, 0.3), (200e9, 0.3))));
            let found = 1e-6 * area.ln_strength(2e-3, force).exp();
            assert!((found / sigma - 1.0).abs() < 1e-4, "{found}");
        }
    }

    #[test]
    fn what_forces_identify_does_not_need_angle_or_moduli() {
        let pairs = [(Area::fixed_angle(Some(0.35)), Area::fixed_angle(None)), (Area::hertz(Some(5e9)), Area::hertz(None))];
        for (known, unknown) in pairs {
            let (a, b) = (known.ln_strength(3e-3, 80.0).exp(), unknown.ln_strength(3e-3, 80.0).exp());
            assert!((known.identified_mpa(a) / unknown.identified_mpa(b) - 1.0).abs() < 1e-12);
            assert!((known.force(a, 3e-3) / 80.0 - 1.0).abs() < 1e-12);
            let twice = known.ln_strength(3e-3, 160.0) - known.ln_strength(3e-3, 80.0);
            assert!((twice * known.power() - 2.0_f64.ln()).abs() < 1e-12);
        }
    }
}
