//! Linear contact law, Ciantia et al. 2015 eq. (13).
//!
//! ```text
//! k_N = 2 K_eff D1 D2/(D1 + D2) = 4 K_eff R*     F = k_N U     k_S = alpha_S k_N
//! ```
//!
//! D1, D2: diameters; U: overlap. Between two materials K_eff is the harmonic mean of theirs, alpha_S the arithmetic mean.

use super::{Coefficients, Elastic, Law, Moduli};
use crate::contact::pair::Pair;
use crate::material::Material;
use crate::math::real::Real;
use crate::parameter::{Parameter, Range, Values};

/// Linear law, Ciantia et al. 2015 eq. (13).
#[derive(Clone, Copy)]
pub struct Linear;

/// [`Linear`], but fragments keep the stiffness of the initial grain they come from: D1, D2 of eq. (13) are the diameters of the initial grains. This is another
/// reading of the paper, which says that daughters "assume the … material parameters of the mother" and whose code sets the stiffness ball by ball.
#[derive(Clone, Copy)]
pub struct LinearInherited;

impl Law for Linear {
    const HERTZIAN: bool = false;
    const PARAMETERS: &'static [Parameter] = &[
        Parameter {
            key: "linear.K_eff_MPa",
            range: Range::POSITIVE,
            default: None,
            meaning: "stiffness of the linear law (eq. 13)",
        },
        Parameter {
            key: "linear.alpha_s",
            range: Range::closed(0.0, 10.0),
            default: Some("0.25"),
            meaning: "tangential over normal stiffness (eq. 13)",
        },
    ];

    fn coefficients(_: Moduli, first: &Values, second: Option<&Values>) -> Coefficients {
        let (k_eff, alpha) = match second {
            Some(second) => (2.0 / (1.0 / first[0] + 1.0 / second[0]), 0.5 * (first[1] + second[1])),
            None => (first[0], first[1]),
        };
        Coefficients { normal: 4.0 * k_eff, tangential: 4.0 * alpha * k_eff, viscous: 0.0, yield_overlap: 0.0 }
    }

    #[inline(always)]
    fn elastic<R: Real>(overlap: R, _: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        let k_n = pair.normal_stiffness * r_eff;
        let force = k_n * overlap;
        Elastic { force, k_n, k_t: pair.tangential_stiffness * r_eff, energy: force * overlap * 0.5 }
    }

    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64 {
        force / (pair.normal_stiffness * r_eff)
    }

    /// √(m/k), with the stiffness k = 4 K_eff R* of one contact with a wall.
    fn free_step(m: &Material, mass: f64, _: f64, stiffness_radius: f64) -> f64 {
        (mass / (4.0 * m.contact[0] * stiffness_radius)).sqrt()
    }
}

impl Law for LinearInherited {
    const HERTZIAN: bool = false;
    const INHERITED: bool = true;
    const PARAMETERS: &'static [Parameter] = Linear::PARAMETERS;

    fn coefficients(moduli: Moduli, first: &Values, second: Option<&Values>) -> Coefficients {
        Linear::coefficients(moduli, first, second)
    }

    #[inline(always)]
    fn elastic<R: Real>(overlap: R, largest: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        Linear::elastic(overlap, largest, r_eff, pair)
    }

    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64 {
        Linear::overlap_under(force, r_eff, pair)
    }

    fn free_step(m: &Material, mass: f64, r: f64, stiffness_radius: f64) -> f64 {
        Linear::free_step(m, mass, r, stiffness_radius)
    }
}
