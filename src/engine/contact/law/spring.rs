//! Linear spring and dashpot with stiffnesses as given, whatever the size of the grains: Jiang et al. 2020 eq. (43), with a dashpot.
//!
//! ```text
//! F_n = k_n U + η_n v_n     F_t = k_t s (limit μ F_n)     η = c √(k m*)     c = 2 β,  β = −ln e / √(π² + ln² e)
//! ```
//!
//! With this c the coefficient of restitution is e where the force may become tensile at the end of an impact. In plane strain stiffnesses count per metre of depth,
//! N/m². Between two materials stiffnesses are harmonic means, restitution is the geometric mean.

use super::hertz_viscous::{RESTITUTION, damping_ratio, restitution};
use super::{Coefficients, Elastic, Law, Moduli};
use crate::contact::pair::Pair;
use crate::material::Material;
use crate::math::real::Real;
use crate::parameter::{Parameter, Range, Values};

/// Linear spring and dashpot, Jiang et al. 2020 eq. (43).
#[derive(Clone, Copy)]
pub struct Spring;

impl Law for Spring {
    const HERTZIAN: bool = false;
    const VISCOUS: bool = true;
    const PARAMETERS: &'static [Parameter] = &[
        RESTITUTION,
        Parameter {
            key: "spring.k_n_N_m",
            range: Range::POSITIVE,
            default: None,
            meaning: "normal stiffness of the law spring; in plane strain per metre of depth",
        },
        Parameter {
            key: "spring.k_t_N_m",
            range: Range::POSITIVE,
            default: None,
            meaning: "tangential stiffness of the law spring; in plane strain per metre of depth",
        },
    ];

    fn coefficients(_: Moduli, first: &Values, second: Option<&Values>) -> Coefficients {
        let viscous = 2.0 * damping_ratio(restitution(first, second));
        let second = second.unwrap_or(first);
        let [normal, tangential] = [1, 2].map(|k| 2.0 / (1.0 / first[k] + 1.0 / second[k]));
        Coefficients { normal, tangential, viscous, yield_overlap: 0.0 }
    }

    #[inline(always)]
    fn elastic<R: Real>(overlap: R, _: R, _: R, pair: &Pair<R>) -> Elastic<R> {
        let force = pair.normal_stiffness * overlap;
        Elastic { force, k_n: pair.normal_stiffness, k_t: pair.tangential_stiffness, energy: force * overlap * 0.5 }
    }

    fn overlap_under(force: f64, _: f64, pair: &Pair) -> f64 {
        force / pair.normal_stiffness
    }

    fn restitution(values: &Values) -> f64 {
        values[0]
    }

    /// √(m/k) with the stiffness of one contact.
    fn free_step(m: &Material, mass: f64, _: f64, _: f64) -> f64 {
        (mass / m.contact[1]).sqrt()
    }
}
