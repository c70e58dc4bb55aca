//! Records of a cylindrical specimen under test: rows of history, and what the summary remembers of them.

use super::breakages::Breakages;
use super::gradations::{self, gradation};
use super::quasi_static::{self, Held};
use crate::error::{Error, Result};
use crate::gradation::{Gradation, Indices};
use crate::model::Model;
use crate::rig::cylinder::{Stresses, TOP, inertial_time, space};
use engine::dem::observables;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};
use table::Row;

/// What the recorder carries along; part of the checkpoint.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Recorder {
    /// Stage and position in the series of levels of the last record.
    pub(crate) last: Option<(usize, i64)>,
    /// Position in the list of full records for the present stage.
    pub(crate) next_at: usize,
    pub(crate) ended_stages: usize,
    /// Largest measured vertical stress at a record, Pa.
    pub max_stress: f64,
    /// Initial mass, kg.
    pub mass: f64,
    /// Largest overlap over the smaller radius at a record.
    pub deepest: f64,
    /// Over every step: how the test was held, and what has broken.
    pub held: Held,
    pub broken: Breakages,
    /// Measured vertical stress, Pa, axial strain and breakages at the last record.
    pub(crate) row_stress: f64,
    pub(crate) row_strain: f64,
    pub(crate) row_events: u64,
    /// Worst values at records above 50 kPa: platen difference, distance from the target, inertial number.
    pub worst: [f64; 3],
    /// Energy error and non-conservative share at the last record.
    pub energy_error: f64,
    pub energy_nonconservative: f64,
    pub mass_error: f64,
    /// What the summary says of the last record.
    pub k0: f64,
    pub at_end: AtEnd,
    /// Where the void ratio first fell below `records.least_void_ratio`.
    pub below_least: Option<BelowLeast>,
}

/// Values of the last record for the summary; ratios as in the history.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct AtEnd {
    pub porosity: f64,
    pub void_ratio: f64,
    pub void_ratio_grains: f64,
    pub void_ratio_star: f64,
    pub axial_strain: f64,
    pub hardin_br: f64,
    pub einav_br: f64,
    pub einav_beyond: f64,
}

/// The first record with a void ratio that fines cannot reach.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BelowLeast {
    /// Vertical stress, Pa.
    pub sigma_v: f64,
    pub axial_strain: f64,
    pub void_ratio: f64,
}

impl BelowLeast {
    /// What a person is told, with the limit it fell below.
    pub fn in_words(&self, least: f64) -> String {
        format!(
            "void ratio of all dry mass is {:.3} at {:.0} kPa, below records.least_void_ratio = {least}: grains have broken into more \
             fines than the voids can hold; the curve has no meaning from there on",
            self.void_ratio,
            self.sigma_v * 1e-3
        )
    }
}

/// What a record is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// A row of the history.
    Row,
    /// A row, a gradation and a snapshot.
    Full,
}

/// What the rig says of this instant.
pub struct Moment {
    pub stage: &'static str,
    /// The stress that a servo is to hold, Pa, and what it is.
    pub target: f64,
    pub held: f64,
    /// Height at the start of the test, m.
    pub start_height: f64,
    /// The rig's own columns.
    pub own: Row,
}

