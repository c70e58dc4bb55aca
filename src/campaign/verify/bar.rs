//! Axial vibration of a bar.

use super::block::{self, APIC, FLIP, GIMP, Method, elastic, fill};
use super::{Case, Found, Task};
use engine::mpm::Continuum;
use laboratory::error::Result;
use std::f64::consts::PI;

/// The case in the list of cases.
pub const CASE: Case = Case {
    name: "bar",
    about: "Axial vibration of a bar, fixed at one end, in its first mode, over two periods",
    exact: "v = v0 cos(ω t) sin(π x/2L), ω = (π/2L) √(E/ρ); L 25 m, E 100 Pa, ρ 1 kg/m³, ν 0: the period is 10 s, the energy stays",
    across: "cells along the bar",
    resolutions: &[12, 25, 50, 100],
    ways: &["B-splines, FLIP", "GIMP, FLIP", "B-splines, APIC"],
    quantities: &["period", "energy"],
    scene: false,
    run,
    graphs: None,
};
const METHODS: [Method; 3] = [FLIP, GIMP, APIC];
const LENGTH: f64 = 25.0;

fn run(task: &Task) -> Result<Found> {
    vibrate(METHODS[task.way], task.cells)
}

/// Errors of the period and of the energy (kinetic energy plus stress work).
///
/// # Errors
/// A lost point.
pub fn vibrate(method: Method, cells: u32) -> Result<Found> {
    let cell = LENGTH / f64::from(cells);
    let s = block::strip(cell, cells + cells / 5 + 2, method);
    let velocity = |[x, ..]: [f64; 3]| [0.1 * (0.5 * PI * x / LENGTH).sin(), 0.0, 0.0];
    let points = fill(&s, [[0.0; 3], [LENGTH, cell, 0.0]], 2, 1.0, |_| true, velocity);
    let count = points.len();
    let mut c = Continuum::new(s, elastic(100.0, 0.0), points)?;
    let dt = 0.2 * cell / 10.0;
    let start = c.totals().kinetic;
    let (mut last, mut zeros) = (0.0, vec![]);
    for k in 1..=(20.0 / dt).round() as u64 {
        c.step(dt)?;
        let v = c.totals().momentum[0];
        if last * v < 0.0 {
            zeros.push((k as f64 - v / (v - last)) * dt);
        }
        last = v;
    }
    let t = c.totals();
    // from the first to the fourth zero of the momentum there are three half periods
    let period = zeros.get(3).map_or(f64::INFINITY, |last| 2.0 * (last - zeros[0]) / 3.0);
    Ok(Found { points: count, steps: c.steps(), errors: vec![period / 10.0 - 1.0, (t.kinetic + c.stress_work()) / start - 1.0] })
}
