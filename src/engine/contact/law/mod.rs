//! Contact laws: the normal force of a contact from its overlap, and the stiffness of its tangential spring. Functions of one contact, or of one per SIMD lane.
//!
//! | symbol | meaning | unit |
//! |---|---|---|
//! | `overlap` | depth of the overlap of two spheres, > 0 in contact | m |
//! | `largest` | largest overlap that the contact has had, not below `overlap` | m |
//! | `r_eff` R* | r1 r2 / (r1 + r2); the grain's own radius on a wall | m |
//! | E*, G* | 1/E* = Σ (1 − ν²)/E; 1/G* = Σ (2 − ν)/G | Pa |
//!
//! A wall is rigid, which is the same as the grain's mirror image behind it (`docs/theory/contact_normal.md`, Walls): R* = r, E* = E/(1 − ν²), G* = G/(2 − ν) of
//! the grain.
//!
//! To add a law, write a type that implements [`Law`] in a file of its own, and a line in [`super::registry`].

mod elasto_plastic;
mod hertz;
mod hertz_viscous;
mod linear;
mod spring;

pub use elasto_plastic::ElastoPlastic;
pub use hertz::Hertz;
pub use hertz_viscous::{HertzViscous, HertzViscousNoTension, viscous_coefficient, viscous_coefficient_without_tension};
pub use linear::{Linear, LinearInherited};
pub use spring::Spring;

pub use super::pair::{Coefficients, Moduli, Pair};
use crate::material::Material;
use crate::math::real::Real;
use crate::parameter::{Parameter, Values};

/// Force, stiffness and energy of a contact at one overlap.
#[derive(Clone, Copy, Debug)]
pub struct Elastic<R = f64> {
    /// Normal force, N.
    pub force: R,
    /// Normal stiffness dF/d(overlap), N/m; the larger one where that of loading and that of unloading differ.
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
    /// The parameters that the law needs of each material besides Young's modulus, Poisson's ratio and friction.
    const PARAMETERS: &'static [Parameter] = &[];
    /// Whether force and contact area follow from the elastic moduli of the grains, as in Hertz's theory.
    const HERTZIAN: bool = true;
    /// Whether the law adds viscous forces.
    const VISCOUS: bool = false;
    /// Whether the dashpot may make the normal force tensile at the end of an impact.
    const TENSION: bool = true;
    /// Whether fragments keep the stiffness of the grain they come from: R* is then that of [`crate::grains::Grains::stiffness_radius`].
    const INHERITED: bool = false;
    /// Whether the force depends on the largest overlap that the contact has had; contacts then keep it.
    const PLASTIC: bool = false;

    /// The coefficients for two materials, from their reduced moduli and from their values of [`Law::PARAMETERS`]; `second` is `None` for a rigid wall.
    fn coefficients(moduli: Moduli, first: &Values, second: Option<&Values>) -> Coefficients;

    /// Force, stiffness and energy at the overlap `overlap` > 0, m; `largest`, m, is the largest overlap so far, `r_eff` is R*, m.
    fn elastic<R: Real>(overlap: R, largest: R, r_eff: R, pair: &Pair<R>) -> Elastic<R>;

    /// Energy, J, that a contact has lost to yielding when the largest overlap it has had is `largest`, m; `r_eff` is R*, m.
    #[inline(always)]
    fn dissipated<R: Real>(largest: R, _r_eff: R, _pair: &Pair<R>) -> R {
        largest.constant(0.0)
    }

    /// Overlap, m, at which a contact loaded for the first time has the normal force `force`, N; `r_eff` is R*, m.
    fn overlap_under(force: f64, r_eff: f64, pair: &Pair) -> f64;

    /// Coefficient of restitution of a material from its values of [`Law::PARAMETERS`], -; 1 for laws without dashpots. It bounds the time step, as dashpots must
    /// be resolved in time.
    fn restitution(_values: &Values) -> f64 {
        1.0
    }

    /// Time scale, s, of a grain without contacts, for the choice of the time step: for Hertzian laws the Rayleigh time π r √(ρ/G) / (0.163 ν + 0.877) (Li et al.
    /// 2023 eq. 38). `mass`, kg; `r`: radius, m; `stiffness_radius`, m: radius that sets the stiffness of the grain's contacts, which is another one for fragments
    /// under a law that is [`Law::INHERITED`].
    fn free_step(m: &Material, _mass: f64, r: f64, _stiffness_radius: f64) -> f64 {
        let shear = m.young / (2.0 * (1.0 + m.poisson));
        std::f64::consts::PI * r * (m.density / shear).sqrt() / (0.163 * m.poisson + 0.877)
    }
}
