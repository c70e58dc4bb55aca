//! Records of grains that break in a mixture: `breakage.csv`, `gsd.csv` and the columns of breakage in the history, as for
//! specimens of grains. Gradations are those of the grains and of the mass that they have lost; the points of the scene are not
//! in them.

use super::ancestors::Ancestors;
use super::block_breakages::{self, BLOCK_BREAKAGE};
use super::blocks;
use super::breakages::{self, Breakages};
use super::gradations::{self, At, gradation};
use crate::error::{Error, Result};
use crate::gradation::{Gradation, Indices};
use crate::model::Model;
use crate::model::continuum::MpmTest;
use crate::rig::continuum::{Broken, State};
use engine::breakage::lost_mass::excluded_grains;
use engine::check::{Checked, lengths};
use engine::coupling::Mixture;
use engine::grains::Grains;
use engine::rigid::{Blocks, Breaking, MOST_LOST};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::path::Path;
use table::{Row, Table};

/// Table of gradations.
pub const GSD: &str = "gsd.csv";
/// Table of breakages.
pub const BREAKAGE: &str = "breakage.csv";

/// The records of breakage of a mixture; part of the checkpoint.
#[derive(Serialize, Deserialize)]
pub struct Crushed {
    gsd: Table,
    breakage: Table,
    block_breakage: Table,
    broken: Breakages,
    ancestors: Ancestors,
    /// Largest number of contacts between grains and of grains with walls at a row. Only such contacts break grains.
    contacts: u64,
    /// Relative breakage of Hardin and of Einav at the last row, and the part beyond Einav's ultimate gradation.
    indices: [f64; 3],
    /// Gradation before loading; a resumed run takes it from the rig.
    #[serde(skip)]
    initial: Option<Gradation>,
}

/// Breakages since they were last taken.
pub struct Taken {
    /// Rows of `breakage.csv`.
    pub grains: Vec<Row>,
    /// Rows of `block_breakage.csv`.
    pub bodies: Vec<Row>,
    /// Rigid bodies that have a new surface, by number.
    pub pieces: Vec<u32>,
}

impl Default for Crushed {
    fn default() -> Crushed {
        Crushed {
            gsd: Table::new(GSD),
            breakage: Table::new(BREAKAGE),
            block_breakage: Table::new(BLOCK_BREAKAGE),
            broken: Breakages::default(),
            ancestors: Ancestors::default(),
            contacts: 0,
            indices: [f64::NAN; 3],
            initial: None,
        }
    }
}

