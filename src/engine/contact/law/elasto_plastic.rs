//! Elastic–perfectly plastic contact of spheres, Thornton (1997, J. Appl. Mech. 64:383): Hertz's law until the pressure in the middle of the contact reaches the
//! yield pressure p_y. Beyond, the force grows in proportion to the overlap. Unloading and reloading follow Hertz's law for the flatter surface that yielding
//! leaves, with the larger radius of curvature R_p.
//!
//! ```text
//! a_y = π R* p_y/(2 E*)    δ_y = a_y²/R*    F_y = 4/3 E* a_y δ_y                       where yielding begins
//! F = F_y + π p_y R* (δ − δ_y)                                                          first loading, δ > δ_y
//! F = 4/3 E* √R_p (δ − δ_p)^(3/2)    R_p = 4 E* a³/(3 F_max)    δ_p = δ_max − a²/R_p    unloading, with a = √(R* δ_max)
//! ```
//!
//! When the force of unloading reaches zero, an overlap δ_p is left; it is forgotten once the grains do not overlap any more. An impact at the speed V above
//! V_y = (16/15)^(1/2) (π/2)^(5/2) √(p_y⁵ R*³/(E*⁴ m*)) has the restitution
//! e = (6√3/5)^(1/2) [1 − (V_y/V)²/6]^(1/2) [x/(x + 2 √(6/5 − x²/5))]^(1/4), x = V_y/V: it falls with the speed, with V^(−1/4) far above V_y.
//!
//! Valid for small contacts without dashpots; grains do not break by yielding, and p_y is about 1.6 times the substance's yield stress for metals (Johnson 1985).

use super::{Coefficients, Elastic, Hertz, Law, Moduli};
use crate::contact::pair::Pair;
use crate::math::real::Real;
use crate::parameter::{Parameter, Range, Values};
use std::f64::consts::FRAC_PI_2;

/// Elastic–perfectly plastic contact, Thornton (1997).
#[derive(Clone, Copy)]
pub struct ElastoPlastic;

/// Smallest contact radius, m: that of a contact without force. Small enough to make no force, large enough to divide by.
const NO_RADIUS: f64 = 1e-30;

/// State on the curve of first loading at one overlap.
struct Loading<R> {
    /// Radius of the contact, m.
    radius: R,
    /// Force, N.
    force: R,
    /// Part of the overlap that is recovered in unloading, m.
    recovered: R,
    /// Work done on the contact so far, J.
    work: R,
}

impl<R: Real> Loading<R> {
    #[inline(always)]
    fn at(largest: R, r_eff: R, pair: &Pair<R>) -> Loading<R> {
        let first = pair.yield_overlap * r_eff;
        let first_radius = (r_eff * first).sqrt();
        let (first_force, slope) = (pair.normal_stiffness * first_radius * first, pair.normal_stiffness * 1.5 * first_radius);
        let radius = (r_eff * largest).sqrt();
        let elastic = pair.normal_stiffness * radius * largest;
        let (beyond, yields) = (largest - first, largest.above(first));
        let force = (first_force + slope * beyond).where_else(yields, elastic);
        let plastic_work = first_force * first * 0.4 + (first_force + slope * beyond * 0.5) * beyond;
        Loading {
            radius,
            force,
            recovered: force / (pair.normal_stiffness * radius),
            work: plastic_work.where_else(yields, elastic * largest * 0.4),
        }
    }
}