impl Recorder {
    /// The row of this instant.
    pub fn row(&mut self, model: &Model, moment: Moment, state: &State, work: &Workspace, initial: &Gradation) -> Result<Row> {
        let size = space(state);
        let s = Stresses::of(state);
        let sums = observables::sums(&model.physics, state, work);
        let n = state.grains.len();
        let (v, h) = (s.vertical(), s.horizontal);
        let (q, p) = (v - h, (v + 2.0 * h) / 3.0);
        let internal = model.physics.materials[0].internal_porosity;
        let lost: f64 = state.lost.iter().map(|l| l.0).sum();
        let lost_volume = lost / model.physics.materials[0].density;
        // all dry mass is solid, the lost mass too; `grains` counts what is left in grains only
        let porosity = 1.0 - (sums.volume + lost_volume) / size.volume();
        let grains = 1.0 - sums.volume / size.volume();
        // n* = 1 − (1 − n)(1 − n_int), eq. (20)
        let star = |n: f64| 1.0 - (1.0 - n) * (1.0 - internal);
        let void_ratio = |n: f64| n / (1.0 - n);
        let rate = state.walls[TOP].speed.abs() / size.height;
        let inertial = rate * inertial_time(state, v.max(f64::MIN_POSITIVE));
        let lag = moment.held / moment.target - 1.0;
        let balance = state.ledger.balance(&state.walls, &sums);
        let inner = 0.8;
        let low = size.bottom + 0.5 * (1.0 - inner) * size.height;
        let (lw_v, lw_h) = observables::love_weber(state, work, inner * size.radius, low, low + inner * size.height);
        let mass_error = (sums.mass + lost - self.mass) / self.mass;
        let indices = Indices::between(initial, &gradation(model, state))
            .map_err(|e| Error::Failed { step: state.step, what: e.to_string() })?;
        let mm = |x: f64| x * 1e3;
        let axial_strain = 1.0 - size.height / moment.start_height;
        let [hardin_br, einav_br, einav_beyond] = gradations::breakage(indices.as_ref());

        self.max_stress = self.max_stress.max(v);
        self.deepest = self.deepest.max(sums.worst_overlap);
        (self.row_stress, self.row_strain, self.row_events) = (v, 1.0 - size.height / moment.start_height, state.crush_events);
        if v >= quasi_static::FROM {
            for (worst, now) in self.worst.iter_mut().zip([s.platen_difference(), lag.abs(), inertial]) {
                *worst = worst.max(now);
            }
        }
        (self.energy_error, self.energy_nonconservative) = (balance.error(), balance.nonconservative() / balance.scale());
        (self.mass_error, self.k0) = (mass_error, h / v);
        self.at_end = AtEnd {
            porosity,
            void_ratio: void_ratio(porosity),
            void_ratio_grains: void_ratio(grains),
            void_ratio_star: void_ratio(star(porosity)),
            axial_strain,
            hardin_br,
            einav_br,
            einav_beyond,
        };
        if self.below_least.is_none() && void_ratio(porosity) < model.records.least_void_ratio {
            self.below_least = Some(BelowLeast { sigma_v: v, axial_strain, void_ratio: void_ratio(porosity) });
        }

        let mut row: Row = vec![
            ("step", state.step.into()),
            ("stage", moment.stage.into()),
            ("target_kPa", (moment.target * 1e-3).into()),
            ("sigma_v_kPa", (v * 1e-3).into()),
            ("sigma_h_kPa", (h * 1e-3).into()),
        ];
        row.extend(moment.own);
        row.extend([
            ("q_kPa", (q * 1e-3).into()),
            ("p_kPa", (p * 1e-3).into()),
            ("axial_strain", axial_strain.into()),
            ("height_mm", mm(size.height).into()),
            ("porosity", porosity.into()),
            ("void_ratio", void_ratio(porosity).into()),
            ("porosity_grains", grains.into()),
            ("void_ratio_grains", void_ratio(grains).into()),
            ("porosity_star", star(porosity).into()),
            ("void_ratio_star", void_ratio(star(porosity)).into()),
            ("platen_difference", s.platen_difference().into()),
            ("coordination_number", sums.coordination(n).into()),
            ("coordination_number_no_rattlers", sums.mechanical_coordination(n).into()),
            ("fabric_zz", sums.fabric.tensor()[2].into()),
            ("rattlers", (sums.without + sums.with_one).into()),
            ("unbalanced_ratio", sums.unbalanced_ratio(n).into()),
            ("inertial_number", inertial.into()),
            ("grains", n.into()),
            ("crush_events", state.crush_events.into()),
            ("love_weber_sigma_v_kPa", (lw_v * 1e-3).into()),
            ("love_weber_sigma_h_kPa", (lw_h * 1e-3).into()),
            ("overlap_fraction", (sums.overlap_volume / sums.volume).into()),
            ("largest_overlap_ratio", sums.worst_overlap.into()),
            ("mass_grains_kg", sums.mass.into()),
            ("mass_lost_kg", lost.into()),
            ("mass_error", mass_error.into()),
        ]);
        row.extend(gradations::columns(indices.as_ref()));
        if model.records.energy {
            row.extend([
                ("energy_wall_J", balance.wall.into()),
                ("energy_path_J", balance.path.into()),
                ("energy_stored_J", balance.stored.into()),
                ("energy_slip_J", balance.slip.into()),
                ("energy_viscous_J", balance.viscous.into()),
                ("energy_damping_J", balance.damping.into()),
                ("energy_kinetic_J", balance.kinetic.into()),
                ("energy_lost_kinetic_J", balance.lost_kinetic.into()),
                ("energy_contacts_removed_J", balance.removed.into()),
                ("energy_contacts_made_J", balance.made.into()),
                ("energy_inertia_J", balance.inertia.into()),
                ("energy_growth_J", balance.growth.into()),
                ("energy_release_J", balance.release.into()),
                ("energy_error", balance.error().into()),
                ("energy_nonconservative", (balance.nonconservative() / balance.scale()).into()),
            ]);
        }
        Ok(row)
    }
}
