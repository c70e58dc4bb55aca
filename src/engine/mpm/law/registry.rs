//! The list of constitutive laws. To add one, write a type that implements [`ConstitutiveLaw`] in a file of this folder, and a line in the list below; from that
//! line follow the word in material files, the checks of its keys, and the calls.

use super::{
    CamClay, Cone, ConstitutiveLaw, DruckerPrager, Elastic, InternalVariables, MohrCoulomb, Parameters, Sym, YieldParameters,
};
use serde::{Deserialize, Serialize};

/// Writes the enumeration [`Law`] with its functions from the list of laws, and the macro `with_law!`, which runs `$body` with the name `$own` standing for a
/// reference to the law of its own type.
macro_rules! constitutive_laws {
    (($d:tt) $($(#[$doc:meta])* $law:ident = $word:literal, $meaning:literal, gpu: $gpu:expr;)*) => {
        /// The constitutive law of a material.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        pub enum Law {
            $($(#[$doc])* $law($law),)*
        }

        impl Law {
            /// The words for the laws in material files.
            pub const WORDS: &'static [&'static str] = &[$($word),*];
            /// What each law is, in a few words, in the order of their words.
            pub const MEANINGS: &'static [&'static str] = &[$($meaning),*];

            /// The law with this word and these parameters; `None` where there is none.
            pub fn named(word: &str, parameters: &Parameters) -> Option<Law> {
                match word {
                    $($word => Some(Law::$law(ConstitutiveLaw::of(parameters))),)*
                    _ => None,
                }
            }

            /// [`ConstitutiveLaw::KEYS`] of the law with this word; `None` where there is none.
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

            /// Number of the law in shaders; or, for a law that shaders do not have, which to use instead on a graphics device.
            pub fn on_gpu(&self) -> Result<u32, &'static str> {
                match self { $(Law::$law(_) => $gpu,)* }
            }

            /// [`ConstitutiveLaw::update`]
            #[inline]
            pub fn update(&self, stress: Sym, dstrain: Sym, internal: InternalVariables) -> (Sym, InternalVariables) {
                match self { $(Law::$law(law) => ConstitutiveLaw::update(law, stress, dstrain, internal),)* }
            }

            /// [`ConstitutiveLaw::elastic`]
            pub fn elastic(&self) -> Elastic {
                match self { $(Law::$law(law) => ConstitutiveLaw::elastic(law),)* }
            }

            /// [`ConstitutiveLaw::stiffness`]
            pub fn stiffness(&self, stress: &Sym, internal: InternalVariables) -> Elastic {
                match self { $(Law::$law(law) => ConstitutiveLaw::stiffness(law, stress, internal),)* }
            }

            /// [`ConstitutiveLaw::elastic_energy`]
            pub fn elastic_energy(&self, stress: &Sym, internal: InternalVariables) -> f64 {
                match self { $(Law::$law(law) => ConstitutiveLaw::elastic_energy(law, stress, internal),)* }
            }

            /// [`ConstitutiveLaw::PLASTIC_FALLS`]
            pub fn plastic_falls(&self) -> bool {
                match self { $(Law::$law(_) => <$law as ConstitutiveLaw>::PLASTIC_FALLS,)* }
            }

            /// [`ConstitutiveLaw::STIFFENS`]
            pub fn stiffens(&self) -> bool {
                match self { $(Law::$law(_) => <$law as ConstitutiveLaw>::STIFFENS,)* }
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

        macro_rules! with_law {
            ($d law:expr, $d own:ident => $d body:expr) => {
                match $d law {
                    $($crate::mpm::law::Law::$law($d own) => $d body,)*
                }
            };
        }
        pub(crate) use with_law;
    };
}

constitutive_laws! { ($)
    /// Linear elasticity.
    Elastic = "elastic", "linear elasticity", gpu: Ok(0);
    /// Drucker–Prager with a tension cut-off, hardening and softening.
    DruckerPrager = "drucker_prager", "elastic up to a cone of failure, which may harden and soften", gpu: Ok(1);
    /// Mohr–Coulomb with an exact return.
    MohrCoulomb = "mohr_coulomb", "elastic up to the pyramid of Mohr-Coulomb, which may harden and soften", gpu: Ok(2);
    /// Modified Cam-clay.
    CamClay = "cam_clay", "Modified Cam-clay: stiffness that goes with the pressure, and an ellipse that plastic compression makes larger", gpu: Ok(3);
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

    /// Poisson's ratio, -.
    pub fn poisson(&self) -> f64 {
        self.elastic().poisson()
    }

    /// Elastic moduli under an isotropic pressure, Pa, before any plastic strain.
    pub fn under(&self, pressure: f64) -> Elastic {
        self.stiffness(&[-pressure, -pressure, -pressure, 0.0, 0.0, 0.0], InternalVariables::default())
    }

    /// Speed of compression waves, m/s, in a material of this density, kg/m³, at this stress, Pa, and these internal variables.
    pub fn wave_speed_at(&self, density: f64, stress: &Sym, internal: InternalVariables) -> f64 {
        (self.stiffness(stress, internal).oedometric() / density).sqrt()
    }

    /// Speed of compression waves, m/s, in a material of this density, kg/m³, with the moduli of [`Law::elastic`]. Plastic flow makes it smaller, never larger.
    pub fn wave_speed(&self, density: f64) -> f64 {
        (self.elastic().oedometric() / density).sqrt()
    }
}
