//! The common normal of two superquadrics that touch, by Newton's method.

use super::Smooth;
use crate::math::vector::{cross, dot, less, plus, scaled};

/// A superquadric in space.
#[derive(Clone, Copy)]
pub struct PlacedSmooth<'a> {
    /// Its shape.
    pub smooth: &'a Smooth,
    /// Its centre, m.
    pub centre: [f64; 3],
    /// Its axes, unit vectors.
    pub axes: [[f64; 3]; 3],
}

/// Where two bodies overlap along a common normal.
#[derive(Clone, Copy, Debug)]
pub struct Tangent {
    /// Unit normal out of the first body.
    pub normal: [f64; 3],
    /// Overlap, m; negative where there is a gap.
    pub depth: f64,
    /// Middle of the overlap, m.
    pub at: [f64; 3],
}

/// Most rounds; from a good start it takes two or three.
const ROUNDS: usize = 12;
/// Distance of the two points aside of the normal, over the sum of the radii of the spheres swept over the cores, from which on they count as one.
const ASIDE: f64 = 1e-9;
/// Change of the normal that is none: on two flat sides it decides by more than its rounding where the points lie.
const NO_TURN: f64 = 1e-15;

impl PlacedSmooth<'_> {
    fn inwards(&self, v: [f64; 3]) -> [f64; 3] {
        self.axes.map(|axis| dot(axis, v))
    }

    fn outwards(&self, v: [f64; 3]) -> [f64; 3] {
        let [a, b, c] = self.axes;
        plus(scaled(a, v[0]), plus(scaled(b, v[1]), scaled(c, v[2])))
    }

    /// The point with a normal, m.
    fn furthest(&self, towards: [f64; 3]) -> [f64; 3] {
        plus(self.centre, self.outwards(self.smooth.furthest(self.inwards(towards))))
    }

    /// The point beside a point of the surface, and its normal.
    fn beside(&self, at: [f64; 3], way: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        let local = self.smooth.on_ray(self.inwards(plus(less(at, self.centre), way)));
        (plus(self.centre, self.outwards(local)), self.outwards(self.smooth.bent(local).0))
    }

    /// How the normal changes along two tangents at a point, less `depth`, m: as on the surface that lies further inside by that: [xx, xy, yy], 1/m.
    fn curvature(&self, at: [f64; 3], tangents: [[f64; 3]; 2], depth: f64) -> [f64; 3] {
        let bent = self.smooth.bent(self.inwards(less(at, self.centre))).1;
        let [p, q] = tangents.map(|t| self.inwards(t));
        let of = |p: [f64; 3], q: [f64; 3]| dot(p, bent.map(|row| dot(row, q)));
        let [xx, xy, yy] = [of(p, p), of(p, q), of(q, q)];
        // K (1 − depth K)⁻¹
        let [a, b, c] = [1.0 - depth * xx, -depth * xy, 1.0 - depth * yy];
        let below = a * c - b * b;
        [(xx * c - xy * b) / below, (xy * a - xx * b) / below, (yy * a - xy * b) / below]
    }
}

