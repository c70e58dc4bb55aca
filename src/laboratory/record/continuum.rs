//! Records of a continuum or mixture: rows of `history.csv`, the values of rows that the summary needs, points as tables and
//! snapshots. Compression is positive.

use super::gradations::At;
use super::vtk::{self, Fact, Field, VtkError};
use crate::error::{Error, Result};
use crate::model::continuum::{Drainage, MpmTest, Test};
use crate::model::inertial;
use crate::rig::continuum::{GrainMeasures, Moment, Phase, State};
use engine::grains::Grains;
use engine::mpm::{Continuum, Dimension, Points};
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::path::Path;
use table::{Row, number};

/// Table of the points at the start of the test.
pub const START: &str = "points_start.csv";
/// Table of the points at the end.
pub const END: &str = "points_final.csv";
/// Table of the grains of a mixture at the start of the test.
pub const GRAINS_START: &str = "grains_start.csv";
/// Stresses of smaller magnitude are written as 0, Pa.
const NOTHING: f64 = 1e-3;
/// Times of a wave through the specimen between two rows while it settles.
const SETTLE_EVERY: f64 = 5.0;
/// Axial strain, over that at the end, from which on the quasi-static measures count.
const FROM: f64 = 0.05;
/// Last share of the axial strain over which the residual stress ratio is averaged.
const RESIDUAL: f64 = 0.1;

/// The state of the records; part of the checkpoint.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Recorder {
    /// Whether the last row was one of settling, and its number.
    level: Option<(bool, i64)>,
    /// Number of snapshots so far.
    frame: u64,
    /// Largest σ1/σ3 of all rows, with the axial strain and q, Pa, of the same row.
    pub peak: [f64; 3],
    /// Sum and number of the stress ratios over the last share [`RESIDUAL`] of the test.
    residual: [f64; 2],
    /// Largest difference of opposite sides, and largest kinetic energy over stress work, of the rows that count.
    pub worst: [f64; 2],
    /// Largest inertial numbers of points and of coarse grains of the rows that count; kept where points have another inertia than that of their mass, and for rigid bodies without points.
    pub inertial: [f64; 2],
    /// Error of the energy account in the last row; `None`: the run keeps none.
    pub account_error: Option<f64>,
    /// Dissipated share of all energy given, in the last row.
    pub dissipated: f64,
    /// Difference of opposite sides in the last row, -.
    pub difference: f64,
    /// Axial strain and axial stress, Pa, of the last row.
    now: [f64; 2],
    /// Largest axial stress of a row of loading, Pa.
    pub most: f64,
    /// Axial strain and axial stress, Pa, of the first row of loading.
    pub first: Option<[f64; 2]>,
    /// Axial strain and axial stress, Pa, of the last row of loading.
    pub last: [f64; 2],
    /// Lateral stress of the last row of loading, Pa.
    pub lateral: f64,
    /// Void ratio in the last row.
    pub void_ratio: f64,
    /// Largest plastic strain in the last row.
    pub plastic: f64,
    /// Run-out and height, m, of the first and of the last row of a free scene.
    pub reach: [Option<[f64; 2]>; 2],
}

/// The records that are due.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Due {
    /// A row of the history.
    pub row: bool,
    /// A snapshot and a gradation.
    pub frame: bool,
}

impl Recorder {
    /// The records that are due for the present state; counts them as made.
    pub fn due(&mut self, rig: &MpmTest, state: &State) -> Due {
        let (settling, share) = (state.phase == Phase::Settle, state.share(rig));
        let level = match settling {
            true => (state.phase_time / (SETTLE_EVERY * state.wave)) as i64,
            false => (share * f64::from(rig.rows) + 1e-9).floor() as i64,
        };
        let done = state.phase == Phase::Done;
        let row = done || self.level.is_none_or(|last| last != (settling, level) && (last.0 != settling || level > last.1));
        if row {
            self.level = Some((settling, level));
        }
        let next = 1.0 + (share * f64::from(rig.frames) + 1e-9).floor().min(f64::from(rig.frames));
        let frame = done || (next as u64) > self.frame;
        if frame {
            self.frame = next as u64;
        }
        Due { row: row || frame, frame }
    }

