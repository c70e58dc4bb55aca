//! A block of material points that slides on a wall; the contacts are those of the points' ghosts.

use super::{Case, Found, Task, scene, slide};
use laboratory::error::Result;
use std::f64::consts::PI;

pub const CASE: Case = Case {
    name: "contact_slide",
    about: "A block of points slides on a wall of grains' contacts, half a second (Li et al. 2023, section 3.2; scene mixture/sliding_block)",
    exact: EXACT,
    across: "cells along the height",
    resolutions: &[3, 6, 10],
    ways: WAYS,
    quantities: QUANTITIES,
    scene: true,
    run,
    graphs: None,
};
pub(super) const EXACT: &str = "v = v₀ + (10 − 10 μ) t, s = (v₀ + v) t/2 (eqs 40, 41, there from rest)";
/// Height of the block, mm, pressure under it, Pa, and E* of its ghosts on a rigid wall, Pa.
const HEIGHT: f64 = 150.0;
const PRESSURE: f64 = 2000.0 * 10.0 * 0.15;
pub(super) const MODULUS: f64 = 80e6 / (1.0 - POISSON * POISSON);
const POISSON: f64 = 0.3;

pub(super) const QUANTITIES: &[&str] = &["velocity", "distance", "distance, give known"];
/// Quantities of a body that slides from the start: the contacts slide at once, so that there is no
/// error with their deformation taken into account.
pub(super) const SLIDES: &[&str] = &["velocity", "distance"];
/// Frictions with a start from rest, where contacts first deform until friction is mobilised; then
/// the same frictions with a speed at the start, so that the block slides at once.
pub(super) const WAYS: &[&str] = &[
    FRICTIONS[0],
    FRICTIONS[1],
    FRICTIONS[2],
    FRICTIONS[3],
    FRICTIONS[4],
    "μ = 0.1, from 0.3 m/s",
    "μ = 0.2, from 0.3 m/s",
    "μ = 0.3, from 0.3 m/s",
    "μ = 0.4, from 0.3 m/s",
    "μ = 0.5, from 0.3 m/s",
];
pub(super) const FRICTIONS: &[&str] = &["μ = 0.1", "μ = 0.2", "μ = 0.3", "μ = 0.4", "μ = 0.5"];
/// Number of ways that start from rest; these come first in [`WAYS`].
pub(super) const AT_REST: usize = FRICTIONS.len();

/// Friction, and speed at the start, m/s, of the way with this index in [`WAYS`].
pub(super) fn friction_and_speed(way: usize) -> (f64, f64) {
    (0.1 * (way % AT_REST + 1) as f64, if way < AT_REST { 0.0 } else { 0.3 })
}

fn run(task: &Task) -> Result<Found> {
    let (friction, start) = friction_and_speed(task.way);
    let sets = [
        format!("grid.cell_mm={:?}", cell(task)),
        format!("grid.min_mm={:?}", [100.0, 50.0, 100.0].map(|x| -whole(task, x))),
        format!("grid.max_mm={:?}", [1700.0, 200.0, 300.0].map(|x| whole(task, x))),
        format!("wall[0].point_m=[0.0, 0.0, {:?}]", wall(task, MODULUS)),
        format!("wall[0].friction={friction:?}"),
        format!("body[0].velocity_m_s=[{start:?}, 0.0, 0.0]"),
    ];
    let run = scene::run(task, "../mixture/sliding_block", &sets)?;
    let (mut found, time) = (slide::found(&run, friction, start)?, run.number("time_s")?);
    found.errors.push(with_give(found.errors[1], (task, task.way), MODULUS, time));
    Ok(found)
}

/// Error of the distance against a closed form that includes the deformation of the contacts;
/// `error` is the error against eq. 40.
///
/// From rest the contacts first act as springs: the block moves by x'' = g − ω² x, ω² = Σk_t/m,
/// until friction is mobilised at the time t₁ with cos ω t₁ = 1 − μ. From then on eq. 40 holds.
/// Hertz–Mindlin: k_t = 6 (G*/E*) F/δ; for equal materials and for a rigid wall alike,
/// G*/E* = (1 − ν)/(2 (2 − ν)). With a speed at the start, `error` is returned.
pub(super) fn with_give(error: f64, (task, way): (&Task, usize), modulus: f64, time: f64) -> f64 {
    let (friction, start) = friction_and_speed(way);
    let [_, whole] = slide::exact(friction, start, time);
    if start > 0.0 {
        return error;
    }
    let (gravity, ratio) = (10.0, (1.0 - POISSON) / (2.0 * (2.0 - POISSON)));
    let omega = (6.0 * ratio * gravity / depth(task, modulus)).sqrt();
    let held = (1.0 - friction).acos() / omega;
    let (speed, gone) = (gravity / omega * (omega * held).sin(), friction * gravity / (omega * omega));
    let [_, then] = slide::exact(friction, speed, time - held);
    (1.0 + error) * whole / (gone + then) - 1.0
}

/// Edge of a cell, mm.
pub(super) fn cell(task: &Task) -> f64 {
    HEIGHT / f64::from(task.cells)
}

/// Overlap, m, of each ghost in the face of the points with the other body, under the block's
/// weight (Hertz).
fn depth(task: &Task, modulus: f64) -> f64 {
    let spacing = 0.5e-3 * cell(task);
    let ghost = (0.75 / PI).cbrt() * spacing;
    (PRESSURE * spacing * spacing / (4.0 / 3.0 * modulus * ghost.sqrt())).cbrt().powi(2)
}

/// Position of the surface of the other body, m from the face of the points, positive into the
/// points. Ghosts reach out of the face by their radius less half a spacing, and overlap by
/// [`depth`].
pub(super) fn wall(task: &Task, modulus: f64) -> f64 {
    let spacing = 0.5e-3 * cell(task);
    let ghost = (0.75 / PI).cbrt() * spacing;
    0.5 * spacing - ghost + depth(task, modulus)
}

/// The length, mm, rounded up to whole cells, so that the points' lattice fits the grid and the
/// block stands on a node.
pub(super) fn whole(task: &Task, length: f64) -> f64 {
    cell(task) * (length / cell(task)).ceil()
}
