//! Convex polygons enlarged by a disc: the geometry of rounded polygons, and with one corner of discs, in plane strain.

use super::Nearest;
use crate::math::portable::sin;
use crate::math::vector::{dot, less, plus, scaled};
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// A convex polygon in the plane z = 0 with a disc swept over it (Minkowski sum; Jiang et al. 2020, section 3.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ring {
    /// Corners, counter-clockwise, m; one for a disc, two for a rod.
    pub corners: Vec<[f64; 3]>,
    /// Radius of the disc, m.
    pub rounding: f64,
    /// Distance of the furthest point of the rounded polygon from the origin, m.
    pub reach: f64,
}

/// Area, m², centre, m, and polar moment of inertia about the origin for a density of 1, m⁴.
#[derive(Clone, Copy, Debug, Default)]
struct Part {
    area: f64,
    first: [f64; 3],
    polar: f64,
}

impl Part {
    /// With a centre and a polar moment about it.
    fn at(area: f64, centre: [f64; 3], own: f64) -> Part {
        Part { area, first: scaled(centre, area), polar: own + area * dot(centre, centre) }
    }

    fn add(self, other: Part) -> Part {
        Part { area: self.area + other.area, first: plus(self.first, other.first), polar: self.polar + other.polar }
    }
}

impl Ring {
    /// A ring of these corners.
    pub fn of(corners: Vec<[f64; 3]>, rounding: f64) -> Ring {
        let reach = corners.iter().map(|p| dot(*p, *p).sqrt()).fold(0.0, f64::max) + rounding;
        Ring { corners, rounding, reach }
    }

    /// The sides: both ends and the outward unit normal. A disc has none, a rod two.
    pub(super) fn sides(&self) -> impl Iterator<Item = ([[f64; 3]; 2], [f64; 3])> {
        let n = self.corners.len();
        let all = if n > 1 { n } else { 0 };
        (0..all).map(move |k| {
            let [p, q] = [self.corners[k], self.corners[(k + 1) % n]];
            let along = less(q, p);
            let length = dot(along, along).sqrt();
            ([p, q], [along[1] / length, -along[0] / length, 0.0])
        })
    }

    /// Places that stand for the polygon (Jiang et al. 2020, section 1, of blocks of Liu et al.): its corners, as far out as they are round, the middles of its sides, and the origin. Of a disc the ends of two
    /// diameters and the origin.
    pub fn landmarks(&self) -> Vec<[f64; 3]> {
        let r = self.rounding;
        let mut places: Vec<[f64; 3]> = Vec::new();
        for ([p, q], normal) in self.sides() {
            places.extend([scaled(p, 1.0 + r / dot(p, p).sqrt()), plus(scaled(plus(p, q), 0.5), scaled(normal, r))]);
        }
        if let [only] = self.corners[..] {
            places.extend([[r, 0.0, 0.0], [0.0, r, 0.0], [-r, 0.0, 0.0], [0.0, -r, 0.0]].map(|way| plus(only, way)));
        }
        places.push([0.0; 3]);
        places
    }

