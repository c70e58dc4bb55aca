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
