//! Shape functions: weights between a point and its nodes, N(x) = w(ζx) w(ζy) w(ζz) (Li et al. 2023, eq. 11). Each point reaches three nodes along
//! each axis.
//!
//! Along an axis, with the coordinate ξ in units of a cell, a point belongs to the cell ⌊ξ − reach⌋ and reaches the node of that number and the next two.

use crate::math::real::Four;
use serde::{Deserialize, Serialize};

/// Kind of shape functions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShapeFunctions {
    /// Quadratic B-spline (Li et al. 2023, eq. 10).
    BSpline,
    /// Generalised interpolation (GIMP): linear hat functions averaged over a box around the point (Jiang et al. 2020, eq. A2).
    Gimp {
        /// Half of the width of the box over the edge of a cell, above 0 and at most ½.
        half_width: f64,
    },
}

/// One-dimensional weights of a point: `value[node][axis]` for three nodes along each axis; fourth numbers are not used.
#[derive(Clone, Copy, Debug)]
pub struct Weights {
    /// Weights w.
    pub value: [[f64; 4]; 3],
    /// Derivatives of the weights by the coordinate, 1/m.
    pub slope: [[f64; 4]; 3],
}

/// A kind of shape functions, for the inner loops.
pub trait ShapeFunction: Copy + Send + Sync {
    /// Smallest distance, in cells, of the points of a cell from the node of the same number.
    fn reach(self) -> f64;
    /// Weights of a point. `t`: distances from its first node along the axes, in cells, with reach ≤ t < 1 + reach.
    fn weights<F: Four>(self, token: F::Token, t: F, inverse_cell: f64) -> Weights;
    /// Weights along one axis for a traction on the face of a point, `half` cells from its centre; `t`: distance of the face from the point's first node, in
    /// cells. With these weights a uniform stress is in equilibrium wherever the points are between the nodes: Σ V ∂N over a regular row of points equals
    /// the difference of the weights at its two ends.
    fn at_edge(self, t: f64, half: f64) -> [f64; 3];
}

/// Number of hat functions whose mean is as good as the spline.
const MANY: f64 = 8.0;

/// Quadratic B-spline.
#[derive(Clone, Copy, Debug)]
pub struct BSpline;

impl ShapeFunction for BSpline {
    #[inline(always)]
    fn reach(self) -> f64 {
        0.5
    }

    /// w(ζ) = ¾ − ζ² for |ζ| < ½ and ½ (3/2 − |ζ|)² for ½ ≤ |ζ| < 3/2.
    #[inline(always)]
    fn weights<F: Four>(self, token: F::Token, t: F, inverse_cell: f64) -> Weights {
        let (half, inverse) = (F::all(token, 0.5), F::all(token, inverse_cell));
        let (left, middle, right) = (F::all(token, 1.5) - t, t - F::all(token, 1.0), t - half);
        let value = [half * left * left, F::all(token, 0.75) - middle * middle, half * right * right];
        let slope = [(F::all(token, 0.0) - left) * inverse, F::all(token, -2.0) * middle * inverse, right * inverse];
        Weights {
            value: [value[0].xyzw(), value[1].xyzw(), value[2].xyzw()],
            slope: [slope[0].xyzw(), slope[1].xyzw(), slope[2].xyzw()],
        }
    }

    /// The derivative of the spline at x is the difference of linear hat functions at x + ½ and x − ½. In a row with n points per cell these differences
    /// cancel except for n hats at each end, spread evenly around the face; the weights are their mean. With many points that is the spline itself.
    #[inline(always)]
    fn at_edge(self, t: f64, half: f64) -> [f64; 3] {
        let n = (0.5 / half + 0.5).floor().clamp(1.0, MANY);
        let mut sum = [0.0; 3];
        let mut k = 0.5;
        while k < n {
            for (sum, hat) in sum.iter_mut().zip(hats(t + k / n - 0.5)) {
                *sum += hat / n;
            }
            k += 1.0;
        }
        sum
    }
}

/// Linear hat functions of the three nodes at `t` cells from the first; `t` is limited to the range of the nodes.
#[inline(always)]
pub fn hats(t: f64) -> [f64; 3] {
    let t = t.clamp(0.0, 2.0);
    [0.0, 1.0, 2.0].map(|node: f64| (1.0 - (t - node).abs()).max(0.0))
}

