//! Cuts a rounded convex body in two along a plane, or into the cells around given seeds.
//!
//! The hull within each piece ends by the radius of the edges before the plane, so that the rounded pieces touch each other in the plane and lie inside of the
//! body: they overlap neither each other nor what the body did not overlap. At the new edges the round of both leaves a little of the body's volume to neither, (2 − π/2) r² for
//! a metre of the cut's outline where it meets the faces at right angles.

use super::ring::convex_ring;
use super::{Polygon, Polyhedron, Rounded, Shape};
use crate::math::vector::{dot, less, plus, scaled};

/// A piece of a body, with the place of its own frame in that of the body: x = centre + Σ axes`[k]` x'_k.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragment {
    /// Its shape.
    pub shape: Shape,
    /// Its centre of mass, m.
    pub centre: [f64; 3],
    /// Its principal axes, unit vectors.
    pub axes: [[f64; 3]; 3],
}

/// Corners nearer to each other than this share of the body's reach are one.
const ONE: f64 = 1e-6;
/// Normals that differ by less than this belong to one flat face.
const FLAT: f64 = 1e-6;

impl Shape {
    /// The two pieces on the sides of the plane n·x = `offset`, m, in the frame of the body, the one on the side of the unit vector `normal` last. `None`: the plane
    /// leaves no hull with a volume on one of its sides, or the body is none that can be cut (a superquadric, a mesh, a compound, a disc).
    pub fn cut(&self, normal: [f64; 3], offset: f64) -> Option<[Fragment; 2]> {
        let rounded = self.rounded();
        let side = |sign: f64| rounded.beyond(scaled(normal, -sign), -sign * offset);
        Some([side(1.0)?, side(-1.0)?])
    }

    /// The pieces of a body whose points are nearer to one of the `seeds` than to all others, in the order of the seeds. Seeds are in shares of half the body's size along each of
    /// its axes, from the middle of its box, and distances are measured in these shares: cells of a cube (Voronoi), stretched with the body. A cell that leaves no hull with a
    /// volume is no piece; of a body that cannot be cut there is none.
    pub fn cells(&self, seeds: &[[f64; 3]]) -> Vec<Fragment> {
        let [middle, half] = self.rounded().half_sizes();
        // the side of seed p of the plane between p and q
        let plane = |p: [f64; 3], q: [f64; 3]| {
            let normal: [f64; 3] = std::array::from_fn(|a| if half[a] > 0.0 { (p[a] - q[a]) / half[a] } else { 0.0 });
            let square = |s: [f64; 3]| (0..3).filter(|&a| half[a] > 0.0).map(|a| s[a] * s[a]).sum::<f64>();
            let size = dot(normal, normal).sqrt();
            (scaled(normal, 1.0 / size), (0.5 * (square(p) - square(q)) + dot(normal, middle)) / size)
        };
        let cell = |(k, &seed): (usize, &[f64; 3])| {
            let others = seeds.iter().enumerate().filter(|(other, _)| *other != k);
            others
                .map(|(_, &other)| plane(seed, other))
                .try_fold(Fragment::whole(self), |piece, (n, offset)| piece.beyond(n, offset))
        };
        seeds.iter().enumerate().filter_map(cell).collect()
    }
}

impl Fragment {
    /// All of a body.
    fn whole(shape: &Shape) -> Fragment {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Fragment { shape: shape.clone(), centre: [0.0; 3], axes }
    }

    /// Its volume, m³; in plane strain its area, m².
    pub fn volume(&self) -> f64 {
        self.shape.solid().bulk().volume
    }

    /// The hull of `corners`, m, with a sphere of radius `rounding`, m, swept over it, in their frame; `None` where it has no volume.
    pub(super) fn of_hull(corners: &[[f64; 3]], rounding: f64) -> Option<Fragment> {
        let placed = Polyhedron::hull(corners, rounding).ok()?;
        Some(Fragment { shape: Shape::Polyhedron(placed.polyhedron), centre: placed.centre, axes: placed.axes })
    }

