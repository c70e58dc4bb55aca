//! Blocks of points on a grid, for cases that no scene describes.

use engine::mpm::law::{Elastic, Law};
use engine::mpm::{Continuum, Dimension, GridWall, Point, Points, Settings, ShapeFunctions, Transfer};
use laboratory::error::Result;

/// Numerical method: shape functions, and transfer between points and nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// Shape functions.
    pub shape: ShapeFunctions,
    /// Transfer between points and nodes.
    pub transfer: Transfer,
}

/// FLIP with splines.
pub const FLIP: Method = Method { shape: ShapeFunctions::BSpline, transfer: Transfer::Blend { pic: 0.0 } };
/// PIC with splines.
pub const PIC: Method = Method { transfer: Transfer::Blend { pic: 1.0 }, ..FLIP };
/// APIC with splines.
pub const APIC: Method = Method { transfer: Transfer::Affine, ..FLIP };
/// FLIP with GIMP, for two points along the edge of a cell.
pub const GIMP: Method = Method { shape: ShapeFunctions::Gimp { half_width: 0.25 }, ..FLIP };

/// Smooth walls that hold the material, on all sides.
pub const SMOOTH: [GridWall; 6] = [GridWall::Symmetry; 6];

/// A grid of `cells` cells with the edge `cell`, m: open sides, no gravity, no damping.
pub fn settings(dimension: Dimension, cell: f64, cells: [u32; 3], method: Method) -> Settings {
    let Method { shape, transfer } = method;
    Settings {
        dimension,
        cell,
        lower: [0.0; 3],
        cells,
        walls: [GridWall::Open; 6],
        gravity: [0.0; 3],
        shape,
        transfer,
        damping: 0.0,
    }
}

/// A strip one cell wide between smooth walls, held at x = 0 and free at the other end; `room` cells long.
pub fn strip(cell: f64, room: u32, method: Method) -> Settings {
    let mut s = settings(Dimension::PlaneStrain, cell, [room, 1, 1], method);
    s.walls = [GridWall::Symmetry, GridWall::Open, GridWall::Symmetry, GridWall::Symmetry, GridWall::Open, GridWall::Open];
    s
}

/// Points on a lattice, `per` to a cell along each axis, in the box from `low` to `high`, where
/// `keep` is true; `velocity` depends on the place.
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
                    let (velocity, mass, porosity) = (velocity(position), density * volume, 0.4);
                    points.add(&Point { position, velocity, mass, volume, stress: [0.0; 6], porosity, law: 0 });
                }
            }
        }
    }
    points
}

/// An elastic law with Young's modulus, Pa, and Poisson's ratio, for all points.
pub fn elastic(young: f64, poisson: f64) -> Vec<Law> {
    vec![Law::Elastic(Elastic::of_young(young, poisson))]
}

/// Does `n` steps of `dt`.
///
/// # Errors
/// A lost point.
pub fn steps(c: &mut Continuum, dt: f64, n: u64) -> Result<()> {
    (0..n).try_for_each(|_| Ok(c.step(dt)?))
}
