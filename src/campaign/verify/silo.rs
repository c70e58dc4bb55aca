//! A silo that empties through its neck in plane strain, against the flow law that Jiang et al. 2020 compare with.

use super::{Case, Found, Row, Task, scene};
use laboratory::error::{Error, Result};
use plot::{Drawn, Graph, Look, Quantity, Tone};

pub const CASE: Case = Case {
    name: "silo",
    about: "Sand flows out of a silo of held rods in plane strain (Jiang et al. 2020, section 5.3 and Table 3; scene silo)",
    exact: "M = 0.58 ρ √g (D0 − 2.2 r_p)^1.5 (Beverloo in two dimensions with the coefficients of Jiang et al., Fig. 16)",
    across: "cells along the width",
    resolutions: &[44],
    ways: &["neck 20 mm", "neck 30 mm", "neck 40 mm", "neck 50 mm", "neck 60 mm"],
    quantities: &["discharge"],
    scene: true,
    run,
    graphs: Some(graphs),
};

/// Width of the neck, m.
const NECKS: [f64; 5] = [0.02, 0.03, 0.04, 0.05, 0.06];
/// Between these times, s, the discharge is measured: the neck is full, and the filling still high.
const TIMES: [f64; 2] = [0.15, 0.3];
/// Half the length of the bottom's rods, m.
const ROD: f64 = 0.04;
/// Discharge per metre of depth, kg/(m s), for sand of 1500 kg/m³ and points of 0.875 mm.
fn law(neck: f64) -> f64 {
    0.58 * 1500.0 * 9.81_f64.sqrt() * (neck - 2.2 * 0.875e-3).powf(1.5)
}

fn run(task: &Task) -> Result<Found> {
    let neck = NECKS[task.way];
    let at = 1e3 * (0.5 * neck + ROD);
    let sets = [format!("block[0].position_mm=[{:?}, -5.875, 0.0]", -at), format!("block[1].position_mm=[{at:?}, -5.875, 0.0]")];
    let run = scene::run(task, "silo", &sets)?;
    let (points, steps) = run.size()?;
    let rows: Vec<(f64, f64)> =
        run.column("history.csv", "time_s")?.into_iter().zip(run.column("history.csv", "passed_kg")?).collect();
    let discharge = rate(&rows).ok_or_else(|| Error::Failed { step: steps, what: "the silo's history is too short".into() })?;
    Ok(Found { points, steps, errors: vec![discharge / law(neck) - 1.0, discharge] })
}

/// Change of the second number over that of the first, between the first rows at or after [`TIMES`].
fn rate(rows: &[(f64, f64)]) -> Option<f64> {
    let [from, to] = TIMES.map(|t| rows.iter().find(|r| r.0 >= t));
    let ((start, before), (end, after)) = (from?, to?);
    Some((after - before) / (end - start))
}

fn graphs(rows: &[Row]) -> Vec<Graph> {
    let necks = (0..=40).map(|k| 0.015 + 0.00125 * f64::from(k));
    let beverloo = Drawn {
        name: "law".into(),
        label: Some("0.58 ρ √g (D_{0} − 2.2 r_{p})^{1.5}".into()),
        tone: Tone::Ink,
        look: Look::Line(0),
        points: necks.map(|d| (1e3 * d, law(d))).collect(),
    };
    let here = Drawn {
        name: "here".into(),
        label: Some("material points between rods".into()),
        tone: Tone::Kind(0),
        look: Look::Symbols(0),
        points: rows.iter().map(|r| (1e3 * NECKS[r.way], r.found.errors[1])).collect(),
    };
    vec![Graph {
        name: "silo_discharge".into(),
        title: vec!["silo in plane strain".into(), "φ 35°".into()],
        legend_title: None,
        x: Quantity::linear("width of the neck D_{0} (mm)", "neck_mm", &[0.0]),
        y: Quantity::linear("discharge M (kg/(m s))", "discharge_kg_m_s", &[0.0]),
        series: vec![beverloo, here],
    }]
}
