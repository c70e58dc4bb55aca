//! A ball that falls into dry sand, against the depth that experiments have found.

use super::{Case, Found, Row, Task, scene};
use laboratory::error::Result;
use nalgebra::{DMatrix, DVector};
use plot::{Drawn, Graph, Look, Quantity, Tone, significant};

const ABOUT: &str =
    "A ball falls into dry sand (Zhang et al., section 5.2: E 2 MPa, ν 0.3, 1510 kg/m³; ball 2200 kg/m³; scene crater)";
const EXACT: &str =
    "D = 0.14/μ √(ρ_ball/ρ_sand) (2R)^(2/3) (h + D)^(1/3) (eq. 62; Uehara et al. 2003, Ambroso et al. 2005, experiments)";
const ACROSS: &str = "cells along the ball's radius";
/// Scene of the cases with a cone.
const SCENE: &str = "../mixture/crater";
/// The ways: three heights of fall for each combination of ball and sand.
const DROPS: &[&str] = &[
    "R 12.5 mm, μ 0.3, h 50 mm",
    "R 12.5 mm, μ 0.3, h 100 mm",
    "R 12.5 mm, μ 0.3, h 200 mm",
    "R 12.5 mm, μ 0.5, h 50 mm",
    "R 12.5 mm, μ 0.5, h 100 mm",
    "R 12.5 mm, μ 0.5, h 200 mm",
    "R 20 mm, μ 0.3, h 50 mm",
    "R 20 mm, μ 0.3, h 100 mm",
    "R 20 mm, μ 0.3, h 200 mm",
    "R 20 mm, μ 0.5, h 50 mm",
    "R 20 mm, μ 0.5, h 100 mm",
    "R 20 mm, μ 0.5, h 200 mm",
];

/// The case with the plane-strain cone, as in the paper.
pub const CASE: Case = Case {
    name: "crater",
    about: ABOUT,
    exact: EXACT,
    across: ACROSS,
    resolutions: &[2, 3, 4],
    ways: DROPS,
    quantities: &["depth"],
    scene: true,
    run: |task| fall(task, SCENE, &drop(task.way), &[]),
    graphs: Some(|rows| graphs("crater", "plane-strain cone", rows)),
};
pub const OUTER: Case = Case {
    name: "crater_outer",
    about: "A ball falls into dry sand (as crater, with the outer cone)",
    resolutions: &[2],
    run: |task| fall(task, SCENE, &drop(task.way), &["materials.sand.continuum.cone=\"outer\"".into()]),
    graphs: Some(|rows| graphs("crater_outer", "outer cone", rows)),
    ..CASE
};
/// The case with the surface of Mohr–Coulomb, between both cones.
pub const MOHR_COULOMB: Case = Case {
    name: "crater_mohr_coulomb",
    about: "A ball falls into dry sand (as crater, with the surface of Mohr-Coulomb; scene crater_mohr_coulomb)",
    resolutions: &[2, 3],
    run: |task| fall(task, "../mixture/crater_mohr_coulomb", &drop(task.way), &[]),
    graphs: Some(|rows| graphs("crater_mohr_coulomb", "Mohr–Coulomb", rows)),
    ..CASE
};
/// The case that shows how the depth of one drop depends on the method, the ball's friction and the
/// sand's stiffness.
pub const NUMERICS: Case = Case {
    name: "crater_numerics",
    about: "A ball of 20 mm falls from 200 mm into dry sand with μ 0.3 (as crater)",
    resolutions: &[2, 3],
    ways: &[
        "0.1 % PIC",
        "no PIC",
        "1 % PIC",
        "APIC",
        "0.1 % PIC, smooth ball",
        "0.1 % PIC, sand of 20 MPa",
        "no PIC, forces at faces",
        "no PIC, forces at faces, smooth ball",
    ],
    run: |task| {
        let own: &[&str] = match task.way {
            1 => &["grid.pic=0.0"],
            2 => &["grid.pic=0.01"],
            3 => &["grid.pic=0.0", "grid.transfer=\"apic\""],
            4 => &["materials.ball.contact.friction=0.0"],
            5 => &["materials.sand.continuum.E_MPa=20.0", "materials.sand.elastic.E_GPa=0.02"],
            6 => &["grid.pic=0.0", "contact.on_points=\"face\""],
            7 => &["grid.pic=0.0", "contact.on_points=\"face\"", "materials.sand.continuum.interface_friction=0.0"],
            _ => &[],
        };
        let own: Vec<String> = own.iter().map(|s| (*s).into()).collect();
        fall(task, SCENE, &drop(8), &own)
    },
    graphs: None,
    ..CASE
};
/// The case that shows how the depth of one drop depends on the cell. From eight cells on (1.6 million points) it wants a
/// graphics device.
pub const CELLS: Case = Case {
    name: "crater_cells",
    about: "A ball of 20 mm falls from 200 mm into dry sand with μ 0.3, with cells to an eighth of its radius (as crater)",
    resolutions: &[2, 3, 4, 6, 8],
    ways: &["plane-strain cone"],
    run: |task| fall(task, SCENE, &drop(8), &[]),
    graphs: Some(|rows| vec![convergence(rows)]),
    ..CASE
};
/// Densities of ball and sand, kg/m³, and gravity, m/s².
const BALL: f64 = 2200.0;
const SAND: f64 = 1510.0;
const GRAVITY: f64 = 9.81;
/// Lengths over the ball's radius: half the width of the sand, depth of the sand (a layer for each
/// radius), room above the sand, and gap between ball and sand at the start.
const HALF: f64 = 4.0;
const LAYERS: usize = 6;
const ABOVE: f64 = 4.0;
const GAP: f64 = 0.025;
/// Time in which the largest ball comes to rest, s, and its radius, m; the time of another ball is
/// in proportion to the square root of its radius.
const DURATION: [f64; 2] = [0.1, 0.02];

