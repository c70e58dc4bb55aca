//! Several numbers side by side: one in each lane of a SIMD register.

use super::Real;
use pulp::Simd;
use pulp::bytemuck;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Largest number of lanes of any instruction set.
pub const MOST_LANES: usize = 8;

/// As many numbers as a register of the instruction set `S` holds.
#[derive(Clone, Copy)]
pub struct Lanes<S: Simd> {
    simd: S,
    values: S::f64s,
}

macro_rules! operator {
    ($trait:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Lanes<S>;
            #[inline(always)]
            fn $method(self, other: Lanes<S>) -> Lanes<S> {
                Lanes { simd: self.simd, values: self.simd.$simd(self.values, other.values) }
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Lanes<S>;
    #[inline(always)]
    fn mul(self, x: f64) -> Lanes<S> {
        self * self.constant(x)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Lanes<S>;
    #[inline(always)]
    fn neg(self) -> Lanes<S> {
        Lanes { simd: self.simd, values: self.simd.neg_f64s(self.values) }
    }
}

impl<S: Simd> Real for Lanes<S> {
    type Mask = S::m64s;
    #[inline(always)]
    fn constant(self, x: f64) -> Lanes<S> {
        Lanes::constants(self.simd, x)
    }
    #[inline(always)]
    fn sqrt(self) -> Lanes<S> {
        Lanes { simd: self.simd, values: self.simd.sqrt_f64s(self.values) }
    }
    #[inline(always)]
    fn above(self, other: Lanes<S>) -> S::m64s {
        self.simd.greater_than_f64s(self.values, other.values)
    }
    #[inline(always)]
    fn where_else(self, mask: S::m64s, other: Lanes<S>) -> Lanes<S> {
        Lanes { simd: self.simd, values: self.simd.select_f64s(mask, self.values, other.values) }
    }
    #[inline(always)]
    fn may_skip(_: S::m64s) -> bool {
        false
    }
}

impl<S: Simd> Lanes<S> {
    /// Number of lanes.
    pub const COUNT: usize = S::F64_LANES;

    /// `x` in every lane.
    #[inline(always)]
    pub fn constants(simd: S, x: f64) -> Lanes<S> {
        Lanes { simd, values: simd.splat_f64s(x) }
    }

    /// The number in the first lane.
    #[inline(always)]
    pub fn first(self) -> f64 {
        bytemuck::cast_slice::<S::f64s, f64>(std::slice::from_ref(&self.values))[0]
    }

    /// Whether the mask holds in every lane.
    #[inline(always)]
    pub fn all(simd: S, mask: S::m64s) -> bool {
        simd.first_true_m64s(simd.not_m64s(mask)) == Self::COUNT
    }

    /// Reads [`Self::COUNT`] rows of four numbers and returns the four columns. The order of lanes may differ from that of rows, but is always the same.
    //
    // Arrays are taken apart by hand here and in `rows`: both are inlined a thousand times, and `map` on arrays made up a third of what the compiler had to optimise.
    #[inline(always)]
    pub fn columns(simd: S, row: impl Fn(usize) -> [f64; 4]) -> [Lanes<S>; 4] {
        let mut rows = [simd.splat_f64s(0.0); 4];
        for (k, r) in bytemuck::cast_slice_mut::<S::f64s, [f64; 4]>(&mut rows).iter_mut().enumerate() {
            *r = row(k);
        }
        let [a, b, c, d] = simd.deinterleave_shfl_f64s(rows);
        let lanes = |values| Lanes { simd, values };
        [lanes(a), lanes(b), lanes(c), lanes(d)]
    }

    /// Calls `row` with the index and the four numbers of each row of four columns: the reverse of [`Self::columns`].
    #[inline(always)]
    pub fn rows(simd: S, [a, b, c, d]: [Lanes<S>; 4], mut row: impl FnMut(usize, [f64; 4])) {
        let rows = simd.interleave_shfl_f64s([a.values, b.values, c.values, d.values]);
        for (k, r) in bytemuck::cast_slice::<S::f64s, [f64; 4]>(&rows).iter().enumerate() {
            row(k, *r);
        }
    }
}
