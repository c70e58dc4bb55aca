//! Constitutive laws of a material point. A law takes the stress and a strain increment to the new stress; it knows no
//! arrays, files or clocks. Inside the laws tension is positive; records turn the sign.
//!
//! Only + - * / and square roots in a stated order reach results, so that they are the same bytes on every machine.

use serde::{Deserialize, Serialize};

mod cone;
mod drucker_prager;
mod elastic;
mod evolution;
mod mohr_coulomb;
mod registry;
mod surface;
pub mod tensor;
#[cfg(test)]
pub mod tests;

pub use cone::Cone;
pub use drucker_prager::{DruckerPrager, Parameters};
pub use elastic::Elastic;
pub use evolution::Evolution;
pub use mohr_coulomb::MohrCoulomb;
pub use registry::Law;
pub use surface::YieldParameters;

/// Symmetric tensor, components xx, yy, zz, xy, yz, zx (tensor components: half the engineering shear strain). Tension is
/// positive.
pub type Sym = [f64; 6];

/// What a law remembers of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InternalVariables {
    /// Accumulated plastic strain, the integral of sqrt(2/3 de_p:de_p) with all of the plastic strain de_p, -
    pub plastic: f64,
}

/// A law of a material point.
///
/// # Example
/// A soil with the friction angle 30° and no cohesion is compressed axially at a constant cell pressure of 100 kPa, as in a
/// drained triaxial test. It fails at three times the cell pressure, (1 + sin φ)/(1 − sin φ).
///
/// ```
/// use comminute_engine::mpm::law::{Cone, Elastic, Evolution, InternalVariables, Law, MohrCoulomb, Parameters};
///
/// let law = Law::MohrCoulomb(MohrCoulomb::from(Parameters {
///     elastic: Elastic::of_young(20e6, 0.3), // Pa, -
///     cone: Cone::Outer,                     // of Drucker-Prager's law only
///     friction: Evolution::Constant(30_f64.to_radians()),
///     cohesion: Evolution::Constant(0.0),
///     dilation: 0.0,
///     tension: f64::INFINITY,
/// }));
/// let cell = -100e3; // tension is positive
/// let (mut stress, mut memory) = ([cell, cell, cell, 0.0, 0.0, 0.0], InternalVariables::default());
/// for _ in 0..300 {
///     // the lateral strain at which the lateral stress stays, by bisection
///     let axial = -1e-4;
///     let after = |lateral: f64| law.update(stress, [lateral, lateral, axial, 0.0, 0.0, 0.0], memory);
///     let (mut low, mut high) = (0.0, -2.0 * axial);
///     for _ in 0..60 {
///         let middle = 0.5 * (low + high);
///         // wider means less lateral pressure
///         if after(middle).0[0] < cell { low = middle } else { high = middle }
///     }
///     (stress, memory) = after(0.5 * (low + high));
/// }
/// assert!((stress[2] / stress[0] - 3.0).abs() < 1e-6, "{stress:?}");
/// assert!(memory.plastic > 0.0);
/// ```
pub trait ConstitutiveLaw: Sized {
    /// Keys of a material's table [continuum] that the law reads besides `law` and the moduli, without their units; all but evolutions and `tension` are needed.
    const KEYS: &'static [&'static str];

    /// The law of these parameters; it looks at those of its keys.
    fn of(parameters: &Parameters) -> Self;

    /// Stress, Pa, and memory after the strain increment `dstrain`. `stress` has been rotated with the material already
    /// ([`crate::mpm::rotate_jaumann`]).
    fn update(&self, stress: Sym, dstrain: Sym, memory: InternalVariables) -> (Sym, InternalVariables);

    /// The elastic part of the law.
    fn elastic(&self) -> Elastic;

    /// The place of a cone of failure at the Mohr-Coulomb pyramid, of a law that has one.
    fn cone(&self) -> Option<Cone> {
        None
    }

    /// Friction angle, rad, and cohesion, Pa, at a plastic strain, of a law that yields.
    fn shear_strength(&self, _plastic: f64) -> Option<[f64; 2]> {
        None
    }

    /// The line of failure in triaxial compression at a plastic strain, of a law that yields.
    fn yield_line(&self, _plastic: f64) -> Option<YieldParameters> {
        None
    }

    /// Deviatoric stress q at failure in triaxial compression at the cell pressure, Pa (compression positive), at a plastic strain.
    fn q_compression(&self, _cell: f64, _plastic: f64) -> Option<f64> {
        None
    }

    /// Radial less axial stress at failure in triaxial extension at the cell pressure, Pa (compression positive), at a plastic strain.
    fn q_extension(&self, _cell: f64, _plastic: f64) -> Option<f64> {
        None
    }

    /// The largest of these that the law reaches at any plastic strain, in compression or extension; `None` where no closed form says.
    fn peak_q(&self, _cell: f64, _compression: bool) -> Option<f64> {
        None
    }
}
