//! Simplified Hertz–Mindlin law, Ciantia et al. 2015 eq. (14).
//!
//! ```text
//! F = 4/3 E* √R* U^(3/2)     k_N = dF/dU = 2 E* √(R* U)     k_S = 8 G* √(R* U)
//! ```
//!
//! For equal grains that is Hertz's law with Mindlin's tangential stiffness before any slip. Written with E*, G* (Li et al. 2023 eqs 20, 21) it also holds for two
//! materials.

use super::{Coefficients, Elastic, Law, Moduli};
use crate::contact::pair::Pair;
use crate::math::real::Real;
use crate::parameter::Values;

/// Simplified Hertz–Mindlin law, Ciantia et al. 2015 eq. (14); Li et al. 2023 eqs (20), (21) for pairs of different materials.
#[derive(Clone, Copy)]
pub struct Hertz;

impl Law for Hertz {
    fn coefficients(moduli: Moduli, _: &Values, _: Option<&Values>) -> Coefficients {
        Coefficients { normal: 4.0 / 3.0 * moduli.young, tangential: 8.0 * moduli.shear, viscous: 0.0, yield_overlap: 0.0 }
    }

    #[inline(always)]
    fn elastic<R: Real>(overlap: R, _: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        let contact_radius = (r_eff * overlap).sqrt();
        let force = pair.normal_stiffness * contact_radius * overlap;
        Elastic {
            force,
            k_n: pair.normal_stiffness * 1.5 * contact_radius,
            k_t: pair.tangential_stiffness * contact_radius,
            energy: force * 0.4 * overlap,
        }
    }

    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64 {
        (force / (pair.normal_stiffness * r_eff.sqrt())).cbrt().powi(2)
    }
}
