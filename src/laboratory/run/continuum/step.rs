//! One step of a continuum or mixture with all that belongs to it: forces, time step, programme, the records that are due, motion, breakages, and the looks that end a test which has lost its
//! meaning. A run, and a program that makes the steps itself, take it from here.

use super::super::{LOOK, multiplies, watch};
use crate::error::Result;
use crate::model::Model;
use crate::model::continuum::MpmTest;
use crate::record::continuum::Recorder;
use crate::record::crushed::Crushed;
use crate::rig::continuum::{Engine, Phase, State};
use engine::boundary::Drive;
use table::Row;

/// A test that moves, with all that a step needs.
pub struct Moving<'a> {
    /// The model.
    pub model: &'a Model,
    /// The test, with the specimen that has grown.
    pub rig: &'a MpmTest,
    /// Points, grains, bodies and loading plates.
    pub state: &'a mut State,
    /// Who makes the steps.
    pub engine: &'a mut Engine,
    /// The state of the records.
    pub recorder: &'a mut Recorder,
    /// What is known of breakages.
    pub crushed: &'a mut Crushed,
    /// What is known of earlier steps.
    pub looks: &'a mut Looks,
}

/// What steps need to know of those before them; no checkpoint keeps it.
#[derive(Debug, Default)]
pub struct Looks {
    /// [`watch::first_step_of_points`].
    first_step: f64,
    /// Number of grains at the last look at all of them.
    looked_at: usize,
    /// Whether this instant has a row, so that a device's points are known.
    recorded: bool,
}

impl Looks {
    /// At the first step that is made here.
    pub fn new(model: &Model, rig: &MpmTest, state: &State) -> Looks {
        Looks { first_step: watch::first_step_of_points(model, rig), looked_at: grains(state), recorded: false }
    }
}

/// Who moves walls and loading plates, and until when.
#[derive(Clone, Debug, Default)]
pub struct Lead {
    /// What a program has told each loading plate of a specimen, instead of the programme of the test; then no row is due by itself. `None`: the programme.
    pub told: Option<Vec<Drive>>,
    /// Whether steps go on beyond the end of the programme.
    pub beyond: bool,
}

/// Who keeps the records of a test.
pub trait Records {
    /// Takes the row of the history for this instant.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn row(&mut self, at: &mut Moving<'_>, row: Row) -> Result<()>;

    /// Keeps bodies, joints and walls at a row, once it is known that the test still means something.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn bodies(&mut self, _: &Moving<'_>) -> Result<()> {
        Ok(())
    }

    /// Keeps snapshots and gradations of this instant.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn frame(&mut self, _: &mut Moving<'_>) -> Result<()> {
        Ok(())
    }

    /// Takes the breakages since it was last asked.
    ///
    /// # Errors
    /// A file that cannot be written.
    fn breakages(&mut self, at: &mut Moving<'_>) -> Result<()>;
}

/// Number of grains.
fn grains(state: &State) -> usize {
    state.mixture.as_ref().map_or(0, |mixture| mixture.grains.grains.len())
}

impl Moving<'_> {
    /// First part of a step: forces, time step and programme, and the records that are due. Gives the share of the test at which the next look is needed.
    ///
    /// # Errors
    /// Those of [`State::advance`], and a state that means nothing any more; the errors of `records`.
    pub fn look(&mut self, lead: &Lead, records: &mut impl Records) -> Result<f64> {
        self.state.look(self.model, self.rig, self.engine, lead.told.as_deref())?;
        if lead.beyond && self.state.phase == Phase::Done {
            self.state.phase = Phase::Load;
        }
        watch::slow_points(self.model, self.state, self.looks.first_step)?;
        self.looks.recorded = false;
        if lead.told.is_some() {
            return Ok(1.0);
        }
        let due = self.recorder.due(self.rig, self.state);
        if due.row {
            self.looks.recorded = true;
            self.engine.read_back(self.state, self.model)?;
            let row = self.row()?;
            records.row(self, row)?;
            watch::continuum(self.rig, self.state, self.recorder)?;
            records.bodies(self)?;
        }
        if due.frame {
            records.frame(self)?;
        }
        Ok(self.recorder.next(self.rig, self.state))
    }

    /// The row of the history for this instant; means over steps begin anew.
    ///
    /// # Errors
    /// Those of [`Crushed::columns`].
    pub fn row(&mut self) -> Result<Row> {
        let mut row = self.recorder.row(self.rig, self.state);
        row.extend(self.crushed.columns(self.model, self.state)?);
        Ok(row)
    }

    /// The row that the history would have if one were due at this instant; the test goes on as if nobody had asked.
    ///
    /// # Errors
    /// Those of [`Crushed::columns`].
    pub fn row_aside(&mut self) -> Result<Row> {
        let mut recorder = self.recorder.clone();
        let mut row = self.state.aside(|state| recorder.row(self.rig, state));
        row.extend(self.crushed.columns(self.model, self.state)?);
        Ok(row)
    }

    /// Second part of a step: moves all until the share `next` of the test, records breakages, and looks whether the state still means something. True when the test is done; then nothing moves.
    ///
    /// # Errors
    /// As [`Self::look`].
    pub fn go(&mut self, next: f64, records: &mut impl Records) -> Result<bool> {
        let moved = self.state.go(self.model, self.rig, self.engine, next);
        // breakages before an error are recorded as well
        records.breakages(self)?;
        moved?;
        let done = self.state.phase == Phase::Done;
        // a device's points are known where they have been copied for a row
        let known = if self.engine.is_device() { self.looks.recorded } else { self.state.continuum.steps().is_multiple_of(LOOK) };
        if done || known {
            self.watch()?;
            watch::kinetic_of_points(self.rig, self.state)?;
        }
        if multiplies(self.looks.looked_at, grains(self.state)) {
            self.watch()?;
            self.looks.looked_at = grains(self.state);
        }
        Ok(done)
    }

    /// A whole step, or on a device as many as it makes until something is due. True when the test is done.
    ///
    /// # Errors
    /// As [`Self::look`].
    pub fn advance(&mut self, records: &mut impl Records) -> Result<bool> {
        match self.look(&Lead::default(), records) {
            Ok(next) => self.go(next, records),
            Err(error) => {
                records.breakages(self)?;
                Err(error)
            }
        }
    }

    /// Fails when places or overlaps of grains are no longer meaningful.
    fn watch(&self) -> Result<()> {
        let Some(mixture) = &self.state.mixture else { return Ok(()) };
        watch::grains(&mixture.grains, self.model.records.stop_at_overlap, self.state.continuum.steps())
    }
}