/// A ball, the sand's friction coefficient and the height from which the ball falls, m.
#[derive(Clone, Copy, Debug)]
struct Drop {
    radius: f64,
    friction: f64,
    height: f64,
}

fn drop(way: usize) -> Drop {
    Drop { radius: [0.0125, 0.02][way / 6], friction: [0.3, 0.5][way / 3 % 2], height: [0.05, 0.1, 0.2][way % 3] }
}

impl Drop {
    /// Depth D by eq. 62, m, where the ball's whole way H = h + D contains D: solved by iteration.
    fn law(&self) -> f64 {
        let factor = 0.14 / self.friction * (BALL / SAND).sqrt() * (2.0 * self.radius).powf(2.0 / 3.0);
        // each round leaves the share D/(3 (h + D)) of the error
        (0..60).fold(self.radius, |depth, _| factor * (self.height + depth).cbrt())
    }

    fn sets(&self, cells: u32) -> Vec<String> {
        let r = 1e3 * self.radius;
        let wide = HALF * r;
        let mut sets = vec![
            format!("name=\"R{r}_mu{}_h{}\"", self.friction, 1e3 * self.height),
            format!("grid.cell_mm={:?}", r / f64::from(cells)),
            format!("grid.min_mm=[{:?}, {:?}, {:?}]", -wide, -wide, -(LAYERS as f64) * r),
            format!("grid.max_mm=[{wide:?}, {wide:?}, {:?}]", ABOVE * r),
            format!("grain[0].radius_m={:?}", self.radius),
            format!("grain[0].position_m=[0.0, 0.0, {:?}]", self.radius * (1.0 + GAP)),
            format!("grain[0].velocity_m_s=[0.0, 0.0, {:?}]", -(2.0 * GRAVITY * self.height).sqrt()),
            format!("materials.sand.contact.friction={:?}", self.friction),
            format!("materials.sand.continuum.friction_angle_rad={:?}", self.friction.atan()),
            format!("duration_s={:?}", DURATION[0] * (self.radius / DURATION[1]).sqrt()),
        ];
        for layer in 0..LAYERS {
            let (top, middle) = (-(layer as f64) * r, (layer as f64 + 0.5) * self.radius);
            sets.push(format!("body[{layer}].min_mm=[{:?}, {:?}, {:?}]", -wide, -wide, top - r));
            sets.push(format!("body[{layer}].max_mm=[{wide:?}, {wide:?}, {top:?}]"));
            sets.push(format!("body[{layer}].stress_kPa={:?}", 1e-3 * SAND * GRAVITY * middle));
        }
        sets
    }
}

