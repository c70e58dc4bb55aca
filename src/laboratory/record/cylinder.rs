//! Records of a cylindrical specimen of grains under test: rows of `history.csv`, and the values of rows that the summary needs.

use super::breakages::Breakages;
use super::gradations::{self, gradation};
use super::quasi_static::{self, Held};
use crate::error::{Error, Result};
use crate::gradation::{Gradation, Indices};
use crate::model::Model;
use crate::rig::cylinder::{Stresses, TOP, inertial_time, space};
use engine::check::{Checked, lengths};
use engine::dem::observables;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};
use table::Row;

/// The state of the records; part of the checkpoint.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Recorder {
    /// Stage of the last record, and its number in the series of stresses (oedometer) or strains (triaxial) at which rows are
    /// due.
    pub(crate) last: Option<(usize, i64)>,
    /// Number of full records that the present stage has had.
    pub(crate) next_at: usize,
    /// Number of stages whose end has been recorded.
    pub(crate) ended_stages: usize,
    /// Largest measured vertical stress at a record, Pa.
    pub max_stress: f64,
    /// Initial mass, kg.
    pub mass: f64,
    /// Largest overlap over the smaller radius at a record.
    pub deepest: f64,
    /// How well the stress was held, over every step.
    pub held: Held,
    /// Statistics of all breakages.
    pub broken: Breakages,
    /// Measured vertical stress at the last record, Pa.
    pub(crate) row_stress: f64,
    /// Axial strain at the last record.
    pub(crate) row_strain: f64,
    /// Breakages up to the last record.
    pub(crate) row_events: u64,
    /// Largest values at records above 50 kPa: difference of the platens, difference of the stress from its target, inertial
    /// number.
    pub worst: [f64; 3],
    /// Error of the energy balance at the last record, -.
    pub energy_error: f64,
    /// Non-conservative share of the contacts' work at the last record, -.
    pub energy_nonconservative: f64,
    /// Relative error of the mass at the last record.
    pub mass_error: f64,
    /// Horizontal over vertical stress at the last record.
    pub k0: f64,
    /// Further values of the last record.
    pub at_end: AtEnd,
    /// The first record with a void ratio below `records.least_void_ratio`.
    pub below_least: Option<BelowLeast>,
    /// The first record with a `void_ratio_star` below 0.
    pub without_voids: Option<WithoutVoids>,
}

/// Values of the last record for the summary; each is the column of the same name of the history.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct AtEnd {
    /// Porosity with all dry mass as solids.
    pub porosity: f64,
    /// Void ratio with all dry mass as solids.
    pub void_ratio: f64,
    /// Void ratio with the grains alone as solids.
    pub void_ratio_grains: f64,
    /// Void ratio with all dry mass as solids and the pores inside the grains as voids (eq. 20).
    pub void_ratio_star: f64,
    /// Axial strain, compression positive.
    pub axial_strain: f64,
    /// Relative breakage of Hardin.
    pub hardin_br: f64,
    /// Relative breakage of Einav.
    pub einav_br: f64,
    /// The part of the gradation beyond Einav's ultimate one.
    pub einav_beyond: f64,
}

/// The first record with a void ratio below `records.least_void_ratio`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BelowLeast {
    /// Vertical stress, Pa.
    pub sigma_v: f64,
    /// Axial strain, compression positive.
    pub axial_strain: f64,
    /// Void ratio with all dry mass as solids.
    pub void_ratio: f64,
}

impl BelowLeast {
    /// The warning for the user; `least` is `records.least_void_ratio`.
    pub fn in_words(&self, least: f64) -> String {
        format!(
            "the void ratio of all dry mass is {:.3} at {:.0} kPa, below records.least_void_ratio = {least}: the grains have broken into more \
             fines than would fit into the voids; the curve has no meaning from there on",
            self.void_ratio,
            self.sigma_v * 1e-3
        )
    }
}

/// The first record with a `void_ratio_star` below 0: all dry mass, the pores inside the grains excluded, would fill more than the whole volume.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WithoutVoids {
    /// Vertical stress of the record before, the last one at which there were voids, Pa.
    pub last_with_voids: f64,
    /// Vertical stress, Pa.
    pub sigma_v: f64,
    /// Axial strain, compression positive.
    pub axial_strain: f64,
    /// Porosity with all dry mass as solids and the pores inside the grains as voids.
    pub porosity_star: f64,
}

