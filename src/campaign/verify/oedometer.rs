//! An elastic oedometer under its platen.

use super::{Case, Found, Task, scene};
use laboratory::error::Result;

pub const CASE: Case = Case {
    name: "oedometer",
    about: "An elastic soil under the platen of an oedometer, to 2 % strain (scene oedometer)",
    exact: "M = E (1 − ν)/((1 + ν)(1 − 2ν)), k0 = ν/(1 − ν); E 10 MPa, ν 0.3: 13.462 MPa and 0.42857",
    across: "cells along the height",
    resolutions: &[3, 6, 12, 24],
    ways: &["plane strain", "space"],
    quantities: &["modulus", "k0"],
    scene: true,
    run,
    graphs: None,
};
/// Height of the specimen, mm.
const HEIGHT: f64 = 60.0;

fn run(task: &Task) -> Result<Found> {
    let cell = format!("grid.cell_mm={:?}", HEIGHT / f64::from(task.cells));
    let plane = ["grid.plane_strain=true".into(), format!("body[0].max_mm=[20.0, {HEIGHT:?}, 0.0]")];
    let sets: Vec<String> = if task.way == 0 { [cell].into_iter().chain(plane).collect() } else { vec![cell] };
    let run = scene::run(task, "oedometer", &sets)?;
    let (points, steps) = run.size()?;
    let modulus = run.number("oedometric_modulus_MPa")? / run.number("oedometric_modulus_of_the_law_MPa")?;
    Ok(Found { points, steps, errors: vec![modulus - 1.0, run.number("k0_final")? / (3.0 / 7.0) - 1.0] })
}