    /// Share of the test at which the next row or snapshot is due.
    pub fn next(&self, rig: &MpmTest, state: &State) -> f64 {
        let share = state.share(rig);
        let after = |n: u32| ((share * f64::from(n) + 1e-9).floor() + 1.0) / f64::from(n);
        after(rig.rows).min(after(rig.frames))
    }

    /// The row of `history.csv` for the present state. Keeps what the summary needs.
    pub fn row(&mut self, rig: &MpmTest, state: &mut State) -> Row {
        let mut m = state.moment(rig);
        // platens that just touch give rounding, which no logarithmic axis should show
        for stress in [&mut m.axial, &mut m.lateral] {
            *stress = if stress.abs() < NOTHING { 0.0 } else { *stress };
        }
        let mut row: Row = vec![
            ("step", state.continuum.steps().into()),
            ("time_s", state.time.into()),
            ("stage", stage(state.phase).into()),
            ("dt_s", state.dt.into()),
        ];
        match &rig.test {
            Test::Free { .. } => {
                let [front, height] = state.reach(rig);
                self.reach = [self.reach[0].or(Some([front, height])), Some([front, height])];
                row.extend([("front_mm", (1e3 * front).into()), ("height_mm", (1e3 * height).into())]);
                row.extend(rig.gate.map(|gate| ("passed_kg", state.passed(&gate).into())));
            }
            Test::Oedometer(_) => row.extend([
                ("axial_strain", m.axial_strain.into()),
                ("sigma_v_kPa", (1e-3 * m.axial).into()),
                ("sigma_h_kPa", (1e-3 * m.lateral).into()),
                ("k0", (m.lateral / m.axial).into()),
            ]),
            Test::Triaxial { .. } => row.extend([
                ("axial_strain", m.axial_strain.into()),
                ("volumetric_strain", m.volumetric_strain.into()),
                ("sigma_1_kPa", (1e-3 * m.axial).into()),
                ("sigma_3_kPa", (1e-3 * m.lateral).into()),
                ("principal_ratio", (m.axial / m.lateral).into()),
            ]),
        }
        if let Test::Triaxial { cell_pressure, drainage: Drainage::ConstantVolume, .. } = &rig.test {
            row.push(("pore_pressure_kPa", (1e-3 * (cell_pressure - m.lateral)).into()));
        }
        if rig.specimen().is_some() {
            let plane = rig.settings.dimension == Dimension::PlaneStrain;
            row.extend([("q_kPa", (1e-3 * m.q()).into()), ("p_kPa", (1e-3 * m.p(plane)).into())]);
            row.push(("platen_difference", m.difference.into()));
        }
        let [px, py, pz] = m.totals.momentum;
        row.extend([
            ("void_ratio", m.void_ratio.into()),
            ("porosity", (m.void_ratio / (1.0 + m.void_ratio)).into()),
            ("plastic_strain_mean", m.plastic[0].into()),
            ("plastic_strain_max", m.plastic[1].into()),
            ("kinetic_J", m.totals.kinetic.into()),
            ("potential_J", m.totals.potential.into()),
            ("stress_work_J", m.stress_work.into()),
            ("platen_work_J", m.plate_work.into()),
            ("contact_J", m.stored.into()),
        ]);
        row.extend(m.driven_work.map(|work| ("driven_work_J", work.into())));
        row.extend([
            ("dissipated_J", m.dissipated.into()),
            ("dissipated_share", m.dissipated_share().into()),
            ("momentum_x_kg_m_s", px.into()),
            ("momentum_y_kg_m_s", py.into()),
            ("momentum_z_kg_m_s", pz.into()),
        ]);
        if let Some(g) = &m.grains {
            row.extend(coarse(g, rig.settings.dimension == Dimension::PlaneStrain));
            if rig.specimen().is_none() {
                row.push(("lowest_grain_mm", (1e3 * g.lowest).into()));
            }
        }
        self.remember(rig, state.phase, &m);
        let bed = rig.specimen().is_some_and(|s| s.bed.is_some());
        if (bed || rig.points_inertia != 1.0) && self.under_way(rig, state.phase) {
            self.note_inertia(rig, state, m.p(rig.settings.dimension == Dimension::PlaneStrain));
        }
        row
    }