impl WithoutVoids {
    /// The warning for the reader of the results.
    pub fn in_words(&self) -> String {
        format!(
            "the porosity with the mass restored that breakages have lost is below 0 from {:.0} kPa on ({:.4} at an axial strain of {:.4}; last above 0 at {:.0} kPa): \
             more solids than space, which no specimen can have. Volume, strain and what goes with them mean nothing beyond; mass lost by breakages bears no stress here",
            self.sigma_v * 1e-3,
            self.porosity_star,
            self.axial_strain,
            self.last_with_voids * 1e-3
        )
    }
}

/// The kind of a record that is due.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Due {
    /// A row of the history.
    Row,
    /// A row, a gradation and a snapshot.
    Full,
}

/// What only the test knows of an instant.
pub struct Moment {
    /// Name of the stage.
    pub stage: &'static str,
    /// Target of the stress under servo, Pa.
    pub target: f64,
    /// The same stress as measured, Pa.
    pub held: f64,
    /// Height at the start of the test, m.
    pub start_height: f64,
    /// The test's own columns.
    pub own: Row,
}

impl Recorder {
    /// Checks what a checkpoint says of breakages against its state. The other values only reach the records.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, state: &State) -> Checked {
        lengths("breakages", state.crush_events as usize, [self.broken.len()])
    }

    /// The row of `history.csv` for the present state; `initial` is the gradation before loading. Keeps what the summary needs.
    ///
    /// # Errors
    /// [`Error::Failed`]: the gradation is coarser than at the start, so mass was lost or added.
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
        // here all dry mass counts as solid, that lost by breakages included; in `grains` the mass of the grains alone
        let porosity = 1.0 - (sums.volume + lost_volume) / size.volume();
        let grains = 1.0 - sums.volume / size.volume();
        // n* = 1 − (1 − n)(1 − n_int), eq. (20)
        let star = 1.0 - (1.0 - porosity) * (1.0 - internal);
        let void_ratio = |n: f64| n / (1.0 - n);
        let rate = state.walls[TOP].speed.abs() / size.height;
        let inertial = rate * inertial_time(state, v.max(f64::MIN_POSITIVE));
        let target_error = moment.held / moment.target - 1.0;
        let balance = state.ledger.balance(&state.walls, &sums);
        let inner = 0.8;
        let low = size.bottom + 0.5 * (1.0 - inner) * size.height;
        let (lw_v, lw_h) = observables::love_weber(state, work, inner * size.radius, low, low + inner * size.height);
        let mass_error = (sums.mass + lost - self.mass) / self.mass;
        let indices = Indices::between(initial, &gradation(model, state))
            .map_err(|e| Error::Failed { step: state.step, what: e.to_string() })?;
        let mm = |x: f64| x * 1e3;
        let axial_strain = 1.0 - size.height / moment.start_height;
        if self.without_voids.is_none() && star < 0.0 {
            // the stress of the record before
            let last_with_voids = self.row_stress;
            self.without_voids = Some(WithoutVoids { last_with_voids, sigma_v: v, axial_strain, porosity_star: star });
        }
        let [hardin_br, einav_br, einav_beyond] = gradations::breakage(indices.as_ref());

        self.max_stress = self.max_stress.max(v);
        self.deepest = self.deepest.max(sums.worst_overlap);
        (self.row_stress, self.row_strain, self.row_events) = (v, 1.0 - size.height / moment.start_height, state.crush_events);
        if v >= quasi_static::FROM {
            for (worst, now) in self.worst.iter_mut().zip([s.platen_difference(), target_error.abs(), inertial]) {
                *worst = worst.max(now);
            }
        }
        (self.energy_error, self.energy_nonconservative) = (balance.error(), balance.nonconservative() / balance.scale());
        (self.mass_error, self.k0) = (mass_error, h / v);
        self.at_end = AtEnd {
            porosity,
            void_ratio: void_ratio(porosity),
            void_ratio_grains: void_ratio(grains),
            void_ratio_star: void_ratio(star),
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
            ("porosity_star", star.into()),
            ("void_ratio_star", void_ratio(star).into()),
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
