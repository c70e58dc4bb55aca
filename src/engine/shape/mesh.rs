//! Surfaces made of triangles, and their volume and inertia.

use super::Bulk;
use super::moments::Moments;
use crate::math::vector::{cross, dot, less, plus};

/// A closed surface made of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners, m.
    pub corners: Vec<[f64; 3]>,
    /// Triangles as indices of corners, counter-clockwise when seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The surface of the cube from −1 to 1, divided into `n` squares along an edge, with each corner moved by `place`, which must not turn triangles inside
    /// out.
    pub fn of_cube(n: u32, place: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
        let mut mesh = Mesh::default();
        let at = |k: u32| 2.0 * f64::from(k) / f64::from(n) - 1.0;
        for (axis, side) in (0..3).flat_map(|axis| [(axis, -1.0), (axis, 1.0)]) {
            let first = mesh.corners.len() as u32;
            for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, at(i), at(j));
                mesh.corners.push(place(p));
            }
            for (j, i) in (0..n).flat_map(|j| (0..n).map(move |i| (j, i))) {
                let [a, b] = [first + j * (n + 1) + i, first + (j + 1) * (n + 1) + i];
                for [p, q, r] in [[a, a + 1, b + 1], [a, b + 1, b]] {
                    mesh.triangles.push(if side > 0.0 { [p, q, r] } else { [p, r, q] });
                }
            }
        }
        mesh
    }

    /// Adds a triangle with these corners, m, ordered so that its normal points to the side of `outwards`.
    pub fn add(&mut self, corners: [[f64; 3]; 3], outwards: [f64; 3]) {
        let k = self.corners.len() as u32;
        let [p, q, r] = corners;
        let looks = dot(cross(less(q, p), less(r, p)), outwards) >= 0.0;
        self.corners.extend(corners);
        self.triangles.push(if looks { [k, k + 1, k + 2] } else { [k, k + 2, k + 1] });
    }

    /// Volume, m³, centre of the volume, m, and tensor of inertia about it for a density of 1, `[xx, yy, zz, xy, yz, zx]`, m⁵.
    pub fn inertia(&self) -> (f64, [f64; 3], [f64; 6]) {
        let from = |origin: [f64; 3]| {
            let of = |t: &[u32; 3]| Moments::of_tetrahedron(t.map(|k| less(self.corners[k as usize], origin)));
            self.triangles.iter().fold(Moments::default(), |sum, t| sum.plus(&of(t), 1.0))
        };
        // about the centre itself, so that no large parts cancel
        let origin = self.corners.first().copied().unwrap_or_default();
        let centre = plus(origin, from(origin).centre());
        let about = from(centre);
        (about.volume, centre, about.inertia())
    }

    /// Volume and moments of inertia of a surface whose centre is the origin and whose principal axes are x, y, z.
    pub fn bulk(&self) -> Bulk {
        let (volume, _, inertia) = self.inertia();
        let [xx, yy, zz, ..] = inertia;
        Bulk { volume, moments: [xx, yy, zz] }
    }
}
