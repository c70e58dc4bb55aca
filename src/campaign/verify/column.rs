//! A column that settles under its own weight.

use super::block::{self, FLIP, GIMP, Method, SMOOTH, elastic, fill};
use super::{Case, Found, Task};
use engine::mpm::{Continuum, Dimension, GridWall};
use laboratory::error::Result;

/// The case in the list of cases.
pub const CASE: Case = Case {
    name: "column",
    about: "A column between smooth walls settles under its own weight, suddenly applied, with local damping",
    exact: "σz = ρ g (H − z), settlement ρ g (H z − z²/2)/M for small strains; E 10 MPa, ν 0.3, ρ 2000 kg/m³, H 1 m: 0.72874 mm at the top",
    across: "cells along the height",
    resolutions: &[5, 10, 20, 40],
    ways: &["B-splines", "GIMP"],
    quantities: &["stress", "settlement"],
    scene: false,
    run,
    graphs: None,
};
const METHODS: [Method; 2] = [FLIP, GIMP];

fn run(task: &Task) -> Result<Found> {
    settle(METHODS[task.way], Dimension::PlaneStrain, GridWall::Symmetry, task.cells)
}

/// Errors as root mean squares over the points: vertical stress over ρ g H; settlement over that of
/// the top; lateral stress less k0 times the vertical one, over ρ g H. The last entry is the error
/// of the floor's reaction.
///
/// # Errors
/// A lost point.
pub fn settle(method: Method, dimension: Dimension, floor: GridWall, cells: u32) -> Result<Found> {
    let cell = 1.0 / f64::from(cells);
    let mut s = block::settings(dimension, cell, [1, cells + 2, 1], method);
    s.walls = SMOOTH;
    (s.walls[2], s.walls[3]) = (floor, GridWall::Open);
    (s.gravity, s.damping) = ([0.0, -9.81, 0.0], 0.4);
    let width = if dimension == Dimension::Space { cell } else { 0.0 };
    let points = fill(&s, [[0.0; 3], [cell, 1.0, width]], 2, 2000.0, |_| true, |_| [0.0; 3]);
    let start = points.clone();
    let mut c = Continuum::new(s, elastic(10e6, 0.3), points)?;
    let dt = c.stable_step(0.4);
    block::steps(&mut c, dt, 150 * u64::from(cells))?;
    let points = c.points();
    let (weight, modulus) = (2000.0 * 9.81, 13.461_538e6);
    let mut sums = [0.0; 3];
    for i in 0..points.len() {
        let z = start.position[points.id[i] as usize][1];
        let stress = (points.stress[i][1] + weight * (1.0 - z)) / weight;
        let settled = (z - points.position[i][1]) * modulus / weight;
        let lateral = (points.stress[i][0] - 3.0 / 7.0 * points.stress[i][1]) / weight;
        for (sum, error) in sums.iter_mut().zip([stress, 2.0 * settled - (2.0 * z - z * z), lateral]) {
            *sum += error * error;
        }
    }
    let count = points.len();
    let mut errors: Vec<f64> = sums.iter().map(|sum| (sum / count as f64).sqrt()).collect();
    errors.push(c.wall_force()[2][1] / (c.totals().mass * 9.81) - 1.0);
    Ok(Found { points: count, steps: c.steps(), errors })
}
