//! Rounded convex polyhedra: the convex hull of given points, enlarged by a sphere (Minkowski sum, as in Jiang et al. 2020).

use super::hull::Hull;
use super::{Bulk, Mesh, Nearest, Solid, steiner};
use crate::math::eigen::principal;
use crate::math::vector::{cross, dot, less, plus, scaled};
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;
use serde::{Deserialize, Serialize};

/// A rounded convex polyhedron.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Polyhedron {
    /// Its corners, faces and rounding.
    hull: Hull,
    /// Volume and moments of inertia of the rounded body.
    bulk: Bulk,
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

/// Number of times that arcs are halved for pictures.
pub(super) const SHOWN: u32 = 1;

impl Polyhedron {
    /// The convex hull of `points`, m, enlarged by a sphere of radius `rounding`, m.
    ///
    /// # Errors
    /// Points whose hull has no volume; the text says so.
    pub fn hull(points: &[[f64; 3]], rounding: f64) -> Result<Placed, String> {
        let vectors: Vec<Vector> = points.iter().map(|&p| Vector::from(p)).collect();
        let (corners, triangles) = try_convex_hull(&vectors).map_err(|e| format!("have no convex hull with a volume: {e}"))?;
        let hull = Hull::of(corners.into_iter().map(Into::into).collect(), &triangles, rounding);
        let (volume, centre, inertia) = steiner::inertia(&hull);
        let size = hull.reach * hull.reach * hull.reach;
        if volume.is_nan() || volume <= 1e-9 * size {
            return Err("have no convex hull with a volume".into());
        }
        let (moments, [first, second, _]) = principal(inertia);
        let axes = [first, second, cross(first, second)];
        let turned = |p: &[f64; 3]| axes.map(|axis| dot(axis, less(*p, centre)));
        let bulk = Bulk { volume, moments };
        let hull = Hull::of(hull.corners.iter().map(turned).collect(), &triangles, rounding);
        Ok(Placed { polyhedron: Polyhedron { hull, bulk }, centre, axes })
    }

    /// Its corners, faces and rounding.
    pub fn rounded_hull(&self) -> &Hull {
        &self.hull
    }
}

/// The rounded surface as triangles; arcs are halved `fine` times.
pub(super) fn triangles(hull: &Hull, fine: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let corner = |k: u32| hull.corners[k as usize];
    let out = |p: [f64; 3], n: [f64; 3]| plus(p, scaled(n, hull.rounding));
    for face in &hull.faces {
        mesh.add(face.corners.map(|k| out(corner(k), face.normal)), face.normal);
    }
    if hull.rounding == 0.0 {
        return mesh;
    }
    let corner_normals = hull.outwards();
    for ([i, j], [m, n]) in hull.edges() {
        let (p, q) = (corner(i), corner(j));
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
        for k in [i, j] {
            cap(&mut mesh, &|n| out(corner(k), n), [corner_normals[k as usize], m, n], fine);
        }
    }
    mesh
}

/// Unit vector halfway between two unit vectors.
pub(super) fn halfway(m: [f64; 3], n: [f64; 3]) -> [f64; 3] {
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
    fn nearest(&self, at: [f64; 3]) -> Nearest {
        self.hull.nearest(at)
    }

    fn clearance(&self, at: [f64; 3]) -> f64 {
        dot(at, at).sqrt() - self.hull.reach
    }

    fn reach(&self) -> f64 {
        self.hull.reach
    }

    fn spots(&self) -> usize {
        self.hull.corners.len()
    }

    fn spot(&self, k: usize, towards: [f64; 3]) -> [f64; 3] {
        plus(self.hull.corners[k], scaled(towards, self.hull.rounding))
    }

    fn bulk(&self) -> Bulk {
        self.bulk
    }

    fn surface(&self) -> Mesh {
        triangles(&self.hull, SHOWN)
    }
}
