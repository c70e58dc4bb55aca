//! A block that slides down a frictional slope.

use super::{Case, Found, Task, scene};
use crate::error::Result;

pub const CASE: Case = Case {
    name: "slide",
    about: "A block slides from rest down a slope of 45° with Coulomb's friction, half a second, gravity 10 √2 m/s² (scene sliding_block)",
    exact: "v = (10 − 10 μ) t, s = v t/2 (Li et al. 2023, section 3.2, eqs 40, 41; theirs is made of grains and points)",
    across: "cells along the height",
    resolutions: &[2, 4, 8, 16],
    ways: &["μ = 0.1", "μ = 0.3", "μ = 0.5", "μ = 0.5, 1 % PIC"],
    quantities: &["velocity", "distance"],
    run,
    graphs: None,
};
const FRICTION: [f64; 4] = [0.1, 0.3, 0.5, 0.5];
/// Height of the block, mm.
const HEIGHT: f64 = 150.0;

fn run(task: &Task) -> Result<Found> {
    let friction = FRICTION[task.way];
    let mut sets = vec![format!("grid.cell_mm={:?}", HEIGHT / f64::from(task.cells)), format!("grid.friction={friction:?}")];
    if task.way == 3 {
        sets.push("grid.pic=0.01".into());
    }
    let run = scene::run(task, "sliding_block", &sets)?;
    found(&run, friction)
}

/// Errors of a block that has slid from rest, as its run has left it.
pub(super) fn found(run: &scene::Run, friction: f64) -> Result<Found> {
    let (points, steps) = run.size()?;
    let time = run.number("time_s")?;
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let velocity = mean(run.column("points_final.csv", "vx_m_s")?);
    let moved = mean(run.column("points_final.csv", "x_m")?) - mean(run.column("points_start.csv", "x_m")?);
    let exact = 10.0 * (1.0 - friction) * time;
    Ok(Found { points, steps, errors: vec![velocity / exact - 1.0, moved / (0.5 * exact * time) - 1.0] })
}
