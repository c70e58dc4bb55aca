//! Superquadrics f(x) = 0 with f(x) = (|x/a|^n₂ + |y/b|^n₂)^(n₁/n₂) + |z/c|^n₁ − 1 and n₁, n₂ ≥ 2 (Li et al. 2023, eq. 39).

use super::{Bulk, Mesh, Nearest, Solid};
use crate::math::portable::{exp, ln_gamma, pow};
use crate::math::vector::{dot, less, scaled};
use serde::{Deserialize, Serialize};

/// A superquadric.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Superquadric {
    /// Half lengths a, b, c along x, y, z, m.
    pub half: [f64; 3],
    /// Exponents n₁ (towards z) and n₂ (around z); 2 and 2 make an ellipsoid, larger ones a block.
    pub blockiness: [f64; 2],
}

/// Numbers below this count as zero in powers.
const NOTHING: f64 = 1e-100;
/// Largest number of rounds of a search for a root; it ends earlier when the root does not change any more.
const ROUNDS: usize = 200;

/// x^n for x ≥ 0; whole powers by repeated squaring.
fn power(x: f64, n: f64) -> f64 {
    if x < NOTHING {
        return if n == 0.0 { 1.0 } else { 0.0 };
    }
    if n.fract() != 0.0 || n < 0.0 {
        return pow(x, n);
    }
    let (mut whole, mut square, mut product) = (n as u32, x, 1.0);
    while whole > 0 {
        if whole & 1 == 1 {
            product *= square;
        }
        square *= square;
        whole >>= 1;
    }
    product
}

/// Root of `f` between `low`, where f is positive, and `high`, where it is not: method of false position that halves the weight of an end that stays twice in
/// a row (Illinois).
fn root(mut low: f64, mut high: f64, mut f: impl FnMut(f64) -> f64) -> f64 {
    let (mut at_low, mut at_high) = (f(low), f(high));
    if at_low <= 0.0 {
        return low;
    }
    let (mut last, mut side) = (f64::NAN, 0);
    for round in 1..ROUNDS {
        let mut middle = (low * at_high - high * at_low) / (at_high - at_low);
        if !(middle > low && middle < high) || round % 8 == 0 {
            middle = 0.5 * (low + high);
        }
        let value = f(middle);
        if value == 0.0 || (middle - last).abs() <= 2.0 * f64::EPSILON * middle {
            return middle;
        }
        last = middle;
        let now = if value > 0.0 { 1 } else { -1 };
        let weight = if now == side { 0.5 } else { 1.0 };
        if now > 0 {
            (low, at_low, at_high) = (middle, value, at_high * weight);
        } else {
            (high, at_high, at_low) = (middle, value, at_low * weight);
        }
        side = now;
    }
    0.5 * (low + high)
}

/// Root u ≥ 0 of u + κ u^(n−1) = q, by Newton's method from above, which converges as the left side is convex.
fn shrunk(q: f64, kappa: f64, n: f64) -> f64 {
    if n == 2.0 {
        return q / (1.0 + kappa);
    }
    let mut u = if 1.0 + kappa >= q { q.min(1.0) } else { q };
    for _ in 0..ROUNDS {
        let below = power(u, n - 2.0);
        let next = u - (u + kappa * below * u - q) / (1.0 + kappa * (n - 1.0) * below);
        if next >= u {
            break;
        }
        u = next;
    }
    u.max(0.0)
}

impl Superquadric {
    /// n₁/n₂.
    fn ratio(&self) -> f64 {
        self.blockiness[0] / self.blockiness[1]
    }

    /// u^n₂ + v^n₂ with u = |x/a| and v = |y/b|.
    fn around(&self, u: f64, v: f64) -> f64 {
        power(u, self.blockiness[1]) + power(v, self.blockiness[1])
    }

