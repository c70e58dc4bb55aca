//! Four numbers x, y, z, w in one SIMD register: a vector with a fourth number, as grains and contacts store them.

use std::ops::{Add, Div, Mul, Sub};

/// Four numbers x, y, z, w on which each operation acts in the same way.
pub trait Four: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// Proof that the machine has the instructions, needed to make a value.
    type Token: Copy;
    /// The numbers x, y, z, w.
    fn of(token: Self::Token, xyzw: [f64; 4]) -> Self;
    /// The numbers as an array.
    fn xyzw(self) -> [f64; 4];
    /// `x` four times.
    fn all(token: Self::Token, x: f64) -> Self;
    /// w four times.
    fn w(self) -> Self;
    /// The numbers in the order y, z, x, w.
    fn yzxw(self) -> Self;
    /// x, y, z of `self` and w of `other`.
    fn with_w_of(self, other: Self) -> Self;
    /// The larger of each two numbers; that of `other` if one is not a number.
    fn max(self, other: Self) -> Self;
    /// The smaller of each two numbers; that of `other` if one is not a number.
    fn min(self, other: Self) -> Self;
    /// Each number's magnitude with the sign opposite to that in `other`; 0 where that is 0. For local damping.
    fn against(self, other: Self) -> Self;
}

/// Four numbers without SIMD instructions.
#[derive(Clone, Copy)]
pub struct Plain([f64; 4]);

macro_rules! plain {
    ($trait:ident, $method:ident, $op:tt) => {
        impl $trait for Plain {
            type Output = Plain;
            #[inline(always)]
            fn $method(self, other: Plain) -> Plain {
                let (a, b) = (self.0, other.0);
                Plain([a[0] $op b[0], a[1] $op b[1], a[2] $op b[2], a[3] $op b[3]])
            }
        }
    };
}
plain!(Add, add, +);
plain!(Sub, sub, -);
plain!(Mul, mul, *);
plain!(Div, div, /);

impl Plain {
    #[inline(always)]
    fn zip(self, other: Plain, f: impl Fn(f64, f64) -> f64) -> Plain {
        Plain(std::array::from_fn(|a| f(self.0[a], other.0[a])))
    }
}