impl Crushed {
    /// Checks what a checkpoint says of breakages against its state, and its tables against the files in `out`.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, state: &State, out: &Path) -> Checked {
        self.gsd.check(out, GSD)?;
        self.breakage.check(out, BREAKAGE)?;
        self.block_breakage.check(out, BLOCK_BREAKAGE)?;
        let Some(mixture) = &state.mixture else { return lengths("breakages", 0, [self.broken.len()]) };
        let events = mixture.grains.crush_events as usize;
        lengths("breakages", events, [self.broken.len()])?;
        // the state itself is checked: every grain that has been is there or has broken
        let daughters = model.physics.crush.as_ref().map_or(1, |c| c.pattern.count());
        let first = (mixture.grains.grains.next_id as usize).checked_sub(daughters.saturating_mul(events));
        self.ancestors.check(model, &mixture.grains, first.ok_or("more grains have broken than there were")?)
    }

    /// Notes the gradation before loading, if grains or rigid bodies can break.
    pub fn open(&mut self, model: &Model, rig: &MpmTest) {
        let coarse = rig.coarse.as_ref().filter(|_| model.physics.crush.is_some());
        self.initial = coarse.and_then(|coarse| match (coarse.grains.is_empty(), coarse.blocks.is_empty()) {
            (false, _) => Some(gradations::of_listed(model, &coarse.grains)),
            (true, false) => {
                Some(gradations::of_bodies(model, coarse.blocks.iter().map(|block| (block.shape.sieve(), block.mass))))
            }
            (true, true) => None,
        });
    }

    /// The columns of breakage for a row of the history; none where no grain can break.
    ///
    /// # Errors
    /// [`Error::Failed`]: the gradation is coarser than at the start, so mass was lost or added.
    pub fn columns(&mut self, model: &Model, state: &State) -> Result<Row> {
        let (Some(initial), Some(mixture)) = (&self.initial, &state.mixture) else { return Ok(Row::new()) };
        let indices = Indices::between(initial, &present(model, mixture))
            .map_err(|e| Error::Failed { step: state.continuum.steps(), what: e.to_string() })?;
        self.indices = gradations::breakage(indices.as_ref());
        let touching = mixture.touching();
        self.contacts = self.contacts.max(touching.grains + touching.walls);
        let mut row: Row = match breaking(mixture) {
            Some((blocks, _)) => vec![("blocks", blocks.blocks.len().into())],
            None => vec![("mass_lost_kg", lost(state).into())],
        };
        row.extend(gradations::columns(indices.as_ref()));
        Ok(row)
    }

    /// Writes the rows of `gsd.csv` for the present state, if grains can break.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn gradation(&mut self, out: &Path, model: &Model, state: &State, at: &At) -> Result<()> {
        let (Some(initial), Some(mixture)) = (&self.initial, &state.mixture) else { return Ok(()) };
        for mut row in gradations::rows(model, &present(model, mixture), at, initial) {
            row.push(("time_s", state.time.into()));
            self.gsd.push(out, &row)?;
        }
        Ok(())
    }

    /// Takes the breakages since the last call.
    pub fn take(&mut self, state: &mut State) -> Taken {
        let row = |broken: Broken| {
            // the platens move at a given speed: there is no target of the stress
            self.broken.add(&broken.event, false);
            self.ancestors.add(&broken.event);
            let mut row = breakages::row(&broken.event, broken.step, broken.axial);
            row.push(("time_s", broken.time.into()));
            row
        };
        let grains = std::mem::take(&mut state.broken).into_iter().map(row).collect();
        let (time, blocks) = (state.time, state.mixture.as_mut().and_then(|m| m.blocks.as_mut()));
        let broken = blocks.map_or(Vec::new(), |blocks| blocks.take_breakages());
        let mut pieces: Vec<u32> = broken.iter().flat_map(|b| b.pieces.iter().copied()).collect();
        pieces.sort_unstable();
        pieces.dedup();
        Taken { grains, bodies: broken.iter().map(|b| block_breakages::row(b, time)).collect(), pieces }
    }

    /// Writes the rows of `breakage.csv` and of `block_breakage.csv` for the breakages since the last call, and those of the pieces' surfaces.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn breakages(&mut self, out: &Path, state: &mut State, surfaces: &mut Table) -> Result<()> {
        let Taken { grains, bodies, pieces } = self.take(state);
        grains.iter().try_for_each(|row| self.breakage.push(out, row))?;
        bodies.iter().try_for_each(|row| self.block_breakage.push(out, row))?;
        let Some(theirs) = state.blocks() else { return Ok(()) };
        for k in pieces {
            blocks::surface(theirs, k as usize).iter().try_for_each(|row| surfaces.push(out, row))?;
        }
        Ok(())
    }

    /// Mother of the grain `id`, and the grain of the start from which it descends ([`Ancestors::of`]).
    pub fn descent(&self, model: &Model, grains: &Grains, id: u32) -> (Option<u32>, u32) {
        self.ancestors.of(id, grains.next_id, model.physics.crush.as_ref().map_or(1, |c| c.pattern.count()))
    }

    /// Hands all rows to the operating system.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn sync(&mut self, out: &Path) -> Result<()> {
        self.gsd.sync(out)?;
        self.block_breakage.sync(out)?;
        Ok(self.breakage.sync(out)?)
    }

    /// Goes on with the tables of a checkpoint, whose files are in `out`.
    ///
    /// # Errors
    /// A file that lacks rows which the checkpoint knows.
    pub fn reopen(&mut self, out: &Path) -> Result<()> {
        self.gsd.reopen(out, GSD)?;
        self.block_breakage.reopen(out, BLOCK_BREAKAGE)?;
        Ok(self.breakage.reopen(out, BREAKAGE)?)
    }

    /// The entries of `summary.json` about breakage; none where no grain can break.
    pub fn summary(&self, model: &Model, state: &State) -> Map<String, Value> {
        let mut s = Map::new();
        let (Some(crush), Some(initial), Some(mixture)) = (&model.physics.crush, &self.initial, &state.mixture) else { return s };
        let mut put = |key: &str, value: Value| s.insert(key.into(), value);
        if let Some((_, breaking)) = breaking(mixture) {
            put("blocks_not_cut", json!(breaking.held));
        } else {
            let excluded = excluded_grains(mixture.grains.crush_events, &crush.pattern);
            put("excluded_grains", json!(excluded.paper));
            put("excluded_grains_smallest", json!(excluded.smallest));
        }
        put("d50_mm", json!(initial.diameter_at(0.5).map(|d| 1e3 * d)));
        let [hardin, einav, beyond] = self.indices;
        put("hardin_br", json!(hardin));
        put("einav_br", json!(einav));
        put("einav_beyond", json!(beyond));
        if breaking(mixture).is_none() {
            put("mass_lost_kg", json!(lost(state)));
            put("breakages", self.broken.summary());
        }
        put("warnings", json!(self.warnings(mixture)));
        s
    }

    fn warnings(&self, mixture: &Mixture) -> Vec<String> {
        if let Some((_, breaking)) = breaking(mixture) {
            let held = breaking.held;
            let warning = format!(
                "{held} rigid bodies over their limit could not be cut: their edges are too round, and a piece would have no hull or more than {MOST_LOST} of the volume would be lost; they break no more"
            );
            return if held > 0 { vec![warning] } else { Vec::new() };
        }
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

/// The rigid bodies of a mixture and how they break; `None`: none does.
fn breaking(mixture: &Mixture) -> Option<(&Blocks, &Breaking)> {
    let blocks = mixture.blocks.as_deref()?;
    Some((blocks, blocks.breaking()?))
}

/// The present gradation, of grains or of rigid bodies.
fn present(model: &Model, mixture: &Mixture) -> Gradation {
    match breaking(mixture) {
        Some((blocks, breaking)) => {
            let bodies = blocks.blocks.iter().zip(&breaking.bodies);
            gradations::of_bodies(model, bodies.map(|(block, fate)| (fate.sieve, block.mass)))
        }
        None => gradation(model, &mixture.grains),
    }
}

/// Mass that breakages have lost so far, kg.
fn lost(state: &State) -> f64 {
    state.mixture.as_ref().map_or(0.0, |m| m.grains.lost.iter().map(|l| l.0).sum())
}
