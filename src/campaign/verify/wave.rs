//! Speed of a compression wave.

use super::block::{self, APIC, FLIP, GIMP, Method, elastic, fill};
use super::{Case, Found, Task};
use engine::mpm::Continuum;
use laboratory::error::Result;

/// The case in the list of cases.
pub const CASE: Case = Case {
    name: "wave",
    about: "A bell of velocity parts into two that run along a strip without lateral strain",
    exact: "c = √(M/ρ), M = E (1 − ν)/((1 + ν)(1 − 2ν)); E 10 MPa, ν 0.3, ρ 2000 kg/m³: 82.041265 m/s; the half that runs on keeps half of the momentum",
    across: "cells along half the width of the bell",
    resolutions: &[2, 4, 8, 16, 32],
    ways: &["B-splines, FLIP", "GIMP, FLIP", "B-splines, APIC"],
    quantities: &["speed", "momentum"],
    scene: false,
    run,
    graphs: None,
};
const METHODS: [Method; 3] = [FLIP, GIMP, APIC];
const SPEED: f64 = 82.041_265;

fn run(task: &Task) -> Result<Found> {
    travel(METHODS[task.way], task.cells)
}

/// Errors, after 0.1 s, of the speed of the half that runs away from the wall, and of its share of
/// the momentum; `cells` cells to a metre.
///
/// # Errors
/// A lost point.
pub fn travel(method: Method, cells: u32) -> Result<Found> {
    let cell = 1.0 / f64::from(cells);
    let s = block::strip(cell, 20 * cells, method);
    let bell = |x: f64| 1e-3 * (-(x - 5.0) * (x - 5.0)).exp();
    let points = fill(&s, [[0.0; 3], [19.0, cell, 0.0]], 2, 2000.0, |_| true, |[x, ..]| [bell(x), 0.0, 0.0]);
    let count = points.len();
    let mut c = Continuum::new(s, elastic(10e6, 0.3), points)?;
    let whole = c.totals().momentum[0];
    let n = 50 * cells;
    let time = 0.1;
    block::steps(&mut c, time / f64::from(n), n.into())?;
    let points = c.points();
    // 9.5 m lies between this half, now near 13.2 m, and the reflection of the other half, near 3.2
    // m
    let ahead = (0..points.len()).filter(|&i| points.position[i][0] > 9.5);
    let (p, px) = ahead.fold((0.0, 0.0), |(p, px), i| {
        let [x, v, m] = [points.position[i][0], points.velocity[i][0], points.velocity[i][3]];
        (p + m * v, px + m * v * x)
    });
    let speed = (px / p - 5.0) / time;
    Ok(Found { points: count, steps: c.steps(), errors: vec![speed / SPEED - 1.0, p / (0.5 * whole) - 1.0] })
}
