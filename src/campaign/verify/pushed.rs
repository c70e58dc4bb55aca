//! An elastic block pushed by a platen through three cells of the grid.

use super::{Case, Found, Task, scene};
use laboratory::error::Result;

pub const CASE: Case = Case {
    name: "pushed",
    about: "A long elastic block is pushed by a platen, through three cells of the grid (scene pushed_block; errors from the first cell on)",
    exact: "σ = M ln(1/(1 − ε)), uniaxial strain with the rate form of elasticity",
    across: "cells along the block",
    resolutions: &[15, 30, 60, 120],
    ways: &["plane strain", "space"],
    quantities: &["reaction, mean", "reaction, largest", "ripple"],
    scene: true,
    run,
    graphs: None,
};
/// Length of the block, mm, and cells that its end passes through.
const LENGTH: f64 = 300.0;
const PASSED: f64 = 3.0;

fn run(task: &Task) -> Result<Found> {
    let cell = LENGTH / f64::from(task.cells);
    let end = PASSED / f64::from(task.cells);
    let mut sets = vec![format!("grid.cell_mm={cell:?}"), format!("test.axial_strain={end:?}")];
    if task.way == 0 {
        sets.extend(["grid.plane_strain=true".into(), format!("body[0].max_mm=[{cell:?}, {LENGTH:?}, 0.0]")]);
    } else {
        sets.push(format!("body[0].max_mm=[{cell:?}, {cell:?}, {LENGTH:?}]"));
    }
    let run = scene::run(task, "pushed_block", &sets)?;
    let (points, steps) = run.size()?;
    let modulus = 1e3 * run.number("oedometric_modulus_of_the_law_MPa")?;
    let pairs = run.column("history.csv", "axial_strain")?.into_iter().zip(run.column("history.csv", "sigma_v_kPa")?);
    let ratios: Vec<f64> = pairs.filter(|(e, _)| *e > end / PASSED).map(|(e, s)| s / (modulus * (1.0 / (1.0 - e)).ln())).collect();
    let (low, high) = ratios.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(*x), b.max(*x)));
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    Ok(Found { points, steps, errors: vec![mean - 1.0, (high - 1.0).max(1.0 - low), high - low] })
}
