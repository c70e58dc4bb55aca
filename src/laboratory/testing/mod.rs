//! The laboratory tests on a cylindrical specimen of grains. A test is a folder here whose state implements [`SpecimenTest`], and a line in [`registry`]; a run prepares the
//! specimen, then steps the test until it is over and writes what it reports.
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
use engine::boundary::CylinderSpace;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use engine::mpm::Continuum;
use serde_json::Value;

/// The state of a laboratory test on a specimen of grains.
pub trait SpecimenTest: Sized {
    /// What the scene says of it.
    type Rig;

    /// The test of a prepared specimen, and the state from which it starts: strengths drawn, no history, at rest.
    ///
    /// # Errors
    /// A rig that this specimen does not allow.
    fn start(model: &Model, rig: &Self::Rig, grains: Grains, size: CylinderSpace) -> Result<(Self, State), Error>;

    /// One step; `observe` sees the state when its forces are known.
    ///
    /// # Errors
    /// A specimen that cannot be tested; what `observe` returns.
    fn advance(
        &mut self,
        model: &Model,
        rig: &Self::Rig,
        state: &mut State,
        work: &mut Workspace,
        observe: &mut dyn FnMut(&Self, &State, &Workspace) -> Result<(), Error>,
    ) -> Result<(), Error>;

    /// Whether the programme has come to its end.
    fn is_over(&self) -> bool;

    /// Whether a record is due now.
    fn due(&self, model: &Model, rig: &Self::Rig, recorder: &mut Recorder, state: &State) -> Option<Due>;

    /// What a servo is to hold and holds now, where that is watched over every step.
    fn held(&self, _rig: &Self::Rig, _state: &State) -> Option<Instant> {
        None
    }

    /// This instant, for a row of the history, with the test's own columns.
    fn moment(&self, rig: &Self::Rig, state: &State) -> Moment;

    /// Vertical stress, Pa, that the programme asks for now, beside which breakages are recorded.
    fn target(&self) -> Option<f64> {
        None
    }

    /// The continuum of fines, where breakages make one.
    fn fines(&self) -> Option<&Continuum> {
        None
    }

    /// Share of the programme done, 0 to 1, and a line for the progress bar.
    fn describe(&self, rig: &Self::Rig, state: &State) -> (f64, String);

    /// The test's own entries of the summary.
    fn summary(&self, rig: &Self::Rig, recorder: &Recorder, put: &mut dyn FnMut(&str, Value));

    /// The specimen of a rig.
    fn specimen(rig: &Self::Rig) -> &Specimen;
}
