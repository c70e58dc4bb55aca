//! Records of grains that break in a continuum: breakages, gradations, and the columns of breakage in the history, as specimens of grains have
//! them. Gradations are those of the grains and of what they have lost; the material of the scene's points is not in them.

use super::ancestors::Ancestors;
use super::breakages::{self, Breakages};
use super::gradations::{self, At, gradation};
use crate::error::{Error, Result};
use crate::gradation::{Gradation, Indices};
use crate::model::Model;
use crate::model::continuum::Continuum as Rig;
use crate::rig::continuum::State;
use engine::breakage::lost_mass::excluded_grains;
use engine::grains::Grains;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::Path;
use table::{Row, Table};

/// Tables of a run whose grains break, and what the summary says; part of the checkpoint.
#[derive(Serialize, Deserialize)]
pub struct Crushed {
    gsd: Table,
    breakage: Table,
    broken: Breakages,
    ancestors: Ancestors,
    /// Most contacts between grains and with walls at a row: nothing else breaks a grain.
    contacts: u64,
    /// Relative breakage of Hardin and of Einav at the last row, and what is beyond Einav's.
    indices: [f64; 3],
    /// Gradation before loading; from the rig when a run is resumed.
    #[serde(skip)]
    initial: Option<Gradation>,
}

impl Default for Crushed {
    fn default() -> Crushed {
        Crushed {
            gsd: Table::new("gsd.csv"),
            breakage: Table::new("breakage.csv"),
            broken: Breakages::default(),
            ancestors: Ancestors::default(),
            contacts: 0,
            indices: [f64::NAN; 3],
            initial: None,
        }
    }
}

impl Crushed {
    /// Takes the gradation that breakage is counted from, where grains break.
    pub fn open(&mut self, model: &Model, rig: &Rig) {
        let coarse = rig.coarse.as_ref().filter(|c| model.physics.crush.is_some() && !c.grains.is_empty());
        self.initial = coarse.map(|c| gradations::of_listed(model, &c.grains));
    }

    /// Columns of this instant; none where nothing can break.
    ///
    /// # Errors
    /// A gradation that is coarser than at the start.
    pub fn columns(&mut self, model: &Model, state: &State) -> Result<Row> {
        let (Some(initial), Some(mixture)) = (&self.initial, &state.mixture) else { return Ok(Row::new()) };
        let indices = Indices::between(initial, &gradation(model, &mixture.grains))
            .map_err(|e| Error::Failed { step: state.continuum.steps(), what: e.to_string() })?;
        self.indices = gradations::breakage(indices.as_ref());
        let touching = mixture.touching();
        self.contacts = self.contacts.max(touching.grains + touching.walls);
        let mut row: Row = vec![("mass_lost_kg", lost(state).into())];
        row.extend(gradations::columns(indices.as_ref()));
        Ok(row)
    }

    /// Rows of `gsd.csv` for this instant, where grains break.
    pub fn gradation(&mut self, out: &Path, model: &Model, state: &State, at: &At) -> Result<()> {
        let (Some(initial), Some(mixture)) = (&self.initial, &state.mixture) else { return Ok(()) };
        for mut row in gradations::rows(model, &gradation(model, &mixture.grains), at, initial) {
            row.push(("time_s", state.time.into()));
            self.gsd.push(out, &row)?;
        }
        Ok(())
    }

    /// Rows of `breakage.csv` for what has broken since the last call.
    pub fn breakages(&mut self, out: &Path, state: &mut State) -> Result<()> {
        for broken in std::mem::take(&mut state.broken) {
            // nothing asks for a stress: the platens go at their speed
            self.broken.add(&broken.event, false);
            self.ancestors.add(&broken.event);
            let mut row = breakages::row(&broken.event, broken.step, broken.axial);
            row.push(("time_s", broken.time.into()));
            self.breakage.push(out, &row)?;
        }
        Ok(())
    }

    /// Mother of a grain, and the grain of the start that it comes from.
    pub fn descent(&self, model: &Model, grains: &Grains, id: u32) -> (Option<u32>, u32) {
        self.ancestors.of(id, grains.next_id, model.physics.crush.as_ref().map_or(1, |c| c.pattern.count()))
    }

    pub fn flush(&mut self, out: &Path) -> Result<()> {
        self.gsd.flush(out)?;
        Ok(self.breakage.flush(out)?)
    }

    /// What the summary says of breakage; nothing where nothing can break.
    pub fn summary(&self, model: &Model, state: &State) -> Map<String, Value> {
        let mut s = Map::new();
        let (Some(crush), Some(initial), Some(mixture)) = (&model.physics.crush, &self.initial, &state.mixture) else { return s };
        let mut put = |key: &str, value: Value| s.insert(key.into(), value);
        let excluded = excluded_grains(mixture.grains.crush_events, &crush.pattern);
        put("excluded_grains", json!(excluded.paper));
        put("excluded_grains_smallest", json!(excluded.smallest));
        put("d50_mm", json!(initial.diameter_at(0.5).map(|d| 1e3 * d)));
        let [hardin, einav, beyond] = self.indices;
        put("hardin_br", json!(hardin));
        put("einav_br", json!(einav));
        put("einav_beyond", json!(beyond));
        put("mass_lost_kg", json!(lost(state)));
        put("breakages", self.broken.summary());
        put("warnings", json!(self.warnings()));
        s
    }

    fn warnings(&self) -> Vec<String> {
        let mut warnings = self.broken.warnings();
        if self.contacts == 0 {
            warnings.push(
                "grains touched neither each other nor a wall at any row: only such contacts break grains, those with points do not, so none could break"
                    .into(),
            );
        }
        warnings
    }
}

/// Mass that breakages have lost so far, kg.
fn lost(state: &State) -> f64 {
    state.mixture.as_ref().map_or(0.0, |m| m.grains.lost.iter().map(|l| l.0).sum())
}
