//! Rounded convex polygons of plane strain, one metre deep: discs, rods and polygons (Jiang et al. 2020, section 3.1).

use super::ring::{Ring, convex_ring};
use super::{Bulk, Mesh, Nearest, Solid};
use crate::math::portable::sin;
use crate::math::vector::{less, plus, scaled};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// A rounded convex polygon. Volume and moments count per metre of depth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Polygon {
    /// Its corners and rounding.
    ring: Ring,
    /// Area times a metre, and the polar moment, which stands for all three.
    bulk: Bulk,
}

/// Points of a corner's arc in pictures.
const ARC: u32 = 12;

impl Polygon {
    /// The polygon with these corners, m, enlarged by a disc of radius `rounding`, m, about its centre of mass; and that centre.
    ///
    /// # Errors
    /// Points that are not the corners of a convex outline; no area.
    pub fn of(points: &[[f64; 2]], rounding: f64) -> Result<(Polygon, [f64; 2]), String> {
        let corners = convex_ring(points);
        if corners.len() != points.len() {
            return Err(format!("must be the corners of a convex outline: {} of {} are", corners.len(), points.len()));
        }
        let (area, [x, y, _], _) = Ring::of(corners.iter().map(|&[x, y]| [x, y, 0.0]).collect(), rounding).area();
        if area.is_nan() || area <= 0.0 {
            return Err("have no area: give rounding_mm to a disc of one corner and a rod of two".into());
        }
        let ring = Ring::of(corners.iter().map(|p| [p[0] - x, p[1] - y, 0.0]).collect(), rounding);
        let (volume, _, polar) = ring.area();
        Ok((Polygon { ring, bulk: Bulk { volume, moments: [polar; 3] } }, [x, y]))
    }

    /// Its corners and rounding.
    pub fn rounded_ring(&self) -> &Ring {
        &self.ring
    }

    /// Radius of the disc of the same area, m.
    pub fn radius(&self) -> f64 {
        (self.bulk.volume / PI).sqrt()
    }
}

impl Solid for Polygon {
    fn nearest(&self, at: [f64; 3]) -> Nearest {
        self.ring.nearest(at)
    }

    fn clearance(&self, [x, y, _]: [f64; 3]) -> f64 {
        (x * x + y * y).sqrt() - self.ring.reach
    }

    fn reach(&self) -> f64 {
        self.ring.reach
    }

    fn spots(&self) -> usize {
        self.ring.corners.len()
    }

    fn spot(&self, k: usize, towards: [f64; 3]) -> [f64; 3] {
        plus(self.ring.corners[k], scaled(towards, self.ring.rounding))
    }

    fn bulk(&self) -> Bulk {
        self.bulk
    }

    fn surface(&self) -> Mesh {
        fan(&self.ring, [0.0; 3])
    }
}

/// A rounded polygon as triangles, for pictures: a fan from `middle`, a place in it.
pub(super) fn fan(ring: &Ring, middle: [f64; 3]) -> Mesh {
    // a fan from the middle to points all around, each on its corner's arc
    let around = ARC * (ring.corners.len() as u32).max(4);
    let rim = |k: u32| {
        // a quarter after the other
        let quarter = around / 4;
        let angle = FRAC_PI_2 * f64::from(k % quarter) / f64::from(quarter);
        let (s, c) = (sin(angle), sin(FRAC_PI_2 - angle));
        let (sine, cosine) = [(s, c), (c, -s), (-s, -c), (-c, s)][(k / quarter % 4) as usize];
        let furthest = |a: &[f64; 3]| a[0] * cosine + a[1] * sine;
        let corner = ring.corners.iter().max_by(|a, b| furthest(a).total_cmp(&furthest(b))).copied().unwrap_or_default();
        plus(corner, [ring.rounding * cosine, ring.rounding * sine, 0.0])
    };
    let mut mesh = Mesh::default();
    for k in 0..around {
        let [p, q] = [rim(k), rim(k + 1)];
        if less(p, q) != [0.0; 3] {
            mesh.add([middle, p, q], [0.0, 0.0, 1.0]);
        }
    }
    mesh
}
