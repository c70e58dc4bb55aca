//! Columns that collapse, in space and in plane strain, against the published run-outs.

use super::{Case, Found, Row, Task, scene};
use laboratory::error::Result;
use plot::{Drawn, Graph, Look, Quantity, Tone};
use std::f64::consts::FRAC_PI_2;

pub const SPACE: Case = Case {
    name: "collapse",
    about: "A quarter of a granular column collapses on a rough floor (Zhang et al., section 5.1: φ 30°, E 5.98 MPa, ν 0.3, 2600 kg/m³; scene collapse)",
    exact: "r∞/r0 = 1 + 1.24 a for a < 1.7, 1 + 1.6 √a beyond (Lube et al. 2004, experiments); energy lost in transfer: none",
    across: "points along the radius",
    resolutions: &[10, 15, 20],
    ways: &[
        "outer cone, FLIP, a = 0.6",
        "outer cone, FLIP, a = 1",
        "outer cone, FLIP, a = 2",
        "plane-strain cone, FLIP, a = 0.6",
        "plane-strain cone, FLIP, a = 1",
        "plane-strain cone, FLIP, a = 2",
        "plane-strain cone, APIC, a = 0.6",
        "plane-strain cone, APIC, a = 1",
        "plane-strain cone, APIC, a = 2",
    ],
    quantities: &["run-out", "energy lost in transfer"],
    scene: true,
    run: in_space,
    graphs: Some(|rows| graphs(&SPACE, rows, &[("Lube et al. 2004", lube)])),
};
pub const PLANE: Case = Case {
    name: "collapse_2d",
    about: "Half a granular column collapses on a rough floor in plane strain (the soil of collapse; scene collapse_2d)",
    exact: "l∞/l0 = 1 + 1.2 a for a < 2.3 (Lube et al. 2005, experiments in a channel); energy lost in transfer: none",
    across: "points along the length",
    resolutions: &[10, 15, 20, 40],
    ways: &["FLIP, a = 0.6", "FLIP, a = 1", "FLIP, a = 2", "APIC, a = 0.6", "APIC, a = 1", "APIC, a = 2"],
    quantities: &["run-out", "energy lost in transfer"],
    scene: true,
    run: in_plane,
    graphs: Some(|rows| graphs(&PLANE, rows, &[("Lube et al. 2005", channel), ("Lajeunesse et al. 2005", beads)])),
};
/// The columns of [`SPACE`] with a surface that has corners, as the tests of Lube et al. have no cone.
pub const MOHR_COULOMB: Case = Case {
    name: "collapse_mohr_coulomb",
    about: "A quarter of a granular column collapses on a rough floor (as collapse, with the surface of Mohr-Coulomb; scene collapse_mohr_coulomb)",
    ways: &["FLIP, a = 0.6", "FLIP, a = 1", "FLIP, a = 2"],
    run: |task| collapse(task, "collapse_mohr_coulomb", false, [height(task)], lube),
    graphs: Some(|rows| graphs(&MOHR_COULOMB, rows, &[("Lube et al. 2004", lube)])),
    ..SPACE
};
const ASPECTS: [f64; 3] = [0.6, 1.0, 2.0];
/// Duration of a run for each aspect ratio, s; all points are at rest then.
const DURATION: [f64; 3] = [0.5, 0.6, 0.8];
/// Radius or length at the start, mm.
const START: f64 = 100.0;
/// Share of PIC with 20 points along the radius. The share is in proportion to the cell, as the
/// time step is, so that PIC takes the same energy in the same time at every resolution.
const PIC: f64 = 2e-4;
/// Number of sectors of a quarter, in each of which the front is searched.
const SECTORS: usize = 9;

/// Lube et al. 2004 (J. Fluid Mech. 508, 175): r∞/r0.
fn lube(a: f64) -> f64 {
    1.0 + if a < 1.7 { 1.24 * a } else { 1.6 * a.sqrt() }
}