/// Generalised interpolation, with the half width l of a point's box over the edge of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Gimp(pub f64);

impl Gimp {
    /// Weight and derivative, 1/cell, of a node at `d` cells before the point.
    #[inline(always)]
    fn at(l: f64, d: f64) -> (f64, f64) {
        let r = if d < 0.0 { -d } else { d };
        let sign = if d < 0.0 { -1.0 } else { 1.0 };
        if r < l {
            (1.0 - (d * d + l * l) / (2.0 * l), -d / l)
        } else if r <= 1.0 - l {
            (1.0 - r, -sign)
        } else if r < 1.0 + l {
            let left = 1.0 + l - r;
            (left * left / (4.0 * l), -sign * left / (2.0 * l))
        } else {
            (0.0, 0.0)
        }
    }
}

impl ShapeFunction for Gimp {
    #[inline(always)]
    fn reach(self) -> f64 {
        self.0
    }

    #[inline(always)]
    fn weights<F: Four>(self, _: F::Token, t: F, inverse_cell: f64) -> Weights {
        let t = t.xyzw();
        let mut weights = Weights { value: [[0.0; 4]; 3], slope: [[0.0; 4]; 3] };
        for node in 0..3 {
            for (axis, t) in t.iter().enumerate().take(3) {
                let (value, slope) = Gimp::at(self.0, t - node as f64);
                weights.value[node][axis] = value;
                weights.slope[node][axis] = slope * inverse_cell;
            }
        }
        weights
    }

    /// Linear hat functions: the shape functions are their means over a point's box.
    #[inline(always)]
    fn at_edge(self, t: f64, _: f64) -> [f64; 3] {
        hats(t)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::real::Plain;
    use proptest::prelude::*;

    fn at(shape: impl ShapeFunction, s: f64) -> (f64, Weights) {
        let t = shape.reach() + s;
        (t, shape.weights((), Plain::of((), [t; 4]), 1.0))
    }

    /// Partition of unity, no sum of slopes, reproduction of a linear field with its slope; largest error.
    fn errors(shape: impl ShapeFunction, s: f64) -> f64 {
        let (t, w) = at(shape, s);
        let sum = |f: &dyn Fn(usize) -> f64| (0..3).map(f).sum::<f64>();
        let unity = sum(&|n| w.value[n][0]) - 1.0;
        let slopes = sum(&|n| w.slope[n][0]);
        let linear = sum(&|n| n as f64 * w.value[n][0]) - t;
        let gradient = sum(&|n| n as f64 * w.slope[n][0]) - 1.0;
        [unity, slopes, linear, gradient].iter().fold(0.0, |a: f64, e| a.max(e.abs()))
    }

    proptest! {
        #[test]
        fn splines_reproduce_linear_fields(s in 0.0..1.0_f64) {
            prop_assert!(errors(BSpline, s) < 1e-15 * 4.0);
        }

        #[test]
        fn gimp_reproduces_linear_fields(s in 0.0..1.0_f64, l in 0.01..0.5_f64) {
            prop_assert!(errors(Gimp(l), s) < 1e-13);
        }

        /// Jiang et al. 2020, section 2.1: a box as wide as the cell makes the two the same.
        #[test]
        fn the_widest_gimp_is_the_spline(s in 0.0..1.0_f64) {
            let ((_, a), (_, b)) = (at(BSpline, s), at(Gimp(0.5), s));
            for n in 0..3 {
                prop_assert!((a.value[n][0] - b.value[n][0]).abs() < 1e-15);
                prop_assert!((a.slope[n][0] - b.slope[n][0]).abs() < 1e-15);
            }
        }

        #[test]
        fn slopes_are_those_of_the_values(s in 0.01..0.98_f64, l in 0.1..0.5_f64) {
            let e = 1e-6;
            for (a, b, mid) in [
                (at(BSpline, s).1, at(BSpline, s + 2.0 * e).1, at(BSpline, s + e).1),
                (at(Gimp(l), s).1, at(Gimp(l), s + 2.0 * e).1, at(Gimp(l), s + e).1),
            ] {
                for n in 0..3 {
                    prop_assert!(((b.value[n][0] - a.value[n][0]) / (2.0 * e) - mid.slope[n][0]).abs() < 1e-5);
                }
            }
        }
    }
}
