//! Hertz–Mindlin with viscous damping, Li et al. 2023 eqs (18)–(21); spring and dashpot together slide (eq. 19).
//!
//! ```text
//! F_n = F_Hertz + η_n v_n     η = c √(S m*)     S_n = 2 E* √(R* U)     S_t = 8 G* √(R* U)
//! ```
//!
//! With c = 2 √(5/6) β, β = −ln e / √(π² + ln² e) (Tsuji's form), the restitution is exactly e where the force may turn tensile at the end of an
//! impact ([`HertzViscous`]); where the force ends at zero ([`HertzViscousNoTension`]) another c gives it ([`viscous_coefficient_without_tension`]).

use super::{Coefficients, Elastic, Hertz, Law, Moduli};
use crate::contact::pair::Pair;
use crate::math::real::Real;
use crate::parameter::{Parameter, Range, Values};

/// Hertz–Mindlin with viscous damping, Li et al. 2023 eqs (18)–(21), whose normal force may turn tensile at the end of an impact.
#[derive(Clone, Copy)]
pub struct HertzViscous;

/// [`HertzViscous`] whose normal force ends where it would turn tensile. The impulse of a sliding contact is then exactly μ (1 + e) m* v.
#[derive(Clone, Copy)]
pub struct HertzViscousNoTension;

const RESTITUTION: &[Parameter] = &[Parameter {
    key: "contact.restitution",
    range: Range::above(0.0, 1.0),
    default: Some("1.0"),
    meaning: "restitution of the laws hertz_viscous and hertz_viscous_no_tension",
}];

/// Geometric mean of the restitutions of two materials.
fn restitution(first: &Values, second: Option<&Values>) -> f64 {
    (first[0] * second.unwrap_or(first)[0]).sqrt()
}

impl Law for HertzViscous {
    const VISCOUS: bool = true;
    const PARAMETERS: &'static [Parameter] = RESTITUTION;

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
    const PARAMETERS: &'static [Parameter] = RESTITUTION;

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

/// Viscous coefficient c of η = c √(S_n m*) that gives the restitution e in (0, 1] where the force ends at zero.
///
/// With z = δ^{5/4} Hertz's contact with Tsuji's damping is a linear oscillator of damping ratio ζ = √0.3 c (Antypov & Elliott 2011). That one leaves contact
/// where its acceleration is zero, at the time t of tan(ω t) = −2 ζ ω / (1 − 2 ζ²), ω² = 1 − ζ², and with the speed e = exp(−ζ t) (Schwager & Pöschel 2007).
pub fn viscous_coefficient_without_tension(restitution: f64) -> f64 {
    let (mut low, mut high) = (0.0, 1e6);
    // the root by halving: e falls with ζ
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if restitution_without_tension(middle) > restitution { low = middle } else { high = middle }
    }
    low / 0.3f64.sqrt()
}

/// Restitution of a damping ratio ζ where the force ends at zero.
fn restitution_without_tension(zeta: f64) -> f64 {
    let difference = 1.0 - zeta * zeta;
    let omega = difference.abs().sqrt();
    let (sine, cosine) = (2.0 * zeta * omega, 1.0 - 2.0 * zeta * zeta);
    let time = match omega {
        // the limit of both
        omega if omega < 1e-6 => 2.0,
        omega if difference > 0.0 => sine.atan2(-cosine) / omega,
        omega => (sine / -cosine).atanh() / omega,
    };
    (-zeta * time).exp()
}

/// Viscous coefficient 2 √(5/6) β of a restitution e in (0, 1].
pub fn viscous_coefficient(restitution: f64) -> f64 {
    let l = restitution.ln();
    let beta = -l / (std::f64::consts::PI.powi(2) + l * l).sqrt();
    2.0 * (5.0f64 / 6.0).sqrt() * beta
}
