//! A grain that hits a ball of points.

use super::{Case, Found, Task, scene};
use crate::error::Result;

pub const CASE: Case = Case {
    name: "impact",
    about: "A grain at 5 m/s hits an elastic ball of points of its size (Li et al. 2023, section 3.1; scene ball_impact)",
    exact: "momentum and energy of two bodies that meet without loss; the second has the mass of its points",
    across: "cells along the diameter",
    resolutions: &[4, 6, 10, 16],
    ways: &["FLIP", "FLIP, 1 % PIC", "APIC"],
    quantities: &["velocity of the grain", "velocity of the points", "energy"],
    run,
    graphs: None,
};
/// Radius of both, mm, density, kg/m³, and speed, m/s.
const RADIUS: f64 = 34.199519;
const DENSITY: f64 = 2000.0;
const SPEED: f64 = 5.0;

fn run(task: &Task) -> Result<Found> {
    let cell = 2.0 * RADIUS / f64::from(task.cells);
    let corner = [2.0 * RADIUS, 2.0 * RADIUS, 3.0 * RADIUS];
    let mut sets = vec![
        format!("grid.cell_mm={cell:?}"),
        format!("grid.min_mm={:?}", corner.map(|x| -x)),
        format!("grid.max_mm={corner:?}"),
        format!("grid.transfer=\"{}\"", if task.way == 2 { "apic" } else { "flip_pic" }),
    ];
    if task.way == 1 {
        sets.push("grid.pic=0.01".into());
    }
    let run = scene::run(task, "../mixture/ball_impact", &sets)?;
    let (points, steps) = run.size()?;
    let last =
        |column: &str| Ok::<f64, crate::error::Error>(run.column("history.csv", column)?.last().copied().unwrap_or(f64::NAN));
    let mass = points as f64 * DENSITY * (0.5e-3 * cell).powi(3);
    let (grain, start) = (last("coarse_mass_kg")?, 0.5 * last("coarse_mass_kg")? * SPEED * SPEED);
    let left = run.column("grains_final.csv", "vz_m_s")?[0];
    let carried = last("momentum_z_kg_m_s")? / mass;
    let of_grain = -SPEED * (grain - mass) / (grain + mass);
    let of_points = -SPEED * 2.0 * grain / (grain + mass);
    let energy = last("kinetic_J")? + last("coarse_kinetic_J")? + last("stress_work_J")?;
    Ok(Found { points, steps, errors: vec![(left - of_grain) / SPEED, carried / of_points - 1.0, energy / start - 1.0] })
}
