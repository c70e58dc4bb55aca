//! A grain that hits a ball of points.

use super::{Case, Found, Row, Task, scene};
use laboratory::error::Result;
use plot::{Drawn, Graph, Look, Quantity, Tone};

pub const CASE: Case = Case {
    name: "impact",
    about: "A grain at 5 m/s hits an elastic ball of points of its size (Li et al. 2023, section 3.1; scene ball_impact)",
    exact: "momentum and energy of two bodies that meet without loss; the second has the mass of its points",
    across: "cells along the diameter",
    resolutions: &[4, 6, 10, 16],
    ways: &["FLIP", "FLIP, 1 % PIC", "APIC"],
    quantities: &["velocity of the grain", "velocity of the points", "energy"],
    scene: true,
    run: |task| {
        let transfer = ["flip_pic", "flip_pic", "apic"][task.way];
        let pic = if task.way == 1 { 0.01 } else { 0.0 };
        simulate(task, &[format!("grid.transfer={transfer:?}"), format!("grid.pic={pic:?}")], 2)
    },
    graphs: None,
};
/// The case in which points and grid are refined apart from each other, with a ball as stiff as in
/// the paper and one of a tenth of that stiffness.
pub const REFINED: Case = Case {
    name: "impact_refined",
    about: "A grain at 5 m/s hits an elastic ball of points of its size, grid and points refined (scene ball_impact; contacts of 1 GPa)",
    exact: "momentum and energy of two bodies that meet without loss; the second has the mass of its points",
    across: "cells along the diameter",
    resolutions: &[4, 6, 8, 10, 12],
    ways: &[
        "1 GPa, 2 points along an edge",
        "1 GPa, 3 points",
        "1 GPa, 4 points",
        "0.1 GPa, 2 points along an edge",
        "0.1 GPa, 3 points",
        "0.1 GPa, 4 points",
    ],
    quantities: &["velocity of the grain", "velocity of the points", "energy", "momentum"],
    scene: true,
    run: |task| {
        let (per_edge, soft) = (2 + task.way % 3, task.way >= 3);
        let (young, duration) = if soft { (100.0, 0.006) } else { (1000.0, 0.002) };
        let ball = [
            format!("materials.ball.continuum.E_MPa={young:?}"),
            format!("duration_s={duration:?}"),
            format!("grid.points_per_edge={per_edge}"),
        ];
        simulate(task, &ball, per_edge)
    },
    graphs: Some(losses),
};
/// Radius of both bodies, mm, their density, kg/m³, and the speed of the grain, m/s.
const RADIUS: f64 = 34.199519;
const DENSITY: f64 = 2000.0;
const SPEED: f64 = 5.0;

/// Errors of the velocities, of the energy and of the momentum; then the share of the initial
/// energy that is not energy of translation of either body.
fn simulate(task: &Task, own: &[String], per_edge: usize) -> Result<Found> {
    let cell = 2.0 * RADIUS / f64::from(task.cells);
    let corner = [2.0 * RADIUS, 2.0 * RADIUS, 3.0 * RADIUS];
    let mut sets =
        vec![format!("grid.cell_mm={cell:?}"), format!("grid.min_mm={:?}", corner.map(|x| -x)), format!("grid.max_mm={corner:?}")];
    sets.extend_from_slice(own);
    let run = scene::run(task, "../mixture/ball_impact", &sets)?;
    let (points, steps) = run.size()?;
    let mass = points as f64 * DENSITY * (1e-3 * cell / per_edge as f64).powi(3);
    let (grain, start) = (run.ends("coarse_mass_kg")?[1], 0.5 * run.ends("coarse_mass_kg")?[1] * SPEED * SPEED);
    let left = run.column("grains_final.csv", "vz_m_s")?[0];
    let momentum = run.ends("momentum_z_kg_m_s")?[1];
    let carried = momentum / mass;
    let of_grain = -SPEED * (grain - mass) / (grain + mass);
    let of_points = -SPEED * 2.0 * grain / (grain + mass);
    let energy = run.ends("kinetic_J")?[1] + run.ends("coarse_kinetic_J")?[1] + run.ends("stress_work_J")?[1];
    let errors = vec![
        (left - of_grain) / SPEED,
        carried / of_points - 1.0,
        energy / start - 1.0,
        (grain * left + momentum) / (-SPEED * grain) - 1.0,
        1.0 - 0.5 * (grain * left * left + mass * carried * carried) / start,
    ];
    Ok(Found { points, steps, errors })
}

/// Graphs of the energy of translation lost in the impact: against the number of points of the
/// ball, and against the number of cells along its diameter.
fn losses(rows: &[Row]) -> Vec<Graph> {
    let graph = |end: &str, x: Quantity, at: fn(&Row) -> f64| {
        let mut series = Vec::new();
        for (way, name) in REFINED.ways.iter().enumerate() {
            let points: Vec<(f64, f64)> =
                rows.iter().filter(|r| r.way == way).map(|r| (at(r), 100.0 * r.found.errors[4])).collect();
            let drawn =
                |look, label| Drawn { label, name: (*name).into(), tone: Tone::Kind(way % 3), look, points: points.clone() };
            series.push(drawn(Look::Line(way / 3), Some((*name).into())));
            series.push(drawn(Look::Symbols(way / 3), None));
        }
        Graph {
            name: format!("{}_loss_{end}", REFINED.name),
            title: vec!["a grain hits a ball of points".into(), "FLIP".into()],
            legend_title: None,
            x,
            y: Quantity::linear("energy of translation lost (%)", "lost_percent", &[0.0]),
            series,
        }
    };
    vec![
        graph("points", Quantity::log("points of the ball", "points"), |r| r.found.points as f64),
        graph("cells", Quantity::log(REFINED.across, "cells"), |r| f64::from(r.cells)),
    ]
}