    /// Keeps the largest inertial numbers; `p` is the mean stress, Pa.
    fn note_inertia(&mut self, rig: &MpmTest, state: &State, p: f64) {
        let of_bed = rig.specimen().and_then(|s| s.inertial_number(1.0, 1.0));
        let coarse = of_bed.or_else(|| {
            let m = state.mixture.as_ref()?;
            let g = &m.grains.grains;
            let grains = g.by_id().into_iter().map(|i| i as usize).map(|i| [2.0 * g.radius(i), g.mass[i]]);
            let blocks = m.blocks.iter().flat_map(|b| &b.blocks).map(|b| [2.0 * b.radius, b.mass]);
            inertial::size(grains.chain(blocks))
        });
        for (most, size) in self.inertial.iter_mut().zip([inertial::size_of_points(rig), coarse]) {
            let now = state.strain_rate(rig) * size.unwrap_or(0.0) / p.sqrt();
            *most = if now.is_finite() { most.max(now) } else { *most };
        }
    }

    /// The instant of the last row, for a gradation.
    pub fn at(&self, rig: &MpmTest, state: &State) -> At {
        let [axial_strain, sigma_v] = if rig.specimen().is_some() { self.now } else { [f64::NAN; 2] };
        At { step: state.continuum.steps(), stage: stage(state.phase), sigma_v, axial_strain }
    }

    fn remember(&mut self, rig: &MpmTest, phase: Phase, m: &Moment) {
        (self.dissipated, self.void_ratio, self.plastic) = (m.dissipated_share(), m.void_ratio, m.plastic[1]);
        (self.difference, self.now) = (m.difference, [m.axial_strain, m.axial]);
        let Some(s) = rig.specimen().filter(|_| phase != Phase::Settle) else { return };
        let now = [m.axial_strain, m.axial];
        self.first.get_or_insert(now);
        (self.last, self.lateral, self.most) = (now, m.lateral, self.most.max(m.axial));
        let ratio = m.axial / m.lateral;
        if ratio.is_finite() && ratio > self.peak[0] {
            self.peak = [ratio, m.axial_strain, m.q()];
        }
        if m.axial_strain >= (1.0 - RESIDUAL) * s.axial_strain {
            self.residual = [self.residual[0] + ratio, self.residual[1] + 1.0];
        }
        if m.axial_strain >= FROM * s.axial_strain {
            let kinetic = m.totals.kinetic / m.stress_work.abs().max(f64::MIN_POSITIVE);
            for (worst, now) in self.worst.iter_mut().zip([m.difference, kinetic]) {
                *worst = worst.max(now);
            }
        }
    }

    /// Whether the test has passed the share [`FROM`] of its axial strain. Before, waves from its start disturb the quasi-static
    /// measures.
    pub fn under_way(&self, rig: &MpmTest, phase: Phase) -> bool {
        phase != Phase::Settle && rig.specimen().is_some_and(|s| self.last[0] >= FROM * s.axial_strain)
    }

    /// Residual stress ratio: mean σ1/σ3 over the last share [`RESIDUAL`] of the axial strain.
    pub fn residual_ratio(&self) -> f64 {
        self.residual[0] / self.residual[1]
    }
}

/// The stage of a test, as a word in its records.
pub fn stage(phase: Phase) -> &'static str {
    if phase == Phase::Settle { "settle" } else { "load" }
}

