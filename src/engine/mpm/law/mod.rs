//! Constitutive laws of a material point. A law takes the stress and a strain increment to the new stress; it knows no
//! arrays, files or clocks. Inside the laws tension is positive; records turn the sign.
//!
//! Only + - * / and square roots in a stated order reach results, so that they are the same bytes on every machine.

use serde::{Deserialize, Serialize};

mod cone;
mod drucker_prager;
mod elastic;
mod evolution;
mod surface;
pub mod tensor;
#[cfg(test)]
pub mod tests;

pub use cone::Cone;
pub use drucker_prager::{DruckerPrager, Parameters};
pub use elastic::Elastic;
pub use evolution::Evolution;
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

/// The law of a material: one of them for all of its points.
#[expect(clippy::large_enum_variant, reason = "a scene has a few laws; points hold none")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Law {
    Elastic(Elastic),
    DruckerPrager(DruckerPrager),
}

impl Law {
    /// Stress, Pa, and memory after the strain increment `dstrain`. `stress` has been rotated with the material already
    /// ([`crate::mpm::rotate_jaumann`]).
    #[inline]
    pub fn update(&self, stress: Sym, dstrain: Sym, memory: InternalVariables) -> (Sym, InternalVariables) {
        match self {
            Law::Elastic(law) => (law.update(stress, dstrain), memory),
            Law::DruckerPrager(law) => law.update(stress, dstrain, memory),
        }
    }

    /// The elastic part of the law.
    pub fn elastic(&self) -> Elastic {
        match self {
            Law::Elastic(law) => *law,
            Law::DruckerPrager(law) => law.elastic(),
        }
    }

    /// Shear modulus G, Pa.
    pub fn shear_modulus(&self) -> f64 {
        self.elastic().shear
    }

    /// Bulk modulus K, Pa.
    pub fn bulk_modulus(&self) -> f64 {
        self.elastic().bulk
    }

    /// Young's modulus E, Pa.
    pub fn young(&self) -> f64 {
        self.elastic().young()
    }

    /// Poisson ratio.
    pub fn poisson(&self) -> f64 {
        self.elastic().poisson()
    }

    /// Speed of P-waves, m/s, in material of this density, kg/m³: no law is stiffer than its elastic part.
    pub fn wave_speed(&self, density: f64) -> f64 {
        (self.elastic().oedometric() / density).sqrt()
    }
}
