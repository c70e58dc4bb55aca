//! Blocks of points.
#![allow(dead_code)] // each test binary uses its part

use comminute::mpm::law::{Elastic, Law};
use comminute::mpm::{Continuum, Dimension, Point, Points, Settings, ShapeFunctions, Transfer, Wall};

pub const FLIP: Transfer = Transfer::Blend { pic: 0.0 };

/// Smooth sides that hold, everywhere.
pub const SMOOTH: [Wall; 6] = [Wall::Symmetry; 6];

pub fn settings(dimension: Dimension, cell: f64, cells: [u32; 3]) -> Settings {
    Settings {
        dimension,
        cell,
        lower: [0.0; 3],
        cells,
        walls: [Wall::Open; 6],
        gravity: [0.0; 3],
        shape: ShapeFunctions::BSpline,
        transfer: FLIP,
        damping: 0.0,
    }
}

/// Points on a lattice, `per` to a cell along each axis, in the box from `low` to `high`; density, velocity by place.
pub fn fill(
    settings: &Settings,
    [low, high]: [[f64; 3]; 2],
    per: u32,
    density: f64,
    mut keep: impl FnMut([f64; 3]) -> bool,
    mut velocity: impl FnMut([f64; 3]) -> [f64; 3],
) -> Points {
    let d = if settings.dimension == Dimension::Space { 3 } else { 2 };
    let spacing = settings.cell / f64::from(per);
    let count: [u32; 3] = std::array::from_fn(|a| if a < d { ((high[a] - low[a]) / spacing).round() as u32 } else { 1 });
    let volume = spacing.powi(d as i32);
    let mut points = Points::default();
    for k in 0..count[2] {
        for j in 0..count[1] {
            for i in 0..count[0] {
                let n = [i, j, k];
                let position: [f64; 3] =
                    std::array::from_fn(|a| if a < d { low[a] + (f64::from(n[a]) + 0.5) * spacing } else { 0.0 });
                if keep(position) {
                    let point = Point {
                        position,
                        velocity: velocity(position),
                        mass: density * volume,
                        volume,
                        stress: [0.0; 6],
                        porosity: 0.4,
                        law: 0,
                    };
                    points.add(&point);
                }
            }
        }
    }
    points
}

pub fn elastic(young: f64, poisson: f64) -> Vec<Law> {
    vec![Law::Elastic(Elastic::of_young(young, poisson))]
}

pub fn continuum(settings: Settings, laws: Vec<Law>, points: Points) -> Continuum {
    Continuum::new(settings, laws, points).unwrap_or_else(|e| panic!("{e}"))
}

pub fn steps(c: &mut Continuum, dt: f64, n: u64) {
    for _ in 0..n {
        c.step(dt).unwrap_or_else(|e| panic!("{e}"));
    }
}
