//! Constitutive laws of material points. Tension is positive inside.

mod elastic;

pub use elastic::Elastic;

use serde::{Deserialize, Serialize};

/// Symmetric tensor: xx, yy, zz, xy, yz, zx (tensor components, not engineering shear).
pub type Sym = [f64; 6];

/// What a point remembers beside its stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Accumulated plastic strain.
    pub plastic: f64,
}

/// A constitutive law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Law {
    Elastic(Elastic),
}

impl Law {
    /// Stress, Pa, and memory after the strain increment `dstrain`; the caller has rotated the stress (Jaumann).
    #[inline(always)]
    pub fn update(&self, stress: Sym, dstrain: Sym, memory: Memory) -> (Sym, Memory) {
        match self {
            Law::Elastic(law) => (law.update(stress, dstrain), memory),
        }
    }

    /// Speed of compression waves, m/s, at a density in kg/m³.
    pub fn wave_speed(&self, density: f64) -> f64 {
        match self {
            Law::Elastic(law) => (law.constrained_modulus() / density).sqrt(),
        }
    }
}
