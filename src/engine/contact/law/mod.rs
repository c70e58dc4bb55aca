//! Contact laws: the normal force of one contact from its overlap, with the stiffness of its tangential spring. Pure functions of one contact.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `overlap` | depth of the overlap of two spheres, > 0 in contact | m |
//! | `largest` | largest overlap that the contact has had, not below `overlap` | m |
//! | `r_eff` R* | r1 r2 / (r1 + r2); the grain's own radius on a wall | m |
//! | E*, G* | 1/E* = Σ (1 − ν²)/E; 1/G* = Σ (2 − ν)/G | Pa |
//!
//! On a wall the law is that of a mirrored identical grain (`docs/theory/contact_normal.md`, Walls): R* = r, E* = E/(1 − ν²), G* = G/(2 − ν).
//!
//! A law is a type that implements [`Law`] in a file of its own, and a line in [`super::registry`].

mod elasto_plastic;
mod hertz;
mod hertz_viscous;
mod linear;

pub use elasto_plastic::ElastoPlastic;
pub use hertz::Hertz;
pub use hertz_viscous::{HertzViscous, HertzViscousNoTension, viscous_coefficient, viscous_coefficient_without_tension};
pub use linear::{Linear, LinearInherited};

pub use super::pair::{Coefficients, Moduli, Pair};
use crate::material::Material;
use crate::math::real::Real;
use crate::parameter::{Parameter, Values};

/// What a law answers for one overlap.
#[derive(Clone, Copy, Debug)]
pub struct Elastic<R = f64> {
    /// Normal force, N.
    pub force: R,
    /// Tangent normal stiffness dF/d(overlap), N/m; where loading and unloading differ the larger of the two.
    pub k_n: R,
    /// Tangential stiffness, N/m.
    pub k_t: R,
    /// Elastic energy of the normal compression, J.
    pub energy: R,
}

/// A normal law with its tangential stiffness.
///
/// # Example
/// A program that uses the engine gives it a law of its own: F = c δ², c = E*. The sweeps over contacts are compiled for it,
/// for one contact at a time and for several side by side.
///
/// ```
/// use comminute_engine::contact::{ContactLaw, law::*, pair::Pair, registry::LawTable};
/// use comminute_engine::{math::real::Real, parameter::Values};
///
/// #[derive(Clone, Copy)]
/// struct Quadratic;
///
/// impl Law for Quadratic {
///     const HERTZIAN: bool = false;
///
///     fn coefficients(moduli: Moduli, _: &Values, _: Option<&Values>) -> Coefficients {
///         Coefficients { normal: moduli.young, tangential: moduli.shear, viscous: 0.0, yield_overlap: 0.0 }
///     }
///
///     #[inline(always)]
///     fn elastic<R: Real>(overlap: R, _largest: R, _r_eff: R, pair: &Pair<R>) -> Elastic<R> {
///         let secant = pair.normal_stiffness * overlap;
///         let force = secant * overlap;
///         Elastic { force, k_n: secant * 2.0, k_t: pair.tangential_stiffness * overlap, energy: force * overlap * (1.0 / 3.0) }
///     }
///
///     fn overlap_under(force: f64, _r_eff: f64, pair: &Pair) -> f64 {
///         (force / pair.normal_stiffness).sqrt()
///     }
/// }
///
/// static TABLE: LawTable = LawTable::of::<Quadratic>();
/// let law = ContactLaw::Custom(&TABLE); // for `Physics::of`, or in place of a model's `physics.contact.law`
///
/// let pair = Pair::of(&Quadratic::coefficients(Moduli { young: 40e9, shear: 16e9 }, &[0.0; 4], None), 0.4, 0.0, 40e9);
/// assert!((law.elastic(1e-6, 1e-6, 1e-3, &pair).force - 0.04).abs() < 1e-12);
/// assert!((law.overlap_under(0.04, 1e-3, &pair) - 1e-6).abs() < 1e-15);
/// ```
pub trait Law: Copy + Send + Sync + 'static {
    /// What the law asks of each material besides Young's modulus, Poisson ratio and friction.
    const PARAMETERS: &'static [Parameter] = &[];
    /// Whether the law follows from the grains' elastic moduli, and its area of contact with it, as Hertz's does.
    const HERTZIAN: bool = true;
    /// Whether the law adds viscous forces.
    const VISCOUS: bool = false;
    /// Whether the dashpot may make the normal force tensile at the end of an impact.
    const TENSION: bool = true;
    /// Whether a grain's stiffness may be that of another size ([`crate::grains::Grains::stiffness_radius`]).
    const INHERITED: bool = false;
    /// Whether the force depends on the largest overlap that the contact has had, which contacts then keep.
    const PLASTIC: bool = false;

    /// The coefficients of two materials in contact, given by the values of [`Law::PARAMETERS`]; a rigid wall has no second one.
    fn coefficients(moduli: Moduli, first: &Values, second: Option<&Values>) -> Coefficients;

    /// Force, stiffness and energy at an overlap > 0.
    fn elastic<R: Real>(overlap: R, largest: R, r_eff: R, pair: &Pair<R>) -> Elastic<R>;

    /// Energy, J, that a contact has lost to yielding when its overlap has been `largest`.
    #[inline(always)]
    fn dissipated<R: Real>(largest: R, _r_eff: R, _pair: &Pair<R>) -> R {
        largest.constant(0.0)
    }

    /// Overlap, m, at which a contact that is loaded for the first time bears the force `force`, N.
    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64;

    /// Coefficient of restitution of a material, where it sets how far dashpots have to be resolved; 1 without dashpots.
    fn restitution(_values: &Values) -> f64 {
        1.0
    }

    /// Step, s, that resolves the free motion of a grain of mass `mass`, kg, and radius `r`, m, whose contacts are as stiff as those of a grain of the radius
    /// `stiffness_radius`, m: the Rayleigh step π r √(ρ/G) / (0.163 ν + 0.877) (Li et al. 2023 eq. 38).
    fn free_step(m: &Material, _mass: f64, r: f64, _stiffness_radius: f64) -> f64 {
        let shear = m.young / (2.0 * (1.0 + m.poisson));
        std::f64::consts::PI * r * (m.density / shear).sqrt() / (0.163 * m.poisson + 0.877)
    }
}
