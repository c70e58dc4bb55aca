//! The constitutive laws that there are. A law is a type in a file of this room that implements [`ConstitutiveLaw`], and a line here; the words of material files, the checks and
//! every dispatch follow from it.

use super::{Cone, ConstitutiveLaw, DruckerPrager, Elastic, InternalVariables, MohrCoulomb, Parameters, Sym, YieldParameters};
use serde::{Deserialize, Serialize};

/// Writes the enumeration of laws and what is asked of them by name.
macro_rules! constitutive_laws {
    ($($(#[$doc:meta])* $law:ident = $word:literal, $meaning:literal, gpu: $gpu:expr;)*) => {
        /// The law of a material: one of them for all of its points.
        #[expect(clippy::large_enum_variant, reason = "a scene has a few laws; points hold none")]
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub enum Law {
            $($(#[$doc])* $law($law),)*
        }

        impl Law {
            /// The words for the laws in material files.
            pub const WORDS: &'static [&'static str] = &[$($word),*];
            /// What each law is, in a few words, in the order of their words.
            pub const MEANINGS: &'static [&'static str] = &[$($meaning),*];

            /// The law of this word and of these parameters.
            pub fn named(word: &str, parameters: &Parameters) -> Option<Law> {
                match word {
                    $($word => Some(Law::$law(ConstitutiveLaw::of(parameters))),)*
                    _ => None,
                }
            }

            /// [`ConstitutiveLaw::KEYS`] of the law of this word.
            pub fn keys(word: &str) -> Option<&'static [&'static str]> {
                match word {
                    $($word => Some(<$law as ConstitutiveLaw>::KEYS),)*
                    _ => None,
                }
            }

            /// The word for the law in material files.
            pub fn word(&self) -> &'static str {
                match self { $(Law::$law(_) => $word,)* }
            }

            /// The law's number in shaders, or what to use instead on a graphics device.
            pub fn on_gpu(&self) -> Result<u32, &'static str> {
                match self { $(Law::$law(_) => $gpu,)* }
            }

            /// [`ConstitutiveLaw::update`]
            #[inline]
            pub fn update(&self, stress: Sym, dstrain: Sym, memory: InternalVariables) -> (Sym, InternalVariables) {
                match self { $(Law::$law(law) => ConstitutiveLaw::update(law, stress, dstrain, memory),)* }
            }

            /// [`ConstitutiveLaw::elastic`]
            pub fn elastic(&self) -> Elastic {
                match self { $(Law::$law(law) => ConstitutiveLaw::elastic(law),)* }
            }

            /// [`ConstitutiveLaw::cone`]
            pub fn cone(&self) -> Option<Cone> {
                match self { $(Law::$law(law) => ConstitutiveLaw::cone(law),)* }
            }

            /// [`ConstitutiveLaw::shear_strength`]
            pub fn shear_strength(&self, plastic: f64) -> Option<[f64; 2]> {
                match self { $(Law::$law(law) => ConstitutiveLaw::shear_strength(law, plastic),)* }
            }

            /// [`ConstitutiveLaw::yield_line`]
            pub fn yield_line(&self, plastic: f64) -> Option<YieldParameters> {
                match self { $(Law::$law(law) => ConstitutiveLaw::yield_line(law, plastic),)* }
            }

            /// [`ConstitutiveLaw::q_compression`]
            pub fn q_compression(&self, cell: f64, plastic: f64) -> Option<f64> {
                match self { $(Law::$law(law) => ConstitutiveLaw::q_compression(law, cell, plastic),)* }
            }

            /// [`ConstitutiveLaw::peak_q`]
            pub fn peak_q(&self, cell: f64, compression: bool) -> Option<f64> {
                match self { $(Law::$law(law) => ConstitutiveLaw::peak_q(law, cell, compression),)* }
            }
        }
    };
}

constitutive_laws! {
    /// Linear elasticity.
    Elastic = "elastic", "linear elasticity", gpu: Ok(0);
    /// Drucker–Prager with a tension cut-off, hardening and softening.
    DruckerPrager = "drucker_prager", "elastic up to a cone of failure, which may harden and soften", gpu: Ok(1);
    /// Mohr–Coulomb with an exact return.
    MohrCoulomb = "mohr_coulomb", "elastic up to the pyramid of Mohr-Coulomb with constant friction, cohesion and dilation", gpu: Err("use drucker_prager");
}

impl Law {
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
