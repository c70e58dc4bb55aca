//! The list of failure criteria. To add one, write a type in a file of [`super::criterion`] and a line in the list below; from that line follow the word in scene
//! files, the keys of materials, their checks, and the calls.

use super::criterion::{self, FailureCriterion, Judges, MeanStress};
use crate::parameter::{Parameter, Values};

/// Writes the enumeration [`Criterion`] with its functions from the list of criteria.
macro_rules! criteria {
    ($($(#[$doc:meta])* $criterion:ident = $word:literal, $meaning:literal, gpu: $gpu:expr;)*) => {
        /// The failure criterion of the grains of a run.
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub enum Criterion {
            $($(#[$doc])* $criterion(criterion::$criterion),)*
        }

        impl Criterion {
            /// The words for the criteria in scene files; a material has the strengths for a criterion in the table of the same name.
            pub const WORDS: &'static [&'static str] = &[$($word),*];
            /// What each criterion is, in a few words, in the order of their words.
            pub const MEANINGS: &'static [&'static str] = &[$($meaning),*];
            /// The parameters that each criterion needs of a material, in the order of their words.
            pub const PARAMETERS: &'static [&'static [Parameter]] = &[$(<criterion::$criterion as FailureCriterion>::PARAMETERS),*];

            /// The criterion with this word and with these values of its parameters; `None` where there is none.
            pub fn named(word: &str, values: &Values) -> Option<Criterion> {
                match word {
                    $($word => Some(Criterion::$criterion(FailureCriterion::of(values))),)*
                    _ => None,
                }
            }

            /// The word for the criterion in scene files.
            pub fn word(&self) -> &'static str {
                match self { $(Criterion::$criterion(_) => $word,)* }
            }

            /// What the criterion is, in a few words.
            pub fn meaning(&self) -> &'static str {
                match self { $(Criterion::$criterion(_) => $meaning,)* }
            }

            /// Ok where shaders have the criterion; otherwise which to use instead on a graphics device.
            pub fn on_gpu(&self) -> Result<(), &'static str> {
                match self { $(Criterion::$criterion(_) => $gpu,)* }
            }

            /// [`FailureCriterion::JUDGES`]
            pub fn judges(&self) -> Judges {
                fn of<C: FailureCriterion>(_: &C) -> Judges { C::JUDGES }
                match self { $(Criterion::$criterion(c) => of(c),)* }
            }

            /// [`FailureCriterion::WEIGHTED`]
            pub fn is_weighted(&self) -> bool {
                fn of<C: FailureCriterion>(_: &C) -> bool { C::WEIGHTED }
                match self { $(Criterion::$criterion(c) => of(c),)* }
            }

            /// [`FailureCriterion::weighs_radius`]
            pub fn weighs_radius(&self) -> bool {
                match self { $(Criterion::$criterion(c) => c.weighs_radius(),)* }
            }

            /// [`FailureCriterion::POWER`]
            pub fn power(&self) -> u32 {
                fn of<C: FailureCriterion>(_: &C) -> u32 { C::POWER }
                match self { $(Criterion::$criterion(c) => of(c),)* }
            }

            /// [`FailureCriterion::threshold`]
            pub fn threshold(&self, sigma_lim: f64, d: f64) -> f64 {
                match self { $(Criterion::$criterion(c) => c.threshold(sigma_lim, d),)* }
            }

            /// [`FailureCriterion::load_weight`]
            pub fn load_weight(&self, r_eff: f64, e_eff: f64) -> f64 {
                match self { $(Criterion::$criterion(c) => c.load_weight(r_eff, e_eff),)* }
            }

            /// [`FailureCriterion::equivalent_stress`]
            pub fn equivalent_stress(&self, stress: &MeanStress) -> f64 {
                match self { $(Criterion::$criterion(c) => c.equivalent_stress(stress),)* }
            }

            /// [`FailureCriterion::limit_force`]
            pub fn limit_force(&self, sigma_lim: f64, d: f64, r_eff: f64, e_eff: f64) -> f64 {
                match self { $(Criterion::$criterion(c) => c.limit_force(sigma_lim, d, r_eff, e_eff),)* }
            }

            /// [`FailureCriterion::plane_area`]
            pub fn plane_area(&self, d: f64) -> Option<f64> {
                match self { $(Criterion::$criterion(c) => c.plane_area(d),)* }
            }

            /// [`FailureCriterion::area`]
            pub fn area(&self, force: f64, d: f64, r_eff: f64, e_eff: f64) -> f64 {
                match self { $(Criterion::$criterion(c) => c.area(force, d, r_eff, e_eff),)* }
            }
        }
    };
}

criteria! {
    /// Contact force over a fixed contact area: Ciantia et al. 2015 eqs (5), (8).
    FixedAngle = "fixed_angle", "force of a contact over a contact area of fixed angle (eq. 8)", gpu: Ok(());
    /// Contact force over Hertz's area of the contact: Ciantia et al. 2015 eqs (5), (9).
    HertzArea = "hertz_area", "force of a contact over its own Hertzian area (eq. 9)", gpu: Ok(());
    /// Deviatoric stress of the grain's mean stress.
    VonMises = "von_mises", "deviatoric stress q of the grain's mean stress", gpu: Err("use fixed_angle");
    /// Mohr–Coulomb on the grain's mean stress.
    MohrCoulomb = "mohr_coulomb", "Mohr-Coulomb on the grain's mean stress", gpu: Err("use fixed_angle");
    /// Christensen's two-parameter criterion on the grain's mean stress.
    Christensen = "christensen", "Christensen's two-parameter criterion (2000) on the grain's mean stress", gpu: Err("use fixed_angle");
}

#[cfg(test)]
impl Criterion {
    /// One of each, with parameters inside their ranges.
    pub fn examples() -> impl Iterator<Item = Criterion> {
        Criterion::WORDS.iter().filter_map(|word| Criterion::named(word, &[0.35, 0.0, 0.0, 0.0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_names_one_criterion() {
        assert_eq!(Criterion::examples().map(|c| c.word()).collect::<Vec<_>>(), Criterion::WORDS);
        for (word, parameters) in Criterion::WORDS.iter().zip(Criterion::PARAMETERS) {
            assert!(parameters.iter().all(|p| p.key.starts_with(&format!("strength.{word}."))), "{word}");
        }
        assert_eq!(Criterion::named("hertz", &Values::default()), None);
    }
}
