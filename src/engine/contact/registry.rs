//! The list of contact laws. To add one, write a type in a file of [`super::law`] and a line in the list below; from that line follow the word and the keys in
//! scene files, their checks, and the calls. A program that uses the engine as a library can pass a law of its own as [`ContactLaw::Custom`].

use super::chunk::Chunk;
use super::force::Rules;
use super::law::{Elastic, Law};
use super::pair::{CoefficientsOf, Pair, PairTable};
use super::pairs::Pairs;
use super::{sweep, wall_sweep};
use crate::boundary::Wall;
use crate::grains::Grains;
use crate::material::Material;
use crate::parameter::{Parameter, Values};

/// Constants and functions of one law behind pointers, so that code need not know its type. A run calls through them once per sweep, not once per contact.
#[derive(Debug)]
pub struct LawTable {
    /// [`Law::PARAMETERS`]
    pub parameters: &'static [Parameter],
    /// [`Law::HERTZIAN`]
    pub hertzian: bool,
    /// [`Law::VISCOUS`]
    pub viscous: bool,
    /// [`Law::INHERITED`]
    pub inherited: bool,
    /// [`Law::PLASTIC`]
    pub plastic: bool,
    /// [`Law::coefficients`]
    pub coefficients: CoefficientsOf,
    /// [`Law::elastic`]
    pub elastic: fn(f64, f64, f64, &Pair) -> Elastic,
    /// [`Law::overlap_under`]
    pub overlap_under: fn(f64, f64, &Pair) -> f64,
    /// [`Law::restitution`]
    pub restitution: fn(&Values) -> f64,
    /// [`Law::free_step`]
    pub free_step: fn(&Material, f64, f64, f64) -> f64,
    /// [`sweep::grains`]
    pub sweep_grains: fn(bool, &PairTable, &Rules, &Grains, Chunk<'_>),
    /// [`wall_sweep::walls`]
    pub sweep_walls: fn(&PairTable, &Rules, &Grains, &[Wall], &mut Pairs),
}

impl LawTable {
    /// The table of the law `L`.
    pub const fn of<L: Law>() -> LawTable {
        LawTable {
            parameters: L::PARAMETERS,
            hertzian: L::HERTZIAN,
            viscous: L::VISCOUS,
            inherited: L::INHERITED,
            plastic: L::PLASTIC,
            coefficients: L::coefficients,
            elastic: L::elastic::<f64>,
            overlap_under: L::overlap_under,
            restitution: L::restitution,
            free_step: L::free_step,
            sweep_grains: sweep::grains::<L>,
            sweep_walls: wall_sweep::walls::<L>,
        }
    }
}

/// Writes the enumeration [`ContactLaw`] with its functions from the list of laws, and the macro `with_law!`, which runs `$body` with the name `$L` standing for
/// the type of a law.
macro_rules! contact_laws {
    (($d:tt) $($(#[$doc:meta])* $law:ident = $word:literal, $meaning:literal, gpu: $gpu:expr;)*) => {
        /// The law of every contact of a run.
        #[derive(Clone, Copy, Debug)]
        pub enum ContactLaw {
            $($(#[$doc])* $law,)*
            /// A law of the program that uses the engine as a library. It acts between spheres and walls only, not on other shapes or material points.
            Custom(&'static LawTable),
        }

        impl ContactLaw {
            /// The words for the laws in scene files.
            pub const WORDS: &'static [&'static str] = &[$($word),*];
            /// All laws that scene files can name, in the order of their words.
            pub const ALL: &'static [ContactLaw] = &[$(ContactLaw::$law),*];

            /// The word for the law in scene files.
            pub fn word(self) -> &'static str {
                match self {
                    $(ContactLaw::$law => $word,)*
                    ContactLaw::Custom(_) => "custom",
                }
            }

            /// What the law is, in a few words.
            pub fn meaning(self) -> &'static str {
                match self {
                    $(ContactLaw::$law => $meaning,)*
                    ContactLaw::Custom(_) => "a law of the calling program",
                }
            }

            /// The law's functions. A table is a `static`, which the engine alone compiles; as a constant it would make every crate that calls this function
            /// compile the sweeps of all laws again.
            #[inline]
            pub fn table(self) -> &'static LawTable {
                match self {
                    $(ContactLaw::$law => {
                        static TABLE: LawTable = LawTable::of::<super::law::$law>();
                        &TABLE
                    })*
                    ContactLaw::Custom(table) => table,
                }
            }

            /// Number of the law in shaders; or, for a law that shaders do not have, which to use instead on a graphics device.
            pub fn on_gpu(self) -> Result<u32, &'static str> {
                match self {
                    $(ContactLaw::$law => $gpu,)*
                    ContactLaw::Custom(_) => Err("use hertz"),
                }
            }
        }

        macro_rules! with_law {
            ($d law:expr, $d L:ident => $d body:expr) => {
                match $d law {
                    $($crate::contact::ContactLaw::$law => {
                        type $d L = $crate::contact::law::$law;
                        $d body
                    })*
                    $crate::contact::ContactLaw::Custom(_) => unreachable!("a custom contact law acts between spheres and walls only"),
                }
            };
        }
        pub(crate) use with_law;
    };
}

contact_laws! { ($)
    /// Linear: Ciantia et al. 2015 eq. (13).
    Linear = "linear", "force in proportion to the overlap (eq. 13)", gpu: Ok(0);
    /// As `Linear`, but fragments keep the stiffness of the initial grain they come from.
    LinearInherited = "linear_inherited", "linear, and fragments keep the stiffness of the initial grain that they come from", gpu: Ok(0);
    /// Hertz–Mindlin: Ciantia et al. 2015 eq. (14); Li et al. 2023 eqs (20), (21) for pairs of different materials.
    Hertz = "hertz", "Hertz-Mindlin (eq. 14)", gpu: Ok(1);
    /// Hertz–Mindlin with viscous damping: Li et al. 2023 eqs (18)-(21).
    HertzViscous = "hertz_viscous", "Hertz-Mindlin with viscous damping", gpu: Ok(2);
    /// As `HertzViscous`, but the normal force ends where it would turn tensile, with the damping that gives the same restitution.
    HertzViscousNoTension = "hertz_viscous_no_tension", "hertz_viscous without tension: the normal force ends where it would turn tensile, so that the friction of a sliding contact is mu times the normal impulse at any restitution", gpu: Err("use hertz_viscous");
    /// Elastic–perfectly plastic with a restitution that falls with the speed: Thornton 1997.
    ElastoPlastic = "elasto_plastic", "Hertz-Mindlin until the contact yields, then plastic (Thornton 1997): the restitution falls with the speed of impact", gpu: Err("use hertz");
    /// Linear spring and dashpot with stiffnesses as given: Jiang et al. 2020 eq. (43).
    Spring = "spring", "spring and dashpot with stiffnesses as given, whatever the size of the grains; in plane strain per metre of depth", gpu: Err("use linear");
}

impl PartialEq for ContactLaw {
    fn eq(&self, other: &ContactLaw) -> bool {
        match (self, other) {
            (ContactLaw::Custom(a), ContactLaw::Custom(b)) => std::ptr::eq(*a, *b),
            (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
        }
    }
}

impl Eq for ContactLaw {}

impl ContactLaw {
    /// The law with this word; `None` where there is none.
    pub fn named(word: &str) -> Option<ContactLaw> {
        ContactLaw::ALL.iter().copied().find(|law| law.word() == word)
    }