    /// Distance of a position from the origin over that of the surface on the same ray: below 1 inside, 1 on the surface.
    fn gauge(&self, at: [f64; 3]) -> f64 {
        let [u, v, w]: [f64; 3] = std::array::from_fn(|a| at[a].abs() / self.half[a]);
        // scaled by the largest, against underflow and overflow
        let most = u.max(v).max(w);
        if most < NOTHING {
            return 0.0;
        }
        let sum = power(self.around(u / most, v / most), self.ratio()) + power(w / most, self.blockiness[0]);
        most * pow(sum, 1.0 / self.blockiness[0])
    }

    /// ∇f/n₁ at a position on or near the surface, 1/m.
    fn gradient(&self, at: [f64; 3]) -> [f64; 3] {
        let [u, v, w]: [f64; 3] = std::array::from_fn(|a| at[a].abs() / self.half[a]);
        let [n1, n2] = self.blockiness;
        let sum = self.around(u, v);
        let outer = if sum < NOTHING { 0.0 } else { power(sum, self.ratio() - 1.0) };
        let of = |a: usize, x: f64| x.copysign(at[a]) / self.half[a];
        [of(0, outer * power(u, n2 - 1.0)), of(1, outer * power(v, n2 - 1.0)), of(2, power(w, n1 - 1.0))]
    }

    /// The position x with x + λ ∇f(x) = p for ν = n₁ λ, divided by the half lengths; p has no negative coordinate.
    fn image(&self, p: [f64; 3], nu: f64) -> [f64; 3] {
        let ([a, b, c], [n1, n2], ratio) = (self.half, self.blockiness, self.ratio());
        let [qx, qy, qz]: [f64; 3] = std::array::from_fn(|k| p[k] / self.half[k]);
        let w = shrunk(qz, nu / (c * c), n1);
        let flat = |mu: f64| [shrunk(qx, mu / (a * a), n2), shrunk(qy, mu / (b * b), n2)];
        let whole = self.around(qx, qy);
        if ratio == 1.0 || whole < NOTHING {
            let [u, v] = flat(nu);
            return [u, v, w];
        }
        // μ = ν s^(n₁/n₂ − 1), where s = u^n₂ + v^n₂ follows from μ
        let excess = |mu: f64| {
            let [u, v] = flat(mu);
            nu * power(self.around(u, v).max(NOTHING), ratio - 1.0) - mu
        };
        let mut high = nu * power(whole, ratio - 1.0);
        while excess(high) > 0.0 {
            high *= 2.0;
        }
        let [u, v] = flat(root(0.0, high, excess));
        [u, v, w]
    }
}

impl Solid for Superquadric {
    /// Outside, the nearest point x solves x + λ ∇f(x) = p with f(x) = 0. For a given λ each coordinate has an equation of its own, and f(x) decreases with λ, so
    /// only roots of one unknown between bounds are needed. Inside, the distance is that to the tangent plane on the same ray.
    fn nearest(&self, at: [f64; 3]) -> Nearest {
        let gauge = self.gauge(at);
        if gauge <= 1.0 {
            let slope = self.gradient(scaled(at, 1.0 / gauge.max(NOTHING)));
            let steep = dot(slope, slope).sqrt();
            if gauge < 1e-6 || steep < NOTHING {
                let a = (0..3).fold(0, |least, a| if self.half[a] < self.half[least] { a } else { least });
                let mut normal = [0.0; 3];
                normal[a] = 1.0;
                return Nearest { distance: -self.half[a], normal };
            }
            let normal = scaled(slope, 1.0 / steep);
            // the tangent plane at the point of the same ray
            return Nearest { distance: (1.0 - 1.0 / gauge) * dot(normal, at), normal };
        }
        let p = at.map(f64::abs);
        let least = self.half.into_iter().fold(f64::INFINITY, f64::min);
        // taking the root of about n₁ of f + 1 makes the function nearly linear, for a fast search; `flat` counts the square roots
        let flat = self.blockiness[0].to_bits() >> 52 & 0x7ff;
        let left = |nu: f64| {
            let [u, v, w] = self.image(p, nu);
            let sum = power(self.around(u, v), self.ratio()) + power(w, self.blockiness[0]);
            (0x3ff..flat).fold(sum, |sum, _| sum.sqrt()) - 1.0
        };
        let mut high = (1.0 - 1.0 / gauge) * dot(p, p).sqrt() * least;
        while left(high) > 0.0 {
            high *= 4.0;
        }
        let image = self.image(p, root(0.0, high, left));
        let foot = std::array::from_fn(|a| (image[a] * self.half[a]).copysign(at[a]));
        let out = less(at, foot);
        let distance = dot(out, out).sqrt();
        if distance < 1e-9 * least {
            let slope = self.gradient(foot);
            return Nearest { distance, normal: scaled(slope, 1.0 / dot(slope, slope).sqrt()) };
        }
        Nearest { distance, normal: scaled(out, 1.0 / distance) }
    }