    /// The convex outline around `corners` in the plane, m, with a disc of radius `rounding`, m, swept over it, in their frame; `None` where it has no area.
    pub(super) fn of_ring(corners: &[[f64; 3]], rounding: f64) -> Option<Fragment> {
        let corners = convex_ring(&corners.iter().map(|&[x, y, _]| [x, y]).collect::<Vec<_>>());
        let (polygon, [x, y]) = Polygon::of(&corners, rounding).ok()?;
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Some(Fragment { shape: Shape::Polygon(polygon), centre: [x, y, 0.0], axes })
    }

    /// A vector of its own frame in that of the body.
    pub(super) fn outwards(&self, v: [f64; 3]) -> [f64; 3] {
        (0..3).fold([0.0; 3], |sum, k| plus(sum, scaled(self.axes[k], v[k])))
    }

    /// A place of its own frame in that of the body, m.
    pub(super) fn place(&self, at: [f64; 3]) -> [f64; 3] {
        plus(self.centre, self.outwards(at))
    }

    /// What of it lies beyond the plane n·x = `offset`, m, in the frame of the body, on the side of the unit vector `normal`.
    pub(super) fn beyond(self, normal: [f64; 3], offset: f64) -> Option<Fragment> {
        let (n, offset) = (self.axes.map(|axis| dot(axis, normal)), offset - dot(self.centre, normal));
        let rounded = self.shape.rounded();
        if rounded.corners().iter().all(|p| dot(*p, n) >= offset + rounded.rounding()) {
            return Some(self);
        }
        let piece = rounded.beyond(n, offset)?;
        let (centre, axes) = (self.place(piece.centre), piece.axes.map(|axis| self.outwards(axis)));
        Some(Fragment { centre, axes, ..piece })
    }
}

impl Shape {
    /// Whether a shape that comes from outside is one that can be made: numbers, corners that there are, a volume.
    pub(crate) fn is_sound(&self) -> bool {
        let rounded = self.rounded();
        let bulk = self.solid().bulk();
        let numbers = rounded.corners().iter().flatten().chain(&bulk.moments);
        let faces = match &rounded {
            Rounded::Hull(hull) => {
                let fits = |face: &super::HullFace| face.corners.iter().all(|&k| (k as usize) < hull.corners.len());
                hull.corners.len() > 3
                    && hull.faces.iter().all(|f| fits(f) && f.normal.iter().chain([&f.offset]).all(|x| x.is_finite()))
            }
            Rounded::Ring(ring) => !ring.corners.is_empty(),
            Rounded::Sheet(..) | Rounded::Union(_) | Rounded::Smooth(_) => false,
        };
        faces && numbers.copied().all(f64::is_finite) && bulk.volume > 0.0 && rounded.rounding() >= 0.0 && rounded.reach() > 0.0
    }
}

impl Rounded {
    /// Middle of the box around its corners and rounding, in its frame, and half the sizes of the box, m; in the plane 0 along z.
    fn half_sizes(&self) -> [[f64; 3]; 2] {
        let far =
            |a: usize, sign: f64| self.corners().iter().map(|p| sign * p[a]).fold(f64::NEG_INFINITY, f64::max) + self.rounding();
        let flat = matches!(self, Rounded::Ring(_));
        let of = |f: &dyn Fn(f64, f64) -> f64| {
            std::array::from_fn(|a| if flat && a == 2 { 0.0 } else { 0.5 * f(far(a, 1.0), far(a, -1.0)) })
        };
        [of(&|high, low| high - low), of(&|high, low| high + low)]
    }

