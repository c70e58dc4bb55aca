//! Arithmetic for contact laws: on one `f64`, or on several side by side in SIMD registers.
//!
//! A law is written once, for any type that is [`Real`]. Lanes compute what a single number does, in the same order and with the same rounding (no fused
//! multiply-add), so that the instruction set of a machine changes no bit of a result.

mod four;
mod lanes;

#[cfg(target_arch = "x86_64")]
pub use four::Quad;
pub use four::{Four, Plain};
pub use lanes::{Lanes, MOST_LANES};

use pulp::Arch;

use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::OnceLock;

/// A number, or several numbers on which each operation acts in the same way.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// A truth value for each number.
    type Mask: Copy;
    /// The constant `x`, as many times as `self` has numbers.
    fn constant(self, x: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Whether `self` is larger than `other`.
    fn above(self, other: Self) -> Self::Mask;
    /// `self` where the mask holds, `other` where it does not.
    fn where_else(self, mask: Self::Mask, other: Self) -> Self;
    /// Whether work that is needed only where `mask` holds can be skipped. For several lanes the answer is always no: a branch costs more than it saves.
    fn may_skip(mask: Self::Mask) -> bool;

    /// The larger of `self` and `x`; `x` if `self` is not a number.
    #[inline(always)]
    fn at_least(self, x: f64) -> Self {
        let x = self.constant(x);
        self.where_else(self.above(x), x)
    }
}

impl Real for f64 {
    type Mask = bool;
    #[inline(always)]
    fn constant(self, x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn sqrt(self) -> f64 {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn above(self, other: f64) -> bool {
        self > other
    }
    #[inline(always)]
    fn where_else(self, mask: bool, other: f64) -> f64 {
        if mask { self } else { other }
    }
    #[inline(always)]
    fn may_skip(mask: bool) -> bool {
        !mask
    }
}

/// Names of instruction sets for [`choose`] and [`at_best`]; `best` stands for the best that the machine has.
pub const ARCHS: [&str; 4] = ["best", "avx512", "avx2", "scalar"];

static ARCH: OnceLock<Arch> = OnceLock::new();

/// The instruction set of the inner loops: the best of the machine, unless [`choose`] was called before. It changes no bit of the results.
pub fn arch() -> Arch {
    *ARCH.get_or_init(Arch::new)
}

/// Limits the instruction set that [`arch`] returns to the one named; without effect once [`arch`] has been called.
pub fn choose(name: &str) {
    ARCH.get_or_init(|| at_best(name));
}

/// The best instruction set of the machine up to the one named.
pub fn at_best(name: &str) -> Arch {
    match (name, Arch::new()) {
        ("scalar", _) => Arch::Scalar,
        #[cfg(target_arch = "x86_64")]
        ("avx2", Arch::V4(v4)) => Arch::V3(*v4),
        (_, best) => best,
    }
}

/// Proof that the instruction set has registers of four numbers, if it does.
#[cfg(target_arch = "x86_64")]
pub fn quads(arch: Arch) -> Option<pulp::x86::V3> {
    match arch {
        Arch::V3(v3) => Some(v3),
        Arch::V4(v4) => Some(*v4),
        _ => None,
    }
}

/// On this kind of machine no registers of four numbers are used.
#[cfg(not(target_arch = "x86_64"))]
pub fn quads(_: Arch) -> Option<()> {
    None
}

/// Name of an instruction set, one of [`ARCHS`].
pub fn name(arch: Arch) -> &'static str {
    match arch {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(_) => "avx512",
        #[cfg(target_arch = "x86_64")]
        Arch::V3(_) => "avx2",
        _ => "scalar",
    }
}