    /// Whether the law adds viscous forces.
    pub fn is_viscous(self) -> bool {
        self.table().viscous
    }

    /// Whether force and contact area follow from the elastic moduli of the grains, as in Hertz's theory.
    pub fn is_hertzian(self) -> bool {
        self.table().hertzian
    }

    /// Force, stiffness and energy at an overlap above 0 ([`Law::elastic`]).
    #[inline]
    pub fn elastic(self, overlap: f64, largest: f64, r_eff: f64, pair: &Pair) -> Elastic {
        (self.table().elastic)(overlap, largest, r_eff, pair)
    }

    /// Overlap, m, at which a contact loaded for the first time has the normal force `force`, N.
    pub fn overlap_under(self, force: f64, r_eff: f64, pair: &Pair) -> f64 {
        (self.table().overlap_under)(force, r_eff, pair)
    }

    /// Parameters of the contacts between two materials.
    pub fn between(self, m1: &Material, m2: &Material) -> Pair {
        Pair::between(self.table().coefficients, m1, m2)
    }

    /// Parameters of the contacts of a material with a rigid wall that has its own coefficient of friction.
    pub fn on_wall(self, m: &Material, friction: f64) -> Pair {
        Pair::on_wall(self.table().coefficients, m, friction)
    }

    /// Parameters of all contacts of a run; `friction`, where given, replaces the friction between grains (during preparation).
    pub fn pairs(self, materials: &[Material], walls: &[Wall], friction: Option<f64>) -> PairTable {
        PairTable::new(self.table().coefficients, materials, walls, friction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_names_one_law_and_parameters_fit_their_array() {
        for (k, law) in ContactLaw::ALL.iter().enumerate() {
            assert_eq!(ContactLaw::named(law.word()), Some(*law));
            assert_eq!(ContactLaw::WORDS[k], law.word());
            assert!(law.table().parameters.len() <= crate::parameter::MOST_PARAMETERS);
            assert_eq!(ContactLaw::ALL.iter().filter(|other| *other == law).count(), 1, "{}", law.word());
        }
        assert_eq!(ContactLaw::named("hert"), None);
    }

    /// A force found for an overlap leads back to the overlap, for every law.
    #[test]
    fn the_overlap_under_a_force_is_the_one_that_gives_it() {
        let material = |law: ContactLaw| Material {
            name: "glass".into(),
            density: 2500.0,
            internal_porosity: 0.0,
            young: 50e9,
            poisson: 0.2,
            friction: 0.3,
            rolling_friction: 0.0,
            interface_friction: None,
            contact: std::array::from_fn(|k| match law.table().parameters.get(k).map(|p| p.key) {
                Some("linear.K_eff_MPa") => 1e9,
                Some("contact.yield_pressure_MPa") => 2e9,
                Some(_) => 0.5,
                None => 0.0,
            }),
        };
        for &law in ContactLaw::ALL {
            let pair = law.between(&material(law), &material(law));
            for overlap in [1e-9, 1e-7, 1e-5] {
                let force = law.elastic(overlap, overlap, 1e-3, &pair).force;
                let found = law.overlap_under(force, 1e-3, &pair);
                assert!((found / overlap - 1.0).abs() < 1e-12, "{}: {found} {overlap}", law.word());
            }
        }
    }
}
