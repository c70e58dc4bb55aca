//! A rigid box, and Li's superquadric, that slide on a plane of material points; the contacts are
//! those of the points' ghosts.

use super::{Case, Found, Task, contact_slide, scene, slide};
use laboratory::error::Result;

pub const CASE: Case = Case {
    name: "contact_box",
    about: "A rigid box slides on a plane of points, half a second (Li et al. 2023, section 3.2; scene mixture/sliding_box)",
    exact: contact_slide::EXACT,
    across: "cells along the height of the box",
    resolutions: &[3, 6],
    ways: contact_slide::WAYS,
    quantities: contact_slide::QUANTITIES,
    scene: true,
    run: |task| slide_on_points(task, task.way, &[]),
    graphs: None,
};
pub const SUPERQUADRIC: Case = Case {
    name: "contact_superquadric",
    about: "A superquadric slides on a plane of points from 0.3 m/s, half a second (Li et al. 2023, section 3.2, eq. 39 with n₁ = n₂ = 20; as large as the box)",
    exact: contact_slide::EXACT,
    across: "cells along the height of the body",
    resolutions: &[3, 6],
    ways: contact_slide::FRICTIONS,
    quantities: contact_slide::SLIDES,
    scene: true,
    run: |task| {
        let sets = ["block[0].shape=\"superquadric\"", "block[0].blockiness=[20.0, 20.0]"];
        slide_on_points(task, task.way + contact_slide::AT_REST, &sets)
    },
    graphs: None,
};
/// E* of two bodies of the same material, Pa.
const MODULUS: f64 = 0.5 * contact_slide::MODULUS;
/// Middle of the box over its lower face, mm.
const MIDDLE: f64 = 75.0;

fn slide_on_points(task: &Task, way: usize, others: &[&str]) -> Result<Found> {
    let (friction, speed) = contact_slide::friction_and_speed(way);
    let whole = |length: f64| contact_slide::whole(task, length);
    let [low, high, bottom] =
        [[-100.0, -25.0, -50.0].map(|x| -whole(-x)), [1600.0, 175.0, 0.0].map(whole), [0.0, 0.0, 50.0].map(whole)];
    let top = [high[0], high[1], bottom[2]];
    let mut sets = vec![
        format!("grid.cell_mm={:?}", contact_slide::cell(task)),
        format!("grid.min_mm={low:?}"),
        format!("grid.max_mm={top:?}"),
        format!("body[0].min_mm={low:?}"),
        format!("body[0].max_mm={high:?}"),
        format!("block[0].position_mm={:?}", [150.0, 75.0, MIDDLE - 1e3 * contact_slide::wall(task, MODULUS)]),
        format!("material.contact.friction={friction:?}"),
        format!("block[0].velocity_m_s=[{speed:?}, 0.0, 0.0]"),
    ];
    sets.extend(others.iter().map(|s| String::from(*s)));
    let run = scene::run(task, "../mixture/sliding_box", &sets)?;
    let (points, steps) = run.size()?;
    let ends = |column: &str| run.column("blocks.csv", column).map(|all| [all[0], all[all.len() - 1]]);
    let ([_, time], [start, end], [_, velocity]) = (ends("time_s")?, ends("x_m")?, ends("vx_m_s")?);
    let dt = run.column("history.csv", "dt_s")?;
    // recorded velocities are those half a step before the recorded time
    let exact = |time: f64| slide::exact(friction, speed, time);
    let velocity = velocity / exact(time - 0.5 * dt[dt.len() - 1])[0] - 1.0;
    let distance = (end - start) / exact(time)[1] - 1.0;
    let with_give = contact_slide::with_give(distance, (task, way), MODULUS, time);
    Ok(Found { points, steps, errors: vec![velocity, distance, with_give] })
}
