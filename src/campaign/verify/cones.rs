//! Drucker–Prager in triaxial compression on the grid.

use super::{Case, Found, Task, scene};
use laboratory::error::Result;

pub const CASE: Case = Case {
    name: "cones",
    about: "Triaxial compression of a perfectly plastic cube between six platens, the largest error at three cell pressures (50, 100 and 200 kPa; scene triaxial_cones)",
    exact: "q = 3√3 α σ3/(1 − √3 α) with each cone's α; φ 30°: 2, 1.2 and 1.1514 times σ3",
    across: "cells along an edge",
    resolutions: &[2, 3, 4, 6],
    ways: &["outer cone", "inner cone", "plane-strain cone"],
    quantities: &["strength"],
    scene: true,
    run,
    graphs: None,
};
const CONES: [(&str, f64); 3] = [("outer", 2.0), ("inner", 1.2), ("plane_strain", 1.151_388)];
/// Edge of the cube, mm.
const EDGE: f64 = 60.0;

fn run(task: &Task) -> Result<Found> {
    let (cone, strength) = CONES[task.way];
    let mut found = Found { points: 0, steps: 0, errors: vec![0.0] };
    for cell_pressure in [50.0, 100.0, 200.0] {
        let sets = [
            format!("grid.cell_mm={:?}", EDGE / f64::from(task.cells)),
            format!("material.continuum.cone={cone:?}"),
            format!("test.cell_pressure_kPa={cell_pressure:?}"),
        ];
        let run = scene::run(task, "triaxial_cones", &sets)?;
        let (points, steps) = run.size()?;
        let error = run.number("residual_stress_ratio")? / (1.0 + strength) - 1.0;
        found.points = points;
        found.steps += steps;
        found.errors[0] = error.abs().max(found.errors[0]);
    }
    Ok(found)
}