/// Runs the case: error of the depth against eq. 62, depth, m, and last speed over the first.
fn fall(task: &Task, name: &str, drop: &Drop, own: &[String]) -> Result<Found> {
    let mut sets = drop.sets(task.cells);
    sets.extend_from_slice(own);
    let run = scene::run(task, name, &sets)?;
    let (points, steps) = run.size()?;
    let depth = -1e-3 * run.ends("lowest_grain_mm")?[1];
    let moving = (run.ends("coarse_kinetic_J")?[1] / run.ends("coarse_kinetic_J")?[0]).sqrt();
    Ok(Found { points, steps, errors: vec![depth / drop.law() - 1.0, depth, moving] })
}

/// Exponents a, b and e of radius, way and friction in D = c R^a H^b μ^e, by least squares of the
/// logarithms. `None` with too few cases.
fn exponents(cases: &[(Drop, f64)]) -> Option<[f64; 3]> {
    let row = |(drop, depth): &(Drop, f64)| [1.0, drop.radius.ln(), (drop.height + depth).ln(), drop.friction.ln()];
    let a = DMatrix::from_row_iterator(cases.len(), 4, cases.iter().flat_map(row));
    let b = DVector::from_iterator(cases.len(), cases.iter().map(|c| c.1.ln()));
    let decomposed = a.svd(true, true);
    let x = (decomposed.rank(1e-9) == 4).then(|| decomposed.solve(&b, 0.0).ok())??;
    Some([x[1], x[2], x[3]])
}

/// Depth over that of the law against the cell over the ball's radius.
fn convergence(rows: &[Row]) -> Graph {
    let points: Vec<(f64, f64)> = rows.iter().map(|r| (1.0 / f64::from(r.cells), 1.0 + r.found.errors[0])).collect();
    let drawn = |look, label| Drawn { label, name: "depth".into(), tone: Tone::Kind(0), look, points: points.clone() };
    let series = vec![drawn(Look::Line(0), None), drawn(Look::Symbols(0), None)];
    Graph {
        name: "crater_cells_depth".into(),
        title: vec!["a ball of 20 mm falls from 200 mm into dry sand".into(), "μ 0.3, plane-strain cone".into()],
        legend_title: None,
        x: Quantity::linear("cell over radius of the ball (–)", "cell_over_radius", &[0.0]),
        y: Quantity::linear("depth over that of eq. 62 (–)", "depth_over_law", &[1.0]),
        series,
    }
}