/// Writes the points as a table in the order of their ids, with the displacement from their places in `start`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_points(path: &Path, rig: &MpmTest, points: &Points, start: Option<&Points>) -> Result<()> {
    let edge = rig.settings.cell / f64::from(rig.per_edge);
    let mut text = format!("# spacing_m = {}\n", number(edge));
    text += "id,x_m,y_m,z_m,volume_m3,plastic_strain,p_kPa,q_kPa,vx_m_s,vy_m_s,vz_m_s,displacement_mm\n";
    for i in points.by_id().into_iter().map(|i| i as usize) {
        let ([x, y, z, volume], [u, v, w, _], s) = (points.position[i], points.velocity[i], points.stress[i]);
        let moved = start.map_or(0.0, |start| {
            // points from breakages were not there at the start
            let Some(p) = start.position.get(points.id[i] as usize) else { return 0.0 };
            1e3 * ((x - p[0]).powi(2) + (y - p[1]).powi(2) + (z - p[2]).powi(2)).sqrt()
        });
        let (p, q) = invariants(&s);
        if !([x, y, z, volume, u, v, w, p, q].iter().all(|x| x.is_finite())) {
            let what = format!(
                "{}: place, volume, velocity or stress of point {} is not finite; nothing was written",
                path.display(),
                points.id[i]
            );
            return Err(Error::Unstable { step: 0, what, grain: None });
        }
        let row = [x, y, z, volume, points.memory[i].plastic, 1e-3 * p, 1e-3 * q, u, v, w, moved].map(number).join(",");
        let _ = writeln!(text, "{},{row}", points.id[i]);
    }
    table::write(path, text).map_err(Error::write(path))
}

/// Mean pressure and √(3 J2), Pa.
fn invariants(s: &[f64; 6]) -> (f64, f64) {
    let p = -(s[0] + s[1] + s[2]) / 3.0;
    let [x, y, z] = [s[0] + p, s[1] + p, s[2] + p];
    let j2 = 0.5 * (x * x + y * y + z * z) + s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    (p, (3.0 * j2).sqrt())
}

/// A field of a snapshot: its name, its number of components, and the components of the body at an index.
type Of<'a> = (&'static str, usize, &'a dyn Fn(usize) -> Vec<f64>);

/// Writes the points as a ParaView snapshot, with `facts` noted in it.
///
/// # Errors
/// A file that cannot be written.
pub fn write_snapshot(path: &Path, facts: &[Fact], continuum: &Continuum) -> Result<()> {
    let points = continuum.points();
    let fields: [Of; 9] = [
        ("id", 1, &|i| vec![f64::from(points.id[i])]),
        ("velocity_m_s", 3, &|i| points.velocity[i][..3].to_vec()),
        ("stress_Pa_tension_positive", 6, &|i| points.stress[i].to_vec()),
        ("p_Pa", 1, &|i| vec![invariants(&points.stress[i]).0]),
        ("q_Pa", 1, &|i| vec![invariants(&points.stress[i]).1]),
        ("plastic_strain", 1, &|i| vec![points.memory[i].plastic]),
        ("volume_m3", 1, &|i| vec![points.position[i][3]]),
        ("porosity", 1, &|i| vec![points.porosity(i)]),
        ("material", 1, &|i| vec![f64::from(points.law[i])]),
    ];
    write_fields(path, facts, continuum.steps(), &points.by_id(), &points.position, &fields)
}

/// Writes the grains of a mixture as a ParaView snapshot. `stresses` are their mean stresses by index, Pa; `descent` gives mother
/// and first ancestor of a grain.
///
/// # Errors
/// A file that cannot be written.
pub fn write_grains(
    path: &Path,
    facts: &[Fact],
    step: u64,
    g: &Grains,
    stresses: &[f64],
    descent: impl Fn(u32) -> (Option<u32>, u32),
) -> Result<()> {
    let fields: [Of; 10] = [
        ("id", 1, &|i| vec![f64::from(g.id[i])]),
        ("radius_m", 1, &|i| vec![g.radius(i)]),
        ("velocity_m_s", 3, &|i| g.vel[i][..3].to_vec()),
        ("spin_rad_s", 3, &|i| g.spin[i][..3].to_vec()),
        ("generation", 1, &|i| vec![f64::from(g.generation[i])]),
        ("material", 1, &|i| vec![f64::from(g.material[i])]),
        ("strength_Pa", 1, &|i| vec![g.strength[i]]),
        ("mean_stress_Pa", 1, &|i| vec![stresses[i]]),
        ("mother_id", 1, &|i| vec![descent(g.id[i]).0.map_or(-1.0, f64::from)]),
        ("ancestor_id", 1, &|i| vec![f64::from(descent(g.id[i]).1)]),
    ];
    write_fields(path, facts, step, &g.by_id(), &g.pos, &fields)
}

