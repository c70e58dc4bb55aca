//! The sieve that a body passes.

use super::{Rounded, Shape, Solid};
use crate::math::portable::sin;
use crate::math::vector::{cross, dot, less, scaled};
use std::f64::consts::FRAC_PI_2;

/// Steps in which a square hole is turned through a quarter of a turn.
const TURNS: u32 = 90;

impl Shape {
    /// Edge, m, of the smallest square hole through which the body passes, on its way along one of its edges, along the normal of one of its faces or along one of its
    /// principal axes; the hole is turned in steps of a degree. In plane strain the smallest slot, which is its least width. A superquadric and a compound pass along their principal axes. A sheet passes nothing: infinite.
    pub fn sieve(&self) -> f64 {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let solid = self.solid();
        match self.rounded() {
            Rounded::Hull(hull) => {
                let edges = hull.edges().into_iter().map(|(ends, _)| {
                    let [p, q] = ends.map(|k| hull.corners[k as usize]);
                    less(p, q)
                });
                let faces = hull.faces.iter().map(|face| face.normal);
                let holes = edges.chain(faces).chain(axes).map(|along| hole(&hull.corners, along));
                holes.fold(f64::INFINITY, f64::min) + 2.0 * hull.rounding
            }
            Rounded::Ring(ring) => {
                let across = |k: usize| {
                    let [x, y, _] = less(ring.corners[(k + 1) % ring.corners.len()], ring.corners[k]);
                    let length = (x * x + y * y).sqrt();
                    if length > 0.0 { width(&ring.corners, [y / length, -x / length, 0.0]) } else { 0.0 }
                };
                (0..ring.corners.len()).map(across).fold(f64::INFINITY, f64::min) + 2.0 * ring.rounding
            }
            Rounded::Sheet(..) => f64::INFINITY,
            Rounded::Union(_) | Rounded::Smooth(_) => {
                let mut extents = axes.map(|axis| extent(solid, axis));
                extents.sort_by(f64::total_cmp);
                extents[1]
            }
        }
    }
}

/// Extent of a body along a principal axis, m.
fn extent(solid: &dyn Solid, axis: [f64; 3]) -> f64 {
    let end =
        |towards: [f64; 3]| (0..solid.spots()).map(|k| dot(solid.spot(k, towards), towards)).fold(f64::NEG_INFINITY, f64::max);
    end(axis) + end(scaled(axis, -1.0))
}

/// Width of points along a direction, m.
fn width(points: &[[f64; 3]], direction: [f64; 3]) -> f64 {
    let ends = points.iter().map(|p| dot(*p, direction));
    let [low, high] = ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
    high - low
}

/// Edge of the smallest square through which points pass along a direction of any length, m.
fn hole(points: &[[f64; 3]], along: [f64; 3]) -> f64 {
    // the axis that is furthest from the direction gives the first across it
    let least = (0..3).fold(0, |least, a| if along[a].abs() < along[least].abs() { a } else { least });
    let unit = |v: [f64; 3]| scaled(v, 1.0 / dot(v, v).sqrt());
    let u = unit(cross(along, std::array::from_fn(|a| f64::from(u8::from(a == least)))));
    let v = unit(cross(along, u));
    let square = |k: u32| {
        let angle = FRAC_PI_2 * f64::from(k) / f64::from(TURNS);
        let (s, c) = (sin(angle), sin(FRAC_PI_2 - angle));
        let turned = |a: f64, b: f64| std::array::from_fn(|k| a * u[k] + b * v[k]);
        width(points, turned(c, s)).max(width(points, turned(-s, c)))
    };
    (0..TURNS).map(square).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Cuboid, Polygon, Polyhedron, Superquadric};

    #[test]
    fn bodies_pass_the_holes_of_the_closed_forms() {
        let near = |shape: Shape, hole: f64| assert!((shape.sieve() / hole - 1.0).abs() < 1e-9, "{} {hole}", shape.sieve());
        // a brick passes lengthwise through a square of its middle edge; its edges count as round
        near(Shape::Box(Cuboid { half: [2.0, 1.0, 0.5] }), 2.0);
        near(Shape::Superquadric(Superquadric { half: [2.0, 1.0, 0.5], blockiness: [2.0, 2.0] }), 2.0);
        // a cube whose points are turned: along a face's normal, though every axis is principal
        let t = std::f64::consts::FRAC_PI_6;
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|k: u32| {
                let [x, y, z]: [f64; 3] = std::array::from_fn(|a| if k >> a & 1 == 1 { 1.0 } else { -1.0 });
                [x * t.cos() - y * t.sin(), x * t.sin() + y * t.cos(), z]
            })
            .collect();
        let cube = Polyhedron::hull(&corners, 0.1).unwrap().polyhedron;
        assert!((Shape::Polyhedron(cube).sieve() / 2.2 - 1.0).abs() < 2e-4);
        // a rectangle of plane strain: its short side; a disc its diameter
        let (rectangle, _) = Polygon::of(&[[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [0.0, 1.0]], 0.05).unwrap();
        near(Shape::Polygon(rectangle), 1.1);
        near(Shape::Polygon(Polygon::of(&[[0.0, 0.0]], 0.4).unwrap().0), 0.8);
    }
}
