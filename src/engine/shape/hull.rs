//! Convex hulls of corners, enlarged by a sphere: the geometry of rounded polyhedra, and of boxes where they touch other bodies.

use super::Nearest;
use super::core::furthest;
use crate::math::vector::{cross, dot, less, plus, scaled};
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query::{PointQueryWithLocation, distance, intersection_test};
use parry3d_f64::shape::{ConvexPolyhedron, Triangle, TrianglePointLocation};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A convex hull with a sphere swept over it (Minkowski sum).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hull {
    /// Corners of the hull, m.
    pub corners: Vec<[f64; 3]>,
    /// Triangles of the hull.
    pub faces: Vec<HullFace>,
    /// Radius of the sphere, m.
    pub rounding: f64,
    /// Distance of the furthest point of the rounded hull from the origin, m.
    pub reach: f64,
}

/// A triangle of the hull.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HullFace {
    /// Indices of its corners.
    pub corners: [u32; 3],
    /// Outward unit normal.
    pub normal: [f64; 3],
    /// Distance of its plane from the origin along the normal, m.
    pub offset: f64,
}

/// Normals that differ by less than this belong to one flat face.
pub(super) const FLAT: f64 = 1e-9;

/// Positions less than this share of the reach in front of a face lie on it.
const ON_FACE: f64 = 1e-13;

/// Share of its distance by which a position may be nearer to the plane of another triangle of the same flat face.
const FLUSH: f64 = 1e-6;

/// The hull of a set of corners, if it has a volume.
fn solid(corners: &[[f64; 3]]) -> Option<ConvexPolyhedron> {
    let corners: Vec<Vector> = corners.iter().map(|&p| Vector::from(p)).collect();
    ConvexPolyhedron::from_convex_hull(&corners)
}

impl Hull {
    /// A hull of these corners and triangles.
    pub fn of(corners: Vec<[f64; 3]>, triangles: &[[u32; 3]], rounding: f64) -> Hull {
        let faces = triangles.iter().map(|&t| {
            let [p, q, r] = t.map(|k| corners[k as usize]);
            let n = cross(less(q, p), less(r, p));
            let normal = scaled(n, 1.0 / dot(n, n).sqrt());
            HullFace { corners: t, normal, offset: dot(normal, p) }
        });
        let reach = corners.iter().map(|p| dot(*p, *p).sqrt()).fold(0.0, f64::max) + rounding;
        Hull { faces: faces.collect(), corners, rounding, reach }
    }

    /// The corner that is furthest along a direction; of several the first.
    pub fn furthest(&self, towards: [f64; 3]) -> [f64; 3] {
        furthest(&self.corners, towards)
    }

    /// At each corner a unit vector that lies between the normals of its faces: along their sum.
    pub fn outwards(&self) -> Vec<[f64; 3]> {
        let mut sums = vec![[0.0; 3]; self.corners.len()];
        for face in &self.faces {
            for k in face.corners {
                sums[k as usize] = plus(sums[k as usize], face.normal);
            }
        }
        sums.into_iter().map(|sum| scaled(sum, 1.0 / dot(sum, sum).sqrt())).collect()
    }

    /// The ends of each edge, lower index first, in their order, with the normals of its two faces. Lines between triangles of one flat face are left out.
    pub fn edges(&self) -> Vec<([u32; 2], [[f64; 3]; 2])> {
        let mut sides: BTreeMap<[u32; 2], Vec<[f64; 3]>> = BTreeMap::new();
        for face in &self.faces {
            for k in 0..3 {
                let (i, j) = (face.corners[k], face.corners[(k + 1) % 3]);
                sides.entry([i.min(j), i.max(j)]).or_default().push(face.normal);
            }
        }
        let sharp = |(ends, normals): ([u32; 2], Vec<[f64; 3]>)| {
            let &[m, n] = normals.as_slice() else { return None };
            let apart = less(m, n);
            (dot(apart, apart) >= FLAT * FLAT).then_some((ends, [m, n]))
        };
        sides.into_iter().filter_map(sharp).collect()
    }

    /// Whether the hulls of two sets of corners in space cut each other.
    pub fn cut(first: &[[f64; 3]], second: &[[f64; 3]]) -> bool {
        let (Some(a), Some(b)) = (solid(first), solid(second)) else { return false };
        intersection_test(&Pose::IDENTITY, &a, &Pose::IDENTITY, &b).is_ok_and(|found| found.intersecting)
    }

