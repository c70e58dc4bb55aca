//! Superquadrics as other bodies touch them: a convex core with a sphere swept over it.
//!
//! A convex body whose surface is nowhere curved more than a sphere of radius ρ is a convex core with that sphere swept over it. The support function of the core is h(n) − ρ |n|,
//! and the point of the core with the normal n is that of the body less ρ n.

use super::Superquadric;
use crate::math::portable::{exp, ln, pow};
use crate::math::vector::{dot, less, scaled};

/// A superquadric with the radius of the sphere in it that rolls all over its inside.
#[derive(Clone, Debug, PartialEq)]
pub struct Smooth {
    shape: Superquadric,
    /// Radius of the sphere, m.
    pub rounding: f64,
    /// Distance of the furthest point from the origin, m.
    pub reach: f64,
}

impl Smooth {
    /// The superquadric with ρ = c²/((n − 1) R): c least half length, n larger exponent, R reach. No radius of curvature is less: with the gauge g of the body, ½ g² bends along a
    /// tangent t by (n − 1) g(t)² at most (Ball, Carlen & Lieb 1994, for norms of exponents of 2 and more, one in the other), g(t) ≤ |t|/c and |∇g| ≥ 1/R. Of an ellipsoid it is the least
    /// radius itself.
    pub fn of(shape: Superquadric) -> Smooth {
        let least = shape.half.into_iter().fold(f64::INFINITY, f64::min);
        let [n1, n2] = shape.blockiness;
        let [a, b, c] = shape.half;
        let reach = furthest(furthest(a, b, n2), c, n1);
        Smooth { shape, rounding: least * least / ((n1.max(n2) - 1.0) * reach), reach }
    }

    /// The point of the core that is furthest along the unit vector `towards`, in the frame of the body.
    pub fn core(&self, towards: [f64; 3]) -> [f64; 3] {
        less(self.furthest(towards), scaled(towards, self.rounding))
    }

    /// The point that is furthest along `towards`, as [`super::Solid::spot`] gives it, with about half as many powers.
    pub fn furthest(&self, towards: [f64; 3]) -> [f64; 3] {
        let [n1, n2] = self.shape.blockiness;
        let x: [f64; 3] = std::array::from_fn(|a| (self.shape.half[a] * towards[a]).abs());
        let most = x.into_iter().fold(NOTHING, f64::max);
        let [x, y, z] = x.map(|x| x / most);
        let (u, v, flat) = dual(x, y, n2);
        let (s, w, _) = dual(flat, z, n1);
        let at = [s * u, s * v, w];
        std::array::from_fn(|a| (at[a] * self.shape.half[a]).copysign(towards[a]))
    }

    /// The point of the surface on the ray from the origin to a position, which is not the origin.
    pub fn on_ray(&self, at: [f64; 3]) -> [f64; 3] {
        let [n1, n2] = self.shape.blockiness;
        let [u, v, w] = self.parts(at);
        let flat = power(u, n2) + power(v, n2);
        let sum = power(flat, n1 / n2) + power(w, n1);
        scaled(at, power(sum, -1.0 / n1))
    }

    /// Outward unit normal at a point of the surface, and how it changes along tangents: the second derivatives of f over the length of its gradient, 1/m.
    pub fn bent(&self, at: [f64; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
        let ([n1, n2], [a, b, c]) = (self.shape.blockiness, self.shape.half);
        let [u, v, w] = self.parts(at);
        let [p, q, r] = [power(u, n2 - 2.0), power(v, n2 - 2.0), power(w, n1 - 2.0)];
        let sum = (p * u * u + q * v * v).max(NOTHING);
        // powers n₁/n₂ − 2 and n₁/n₂ − 1 of the sum
        let inner = power(sum, n1 / n2 - 2.0);
        let outer = inner * sum;
        let [x, y, z] = [p * u, q * v, r * w];
        let side = |k: usize, x: f64| x.copysign(at[k]);
        let gradient = [side(0, outer * x / a), side(1, outer * y / b), side(2, z / c)];
        let length = dot(gradient, gradient).sqrt();
        let twist = (n1 / n2 - 1.0) * n2 * inner;
        let along = |half: f64, x: f64, p: f64| ((n2 - 1.0) * outer * p + twist * x * x) / (half * half * length);
        let across = side(0, 1.0) * side(1, 1.0) * twist * x * y / (a * b * length);
        let up = (n1 - 1.0) * r / (c * c * length);
        let bent = [[along(a, x, p), across, 0.0], [across, along(b, y, q), 0.0], [0.0, 0.0, up]];
        (scaled(gradient, 1.0 / length), bent)
    }

    /// |x/a|, |y/b|, |z/c|.
    fn parts(&self, at: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| (at[k] / self.shape.half[k]).abs())
    }
}

/// Numbers below this count as zero in powers.
const NOTHING: f64 = 1e-100;