    /// Whether sides of two rings, without what is round, cross each other.
    pub fn cross(first: &Ring, second: &Ring) -> bool {
        // on which side of p q a place lies
        let side = |[p, q]: [[f64; 3]; 2], at: [f64; 3]| (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0]);
        let parts = |line: [[f64; 3]; 2], [a, b]: [[f64; 3]; 2]| side(line, a) * side(line, b) < 0.0;
        first.sides().any(|(p, _)| second.sides().any(|(q, _)| parts(p, q) && parts(q, p)))
    }

    /// Surface nearest to a position, whose z does not count.
    pub fn nearest(&self, [x, y, _]: [f64; 3]) -> Nearest {
        let at = [x, y, 0.0];
        let (mut deepest, mut face, mut least, mut out) = (f64::NEG_INFINITY, [1.0, 0.0, 0.0], f64::INFINITY, [0.0; 3]);
        let mut look = |away: [f64; 3]| {
            let square = dot(away, away);
            if square < least {
                (least, out) = (square, away);
            }
        };
        if let [only] = self.corners[..] {
            look(less(at, only));
            deepest = 0.0;
        }
        for ([p, q], normal) in self.sides() {
            let (along, to) = (less(q, p), less(at, p));
            let before = dot(normal, to);
            if before > deepest {
                (deepest, face) = (before, normal);
            }
            if before > 0.0 {
                let s = (dot(along, to) / dot(along, along)).clamp(0.0, 1.0);
                look(less(to, scaled(along, s)));
            }
        }
        if least == f64::INFINITY || least == 0.0 {
            return Nearest { distance: deepest.min(0.0) - self.rounding, normal: face };
        }
        let distance = least.sqrt();
        Nearest { distance: distance - self.rounding, normal: scaled(out, 1.0 / distance) }
    }

    /// Area, m², centre, m, and polar moment of inertia about the centre for a density of 1, m⁴: exact, from the triangles of the polygon, the strips along its
    /// sides and the sectors at its corners.
    pub fn area(&self) -> (f64, [f64; 3], f64) {
        let r = self.rounding;
        let mut all = Part::default();
        let normals: Vec<[f64; 3]> = self.sides().map(|(_, normal)| normal).collect();
        for ([p, q], normal) in self.sides() {
            let triangle = 0.5 * (p[0] * q[1] - p[1] * q[0]);
            let polar = triangle * (dot(p, p) + dot(p, q) + dot(q, q)) / 6.0;
            all = all.add(Part { area: triangle, first: scaled(plus(p, q), triangle / 3.0), polar });
            let along = less(q, p);
            let length = dot(along, along).sqrt();
            let middle = plus(scaled(plus(p, q), 0.5), scaled(normal, 0.5 * r));
            all = all.add(Part::at(length * r, middle, length * r * (length * length + r * r) / 12.0));
        }
        let n = self.corners.len();
        for (k, corner) in self.corners.iter().enumerate() {
            // half the angle between the normals of the sides that meet there
            let (half, sine, middle) = if n == 1 {
                (PI, 0.0, [0.0; 3])
            } else {
                let [m, o] = [normals[(k + n - 1) % n], normals[k]];
                let apart = less(o, m);
                let sine = (0.5 * dot(apart, apart).sqrt()).min(1.0);
                // between both; of opposite ones a quarter turn from the first
                let middle = if sine > 0.999_999 { [-m[1], m[0], 0.0] } else { plus(m, o) };
                (arcsine(sine), sine, scaled(middle, 1.0 / dot(middle, middle).sqrt()))
            };
            let area = half * r * r;
            if area > 0.0 {
                let far = 2.0 * r * sine / (3.0 * half);
                let own = 0.5 * half * r * r * r * r - area * far * far;
                all = all.add(Part::at(area, plus(*corner, scaled(middle, far)), own));
            }
        }
        let centre = scaled(all.first, 1.0 / all.area);
        (all.area, centre, all.polar - all.area * dot(centre, centre))
    }
}

/// Angle of a sine from 0 to 1, rad, by Newton's method.
fn arcsine(sine: f64) -> f64 {
    if sine > 0.75 {
        return FRAC_PI_2 - arcsine((1.0 - sine * sine).sqrt());
    }
    let mut angle = sine;
    for _ in 0..6 {
        angle -= (sin(angle) - sine) / sin(FRAC_PI_2 - angle);
    }
    angle
}