    /// Distance of the hulls of two sets of corners in space, m; 0 where they overlap, infinite where one has no volume.
    pub fn gap(first: &[[f64; 3]], second: &[[f64; 3]]) -> f64 {
        let (Some(a), Some(b)) = (solid(first), solid(second)) else { return f64::INFINITY };
        distance(&Pose::IDENTITY, &a, &Pose::IDENTITY, &b).map_or(f64::INFINITY, |found| found.distance)
    }

    /// Whether any of these triangles cuts the hull of a set of corners in space.
    pub fn cut_by(corners: &[[f64; 3]], triangles: &[[[f64; 3]; 3]]) -> bool {
        let Some(solid) = solid(corners) else { return false };
        triangles.iter().any(|t| {
            let [a, b, c] = t.map(Vector::from);
            let triangle = Triangle::new(a, b, c);
            intersection_test(&Pose::IDENTITY, &solid, &Pose::IDENTITY, &triangle).is_ok_and(|found| found.intersecting)
        })
    }

    /// Largest distance of a position from the plane of a face, less the rounding, m: it is at least so far from the rounded surface.
    pub fn before(&self, at: [f64; 3]) -> f64 {
        self.faces.iter().map(|face| dot(face.normal, at) - face.offset).fold(f64::NEG_INFINITY, f64::max) - self.rounding
    }

    /// The nearest point of the rounded surface.
    pub fn nearest(&self, at: [f64; 3]) -> Nearest {
        let nowhere = Nearest { distance: f64::NEG_INFINITY, normal: [0.0; 3] };
        self.nearest_within(at, f64::INFINITY).unwrap_or(nowhere)
    }

    /// The nearest point of the rounded surface; `None` where it is certainly further than `within`, m, as the plane of a face is. Nothing is nearer than the plane of the face in front of which the
    /// position lies furthest: where the foot on that plane is inside of the face, only others of the same plane are looked at, as the normals of narrow triangles are not exact.
    pub fn nearest_within(&self, at: [f64; 3], within: f64) -> Option<Nearest> {
        let before = |face: &HullFace| dot(face.normal, at) - face.offset;
        let (mut most, mut facing) = (f64::NEG_INFINITY, None);
        for (k, face) in self.faces.iter().enumerate() {
            let before = before(face);
            if before > most {
                (most, facing) = (before, Some((k, face)));
            }
        }
        // of no place at all: as deep as can be, so that a contact with it ends the run
        let Some((facing, face)) = facing else { return Some(Nearest { distance: most, normal: [0.0; 3] }) };
        // a hair for rounding
        if most > (within + self.rounding) * (1.0 + 1e-9) {
            return None;
        }
        // two triangles of one flat face may not agree which side a position in their plane is on
        let hair = ON_FACE * self.reach;
        if most <= hair {
            return Some(Nearest { distance: most - self.rounding, normal: face.normal });
        }
        let (first, inside) = self.foot(face, most, at);
        let above = if inside { (1.0 - FLUSH) * most } else { hair };
        let (mut least, mut out) = (f64::INFINITY, first);
        for (k, face) in self.faces.iter().enumerate() {
            let before = before(face);
            if before <= above || before * before >= least {
                continue;
            }
            let theirs = if k == facing { first } else { self.foot(face, before, at).0 };
            let square = dot(theirs, theirs);
            if square < least {
                (least, out) = (square, theirs);
            }
        }
        let distance = least.sqrt();
        Some(Nearest { distance: distance - self.rounding, normal: scaled(out, 1.0 / distance) })
    }

    /// From the nearest point of a face to a position that lies `before` it, m, and whether that point is inside of the face. Parry's projection on a triangle uses + − × ÷ only.
    fn foot(&self, face: &HullFace, before: f64, at: [f64; 3]) -> ([f64; 3], bool) {
        let [a, b, c] = face.corners.map(|k| Vector::from(self.corners[k as usize]));
        let (projection, place) = Triangle::new(a, b, c).project_local_point_and_get_location(Vector::from(at), false);
        let inside = matches!(place, TrianglePointLocation::OnFace(..));
        (if inside { scaled(face.normal, before) } else { less(at, projection.point.into()) }, inside)
    }
}
