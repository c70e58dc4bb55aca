//! Records of an oedometer: when rows are due, and the test's own columns.

use super::{Loading, Phase};
use crate::model::{Compression, Model};
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::rig::cylinder::{BOTTOM, Stresses, TOP, space};
use engine::coupling::FinesAsPoints;
use engine::dem::State;

/// Relative change of the measured stress after which a row is due if a grain has broken since the last row: every breakage then
/// has a row at nearly its stress.
const NEAR: f64 = 0.04;

impl Recorder {
    /// The record of an oedometer that is due now; `None`: none is.
    pub fn due(&mut self, model: &Model, rig: &Compression, loading: &Loading, state: &State) -> Option<Due> {
        let (k, holding) = match loading.phase {
            Phase::Settle => return None,
            Phase::Load(k) => (k, false),
            Phase::Hold(k) => (k, true),
            Phase::Done => (rig.loading.stages.len() - 1, true),
        };
        let level = (loading.target / rig.specimen.isotropic_stress).log10() * f64::from(model.records.per_decade);
        let mut level = (level + 1e-9).floor() as i64;
        // under strain control the target is the measured stress, which may fall: levels are those of the largest of this stage
        if let (Some(_), true, Some((stage, most))) = (&rig.loading.strain_controlled, loading.rising(k, rig), self.last)
            && stage == k
        {
            level = level.max(most);
        }
        let first = self.last.is_none();
        if first || self.last.is_some_and(|(stage, _)| stage != k) {
            self.next_at = 0;
            self.last = Some((k, level));
            return first.then_some(Due::Full);
        }
        // the end of a stage is recorded when it is at rest, by `stage_end`
        if holding {
            return None;
        }
        let at = &model.records.at;
        if loading.rising(k, rig) {
            let start = if k == 0 { rig.specimen.isotropic_stress } else { rig.loading.stages[k - 1] };
            let end = rig.loading.stages[k];
            let passed = at.iter().filter(|&&s| s > start && s < end && s <= loading.target).count();
            if passed > self.next_at {
                self.next_at = passed;
                self.last = Some((k, level));
                return Some(Due::Full);
            }
        }
        if self.last != Some((k, level)) || self.between_levels(rig, loading, state) {
            self.last = Some((k, level));
            return Some(Due::Row);
        }
        None
    }

    /// Whether strain, breakages, or the stress at which the breakages since the last row have happened ask for a row.
    fn between_levels(&self, rig: &Compression, loading: &Loading, state: &State) -> bool {
        let events = state.crush_events - self.row_events;
        let strain = 1.0 - space(state).height / loading.start.0 - self.row_strain;
        let off = (Stresses::of(state).vertical() / self.row_stress - 1.0).abs();
        rig.loading.row_events.is_some_and(|most| events >= most)
            || rig.loading.row_strain.is_some_and(|most| strain.abs() >= most)
            || (events > 0 && off > NEAR)
    }

    /// Whether a stage has just come to rest: its end is recorded in full.
    pub fn stage_end(&mut self, rig: &Compression, loading: &Loading) -> bool {
        let ended = match loading.phase {
            Phase::Load(k) => k,
            Phase::Done => rig.loading.stages.len(),
            _ => return false,
        };
        let new = ended > self.ended_stages;
        self.ended_stages = self.ended_stages.max(ended);
        new
    }
}

/// The measures of an oedometer for a row of the history.
pub fn moment(rig: &Compression, loading: &Loading, state: &State) -> Moment {
    let s = Stresses::of(state);
    let mut own = vec![("k0", (s.horizontal / s.vertical()).into())];
    if let Some(embedded) = &loading.fines {
        let FinesAsPoints { points, entered, reserve, released, .. } = &embedded.fines;
        let pressed = 0.5 * (embedded.pressed(BOTTOM) + embedded.pressed(TOP)) / space(state).platen_area();
        own.extend([
            ("fines_points", (*points).into()),
            ("fines_mass_kg", entered.mass.into()),
            ("reserve_mass_kg", reserve.mass.into()),
            ("sigma_v_points_kPa", (1e-3 * pressed).into()),
            ("energy_points_J", state.ledger.points.into()),
            ("released_J", (*released).into()),
        ]);
    }
    Moment { stage: stage_name(loading, rig), target: loading.target, held: s.vertical(), start_height: loading.start.0, own }
}

/// Name of the present stage: `settle`, `load`, `unload` or `reload`.
pub fn stage_name(loading: &Loading, rig: &Compression) -> &'static str {
    let k = match loading.phase {
        Phase::Settle => return "settle",
        Phase::Load(k) | Phase::Hold(k) => k,
        Phase::Done => rig.loading.stages.len() - 1,
    };
    match (k, loading.rising(k, rig)) {
        (0, _) => "load",
        (_, false) => "unload",
        (_, true) => "reload",
    }
}
