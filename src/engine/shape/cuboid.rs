//! A box with sharp edges.

use super::hull::Hull;
use super::{Bulk, Mesh, Nearest, Solid};
use crate::math::vector::dot;
use serde::{Deserialize, Serialize};

/// A box with sharp edges.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cuboid {
    /// Half of the edges along x, y, z, m.
    pub half: [f64; 3],
}

/// Radius of the edges against other bodies, over the least half edge.
const ROUNDED: f64 = 0.05;

impl Cuboid {
    /// The box as other bodies touch it: its edges are rounded with a twentieth of the least half edge, because beside a sharp edge the nearest face, and so the
    /// direction of the force, changes suddenly with the overlap. Its faces stay where they are.
    pub fn rounded(&self) -> Hull {
        let rounding = self.rounding();
        let high = self.half.map(|h| h - rounding);
        Cuboid::hull([high.map(|h| -h), high], rounding)
    }

    /// Radius of its edges against other bodies, m.
    pub(super) fn rounding(&self) -> f64 {
        ROUNDED * self.half.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The hull of a box between two corners, m, with a sphere swept over it.
    pub(super) fn hull([low, high]: [[f64; 3]; 2], rounding: f64) -> Hull {
        // corner k lies at the high end of axis a where bit a of k is 1
        let corners = (0..8).map(|k| std::array::from_fn(|a| if k >> a & 1 == 1 { high[a] } else { low[a] })).collect();
        let side = |axis: usize, high: u32| {
            let (u, v) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let first = high << axis;
            let [a, b, c, d] = [first, first | u, first | u | v, first | v];
            if high == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] }
        };
        let triangles: Vec<[u32; 3]> = (0..3).flat_map(|axis| [0, 1].map(|high| side(axis, high))).flatten().collect();
        Hull::of(corners, &triangles, rounding)
    }
}

impl Solid for Cuboid {
    fn nearest(&self, at: [f64; 3]) -> Nearest {
        let beyond: [f64; 3] = std::array::from_fn(|a| at[a].abs() - self.half[a]);
        let side = |a: usize| 1.0_f64.copysign(at[a]);
        let out = beyond.map(|x| x.max(0.0));
        let distance = dot(out, out).sqrt();
        if distance > 0.0 {
            return Nearest { distance, normal: std::array::from_fn(|a| side(a) * out[a] / distance) };
        }
        // inside: the normal of the nearest face
        let a = (0..3).fold(0, |most, a| if beyond[a] > beyond[most] { a } else { most });
        let mut normal = [0.0; 3];
        normal[a] = side(a);
        Nearest { distance: beyond[a], normal }
    }

    fn clearance(&self, at: [f64; 3]) -> f64 {
        (0..3).map(|a| at[a].abs() - self.half[a]).fold(f64::NEG_INFINITY, f64::max)
    }

    fn reach(&self) -> f64 {
        dot(self.half, self.half).sqrt()
    }

    fn spots(&self) -> usize {
        8
    }

    fn spot(&self, k: usize, _: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| if k >> a & 1 == 1 { self.half[a] } else { -self.half[a] })
    }

    fn bulk(&self) -> Bulk {
        let [x, y, z] = self.half;
        let volume = 8.0 * x * y * z;
        Bulk { volume, moments: [y * y + z * z, z * z + x * x, x * x + y * y].map(|sum| volume * sum / 3.0) }
    }

    fn surface(&self) -> Mesh {
        Mesh::of_cube(1, |direction| std::array::from_fn(|a| direction[a] * self.half[a]))
    }
}