impl Four for Plain {
    type Token = ();
    #[inline(always)]
    fn of(_: (), xyzw: [f64; 4]) -> Plain {
        Plain(xyzw)
    }
    #[inline(always)]
    fn xyzw(self) -> [f64; 4] {
        self.0
    }
    #[inline(always)]
    fn all(_: (), x: f64) -> Plain {
        Plain([x; 4])
    }
    #[inline(always)]
    fn w(self) -> Plain {
        Plain([self.0[3]; 4])
    }
    #[inline(always)]
    fn yzxw(self) -> Plain {
        let [x, y, z, w] = self.0;
        Plain([y, z, x, w])
    }
    #[inline(always)]
    fn with_w_of(self, other: Plain) -> Plain {
        let ([x, y, z, _], [.., w]) = (self.0, other.0);
        Plain([x, y, z, w])
    }
    #[inline(always)]
    fn max(self, other: Plain) -> Plain {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn min(self, other: Plain) -> Plain {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn against(self, other: Plain) -> Plain {
        self.zip(other, |a, b| if b == 0.0 { 0.0 } else { a.copysign(-b) })
    }
}

#[cfg(target_arch = "x86_64")]
pub use avx::Quad;

#[cfg(target_arch = "x86_64")]
mod avx {
    use super::Four;
    use pulp::bytemuck;
    use pulp::x86::V3;
    use std::arch::x86_64::__m256d;
    use std::ops::{Add, Div, Mul, Sub};

    /// Four numbers in one AVX register.
    #[derive(Clone, Copy)]
    pub struct Quad(V3, __m256d);

    macro_rules! quad {
        ($trait:ident, $method:ident, $op:ident) => {
            impl $trait for Quad {
                type Output = Quad;
                #[inline(always)]
                fn $method(self, other: Quad) -> Quad {
                    Quad(self.0, self.0.avx.$op(self.1, other.1))
                }
            }
        };
    }
    quad!(Add, add, _mm256_add_pd);
    quad!(Sub, sub, _mm256_sub_pd);
    quad!(Mul, mul, _mm256_mul_pd);
    quad!(Div, div, _mm256_div_pd);

    impl Four for Quad {
        type Token = V3;
        #[inline(always)]
        fn of(v3: V3, xyzw: [f64; 4]) -> Quad {
            Quad(v3, bytemuck::cast(xyzw))
        }
        #[inline(always)]
        fn xyzw(self) -> [f64; 4] {
            bytemuck::cast(self.1)
        }
        #[inline(always)]
        fn all(v3: V3, x: f64) -> Quad {
            Quad(v3, v3.avx._mm256_set1_pd(x))
        }
        #[inline(always)]
        fn w(self) -> Quad {
            Quad(self.0, self.0.avx2._mm256_permute4x64_pd::<0b11_11_11_11>(self.1))
        }
        #[inline(always)]
        fn yzxw(self) -> Quad {
            Quad(self.0, self.0.avx2._mm256_permute4x64_pd::<0b11_00_10_01>(self.1))
        }
        #[inline(always)]
        fn with_w_of(self, other: Quad) -> Quad {
            Quad(self.0, self.0.avx._mm256_blend_pd::<0b1000>(self.1, other.1))
        }
        #[inline(always)]
        fn max(self, other: Quad) -> Quad {
            Quad(self.0, self.0.avx._mm256_max_pd(self.1, other.1))
        }
        #[inline(always)]
        fn min(self, other: Quad) -> Quad {
            Quad(self.0, self.0.avx._mm256_min_pd(self.1, other.1))
        }
        #[inline(always)]
        fn against(self, other: Quad) -> Quad {
            let avx = self.0.avx;
            let signs = avx._mm256_set1_pd(-0.0);
            let size = avx._mm256_andnot_pd(signs, self.1);
            let opposed = avx._mm256_or_pd(size, avx._mm256_andnot_pd(other.1, signs));
            let still = avx._mm256_cmp_pd::<0>(other.1, avx._mm256_setzero_pd());
            Quad(self.0, avx._mm256_andnot_pd(still, opposed))
        }
    }

    #[cfg(test)]
    mod tests {
        use super::super::{Four, Plain};
        use super::Quad;
        use proptest::prelude::*;
        use pulp::x86::V3;

        proptest! {
            #[test]
            fn a_register_does_what_four_numbers_do(a: [f64; 4], b: [f64; 4]) {
                let Some(v3) = V3::try_new() else { return Ok(()) };
                let bits = |v: [f64; 4]| v.map(f64::to_bits);
                let number = |v: [f64; 4]| v.map(|x| if x.is_nan() { 0.0 } else { x });
                for (a, b) in [(a, b), (number(a), [0.0, -0.0, 1.0, -1.0]), ([0.0, -0.0, 2.0, -2.0], number(b))] {
                    let (a, b) = (number(a), number(b));
                    let (p, q) = (Plain::of((), a), Plain::of((), b));
                    let (x, y) = (Quad::of(v3, a), Quad::of(v3, b));
                    let pairs = [
                        (p + q, x + y),
                        (p.against(q), x.against(y)),
                        (p.max(q), x.max(y)),
                        (p.min(q), x.min(y)),
                        (p.yzxw(), x.yzxw()),
                        (p.w(), x.w()),
                        (p.with_w_of(q), x.with_w_of(y)),
                    ];
                    for (plain, quad) in pairs {
                        let (plain, quad) = (plain.xyzw(), quad.xyzw());
                        for k in 0..4 {
                            prop_assert!(bits(plain)[k] == bits(quad)[k] || plain[k].is_nan() && quad[k].is_nan());
                        }
                    }
                }
            }
        }
    }
}