/// Lube et al. 2005 (Phys. Rev. E 72, 041301): l∞/l0.
fn channel(a: f64) -> f64 {
    1.0 + if a < 2.3 { 1.2 * a } else { 1.9 * a.powf(2.0 / 3.0) }
}

/// Lajeunesse et al. 2005 (Phys. Fluids 17, 103302), glass beads in a channel: l∞/l0 for a < 3.
fn beads(a: f64) -> f64 {
    1.0 + 1.8 * a
}

fn in_space(task: &Task) -> Result<Found> {
    let cone = if task.way < 3 { "outer" } else { "plane_strain" };
    collapse(task, "collapse", task.way >= 6, [height(task), format!("material.continuum.cone={cone:?}")], lube)
}

/// The height of a column in space.
fn height(task: &Task) -> String {
    format!("body[0].height_mm={:?}", START * ASPECTS[task.way % 3])
}

fn in_plane(task: &Task) -> Result<Found> {
    let corner = format!("body[0].max_mm=[{START:?}, {:?}, 0.0]", START * ASPECTS[task.way % 3]);
    collapse(task, "collapse_2d", task.way >= 3, [corner, "grid.plane_strain=true".into()], channel)
}

fn collapse(task: &Task, name: &str, affine: bool, own: impl IntoIterator<Item = String>, law: fn(f64) -> f64) -> Result<Found> {
    let cell = 2.0 * START / f64::from(task.cells);
    let mut sets = vec![format!("grid.cell_mm={cell:?}"), format!("duration_s={:?}", DURATION[task.way % 3])];
    if affine {
        sets.extend(["grid.transfer=\"apic\"".into(), "grid.pic=0.0".into()]);
    } else {
        sets.push(format!("grid.pic={:?}", PIC * 20.0 / f64::from(task.cells)));
    }
    sets.extend(own);
    let run = scene::run(task, name, &sets)?;
    let (points, steps) = run.size()?;
    let [x, y, z] = ["x_m", "y_m", "z_m"].map(|c| run.column("points_final.csv", c));
    let flat = z?.iter().all(|z| *z == 0.0);
    let y = if flat { vec![0.0; points] } else { y? };
    let front = front(&x?, &y, [1e-3 * START, 1e-3 * cell]) + 0.25e-3 * cell;
    let [potential, lost] = ["potential_J", "dissipated_J"].map(|c| run.column("history.csv", c));
    let (potential, lost) = (potential?, lost?);
    let fallen = potential[0] - potential[potential.len() - 1];
    let out = front / (1e-3 * START);
    Ok(Found { points, steps, errors: vec![out / law(ASPECTS[task.way % 3]) - 1.0, lost[lost.len() - 1] / fallen, out] })
}

/// Run-out of the column, m: mean over the sectors of the distance of the front. The front of a
/// sector is the outermost point that is not separated from the rest: beyond the radius `start`, no
/// gap between successive points is wider than `cell`.
fn front(x: &[f64], y: &[f64], [start, cell]: [f64; 2]) -> f64 {
    let mut sectors = vec![Vec::new(); SECTORS];
    for (x, y) in x.iter().zip(y) {
        let share = y.atan2(*x).max(0.0) / FRAC_PI_2;
        sectors[((share * SECTORS as f64) as usize).min(SECTORS - 1)].push(x.hypot(*y));
    }
    let ends: Vec<f64> = sectors
        .iter_mut()
        .filter(|s| !s.is_empty())
        .map(|radii| {
            radii.sort_by(f64::total_cmp);
            radii.windows(2).find(|w| w[1] > start && w[1] - w[0] > cell).map_or(radii[radii.len() - 1], |w| w[0])
        })
        .collect();
    ends.iter().sum::<f64>() / ends.len() as f64
}