    /// The piece of which every point x has n·x ≥ `offset`, m, with n = `normal`.
    fn beyond(&self, normal: [f64; 3], offset: f64) -> Option<Fragment> {
        match self {
            Rounded::Hull(hull) => {
                // a line between triangles that are flat but for rounding would put a corner into the middle of a face
                let sharp = |[m, n]: [[f64; 3]; 2]| dot(less(m, n), less(m, n)) > FLAT * FLAT;
                let edges = hull.edges().into_iter().filter(|(_, normals)| sharp(*normals)).map(|(ends, _)| ends);
                let corners = kept(&hull.corners, edges, normal, offset + hull.rounding, ONE * hull.reach);
                Fragment::of_hull(&corners, hull.rounding)
            }
            Rounded::Ring(ring) => {
                let n = ring.corners.len() as u32;
                let sides = (0..n).map(|k| [k, (k + 1) % n]);
                let corners = kept(&ring.corners, sides, normal, offset + ring.rounding, ONE * ring.reach);
                let outline = |f: &Fragment| f.shape.solid().spots() > 2;
                Fragment::of_ring(&corners, ring.rounding).filter(outline)
            }
            Rounded::Sheet(..) | Rounded::Union(_) | Rounded::Smooth(_) => None,
        }
    }
}

/// The corners of a convex body with n·x ≥ `offset`, and where its edges cross the plane there; of those nearer to each other than `one` the first.
fn kept(corners: &[[f64; 3]], edges: impl Iterator<Item = [u32; 2]>, normal: [f64; 3], offset: f64, one: f64) -> Vec<[f64; 3]> {
    let over = |p: [f64; 3]| dot(normal, p) - offset;
    let mut kept: Vec<[f64; 3]> = Vec::new();
    let mut keep = |p: [f64; 3]| {
        let apart = |q: &[f64; 3]| {
            let d = less(p, *q);
            dot(d, d) > one * one
        };
        if kept.iter().all(apart) {
            kept.push(p);
        }
    };
    corners.iter().filter(|p| over(**p) >= 0.0).for_each(|p| keep(*p));
    for ends in edges {
        let [p, q] = ends.map(|k| corners[k as usize]);
        let [a, b] = [over(p), over(q)];
        if (a < 0.0) != (b < 0.0) {
            keep(plus(p, scaled(less(q, p), a / (a - b))));
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half a box: its closed-form volume and centre, and the distance of both pieces is nothing.
    #[test]
    fn pieces_fill_the_body_and_do_not_overlap() {
        let (half, r) = (0.5, 0.01);
        let corners: Vec<[f64; 3]> =
            (0..8).map(|k: u32| std::array::from_fn(|a| if k >> a & 1 == 1 { half } else { -half })).collect();
        let body = Polyhedron::hull(&corners, r).unwrap();
        // the axes of a cube are any: cut across one of its own faces' normals
        let normal = body.axes.map(|axis| axis[0]);
        let shape = Shape::Polyhedron(body.polyhedron);
        for offset in [0.0, 0.2] {
            let [low, high] = shape.cut(normal, offset).unwrap();
            // all three pairs of faces are flat but for the edges: of each cut's outline 4 metres (2 − π/2) r² per metre go, a little less at the corners
            let lost = shape.solid().bulk().volume - low.volume() - high.volume();
            let edges = (2.0 - std::f64::consts::FRAC_PI_2) * r * r * 4.0 * (1.0 + 2.0 * r);
            assert!(lost > 0.0 && lost < edges && lost > 0.95 * edges, "{lost} {edges}");
            let far = |p: &Fragment, n: [f64; 3]| {
                let local = p.axes.map(|axis| dot(axis, n));
                let solid = p.shape.solid();
                let most = (0..solid.spots()).map(|k| dot(solid.spot(k, local), local)).fold(f64::NEG_INFINITY, f64::max);
                most + dot(p.centre, n)
            };
            assert!((far(&low, normal) - offset).abs() < 1e-12 && (far(&high, scaled(normal, -1.0)) + offset).abs() < 1e-12);
            assert_eq!([&low, &high].map(|p| p.shape.solid().spots()), [8, 8]);
            let axes = low.axes;
            assert!((0..3).all(|k| (dot(axes[k], axes[k]) - 1.0).abs() < 1e-12 && dot(axes[k], axes[(k + 1) % 3]).abs() < 1e-12));
        }
        // beside the body there is nothing to cut, and at its skin no hull is left
        assert_eq!(shape.cut(normal, 0.7), None);
        assert_eq!(shape.cut(normal, 0.5), None);
    }

    /// Eight seeds cut a brick into its octants, however long it is and wherever its frame is; two seeds into halves; a seed far away has no cell.
    #[test]
    fn cells_around_seeds_are_stretched_with_the_body() {
        let r = 0.01;
        let corner = |k: u32, half: [f64; 3]| std::array::from_fn(|a| if k >> a & 1 == 1 { half[a] } else { -half[a] });
        let half = [0.5, 1.0, 2.0];
        let body = Shape::Polyhedron(Polyhedron::hull(&(0..8).map(|k| corner(k, half)).collect::<Vec<_>>(), r).unwrap().polyhedron);
        let octants: Vec<[f64; 3]> = (0..8).map(|k| corner(k, [0.5; 3])).collect();
        let pieces = body.cells(&octants);
        assert_eq!(pieces.len(), 8);
        for (piece, seed) in pieces.iter().zip(&octants) {
            let octant = half.iter().map(|h| h + r).product::<f64>();
            assert!(piece.volume() < octant && piece.volume() > 0.99 * octant, "{} {octant}", piece.volume());
            // corners at three planes and three faces
            assert_eq!(piece.shape.solid().spots(), 8);
            assert!((0..3).all(|a| piece.centre[a] * seed[a] > 0.0), "{piece:?}");
        }
        let lost = pieces.iter().fold(body.solid().bulk().volume, |left, piece| left - piece.volume());
        // three cuts, each across all of the body; where cuts cross, the edges of four pieces lose (4 − π) r² instead
        let [a, b, c] = half.map(|h| 2.0 * (h + r));
        let edges =
            (2.0 - std::f64::consts::FRAC_PI_2) * r * r * 4.0 * (a + b + c) + (4.0 - std::f64::consts::PI) * r * r * (a + b + c);
        assert!((lost / edges - 1.0).abs() < 0.02, "{lost} {edges}");
        let halves = body.cells(&[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]);
        let longest = |p: &Fragment| p.shape.rounded().half_sizes()[1].into_iter().fold(0.0, f64::max);
        assert!(halves.len() == 2 && (halves[0].volume() / halves[1].volume() - 1.0).abs() < 1e-12 && longest(&halves[0]) > 1.0);
        assert_eq!(body.cells(&[[0.0; 3], [0.1, 0.0, 0.0], [9.0, 0.0, 0.0]]).len(), 2);
        let (square, _) = Polygon::of(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 1e-3).unwrap();
        let quarters = Shape::Polygon(square).cells(&[[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0]]);
        assert!(quarters.len() == 4 && quarters.iter().all(|p| (p.volume() - 0.5).abs() < 5e-3));
        assert!(Shape::Polygon(Polygon::of(&[[0.0, 0.0]], 1.0).unwrap().0).cells(&octants).is_empty());
    }

    /// A polygon in two: areas and centres of mass of rectangles.
    #[test]
    fn a_polygon_is_cut_into_polygons() {
        let (square, _) = Polygon::of(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]], 1e-3).unwrap();
        let [left, right] = Shape::Polygon(square).cut([1.0, 0.0, 0.0], 0.25).unwrap();
        assert!((left.centre[0] - (-0.375)).abs() < 2e-3 && (right.centre[0] - 0.625).abs() < 2e-3);
        let areas = [&left, &right].map(|p| p.volume());
        assert!((areas[0] - 1.25).abs() < 6e-3 && (areas[1] - 0.75).abs() < 6e-3, "{areas:?}");
        let disc = Shape::Polygon(Polygon::of(&[[0.0, 0.0]], 1.0).unwrap().0);
        assert_eq!(disc.cut([1.0, 0.0, 0.0], 0.0), None);
    }
}