/// Two graphs: depth at the finest resolution against the depth of the law; depth over that of the
/// law against the height of fall, at all resolutions.
fn graphs(name: &str, cone: &str, rows: &[Row]) -> Vec<Graph> {
    let (mut depths, mut ratios) = (Vec::new(), Vec::new());
    let cells = |r: &Row| r.cells;
    let finest = rows.iter().map(cells).max().unwrap_or(0);
    let mut resolutions: Vec<u32> = rows.iter().map(cells).collect();
    resolutions.sort_unstable();
    resolutions.dedup();
    for three in 0..DROPS.len() / 3 {
        for (n, resolution) in resolutions.iter().enumerate() {
            let own: Vec<&Row> = rows.iter().filter(|r| r.way / 3 == three && r.cells == *resolution).collect();
            let (ball, _) = DROPS[3 * three].rsplit_once(", h").unwrap_or_default();
            let label = format!("{ball}, {resolution} cells");
            let drawn = |points| Drawn {
                label: Some(label.clone()),
                name: label.clone(),
                tone: Tone::Kind(three),
                look: Look::Symbols(n),
                points,
            };
            let depth = |r: &&Row| (1e3 * drop(r.way).law(), 1e3 * r.found.errors[1]);
            if *resolution == finest {
                depths.push(drawn(own.iter().map(depth).collect()));
            }
            // the legend names the colours (ball and sand), the title the symbols (resolution)
            let ratio = drawn(own.iter().map(|r| (1e3 * drop(r.way).height, 1.0 + r.found.errors[0])).collect());
            ratios.push(Drawn { label: (n == 0).then(|| ball.into()), ..ratio });
        }
    }
    let line = |points| Drawn { label: Some("eq. 62".into()), name: "eq. 62".into(), tone: Tone::Ink, look: Look::Guide, points };
    depths.push(line(vec![(10.0, 10.0), (50.0, 50.0)]));
    ratios.push(line(vec![(50.0, 1.0), (200.0, 1.0)]));
    let cases: Vec<(Drop, f64)> = rows.iter().filter(|r| r.cells == finest).map(|r| (drop(r.way), r.found.errors[1])).collect();
    let mut title = vec!["a ball falls into dry sand".into(), cone.into()];
    if let Some(fit) = exponents(&cases) {
        let [r, h, mu] = fit.map(|x| significant(x, 2).replace('-', "−"));
        title.push(format!("{finest} cells: D ~ R^{{{r}}} H^{{{h}}} μ^{{{mu}}}"));
    }
    let symbols = ["circles", "squares", "triangles"].into_iter().zip(&resolutions).map(|(symbol, n)| format!("{symbol} {n}"));
    let explained = format!("{} cells along the radius", symbols.collect::<Vec<_>>().join(", "));
    let mut titles = [title.clone(), title];
    titles[1].insert(1, explained);
    let [depth_title, ratio_title] = titles;
    let graph = |end: &str, title, x, y, series| Graph { name: format!("{name}_{end}"), title, legend_title: None, x, y, series };
    vec![
        graph(
            "depth",
            depth_title,
            Quantity::log("depth of eq. 62 (mm)", "law_mm"),
            Quantity::log("depth D (mm)", "depth_mm"),
            depths,
        ),
        graph(
            "ratio",
            ratio_title,
            Quantity::log("height h (mm)", "height_mm"),
            Quantity::linear("depth over that of eq. 62 (–)", "depth_over_law", &[0.7]),
            ratios,
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Depths by eq. 62, m, solved independently of this program for the twelve ways.
    #[test]
    fn the_law_has_the_whole_way_in_it() {
        let known =
            [0.019832, 0.024017, 0.029485, 0.0114, 0.014012, 0.017374, 0.02817, 0.033687, 0.040999, 0.015973, 0.019469, 0.024007];
        for (way, known) in known.into_iter().enumerate() {
            assert!((drop(way).law() / known - 1.0).abs() < 1e-4, "{}: {}", DROPS[way], drop(way).law());
        }
    }

    #[test]
    fn the_fit_finds_the_law_s_exponents() {
        let cases: Vec<(Drop, f64)> = (0..12).map(|way| (drop(way), drop(way).law())).collect();
        let found = exponents(&cases).expect("a fit");
        for (found, wanted) in found.into_iter().zip([2.0 / 3.0, 1.0 / 3.0, -1.0]) {
            assert!((found - wanted).abs() < 1e-9, "{found}");
        }
        assert!(exponents(&cases[..3]).is_none(), "one radius says nothing of radii");
    }
}
