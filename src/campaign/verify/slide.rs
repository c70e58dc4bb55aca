//! A block that slides down a frictional slope.

use super::{Case, Found, Task, scene};
use laboratory::error::Result;

pub const CASE: Case = Case {
    name: "slide",
    about: "A block slides from rest down a slope of 45° with Coulomb's friction, half a second, gravity 10 √2 m/s² (scene sliding_block)",
    exact: "v = (10 − 10 μ) t, s = v t/2 (Li et al. 2023, section 3.2, eqs 40, 41; theirs is made of grains and points)",
    across: "cells along the height",
    resolutions: &[2, 4, 8, 16],
    ways: &["μ = 0.1", "μ = 0.3", "μ = 0.5", "μ = 0.5, 1 % PIC"],
    quantities: &["velocity", "distance"],
    scene: true,
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
    found(&run, friction, 0.0)
}

/// Velocity, m/s, and distance, m, after a time, s, of a block that starts with the speed `start`,
/// m/s (Li et al. 2023, eqs 40, 41).
pub(super) fn exact(friction: f64, start: f64, time: f64) -> [f64; 2] {
    let gained = 10.0 * (1.0 - friction) * time;
    [start + gained, (start + 0.5 * gained) * time]
}

/// Errors of velocity and distance in the run of a block that started with the speed `start`, m/s.
pub(super) fn found(run: &scene::Run, friction: f64, start: f64) -> Result<Found> {
    let (points, steps) = run.size()?;
    let time = run.number("time_s")?;
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    let velocity = mean(run.column("points_final.csv", "vx_m_s")?);
    let moved = mean(run.column("points_final.csv", "x_m")?) - mean(run.column("points_start.csv", "x_m")?);
    let [speed, way] = exact(friction, start, time);
    Ok(Found { points, steps, errors: vec![velocity / speed - 1.0, moved / way - 1.0] })
}
