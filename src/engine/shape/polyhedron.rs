//! Rounded convex polyhedra: the convex hull of given points, enlarged by a sphere (Minkowski sum, as in Jiang et al. 2020).

use super::{Bulk, Mesh, Nearest, Solid};
use crate::math::vector::{cross, dot, less, plus, scaled};
use nalgebra::{Matrix3, SymmetricEigen};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQueryWithLocation;
use parry3d_f64::shape::{Triangle, TrianglePointLocation};
use parry3d_f64::transformation::try_convex_hull;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A rounded convex polyhedron.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Polyhedron {
    /// Corners of the hull, m.
    corners: Vec<[f64; 3]>,
    /// Triangles of the hull.
    faces: Vec<HullFace>,
    /// Radius of the sphere, m.
    rounding: f64,
    /// Volume and moments of inertia of the rounded body.
    bulk: Bulk,
    /// Distance of the furthest point of the rounded body from the origin, m.
    reach: f64,
}

/// A triangle of the hull.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct HullFace {
    /// Indices of its corners.
    corners: [u32; 3],
    /// Outward unit normal.
    normal: [f64; 3],
    /// Distance of its plane from the origin along the normal, m.
    offset: f64,
}

/// A polyhedron in its own frame, with the place of that frame among the points that it was made from: x = centre + Σ axes`[k]` x'_k.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// The polyhedron.
    pub polyhedron: Polyhedron,
    /// Its centre of mass, m.
    pub centre: [f64; 3],
    /// Its principal axes, unit vectors.
    pub axes: [[f64; 3]; 3],
}

/// Number of times that arcs are halved for volume and inertia; once more gives an estimate of the error, which is removed.
const FINE: u32 = 3;
/// Number of times that arcs are halved for pictures.
const SHOWN: u32 = 2;
/// Normals that differ by less than this belong to one flat face.
const FLAT: f64 = 1e-9;

impl Polyhedron {
    /// The convex hull of `points`, m, enlarged by a sphere of radius `rounding`, m.
    ///
    /// # Errors
    /// Points whose hull has no volume; the text says so.
    pub fn hull(points: &[[f64; 3]], rounding: f64) -> Result<Placed, String> {
        let vectors: Vec<Vector> = points.iter().map(|&p| Vector::from(p)).collect();
        let (corners, triangles) = try_convex_hull(&vectors).map_err(|e| format!("have no convex hull with a volume: {e}"))?;
        let corners: Vec<[f64; 3]> = corners.into_iter().map(Into::into).collect();
        let hull = Polyhedron::of(corners, &triangles, rounding);
        let (volume, centre, inertia) = hull.inertia();
        let size = hull.reach * hull.reach * hull.reach;
        if volume.is_nan() || volume <= 1e-9 * size {
            return Err("have no convex hull with a volume".into());
        }
        let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(inertia);
        let column = |k: usize| -> [f64; 3] { std::array::from_fn(|a| eigenvectors[(a, k)]) };
        let axes = [column(0), column(1), cross(column(0), column(1))];
        let turned = |p: &[f64; 3]| axes.map(|axis| dot(axis, less(*p, centre)));
        let mut polyhedron = Polyhedron::of(hull.corners.iter().map(turned).collect(), &triangles, rounding);
        polyhedron.bulk = Bulk { volume, moments: std::array::from_fn(|k| eigenvalues[k]) };
        Ok(Placed { polyhedron, centre, axes })
    }

    /// A polyhedron with these corners and triangles; volume and moments of inertia are not computed yet.
    fn of(corners: Vec<[f64; 3]>, triangles: &[[u32; 3]], rounding: f64) -> Polyhedron {
        let faces = triangles.iter().map(|&t| {
            let [p, q, r] = t.map(|k| corners[k as usize]);
            let n = cross(less(q, p), less(r, p));
            let normal = scaled(n, 1.0 / dot(n, n).sqrt());
            HullFace { corners: t, normal, offset: dot(normal, p) }
        });
        let reach = corners.iter().map(|p| dot(*p, *p).sqrt()).fold(0.0, f64::max) + rounding;
        Polyhedron { faces: faces.collect(), corners, rounding, bulk: Bulk { volume: 0.0, moments: [0.0; 3] }, reach }
    }

    /// Volume, m³, centre, m, and tensor of inertia about it for a density of 1, m⁵. Flat parts are exact. Round parts are approximated by triangles, with an
    /// error in proportion to the square of their size, which is removed by extrapolation from two sizes.
    fn inertia(&self) -> (f64, [f64; 3], Matrix3<f64>) {
        let of = |fine: u32| {
            let (volume, centre, inertia) = self.triangles(fine).inertia();
            let columns: [[f64; 3]; 3] = inertia.to_cols_array_2d();
            (volume, <[f64; 3]>::from(centre), Matrix3::from(columns))
        };
        let coarse = of(FINE);
        if self.rounding == 0.0 {
            return coarse;
        }
        let fine = of(FINE + 1);
        let beyond = |fine: f64, coarse: f64| fine + (fine - coarse) / 3.0;
        let centre = std::array::from_fn(|a| beyond(fine.1[a], coarse.1[a]));
        (beyond(fine.0, coarse.0), centre, fine.2 + (fine.2 - coarse.2) / 3.0)
    }