impl Law for ElastoPlastic {
    const PLASTIC: bool = true;
    const PARAMETERS: &'static [Parameter] = &[Parameter {
        key: "contact.yield_pressure_MPa",
        range: Range::POSITIVE,
        default: None,
        meaning: "elasto_plastic: pressure in the middle of a contact at which the grain's substance yields (Thornton 1997); of two materials the smaller one counts",
    }];

    fn coefficients(moduli: Moduli, first: &Values, second: Option<&Values>) -> Coefficients {
        let yield_pressure = second.map_or(first[0], |second| first[0].min(second[0]));
        let ratio = FRAC_PI_2 * yield_pressure / moduli.young;
        Coefficients { yield_overlap: ratio * ratio, ..Hertz::coefficients(moduli, first, second) }
    }

    #[inline(always)]
    fn elastic<R: Real>(overlap: R, largest: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        let Loading { radius, recovered, .. } = Loading::at(largest, r_eff, pair);
        let left = (overlap - (largest - recovered)).at_least(0.0);
        // a² = R_p (δ − δ_p), R_p = a_max²/(δ_max − δ_p)
        let contact_radius = (radius * radius * left / recovered).sqrt().at_least(NO_RADIUS);
        let force = pair.normal_stiffness * contact_radius * left;
        Elastic {
            force,
            k_n: pair.normal_stiffness * 1.5 * contact_radius,
            k_t: pair.tangential_stiffness * contact_radius,
            energy: force * 0.4 * left,
        }
    }

    #[inline(always)]
    fn dissipated<R: Real>(largest: R, r_eff: R, pair: &Pair<R>) -> R {
        let Loading { force, recovered, work, .. } = Loading::at(largest, r_eff, pair);
        (work - force * recovered * 0.4).at_least(0.0)
    }

    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64 {
        let first = pair.yield_overlap * r_eff;
        let slope = 1.5 * pair.normal_stiffness * (r_eff * first).sqrt();
        let first_force = slope / 1.5 * first;
        if force > first_force { first + (force - first_force) / slope } else { Hertz::overlap_under(force, r_eff, pair) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const R: f64 = 0.5e-3;

    fn pair() -> Pair {
        let moduli = Moduli { young: 38e9, shear: 14e9 };
        Pair::of(&ElastoPlastic::coefficients(moduli, &[3e9, 0.0, 0.0, 0.0], None), 0.3, 0.0, 38e9)
    }

    /// Where yielding begins force and stiffness of both branches are the same, and p_y = 3 F_y/(2 π a_y²).
    #[test]
    fn yields_where_the_pressure_in_the_middle_is_the_yield_pressure() {
        let pair = pair();
        let first = pair.yield_overlap * R;
        let at = |x: f64| ElastoPlastic::elastic(x, x, R, &pair);
        let pressure = 1.5 * at(first).force / (std::f64::consts::PI * R * first);
        assert!((pressure / 3e9 - 1.0).abs() < 1e-12, "{pressure}");
        let (below, above) = (at(first * (1.0 - 1e-9)), at(first * (1.0 + 1e-9)));
        assert!((above.force / below.force - 1.0).abs() < 1e-8);
        // the slope beyond is π p_y R*
        let slope = (at(3.0 * first).force - at(2.0 * first).force) / first;
        assert!((slope / (std::f64::consts::PI * 3e9 * R) - 1.0).abs() < 1e-12, "{slope}");
    }

    /// Unloading begins at the largest force, ends at the residual overlap, and gives back what the contact has not dissipated.
    #[test]
    fn work_of_a_cycle_is_what_is_dissipated() {
        let pair = pair();
        let largest = 20.0 * pair.yield_overlap * R;
        let n = 200_000;
        let dx = largest / f64::from(n);
        let sum = |force: &dyn Fn(f64) -> f64| (0..n).map(|k| force((f64::from(k) + 0.5) * dx) * dx).sum::<f64>();
        let loading = sum(&|x| ElastoPlastic::elastic(x, x, R, &pair).force);
        let unloading = sum(&|x| ElastoPlastic::elastic(x, largest, R, &pair).force);
        let dissipated = ElastoPlastic::dissipated(largest, R, &pair);
        assert!(((loading - unloading) / dissipated - 1.0).abs() < 1e-6, "{loading} {unloading} {dissipated}");
        let top = ElastoPlastic::elastic(largest, largest, R, &pair);
        assert!((unloading / top.energy - 1.0).abs() < 1e-6);
        assert_eq!(ElastoPlastic::elastic(0.1 * largest, largest, R, &pair).force, 0.0);
        assert!((ElastoPlastic::overlap_under(top.force, R, &pair) / largest - 1.0).abs() < 1e-12);
    }

    #[test]
    fn below_yield_it_is_hertz() {
        let pair = pair();
        for share in [0.01, 0.3, 0.99] {
            let x = share * pair.yield_overlap * R;
            let (own, hertz) = (ElastoPlastic::elastic(x, x, R, &pair), Hertz::elastic(x, x, R, &pair));
            for (a, b) in [(own.force, hertz.force), (own.k_n, hertz.k_n), (own.k_t, hertz.k_t), (own.energy, hertz.energy)] {
                assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
            }
            assert!(ElastoPlastic::dissipated(x, R, &pair) <= 1e-15 * own.energy);
        }
    }
}