fn write_fields(path: &Path, facts: &[Fact], step: u64, order: &[u32], position: &[[f64; 4]], fields: &[Of]) -> Result<()> {
    let indices = || order.iter().map(|&i| i as usize);
    let places: Vec<[f64; 3]> = indices().map(|i| [position[i][0], position[i][1], position[i][2]]).collect();
    let field = |&(name, components, of): &Of| Field { name, components, values: indices().flat_map(of).collect() };
    let fields: Vec<Field> = fields.iter().map(field).collect();
    vtk::write_points(path, facts, &places, &fields).map_err(VtkError::at(step))
}

/// Columns of the grains in a continuum.
/// Columns of the grains and rigid bodies; `plane`: in plane strain, whose axial direction is y.
fn coarse(g: &GrainMeasures, plane: bool) -> Row {
    let q = |s: [f64; 3]| 1e-3 * if plane { s[1] - s[0] } else { s[2] - 0.5 * (s[0] + s[1]) };
    // nothing but points has a stress across the plane
    let across = |s: [f64; 3]| if plane && g.void_ratio_points.is_nan() { 0.5 * (s[0] + s[1]) } else { s[2] };
    let p = |s: [f64; 3]| 1e-3 * (s[0] + s[1] + across(s)) / 3.0;
    let (axis, axial) = if plane { (1, "sigma_yy_of_contacts_kPa") } else { (2, "sigma_zz_of_contacts_kPa") };
    let [xx, yy, zz, xy, yz, zx] = g.touching.fabric;
    let mut row: Row = vec![
        ("grains", (g.count as u64).into()),
        ("crush_events", g.crush_events.into()),
        ("void_ratio_points", g.void_ratio_points.into()),
        ("coarse_mass_kg", (g.mass + g.body_mass).into()),
        ("coarse_kinetic_J", g.kinetic.into()),
        ("coarse_potential_J", g.potential.into()),
        ("coordination_number", (2.0 * g.touching.grains as f64 / (g.count + g.bodies).max(1) as f64).into()),
        ("platen_contacts", g.touching.walls.into()),
        ("point_contacts", g.touching.points.into()),
        ("fabric_xx", xx.into()),
        ("fabric_yy", yy.into()),
        ("fabric_zz", zz.into()),
        ("fabric_xy", xy.into()),
        ("fabric_yz", yz.into()),
        ("fabric_zx", zx.into()),
        ("q_matrix_kPa", q(g.shares.matrix).into()),
        ("q_skeleton_kPa", q(g.shares.skeleton).into()),
        ("q_interface_kPa", q(g.shares.interface).into()),
        ("p_matrix_kPa", p(g.shares.matrix).into()),
        ("p_skeleton_kPa", p(g.shares.skeleton).into()),
        ("p_interface_kPa", p(g.shares.interface).into()),
        (axial, (1e-3 * g.shares.total(axis)).into()),
        ("grain_steps", u64::from(g.rates[0]).into()),
        ("continuum_steps", u64::from(g.rates[1]).into()),
    ];
    if let Some(f) = &g.fines {
        row.extend([
            ("fines_points", f.points.into()),
            ("fines_mass_kg", f.entered.into()),
            ("reserve_mass_kg", f.reserve.into()),
            ("total_mass_kg", f.total.into()),
            ("released_J", f.released.into()),
        ]);
    }
    row
}
