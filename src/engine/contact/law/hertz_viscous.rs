//! Hertz–Mindlin with viscous damping, Li et al. 2023 eqs (18)–(21). The limit of friction is that of spring and dashpot together (eq. 19).
//!
//! ```text
//! F_n = F_Hertz + η_n v_n     η = c √(S m*)     S_n = 2 E* √(R* U)     S_t = 8 G* √(R* U)
//! ```
//!
//! With c = 2 √(5/6) β, β = −ln e / √(π² + ln² e) (Tsuji's form) the coefficient of restitution is exactly e if the normal force may become tensile at the end
//! of an impact ([`HertzViscous`]). If the force stops at zero ([`HertzViscousNoTension`]) another c gives the same e ([`viscous_coefficient_without_tension`]).

use super::{Coefficients, Elastic, Hertz, Law, Moduli};
use crate::contact::pair::Pair;
use crate::math::real::Real;
use crate::parameter::{Parameter, Range, Values};

/// Hertz–Mindlin with viscous damping, Li et al. 2023 eqs (18)–(21), whose normal force may become tensile at the end of an impact.
#[derive(Clone, Copy)]
pub struct HertzViscous;

/// [`HertzViscous`] with a normal force that is never tensile. The tangential impulse of an impact that slides throughout is then exactly μ (1 + e) m* v.
#[derive(Clone, Copy)]
pub struct HertzViscousNoTension;

/// The restitution of laws with dashpots.
pub(super) const RESTITUTION: Parameter = Parameter {
    key: "contact.restitution",
    range: Range::above(0.0, 1.0),
    default: Some("1.0"),
    meaning: "restitution of the laws hertz_viscous, hertz_viscous_no_tension and spring",
};

/// Geometric mean of the restitutions of two materials, which are their first values.
pub(super) fn restitution(first: &Values, second: Option<&Values>) -> f64 {
    (first[0] * second.unwrap_or(first)[0]).sqrt()
}

impl Law for HertzViscous {
    const VISCOUS: bool = true;
    const PARAMETERS: &'static [Parameter] = &[RESTITUTION];

    fn coefficients(moduli: Moduli, first: &Values, second: Option<&Values>) -> Coefficients {
        let viscous = viscous_coefficient(restitution(first, second));
        Coefficients { viscous, ..Hertz::coefficients(moduli, first, second) }
    }

    #[inline(always)]
    fn elastic<R: Real>(overlap: R, largest: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        Hertz::elastic(overlap, largest, r_eff, pair)
    }

    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64 {
        Hertz::overlap_under(force, r_eff, pair)
    }

    fn restitution(values: &Values) -> f64 {
        values[0]
    }
}

impl Law for HertzViscousNoTension {
    const VISCOUS: bool = true;
    const TENSION: bool = false;
    const PARAMETERS: &'static [Parameter] = &[RESTITUTION];

    fn coefficients(moduli: Moduli, first: &Values, second: Option<&Values>) -> Coefficients {
        let viscous = viscous_coefficient_without_tension(restitution(first, second));
        Coefficients { viscous, ..Hertz::coefficients(moduli, first, second) }
    }

    #[inline(always)]
    fn elastic<R: Real>(overlap: R, largest: R, r_eff: R, pair: &Pair<R>) -> Elastic<R> {
        Hertz::elastic(overlap, largest, r_eff, pair)
    }

    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64 {
        Hertz::overlap_under(force, r_eff, pair)
    }

    fn restitution(values: &Values) -> f64 {
        values[0]
    }
}

/// Viscous coefficient c of η = c √(S_n m*) that gives the coefficient of restitution `restitution`, in (0, 1], to a force that is never tensile.
///
/// In z = δ^{5/4} a Hertzian contact with Tsuji's damping is a linear oscillator with the damping ratio ζ = √0.3 c (Antypov & Elliott 2011). Its contact ends
/// where the acceleration is zero, at the time t of tan(ω t) = −2 ζ ω / (1 − 2 ζ²), ω² = 1 − ζ², with the share e = exp(−ζ t) of the speed of impact (Schwager &
/// Pöschel 2007).
pub fn viscous_coefficient_without_tension(restitution: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e6);
    // bisection: e falls with ζ
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution_without_tension(middle) > restitution { low = middle } else { high = middle }
    }
    low / 0.3f64.sqrt()
}

/// Coefficient of restitution at the damping ratio `zeta` for a force that is never tensile.
fn restitution_without_tension(zeta: f64) -> f64 {
    let difference = 1.0 - zeta * zeta;
    let omega = difference.abs().sqrt();
    let (sine, cosine) = (2.0 * zeta * omega, 1.0 - 2.0 * zeta * zeta);
    let time = match omega {
        // the limit of the other two expressions at critical damping
        omega if omega < 1e-6 => 2.0,
        omega if difference > 0.0 => sine.atan2(-cosine) / omega,
        omega => (sine / -cosine).atanh() / omega,
    };
    (-zeta * time).exp()
}

/// Viscous coefficient c = 2 √(5/6) β that gives the coefficient of restitution `restitution`, in (0, 1], to a force that may become tensile.
pub fn viscous_coefficient(restitution: f64) -> f64 {
    2.0 * (5.0f64 / 6.0).sqrt() * damping_ratio(restitution)
}

/// Damping ratio β = −ln e / √(π² + ln² e) of a linear oscillator of which half a period leaves the share e of the speed.
pub(super) fn damping_ratio(restitution: f64) -> f64 {
    let l = restitution.ln();
    -l / (std::f64::consts::PI.powi(2) + l * l).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At critical damping the share of the speed that is left is e⁻², and nearly the same just below and above it.
    #[test]
    fn restitution_is_smooth_at_critical_damping() {
        for (zeta, within) in [(1.0, 1e-15), (1.0 - 1e-7, 1e-6), (1.0 + 1e-7, 1e-6)] {
            assert!((restitution_without_tension(zeta) - (-2.0f64).exp()).abs() < within, "{zeta}");
        }
    }
}
