//! The patch test: the strain rate that points see in a uniform gradient of velocity, and a box of
//! points that must stay at rest under uniform stress.

use super::block::{self, APIC, FLIP, GIMP, Method, SMOOTH, elastic, fill};
use super::{Case, Found, Task};
use engine::mpm::{Continuum, Dimension};
use laboratory::error::Result;

/// The case in the list of cases.
pub const CASE: Case = Case {
    name: "patch",
    about: "Points at random places in a uniform gradient of velocity, seen with affine fields; a box of points at uniform stress",
    exact: "every point sees the gradient; nothing moves (speeds over those that the stress would give without the walls)",
    across: "cells along the block",
    resolutions: &[3, 5, 10, 20],
    ways: &["B-splines", "GIMP"],
    quantities: &["strain rate", "speed"],
    scene: false,
    run,
    graphs: None,
};

fn run(task: &Task) -> Result<Found> {
    let rest = equilibrium([FLIP, GIMP][task.way], task.cells)?;
    // with GIMP there are no affine fields
    let seen = if task.way == 0 { gradient(task.cells)?.errors[0] } else { f64::NAN };
    Ok(Found { errors: vec![seen, rest.errors[0]], ..rest })
}

/// Largest error of a component of the strain rate at any point, those at the edges included, over
/// the largest component of the gradient.
///
/// # Errors
/// A lost point.
pub fn gradient(cells: u32) -> Result<Found> {
    let a = [[0.3, -0.2, 0.5], [0.1, 0.4, -0.6], [0.7, -0.1, 0.2]];
    let field = |x: [f64; 3]| a.map(|row: [f64; 3]| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
    let mut random = 1_u64;
    let mut draw = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / (1_u64 << 24) as f64
    };
    let cell = 0.4 / f64::from(cells);
    let s = block::settings(Dimension::Space, cell, [cells + 6; 3], APIC);
    let (low, size) = (3.0 * cell, 0.4);
    let mut points = fill(&s, [[low; 3], [low + size; 3]], 2, 1000.0, |_| true, |_| [0.0; 3]);
    for i in 0..points.len() {
        let x: [f64; 3] = std::array::from_fn(|_| low + size * draw());
        points.position[i][..3].copy_from_slice(&x);
        points.velocity[i][..3].copy_from_slice(&field(x));
    }
    let count = points.len();
    // λ = 0, 2G = E: stress over E is strain
    let mut c = Continuum::new(s, elastic(1e-6, 0.0), points)?;
    c.points_mut().affine.fill(std::array::from_fn(|column| std::array::from_fn(|row| a[row][column])));
    // a very short step, because the field itself changes by A² Δt in the step
    let dt = 1e-9;
    c.step(dt)?;
    let exact = [a[0][0], a[1][1], a[2][2], 0.5 * (a[0][1] + a[1][0]), 0.5 * (a[1][2] + a[2][1]), 0.5 * (a[0][2] + a[2][0])];
    let worst =
        c.points().stress.iter().flat_map(|s| s.iter().zip(exact).map(|(s, e)| (s / 1e-6 / dt - e).abs())).fold(0.0, f64::max);
    Ok(Found { points: count, steps: c.steps(), errors: vec![worst / 0.7] })
}

/// Errors of a box full of points with stresses of 100, 200 and 300 kPa, between smooth walls,
/// after 100 steps: largest speed over the speed that an unbalanced 100 kPa would give to one cell
/// of material, and largest error of the force on a wall.
///
/// # Errors
/// A lost point.
pub fn equilibrium(method: Method, cells: u32) -> Result<Found> {
    let cell = 0.5 / f64::from(cells);
    let mut s = block::settings(Dimension::Space, cell, [cells; 3], method);
    s.walls = SMOOTH;
    let mut points = fill(&s, [[0.0; 3], [0.5; 3]], 2, 1000.0, |_| true, |_| [0.0; 3]);
    points.stress.fill([-1e5, -2e5, -3e5, 0.0, 0.0, 0.0]);
    let count = points.len();
    let mut c = Continuum::new(s, elastic(10e6, 0.3), points)?;
    let dt = c.stable_step(0.5);
    block::steps(&mut c, dt, 100)?;
    let fastest = c.points().velocity.iter().flat_map(|v| [v[0], v[1], v[2]]).fold(0.0_f64, |a, v| a.max(v.abs()));
    let free = 1e5 / (1000.0 * cell) * 100.0 * dt;
    let side = |(force, exact): (&[f64; 3], f64)| force.iter().map(|f| f.abs()).fold(0.0, f64::max) / (0.25 * exact) - 1.0;
    let walls = c.wall_force().iter().zip([1e5, 1e5, 2e5, 2e5, 3e5, 3e5]).map(side).fold(0.0_f64, |a, e| a.max(e.abs()));
    Ok(Found { points: count, steps: c.steps(), errors: vec![fastest / free, walls] })
}