    /// From the box of the half lengths, which holds the shape.
    fn clearance(&self, at: [f64; 3]) -> f64 {
        (0..3).map(|a| at[a].abs() - self.half[a]).fold(f64::NEG_INFINITY, f64::max)
    }

    fn reach(&self) -> f64 {
        dot(self.half, self.half).sqrt()
    }

    fn spots(&self) -> usize {
        1
    }

    /// The point whose outward normal is `towards`, from the dual norms of eq. 39.
    fn spot(&self, _: usize, towards: [f64; 3]) -> [f64; 3] {
        let [n1, n2] = self.blockiness;
        let [x, y, z]: [f64; 3] = std::array::from_fn(|a| (self.half[a] * towards[a]).abs());
        let root = |x: f64, n: f64| power(x, 1.0 / n);
        // scaled by the largest, so that powers stay in range
        let of = |x: f64, y: f64, n: f64| {
            let most = x.max(y).max(NOTHING);
            let [p, q] = [x, y].map(|x| root(x / most, n - 1.0));
            let length = root(power(p, n) + power(q, n), n).max(NOTHING);
            let (u, v) = (p / length, q / length);
            (u, v, x * u + y * v)
        };
        let (u, v, flat) = of(x, y, n2);
        let (s, w, _) = of(flat, z, n1);
        [(0, s * u), (1, s * v), (2, w)].map(|(a, x)| (x * self.half[a]).copysign(towards[a]))
    }

    /// In closed form with the beta function (Jaklič, Leonardis & Solina 2000, Segmentation and recovery of superquadrics, chapter 2), ε₁ = 2/n₁ and
    /// ε₂ = 2/n₂.
    fn bulk(&self) -> Bulk {
        let ([a, b, c], [e1, e2]) = (self.half, self.blockiness.map(|n| 2.0 / n));
        let beta = |x: f64, y: f64| exp(ln_gamma(x) + ln_gamma(y) - ln_gamma(x + y));
        let abc = a * b * c * e1 * e2;
        let volume = 2.0 * abc * beta(0.5 * e1 + 1.0, e1) * beta(0.5 * e2, 0.5 * e2);
        // ∫ x²/a² dV and ∫ y²/b² dV are equal
        let side = 0.5 * abc * beta(1.5 * e2, 0.5 * e2) * beta(0.5 * e1, 2.0 * e1 + 1.0);
        let along = 2.0 * abc * beta(0.5 * e2, 0.5 * e2 + 1.0) * beta(1.5 * e1, e1 + 1.0);
        let moments = [side * b * b + along * c * c, side * a * a + along * c * c, side * (a * a + b * b)];
        Bulk { volume, moments }
    }

    fn surface(&self) -> Mesh {
        Mesh::of_cube(24, |direction| {
            let p = std::array::from_fn(|a| direction[a] * self.half[a]);
            scaled(p, 1.0 / self.gauge(p))
        })
    }
}