/// Name and formula of a published run-out.
type Law = (&'static str, fn(f64) -> f64);

/// Two graphs: run-out against the aspect ratio; run-out over that of the case's law against the
/// energy lost in the transfer. The ways of a case come in threes, one for each aspect ratio.
fn graphs(case: &Case, rows: &[Row], laws: &[Law]) -> Vec<Graph> {
    let name = |setting: usize| case.ways[3 * setting].rsplit_once(", a =").map_or("", |n| n.0);
    let drawn =
        |label: String, tone, look, points: Vec<(f64, f64)>| Drawn { name: label.clone(), label: Some(label), tone, look, points };
    let aspects = || (0..=40).map(|k| 0.4 + 0.045 * f64::from(k));
    let law =
        |(n, (name, law)): (usize, &Law)| drawn((*name).into(), Tone::Ink, Look::Line(n), aspects().map(|a| (a, law(a))).collect());
    let mut out: Vec<Drawn> = laws.iter().enumerate().map(law).collect();
    let mut lost = Vec::new();
    for setting in 0..case.ways.len() / 3 {
        let of = |keep: &dyn Fn(&Row) -> bool, point: &dyn Fn(&Row) -> (f64, f64)| -> Vec<(f64, f64)> {
            rows.iter().filter(|r| r.way / 3 == setting && keep(r)).map(point).collect()
        };
        for (n, &cells) in case.resolutions.iter().enumerate() {
            let found = of(&|r| r.cells == cells, &|r| (ASPECTS[r.way % 3], r.found.errors[2]));
            if !found.is_empty() {
                out.push(drawn(format!("{}, {cells} points", name(setting)), Tone::Kind(setting), Look::Symbols(n), found));
            }
        }
        let all = of(&|_| true, &|r| (100.0 * r.found.errors[1], 1.0 + r.found.errors[0]));
        lost.push(drawn(name(setting).into(), Tone::Kind(setting), Look::Symbols(setting), all));
    }
    let graph = |end: &str, x: Quantity, y: Quantity, series: Vec<Drawn>| Graph {
        name: format!("{}_{end}", case.name),
        title: vec!["columns on a rough floor".into(), "φ 30°".into()],
        legend_title: None,
        x,
        y,
        series,
    };
    let far = Quantity::linear("run-out over the length at the start (–)", "run_out", &[1.0]);
    let over = Quantity::linear("run-out over that of the law (–)", "run_out_over_law", &[1.0]);
    let share = Quantity::linear("energy lost in the transfer (%)", "lost_percent", &[0.0]);
    vec![graph("run_out", Quantity::linear("aspect ratio a (–)", "aspect_ratio", &[]), far, out), graph("lost", share, over, lost)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stray_point_is_no_front() {
        // nine rays of points 10 mm apart up to 150 mm; on one of them also points at 250 and 300
        // mm, behind a gap of 100 mm
        let rays = (0..SECTORS).flat_map(|k| (1..=15).map(move |n| (k, 0.01 * f64::from(n)))).chain([(4, 0.25), (4, 0.3)]);
        let angle = |k: usize| FRAC_PI_2 * (k as f64 + 0.5) / SECTORS as f64;
        let (x, y): (Vec<f64>, Vec<f64>) = rays.map(|(k, r)| (r * angle(k).cos(), r * angle(k).sin())).unzip();
        assert!((front(&x, &y, [0.1, 0.02]) - 0.15).abs() < 1e-12);
        // if such a gap is allowed, the stray points count as the front of their sector
        assert!((front(&x, &y, [0.1, 0.11]) - (0.15 + 0.15 / SECTORS as f64)).abs() < 1e-12);
    }

    #[test]
    fn the_laws_are_the_published_ones() {
        let near = |a: f64, b: f64| (a - b).abs() < 1e-3;
        assert!(near(lube(1.0), 2.24) && near(lube(2.0), 3.2627) && near(channel(2.0), 3.4) && near(channel(3.0), 4.9522));
    }
}