    /// The rounded surface as triangles; arcs are halved `fine` times.
    fn triangles(&self, fine: u32) -> Mesh {
        let mut mesh = Mesh::default();
        let corner = |k: u32| self.corners[k as usize];
        let out = |p: [f64; 3], n: [f64; 3]| plus(p, scaled(n, self.rounding));
        // normals of the two faces at each edge, and sum of the normals around each corner
        let mut edges: BTreeMap<[u32; 2], Vec<[f64; 3]>> = BTreeMap::new();
        let mut means = vec![[0.0; 3]; self.corners.len()];
        for face in &self.faces {
            mesh.add(face.corners.map(|k| out(corner(k), face.normal)), face.normal);
            for k in 0..3 {
                let (i, j) = (face.corners[k], face.corners[(k + 1) % 3]);
                edges.entry([i.min(j), i.max(j)]).or_default().push(face.normal);
                means[i as usize] = plus(means[i as usize], face.normal);
            }
        }
        if self.rounding == 0.0 {
            return mesh;
        }
        for ([i, j], sides) in &edges {
            let &[m, n] = sides.as_slice() else { continue };
            let apart = less(m, n);
            if dot(apart, apart) < FLAT * FLAT {
                continue;
            }
            let (p, q) = (corner(*i), corner(*j));
            let mut arc = vec![m, n];
            for _ in 0..fine {
                let last = [arc[arc.len() - 1]];
                arc = arc.windows(2).flat_map(|w| [w[0], halfway(w[0], w[1])]).chain(last).collect();
            }
            for w in arc.windows(2) {
                let outwards = plus(w[0], w[1]);
                mesh.add([out(p, w[0]), out(q, w[0]), out(q, w[1])], outwards);
                mesh.add([out(p, w[0]), out(q, w[1]), out(p, w[1])], outwards);
            }
            for k in [*i, *j] {
                let middle = means[k as usize];
                let middle = scaled(middle, 1.0 / dot(middle, middle).sqrt());
                cap(&mut mesh, &|n| out(corner(k), n), [middle, m, n], fine);
            }
        }
        mesh
    }
}

/// Unit vector halfway between two unit vectors.
fn halfway(m: [f64; 3], n: [f64; 3]) -> [f64; 3] {
    let sum = plus(m, n);
    scaled(sum, 1.0 / dot(sum, sum).sqrt())
}

/// Adds a triangle of a sphere, divided into four `fine` times; `out` gives the position for a unit normal.
fn cap(mesh: &mut Mesh, out: &impl Fn([f64; 3]) -> [f64; 3], [l, m, n]: [[f64; 3]; 3], fine: u32) {
    if fine == 0 {
        return mesh.add([l, m, n].map(out), plus(l, plus(m, n)));
    }
    let [a, b, c] = [halfway(m, n), halfway(n, l), halfway(l, m)];
    for corners in [[l, c, b], [c, m, a], [b, a, n], [a, b, c]] {
        cap(mesh, out, corners, fine - 1);
    }
}

impl Solid for Polyhedron {
    /// The nearest point on the triangles in front of which the position lies. Parry's projection on a triangle uses + − × ÷ only.
    fn nearest(&self, at: [f64; 3]) -> Nearest {
        let (point, mut least) = (Vector::from(at), f64::INFINITY);
        let (mut deepest, mut found) = (f64::NEG_INFINITY, [0.0; 3]);
        for face in &self.faces {
            let before = dot(face.normal, at) - face.offset;
            if before <= 0.0 {
                // for a position inside of all faces: the nearest face
                if least == f64::INFINITY && before > deepest {
                    (deepest, found) = (before, face.normal);
                }
                continue;
            }
            if before * before >= least {
                continue;
            }
            let [a, b, c] = face.corners.map(|k| Vector::from(self.corners[k as usize]));
            let (projection, place) = Triangle::new(a, b, c).project_local_point_and_get_location(point, false);
            let on_face = matches!(place, TrianglePointLocation::OnFace(..));
            let out = if on_face { scaled(face.normal, before) } else { less(at, projection.point.into()) };
            let square = dot(out, out);
            if square < least {
                (least, found) = (square, out);
            }
        }
        if least == f64::INFINITY {
            return Nearest { distance: deepest - self.rounding, normal: found };
        }
        let distance = least.sqrt();
        Nearest { distance: distance - self.rounding, normal: scaled(found, 1.0 / distance) }
    }

    fn clearance(&self, at: [f64; 3]) -> f64 {
        dot(at, at).sqrt() - self.reach
    }

    fn reach(&self) -> f64 {
        self.reach
    }

    fn spots(&self) -> usize {
        self.corners.len()
    }

    fn spot(&self, k: usize, towards: [f64; 3]) -> [f64; 3] {
        plus(self.corners[k], scaled(towards, self.rounding))
    }

    fn bulk(&self) -> Bulk {
        self.bulk
    }

    fn surface(&self) -> Mesh {
        self.triangles(SHOWN)
    }
}
