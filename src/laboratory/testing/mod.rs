//! The laboratory tests on a cylindrical specimen of grains. A test is a folder here whose state implements [`SpecimenTest`], and
//! a line in `registry.rs`. A run prepares the specimen, makes the steps of the test until it is over, and writes the records.
//!
//! (Unit tests of this crate stand beside what they test, or in the workspace's `tests/`.)

pub mod isotropic;
pub mod oedometer;
mod registry;
pub mod triaxial;

pub use registry::Test;

use crate::error::Error;
use crate::model::{Model, Specimen};
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::record::quasi_static::Instant;
use crate::scene::material::Named;
use crate::scene::view::View;
use engine::boundary::CylinderSpace;
use engine::check::Checked;
use engine::dem::{self, State, Workspace};
use engine::grains::Grains;
use engine::mpm::Continuum;
use serde_json::Value;

/// The state of a laboratory test on a specimen of grains.
pub trait SpecimenTest: Sized {
    /// The model of the test, with its specimen.
    type Rig;

    /// Starts the test with a prepared specimen, at rest in the space `size`. Gives the test and the first state of the grains:
    /// strengths drawn, contacts without history.
    ///
    /// # Errors
    /// A rig that cannot be used with this specimen.
    fn start(model: &Model, rig: &Self::Rig, grains: Grains, size: CylinderSpace) -> Result<(Self, State), Error>;

    /// First part of a step: computes the forces of this instant.
    fn compute_forces(&mut self, model: &Model, state: &mut State, work: &mut Workspace) {
        dem::compute_forces(&model.physics, state, work);
    }

    /// Second part of a step: sets target and phase from the forces of this instant.
    ///
    /// # Errors
    /// A specimen that cannot be tested.
    fn programme(&mut self, model: &Model, rig: &Self::Rig, state: &mut State, work: &Workspace) -> Result<(), Error>;

    /// Third part of a step: sets the speeds of the walls, and counts the step.
    fn servo(&mut self, rig: &Self::Rig, state: &mut State);

    /// Last part of a step: moves grains and walls, and breaks grains.
    ///
    /// # Errors
    /// A step that cannot be made.
    fn integrate(&mut self, model: &Model, state: &mut State, work: &mut Workspace) -> Result<(), Error> {
        dem::integrate(&model.physics, state, work);
        Ok(())
    }

    /// One step, all its parts. `observe` is called when the forces of the step are known and before grains move.
    ///
    /// # Errors
    /// A specimen that cannot be tested; the errors of `observe`.
    fn advance(
        &mut self,
        model: &Model,
        rig: &Self::Rig,
        state: &mut State,
        work: &mut Workspace,
        observe: &mut dyn FnMut(&Self, &State, &Workspace) -> Result<(), Error>,
    ) -> Result<(), Error> {
        self.compute_forces(model, state, work);
        self.programme(model, rig, state, work)?;
        observe(self, state, work)?;
        self.servo(rig, state);
        self.integrate(model, state, work)
    }

    /// Whether the specimen still comes to rest before the programme begins.
    fn settles(&self) -> bool;

    /// Checks a test from a checkpoint, with its grains.
    ///
    /// # Errors
    /// What is wrong, in words.
    fn check(&self, model: &Model, rig: &Self::Rig, state: &State) -> Checked;

    /// Whether the programme is done.
    fn is_over(&self) -> bool;

    /// The record that is due now; `None`: none is.
    fn due(&self, model: &Model, rig: &Self::Rig, recorder: &mut Recorder, state: &State) -> Option<Due>;

    /// Target and value of the stress under servo, if the summary says how well it was held over every step.
    fn held(&self, _rig: &Self::Rig, _state: &State) -> Option<Instant> {
        None
    }

    /// The measures of the test for a row of the history.
    fn moment(&self, rig: &Self::Rig, state: &State) -> Moment;

    /// Present target of the vertical stress, Pa: a breakage is compared with it. `None`: the test has none.
    fn target(&self) -> Option<f64> {
        None
    }

    /// The material points from breakages, where the lost mass becomes points.
    fn fines(&self) -> Option<&Continuum> {
        None
    }

    /// Share of the programme that is done, 0 to 1, and a line for the progress bar.
    fn describe(&self, rig: &Self::Rig, state: &State) -> (f64, String);

    /// Puts the test's own entries into the summary.
    fn summary(&self, rig: &Self::Rig, recorder: &Recorder, put: &mut dyn FnMut(&str, Value));

    /// The specimen of the rig.
    fn specimen(rig: &Self::Rig) -> &Specimen;

    /// As [`SpecimenTest::specimen`], to be changed.
    fn specimen_mut(rig: &mut Self::Rig) -> &mut Specimen;

    /// Largest stress, Pa, that the rig puts on its specimen, or about that: for what `check` tells before a run.
    fn largest_stress(rig: &Self::Rig) -> f64;

    /// The rig from the keys of a scene; `None` with the reasons noted where they do not agree.
    fn of_scene(view: &View<'_>, named: &[Named]) -> Option<Self::Rig>;
}