/// The corners of the convex hull of points in the plane, counter-clockwise (monotone chain); points on its sides are left out.
pub fn convex_ring(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    sorted.dedup();
    if sorted.len() < 3 {
        return sorted;
    }
    let left = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) > 0.0;
    let chain = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for r in points {
            while chain.len() > 1 && !left(chain[chain.len() - 2], chain[chain.len() - 1], r) {
                chain.pop();
            }
            chain.push(r);
        }
        chain.pop();
        chain
    };
    let mut ring = chain(&mut sorted.iter().copied());
    ring.extend(chain(&mut sorted.iter().rev().copied()));
    ring
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f64, rounding: f64) -> Ring {
        Ring::of([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| [half * x, half * y, 0.0]).into(), rounding)
    }

    #[test]
    fn areas_and_moments_are_the_closed_forms() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-13 * b.abs().max(1.0), "{a} {b}");
        // a disc beside the origin
        let (area, centre, polar) = Ring::of(vec![[0.3, -0.2, 0.0]], 0.5).area();
        close(area, PI * 0.25);
        close(polar, 0.5 * PI * 0.0625);
        assert!((centre[0] - 0.3).abs() < 1e-15 && (centre[1] + 0.2).abs() < 1e-15);
        // a square without rounding, moved
        let moved = Ring::of(square(1.0, 0.0).corners.into_iter().map(|p| plus(p, [2.0, 1.0, 0.0])).collect(), 0.0).area();
        close(moved.0, 4.0);
        close(moved.2, 8.0 / 3.0);
        // a rod: a rectangle 2 × 1 and two half discs of radius 1/2
        let (area, centre, polar) = Ring::of(vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], 0.5).area();
        close(area, 2.0 + 0.25 * PI);
        let (r, ends) = (0.5, 0.25 * PI);
        let far = 4.0 * r / (3.0 * PI);
        close(polar, 2.0 * (4.0 + 1.0) / 12.0 + 0.5 * ends * r * r - ends * far * far + ends * (1.0 + far).powi(2));
        assert!(dot(centre, centre) < 1e-28);
        // the sum of a square and a disc: cross of two rectangles less the square, and a disc
        let (area, _, polar) = square(1.0, 0.5).area();
        close(area, 4.0 + 4.0 + 0.25 * PI);
        // of four quarter discs at the corners, by their sums
        let r = 0.5;
        let quarter = 0.25 * PI * r * r;
        let far = 4.0 * r / (3.0 * PI) * 2.0f64.sqrt();
        let corners = 4.0 * (0.5 * quarter * r * r - quarter * far * far + quarter * (2.0f64.sqrt() + far).powi(2));
        let strips = 4.0 * (1.0 * (4.0 + 0.25) / 12.0 + 1.0 * 1.25 * 1.25);
        close(polar, 8.0 / 3.0 + strips + corners);
    }

    #[test]
    fn the_nearest_point_is_on_the_surface() {
        for (ring, count) in
            [(square(1.0, 0.3), 4), (Ring::of(vec![[0.0; 3]], 0.7), 1), (Ring::of(vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], 0.2), 2)]
        {
            assert_eq!(ring.corners.len(), count);
            for k in 0..200 {
                let (angle, far) = (0.1 + 0.31 * f64::from(k), 1.5 + 0.01 * f64::from(k));
                let at = [far * angle.cos(), far * angle.sin(), 5.0];
                let Nearest { distance, normal } = ring.nearest(at);
                let foot = less([at[0], at[1], 0.0], scaled(normal, distance));
                assert!(normal[2] == 0.0 && (dot(normal, normal) - 1.0).abs() < 1e-14);
                assert!(ring.nearest(foot).distance.abs() < 1e-13, "{at:?}");
                // nothing of the ring lies beyond the tangent at the foot
                assert!(ring.corners.iter().all(|c| dot(less(*c, foot), normal) <= -ring.rounding + 1e-13), "{at:?}");
            }
            assert!(ring.nearest([0.0; 3]).distance < 0.0);
        }
    }

    #[test]
    fn a_convex_ring_leaves_out_what_is_not_a_corner() {
        let ring = convex_ring(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]]);
        assert_eq!(ring, [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert_eq!(convex_ring(&[[1.0, 1.0], [1.0, 1.0]]).len(), 1);
    }
}
