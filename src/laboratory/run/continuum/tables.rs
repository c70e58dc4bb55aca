//! The tables and snapshots of a run of a continuum or mixture.

use super::super::files;
use super::step::{Moving, Records};
use super::{has_points, of_grains};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::model::continuum::MpmTest;
use crate::record::continuum::{self as records, Recorder};
use crate::record::crushed::Crushed;
use crate::record::vtk::{self, Fact};
use crate::record::walls::Loaded;
use crate::record::{account, blocks, contacts, joints, wall_rows};
use crate::rig::continuum::{State, shape_of};
use engine::mpm::Dimension;
use std::path::Path;
use table::{Row, Table};

/// The tables of a run in the folder `out`, which the run's progress keeps.
pub struct Tables<'a> {
    pub out: &'a Path,
    pub history: &'a mut Table,
    pub blocks: &'a mut Table,
    pub surfaces: &'a mut Table,
    pub joints: &'a mut Table,
    pub walls: &'a mut Table,
    pub account: &'a mut Table,
    pub snapshots: &'a mut Vec<files::Snapshot>,
}

impl Records for Tables<'_> {
    fn row(&mut self, at: &mut Moving<'_>, row: Row) -> Result<()> {
        let Moving { model, rig, state, recorder, .. } = at;
        self.history.push(self.out, &row)?;
        if let Some(now) = state.account(model, rig) {
            let strain = rig.specimen().map(|_| recorder.at(rig, state).axial_strain);
            self.account.push(self.out, &account::row(&now, state.continuum.steps(), state.time, strain))?;
            recorder.account_error = Some(now.error());
        }
        Ok(())
    }

    fn bodies(&mut self, at: &Moving<'_>) -> Result<()> {
        let Moving { model, rig, state, .. } = at;
        let (step, time) = (state.continuum.steps(), state.time);
        if let Some(theirs) = state.blocks() {
            let mut tracks = blocks::rows(theirs, model.physics.gravity, step, time);
            tracks.try_for_each(|row| self.blocks.push(self.out, &row))?;
            joints::rows(theirs, step, time).iter().try_for_each(|row| self.joints.push(self.out, row))?;
        }
        if let Some((mixture, coarse)) = state.mixture.as_ref().zip(rig.coarse.as_ref()).filter(|_| rig.specimen().is_none()) {
            let rows = wall_rows::rows(mixture, &coarse.walls, step, time);
            rows.iter().try_for_each(|row| self.walls.push(self.out, row))?;
        }
        Ok(())
    }

    fn frame(&mut self, at: &mut Moving<'_>) -> Result<()> {
        let Moving { model, rig, state, recorder, crushed, .. } = at;
        crushed.gradation(self.out, model, state, &recorder.at(rig, state))?;
        instant(self.out, model, state, &facts(rig, state, recorder), crushed, self.snapshots)
    }

    fn breakages(&mut self, at: &mut Moving<'_>) -> Result<()> {
        at.crushed.breakages(self.out, at.state, self.surfaces)
    }
}

/// The numbers that are noted in every snapshot: step, time, and in a test stress and strain.
fn facts(rig: &MpmTest, state: &State, recorder: &Recorder) -> Vec<Fact> {
    let mut facts = vec![("step", state.continuum.steps() as f64), ("time_s", state.time)];
    if rig.specimen().is_some() {
        let at = recorder.at(rig, state);
        facts.extend([("sigma_v_kPa", 1e-3 * at.sigma_v), ("axial_strain", at.axial_strain)]);
    }
    facts
}

/// Writes snapshots of points, grains, rigid bodies and walls, and the contacts of grains, as far as the scene asks for them.
fn instant(
    out: &Path,
    model: &Model,
    state: &State,
    facts: &[Fact],
    crushed: &Crushed,
    snapshots: &mut Vec<files::Snapshot>,
) -> Result<()> {
    if !(model.records.snapshots || model.records.contacts) {
        return Ok(());
    }
    let dir = out.join(files::SNAPSHOTS);
    table::folder(&dir).map_err(Error::write(&dir))?;
    let step = state.continuum.steps();
    let touching = state.mixture.as_ref().map_or(Vec::new(), |m| contacts::of_mixture(m, &state.continuum));
    if let Some(mixture) = state.mixture.as_ref().filter(|_| model.records.contacts) {
        let names = contacts::names(&mixture.grains.walls, !state.plates.is_empty());
        contacts::write(&dir.join(format!("contacts_{step:08}.csv")), facts, &mixture.grains.grains, &names, &touching)?;
    }
    if !model.records.snapshots {
        return Ok(());
    }
    let failed = vtk::VtkError::at(step);
    snapshots.push((state.time, step));
    if has_points(state) {
        records::write_snapshot(&out.join(files::snapshot_name("step_", step)), facts, &state.continuum)?;
        vtk::write_collection(&out.join(files::COLLECTION), &files::listed(snapshots, "step_")).map_err(failed)?;
    }
    if let Some(mixture) = of_grains(state) {
        let grains = &mixture.grains.grains;
        let stresses = contacts::mean_stresses(grains, &touching);
        let descent = |id| crushed.descent(model, grains, id);
        records::write_grains(&dir.join(format!("grains_{step:08}.vtp")), facts, step, grains, &stresses, descent)?;
        vtk::write_collection(&out.join(files::GRAINS), &files::listed(snapshots, "grains_")).map_err(failed)?;
    }
    if let Some(theirs) = state.blocks() {
        blocks::write_surfaces(&dir.join(format!("blocks_{step:08}.vtp")), facts, step, theirs)?;
        vtk::write_collection(&out.join(files::BLOCKS), &files::listed(snapshots, "blocks_")).map_err(failed)?;
    }
    let loaded = walls(state);
    let bodies = state.continuum.points().position.iter().map(|p| [p[0], p[1], p[2], 0.0]);
    let bodies = bodies.chain(state.mixture.iter().flat_map(|m| m.grains.grains.pos.iter().copied()));
    let blocks = state.blocks().into_iter().flat_map(|theirs| &theirs.blocks);
    let bodies = bodies.chain(blocks.map(|b| [b.centre[0], b.centre[1], b.centre[2], b.solid().reach()]));
    files::write_walls(out, step, bodies, &loaded, facts, snapshots)
}

/// Shape and force, N, of the platens and shells of a test, or of the walls of a free scene with grains. Empty in plane strain,
/// where walls would be lines.
fn walls(state: &State) -> Vec<Loaded> {
    if state.continuum.settings().dimension == Dimension::PlaneStrain {
        return Vec::new();
    }
    match &state.mixture {
        Some(mixture) if state.plates.is_empty() => mixture.grains.walls.iter().map(|w| (w.shape, w.reaction)).collect(),
        _ => state.plates.iter().map(|plate| (shape_of(plate), plate.force())).collect(),
    }
}