/// x^n for x ≥ 0.
fn power(x: f64, n: f64) -> f64 {
    match n {
        0.0 => 1.0,
        _ if x < NOTHING => 0.0,
        1.0 => x,
        2.0 => x * x,
        _ => exp(n * ln(x)),
    }
}

/// The point of u^n + v^n = 1 where x u + y v is largest, and that sum; x, y ≥ 0. For x = y = 0 all is zero.
fn dual(x: f64, y: f64, n: f64) -> (f64, f64, f64) {
    let [p, q, length] = if n == 2.0 {
        [x, y, 1.0 / (x * x + y * y).sqrt()]
    } else {
        let [p, q] = [x, y].map(|x| power(x, 1.0 / (n - 1.0)));
        [p, q, power(x * p + y * q, -1.0 / n)]
    };
    // u^n = x p
    let sum = x * p + y * q;
    if sum < NOTHING { (0.0, 0.0, 0.0) } else { (p * length, q * length, sum * length) }
}

/// The largest √(x² + y²) on |x/a|^n + |y/b|^n = 1.
fn furthest(a: f64, b: f64, n: f64) -> f64 {
    let (most, least) = (a.max(b), a.min(b));
    if n - 2.0 < 1e-9 {
        return most;
    }
    let power = 2.0 * n / (n - 2.0);
    // (1 + s^p)^(1/p), where s^p may be nothing
    let s = pow(least / most, power);
    most * pow(1.0 + s, 1.0 / power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vector::plus;
    use crate::shape::Solid;
    use proptest::prelude::*;

    fn unit(v: [f64; 3]) -> [f64; 3] {
        let length = dot(v, v).sqrt();
        if length < 1e-3 { [0.6, 0.0, 0.8] } else { scaled(v, 1.0 / length) }
    }

    #[test]
    fn the_core_of_a_sphere_is_its_centre_and_that_of_an_ellipsoid_ends_at_its_least_radius() {
        let ball = Smooth::of(Superquadric { half: [0.3; 3], blockiness: [2.0; 2] });
        assert!((ball.rounding - 0.3).abs() < 1e-16 && ball.core([0.6, 0.0, 0.8]).iter().all(|x| x.abs() < 1e-16));
        let egg = Smooth::of(Superquadric { half: [0.3, 0.2, 0.1], blockiness: [2.0; 2] });
        assert!((egg.rounding - 0.01 / 0.3).abs() < 1e-16 && egg.reach == 0.3);
    }

    proptest! {
        /// The core is convex: its points go along with their normals. And no point is beyond the reach, which some point has.
        #[test]
        fn cores_are_convex(
            half in [0.1..1.0_f64, 0.1..1.0_f64, 0.1..1.0_f64],
            blockiness in [2.0..20.0_f64, 2.0..20.0_f64],
            from in [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64],
            by in [-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64],
            size in 0.01..1.0_f64,
        ) {
            let body = Smooth::of(Superquadric { half, blockiness });
            let n = unit(from);
            let m = unit(std::array::from_fn(|a| n[a] + size * by[a]));
            prop_assert!(dot(less(body.core(n), body.core(m)), less(n, m)) > -1e-14);
            let at = body.shape.spot(0, n);
            prop_assert!(less(at, body.furthest(n)).iter().all(|x| x.abs() < 1e-12));
            // its normal is n again, which changes along tangents as a small step says
            let (normal, bent) = body.bent(at);
            prop_assert!((dot(normal, n) - 1.0).abs() < 1e-10, "{normal:?} for {n:?}");
            let way = scaled(less(m, scaled(n, dot(m, n))), 1e-6);
            let (beside, change) = (body.bent(body.on_ray(plus(at, way))).0, bent.map(|row| dot(row, way)));
            let change = less(change, scaled(n, dot(change, n)));
            let error = less(less(beside, normal), change);
            prop_assert!(dot(error, error).sqrt() < 1e-3 * (dot(change, change).sqrt() + 1e-9), "{error:?} of {change:?}, {body:?} {n:?}");
            prop_assert!(dot(at, at).sqrt() <= body.reach * (1.0 + 1e-12), "{body:?}");
        }
    }

    #[test]
    fn the_reach_is_that_of_the_furthest_point() {
        for (half, blockiness) in [([0.3, 0.2, 0.1], [2.0, 6.0]), ([0.3, 0.2, 0.25], [8.0, 2.0]), ([0.1, 0.2, 0.3], [5.0, 3.0])] {
            let body = Smooth::of(Superquadric { half, blockiness });
            let most = body.shape.surface().corners.iter().map(|p| dot(*p, *p).sqrt()).fold(0.0, f64::max);
            assert!(most <= body.reach * (1.0 + 1e-12) && most > 0.98 * body.reach, "{most} {body:?}");
        }
    }
}
