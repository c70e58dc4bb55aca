//! Different time steps for grains and continuum: how much the results change if the faster side
//! does κ steps in one step of the slower side, and how much time this saves.

use super::{Case, Found, Row, Task, scene};
use laboratory::error::Result;
use plot::{Drawn, Graph, Look, Quantity, Tone};

pub const CASE: Case = Case {
    name: "rates",
    about: "Grains and continuum with steps of their own (Zhang et al., sections 4.2 and 7.1; scenes crater, stiff_rock, ball_impact)",
    exact: "the same with one step for both; times are the least of three",
    across: "steps of the faster side in one of the slower",
    resolutions: &[1, 2, 4, 8, 16, 32, 64],
    ways: &["ball of 5 GPa, sand of 2 MPa", "rocks of 50 GPa, soil of 3 MPa", "grain of 1 GPa, ball of points of 1 GPa"],
    quantities: &["velocity", "way", "energy"],
    scene: true,
    run,
    graphs: Some(|rows| vec![saving(rows)]),
};
/// For each way: scene, overrides, key for the number of steps of the faster side, and speed at the
/// start, m/s. There is no PIC: PIC takes a share of the energy in each step, so that more steps
/// would lose more.
const CASES: [(&str, &[&str], &str, f64); 3] = [
    ("crater", &["materials.ball.elastic.E_GPa=5.0", "duration_s=0.03", "grid.pic=0.0"], "grain_steps", 2.0),
    ("stiff_rock", &["grid.pic=0.0"], "grain_steps", 5.0),
    ("ball_impact", &[], "continuum_steps", 5.0),
];
const REPEATS: usize = 3;
/// Zhang et al., Tables 3 and 4: κ, and the improvement of efficiency, %.
const PUBLISHED: [(f64, f64); 12] = [
    (9.0, 547.7),
    (9.0, 593.5),
    (9.0, 662.5),
    (2.0, 53.6),
    (2.0, 55.0),
    (2.0, 64.0),
    (2.0, 35.5),
    (2.0, 41.4),
    (2.0, 56.2),
    (2.0, 39.4),
    (2.0, 44.1),
    (2.0, 52.2),
];

/// Errors of velocity, way and lost energy against the run with one step for both sides. Further
/// entries: the share of energy that is lost, and the number of cycles.
fn run(task: &Task) -> Result<Found> {
    let (run, mut least) = once(task, task.cells, 0, task.keep)?;
    for repeat in 1..REPEATS {
        least = least.min(once(task, task.cells, repeat, task.keep)?.1);
    }
    task.seconds.set(Some(least));
    // this run was made first, so its records are there
    let (reference, _) = once(task, 1, 0, true)?;
    let (points, steps) = run.size()?;
    let largest = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let [at, wanted] = [&run, &reference].map(|r| r.column("grains_final.csv", "z_m"));
    let [speeds, right] = [&run, &reference].map(|r| r.column("grains_final.csv", "vz_m_s"));
    let (start, wanted) = (run.column("grains_start.csv", "z_m")?, wanted?);
    let lost = run.ends("dissipated_share")?[1];
    let errors = vec![
        largest(&speeds?, &right?) / CASES[task.way].3,
        largest(&at?, &wanted) / largest(&start, &wanted),
        lost - reference.ends("dissipated_share")?[1],
        lost,
        run.number("cycles")?,
    ];
    Ok(Found { points, steps, errors })
}

/// One run, and its time, s.
fn once(task: &Task, steps: u32, repeat: usize, keep: bool) -> Result<(scene::Run, f64)> {
    let (name, own, side, _) = CASES[task.way];
    let out = task.out.with_file_name(format!("{}-{}-{steps}", CASE.name, task.way + 1)).join((repeat + 1).to_string());
    let mut sets: Vec<String> = own.iter().map(|s| (*s).into()).collect();
    sets.push(format!("stepping.{side}={steps}"));
    let task = task.elsewhere(out, keep);
    let run = scene::run(&task, &format!("../mixture/{name}"), &sets)?;
    Ok((run, task.seconds.get().unwrap_or(f64::NAN)))
}

/// Graph of the time with κ = 1 over the time with κ, against κ. The published improvement is
/// (T_1/T_κ − 1)·100 % (Zhang et al., eq. 64).
fn saving(rows: &[Row]) -> Graph {
    let mut series = Vec::new();
    for (way, name) in CASE.ways.iter().enumerate() {
        let own: Vec<&Row> = rows.iter().filter(|r| r.way == way).collect();
        let Some(alone) = own.iter().find(|r| r.cells == 1).map(|r| r.seconds) else { continue };
        let points: Vec<(f64, f64)> = own.iter().map(|r| (f64::from(r.cells), alone / r.seconds)).collect();
        let drawn = |look, label| Drawn { label, name: (*name).into(), tone: Tone::Kind(way), look, points: points.clone() };
        series.push(drawn(Look::Line(way), Some((*name).into())));
        series.push(drawn(Look::Symbols(way), None));
    }
    let published = PUBLISHED.iter().map(|(kappa, percent)| (*kappa, 1.0 + 0.01 * percent)).collect();
    let other = |label: &str, look, points| Drawn { label: Some(label.into()), name: label.into(), tone: Tone::Ink, look, points };
    series.push(other("Zhang et al., Tables 3, 4", Look::Symbols(3), published));
    series.push(other("only the slower side costs", Look::Guide, vec![(1.0, 1.0), (64.0, 64.0)]));
    Graph {
        name: "rates_saving".into(),
        title: vec!["steps of their own for grains and continuum".into()],
        legend_title: None,
        x: Quantity::log("κ (–)", "kappa"),
        y: Quantity::log("times as fast as with κ = 1 (–)", "times_as_fast"),
        series,
    }
}
