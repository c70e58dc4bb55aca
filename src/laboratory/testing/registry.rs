//! The list of all tests on a specimen: a line for each, named as the variant of [`Rig`] that describes it.

use super::isotropic::Isotropic;
use super::oedometer::Loading;
use super::triaxial::Shearing;
use super::{Instant, SpecimenTest};
use crate::error::Error;
use crate::model::continuum::Growth;
use crate::model::{Model, Rig, Specimen, Subject};
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::scene::material::Named;
use crate::scene::view::View;
use engine::boundary::CylinderSpace;
use engine::check::Checked;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use engine::mpm::Continuum;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Makes the enumeration of tests, whose methods call those of the test that is running, with its rig.
macro_rules! specimen_tests {
    ($($(#[$doc:meta])* $test:ident($state:ident) = $word:literal;)*) => {
        /// A test that is running. Its methods are those of [`SpecimenTest`]; the rig given to them must be that of the test.
        #[derive(Debug, Serialize, Deserialize)]
        pub enum Test {
            $($(#[$doc])* $test($state),)*
        }

        impl Test {
            /// [`SpecimenTest::start`] of the model's rig.
            ///
            /// # Errors
            /// A rig that cannot be used with this specimen.
            pub fn start(model: &Model, grains: Grains, size: CylinderSpace) -> Result<(Test, State), Error> {
                match &model.rig {
                    $(Rig::$test(rig) => <$state as SpecimenTest>::start(model, rig, grains, size).map(|(test, state)| (Test::$test(test), state)),)*
                    Rig::Assembly(_) | Rig::GrainCrushing(_) | Rig::Continuum(_) => unreachable!("no specimen of grains"),
                }
            }

            /// [`SpecimenTest::advance`]
            ///
            /// # Errors
            /// A specimen that cannot be tested; the errors of `observe`.
            pub fn advance(
                &mut self,
                model: &Model,
                state: &mut State,
                work: &mut Workspace,
                observe: &mut dyn FnMut(&Observed<'_>, &State, &Workspace) -> Result<(), Error>,
            ) -> Result<(), Error> {
                match (self, &model.rig) {
                    $((Test::$test(test), Rig::$test(rig)) => SpecimenTest::advance(test, model, rig, state, work, &mut |test, state, work| {
                        observe(&Observed::$test(test, rig), state, work)
                    }),)*
                    _ => unreachable!("a test belongs to its rig"),
                }
            }

            /// [`SpecimenTest::compute_forces`]
            pub fn compute_forces(&mut self, model: &Model, state: &mut State, work: &mut Workspace) {
                match self { $(Test::$test(test) => SpecimenTest::compute_forces(test, model, state, work),)* }
            }

            /// [`SpecimenTest::programme`]
            ///
            /// # Errors
            /// A specimen that cannot be tested.
            pub fn programme(&mut self, model: &Model, state: &mut State, work: &Workspace) -> Result<(), Error> {
                match (self, &model.rig) {
                    $((Test::$test(test), Rig::$test(rig)) => SpecimenTest::programme(test, model, rig, state, work),)*
                    _ => unreachable!("a test belongs to its rig"),
                }
            }

            /// [`SpecimenTest::servo`]
            pub fn servo(&mut self, rig: &Rig, state: &mut State) {
                match (self, rig) {
                    $((Test::$test(test), Rig::$test(rig)) => SpecimenTest::servo(test, rig, state),)*
                    _ => unreachable!("a test belongs to its rig"),
                }
            }

            /// [`SpecimenTest::integrate`]
            ///
            /// # Errors
            /// A step that cannot be made.
            pub fn integrate(&mut self, model: &Model, state: &mut State, work: &mut Workspace) -> Result<(), Error> {
                match self { $(Test::$test(test) => SpecimenTest::integrate(test, model, state, work),)* }
            }

            /// [`SpecimenTest::settles`]
            pub fn settles(&self) -> bool {
                match self { $(Test::$test(test) => SpecimenTest::settles(test),)* }
            }

            /// [`SpecimenTest::fines`]
            pub fn fines(&self) -> Option<&Continuum> {
                match self { $(Test::$test(test) => SpecimenTest::fines(test),)* }
            }

            /// [`SpecimenTest::moment`]
            pub fn moment(&self, rig: &Rig, state: &State) -> Moment {
                match (self, rig) {
                    $((Test::$test(test), Rig::$test(rig)) => SpecimenTest::moment(test, rig, state),)*
                    _ => unreachable!("a test belongs to its rig"),
                }
            }

            /// [`SpecimenTest::check`] against the model's rig.
            ///
            /// # Errors
            /// What is wrong, in words.
            pub fn check(&self, model: &Model, state: &State) -> Checked {
                match (self, &model.rig) {
                    $((Test::$test(test), Rig::$test(rig)) => SpecimenTest::check(test, model, rig, state),)*
                    _ => Err("it is of another kind of test".into()),
                }
            }

            /// [`SpecimenTest::is_over`]
            pub fn is_over(&self) -> bool {
                match self { $(Test::$test(test) => SpecimenTest::is_over(test),)* }
            }

            /// [`SpecimenTest::target`]
            pub fn target(&self) -> Option<f64> {
                match self { $(Test::$test(test) => SpecimenTest::target(test),)* }
            }

            /// [`SpecimenTest::describe`]
            pub fn describe(&self, rig: &Rig, state: &State) -> (f64, String) {
                match (self, rig) {
                    $((Test::$test(test), Rig::$test(rig)) => test.describe(rig, state),)*
                    _ => unreachable!("a test belongs to its rig"),
                }
            }

            /// [`SpecimenTest::summary`]
            pub fn summary(&self, rig: &Rig, recorder: &Recorder, put: &mut dyn FnMut(&str, Value)) {
                match (self, rig) {
                    $((Test::$test(test), Rig::$test(rig)) => test.summary(rig, recorder, put),)*
                    _ => unreachable!("a test belongs to its rig"),
                }
            }
        }

        /// A test and its rig, at the moment of a step when the forces are known and grains have not moved.
        pub enum Observed<'a> {
            $($(#[$doc])* $test(&'a $state, &'a <$state as SpecimenTest>::Rig),)*
        }

        impl Observed<'_> {
            /// [`SpecimenTest::due`]
            pub fn due(&self, model: &Model, recorder: &mut Recorder, state: &State) -> Option<Due> {
                match self { $(Observed::$test(test, rig) => SpecimenTest::due(*test, model, rig, recorder, state),)* }
            }

            /// [`SpecimenTest::held`]
            pub fn held(&self, state: &State) -> Option<Instant> {
                match self { $(Observed::$test(test, rig) => SpecimenTest::held(*test, rig, state),)* }
            }

            /// [`SpecimenTest::moment`]
            pub fn moment(&self, state: &State) -> Moment {
                match self { $(Observed::$test(test, rig) => SpecimenTest::moment(*test, rig, state),)* }
            }

            /// [`SpecimenTest::fines`]
            pub fn fines(&self) -> Option<&Continuum> {
                match self { $(Observed::$test(test, _) => SpecimenTest::fines(*test),)* }
            }
        }

        impl Rig {
            /// What the rig works on.
            pub fn subject(&self) -> Subject<'_> {
                match self {
                    $(Rig::$test(rig) => Subject::Specimen(<$state as SpecimenTest>::specimen(rig)),)*
                    Rig::Assembly(rig) => Subject::Assembly(rig),
                    Rig::GrainCrushing(rig) => Subject::GrainCrushing(rig),
                    Rig::Continuum(rig) => Subject::Continuum(rig),
                }
            }

            /// The cylindrical specimen of grains; `None` for tests that have none.
            pub fn specimen(&self) -> Option<&Specimen> {
                if let Subject::Specimen(specimen) = self.subject() { Some(specimen) } else { None }
            }

            /// How the specimen of a mixture grows; `None` for all others.
            pub fn growth(&self) -> Option<&Growth> {
                if let Rig::Continuum(rig) = self { rig.growth.as_ref() } else { None }
            }

            /// As [`Rig::specimen`], to be changed.
            pub fn specimen_mut(&mut self) -> Option<&mut Specimen> {
                match self {
                    $(Rig::$test(rig) => Some(<$state as SpecimenTest>::specimen_mut(rig)),)*
                    Rig::Assembly(_) | Rig::GrainCrushing(_) | Rig::Continuum(_) => None,
                }
            }

            /// [`SpecimenTest::largest_stress`], Pa; `None` where no specimen is tested.
            pub fn largest_stress(&self) -> Option<f64> {
                match self {
                    $(Rig::$test(rig) => Some(<$state as SpecimenTest>::largest_stress(rig)),)*
                    Rig::Assembly(_) | Rig::GrainCrushing(_) | Rig::Continuum(_) => None,
                }
            }

            /// The rig of the test of this word, from its keys: `None` if no test has it, `Some(None)` with the reasons noted where its keys do not agree.
            pub(crate) fn of_test(word: &str, view: &View<'_>, named: &[Named]) -> Option<Option<Rig>> {
                match word {
                    $($word => Some(<$state as SpecimenTest>::of_scene(view, named).map(Rig::$test)),)*
                    _ => None,
                }
            }
        }
    };
}

specimen_tests! {
    /// One-dimensional compression in a ring.
    Oedometer(Loading) = "oedometer";
    /// Drained triaxial compression at constant cell pressure.
    Triaxial(Shearing) = "triaxial";
    /// Compression from all sides.
    Isotropic(Isotropic) = "isotropic";
}
