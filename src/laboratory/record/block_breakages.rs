//! Rows of `block_breakage.csv`: rigid bodies that have broken.

use engine::rigid::Breakage;
use table::Row;

/// Table of the breakages of rigid bodies.
pub const BLOCK_BREAKAGE: &str = "block_breakage.csv";

/// The row of a breakage that was recorded at `time`, s.
pub fn row(b: &Breakage, time: f64) -> Row {
    vec![
        ("event", b.event.into()),
        ("step", b.step.into()),
        ("time_s", time.into()),
        ("block", u64::from(b.pieces[0]).into()),
        ("piece", u64::from(b.pieces[1]).into()),
        ("pieces", (b.pieces.len() as u64).into()),
        ("generation", u64::from(b.generation).into()),
        ("age_steps", b.age.into()),
        ("diameter_mm", (1e3 * b.diameter).into()),
        ("force_N", b.force.into()),
        ("limit_force_N", b.limit_force.into()),
        ("utilisation", (b.force / b.limit_force).into()),
        ("area_mm2", (1e6 * b.area).into()),
        ("strength_MPa", (1e-6 * b.strength).into()),
        ("x_mm", (1e3 * b.position[0]).into()),
        ("y_mm", (1e3 * b.position[1]).into()),
        ("z_mm", (1e3 * b.position[2]).into()),
        ("normal_x", b.normal[0].into()),
        ("normal_y", b.normal[1].into()),
        ("normal_z", b.normal[2].into()),
        ("block_mass_g", (1e3 * b.masses[0]).into()),
        ("piece_mass_g", (1e3 * b.masses[1]).into()),
        ("lost_volume_mm3", (1e9 * b.lost_volume).into()),
        ("stored_J", b.stored.into()),
        ("lost_kinetic_J", b.lost_kinetic.into()),
    ]
}