/// Where two superquadrics touch, from about the common normal `start`, unit vector; `None` if the rounds do not lead there.
///
/// The points x and y with the normals n and −n lie over each other where n is the common normal. A step Δn = K_A Δx = −K_B Δy closes what they are aside, g: (K_A + K_B) Δx = −K_B g with the
/// curvatures K of both. The flatter body is moved along its surface, whose normal there is the next n: on a flat side the place says more than the normal does.
pub fn tangent(first: PlacedSmooth<'_>, second: PlacedSmooth<'_>, start: [f64; 3]) -> Option<Tangent> {
    let radii = [first.smooth.rounding, second.smooth.rounding];
    let sum = radii[0] + radii[1];
    let mut normal = start;
    let (mut x, mut y) = (first.furthest(normal), second.furthest(scaled(normal, -1.0)));
    let (mut last, mut turned) = (f64::INFINITY, f64::INFINITY);
    for round in 0..ROUNDS {
        let between = less(x, y);
        let depth = dot(between, normal);
        let aside = less(between, scaled(normal, depth));
        let far = dot(aside, aside).sqrt();
        if far < ASIDE * sum || turned < NO_TURN {
            // of bodies deeper in each other it need not be the least overlap
            let found = Tangent { normal, depth, at: scaled(plus(x, y), 0.5) };
            return (depth < sum).then_some(found);
        }
        if far.is_nan() || depth >= sum || (round > 3 && far > 0.9 * last) {
            return None;
        }
        last = far;
        let across = if normal[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
        let t = cross(normal, across);
        let t = scaled(t, 1.0 / dot(t, t).sqrt());
        let tangents = [t, cross(normal, t)];
        let [a, b] = [(first, x, radii[0]), (second, y, radii[1])]
            .map(|(body, at, radius)| body.curvature(at, tangents, depth * radius / sum));
        // a trace of curvature, where both are flat
        let least = 1e-9 * (a[0] + a[2] + b[0] + b[2]);
        let sums = [a[0] + b[0] + 2.0 * least, a[1] + b[1], a[2] + b[2] + 2.0 * least];
        let below = sums[0] * sums[2] - sums[1] * sums[1];
        let g = tangents.map(|t| dot(aside, t));
        // (K_A + K_B)⁻¹ K g as a vector
        let way = |k: [f64; 3]| {
            let r = [(k[0] + least) * g[0] + k[1] * g[1], k[1] * g[0] + (k[2] + least) * g[1]];
            let [p, q] = [(sums[2] * r[0] - sums[1] * r[1]) / below, (sums[0] * r[1] - sums[1] * r[0]) / below];
            plus(scaled(tangents[0], p), scaled(tangents[1], q))
        };
        let old = normal;
        if a[0] + a[2] < b[0] + b[2] {
            (x, normal) = first.beside(x, scaled(way(b), -1.0));
            y = second.furthest(scaled(normal, -1.0));
        } else {
            let (at, out) = second.beside(y, way(a));
            (y, normal) = (at, scaled(out, -1.0));
            x = first.furthest(normal);
        }
        let turn = less(normal, old);
        turned = dot(turn, turn).sqrt();
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::{Superquadric, apart};
    use proptest::prelude::*;

    fn unit(v: [f64; 3]) -> [f64; 3] {
        let length = dot(v, v).sqrt();
        if length < 1e-3 { [0.6, 0.0, 0.8] } else { scaled(v, 1.0 / length) }
    }

    fn axes([p, q]: [[f64; 3]; 2]) -> [[f64; 3]; 3] {
        let a = unit(p);
        let aside = less(q, scaled(a, dot(a, q)));
        let b = if dot(aside, aside) > 1e-3 { unit(aside) } else { unit(cross(a, [0.36, 0.48, 0.8])) };
        [a, b, cross(a, b)]
    }

    fn vector() -> impl Strategy<Value = [f64; 3]> {
        [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64]
    }

    proptest! {
        /// Two superquadrics are put together along a normal with a known overlap: Newton's method from beside that normal finds it if it finds anything, and so do the nearest points of the cores.
        #[test]
        fn the_common_normal_is_found(
            sizes in [[0.5..1.5_f64, 0.5..1.5_f64, 0.5..1.5_f64], [0.5..1.5_f64, 0.5..1.5_f64, 0.5..1.5_f64]],
            blockiness in [[2.0..8.0_f64, 2.0..8.0_f64], [2.0..8.0_f64, 2.0..8.0_f64]],
            turns in [[vector(), vector()], [vector(), vector()]],
            (towards, beside) in (vector(), vector()),
            share in -0.5..0.8_f64,
        ) {
            let smooth = [0, 1].map(|k| Smooth::of(Superquadric { half: sizes[k], blockiness: blockiness[k] }));
            let n = unit(towards);
            let mut bodies = [0, 1].map(|k| PlacedSmooth { smooth: &smooth[k], centre: [0.0; 3], axes: axes(turns[k]) });
            let depth = share * (smooth[0].rounding + smooth[1].rounding);
            let at = less(bodies[0].furthest(n), bodies[1].furthest(scaled(n, -1.0)));
            bodies[1].centre = less(at, scaled(n, depth));
            let [a, b] = bodies;
            let start = unit(plus(n, scaled(beside, 1e-3)));
            if let Some(found) = tangent(a, b, start) {
                prop_assert!((found.depth - depth).abs() < 1e-12, "{found:?} {n:?} {depth:e}");
                prop_assert!((dot(found.normal, n) - 1.0).abs() < 1e-10);
            }
            let core = |body: PlacedSmooth<'_>, n: [f64; 3]| less(body.furthest(n), scaled(n, body.smooth.rounding));
            let sum = smooth[0].rounding + smooth[1].rounding;
            let found = apart(|n| core(a, n), |n| core(b, n), unit(b.centre), [2.0 * sum, 0.0]).expect("near");
            prop_assert!((sum - found.distance - depth).abs() < 1e-12, "{found:?} {depth:e}");
        }
    }
}
