//! Numbers for the laws of contact: one `f64`, or several side by side in the registers of the processor.
//!
//! A law is written once, over [`Real`]. Lanes do what a scalar does, in the same order and rounded the same way (no fused
//! multiply-add), so that which instruction set a machine has changes no bit.

mod four;
mod lanes;

#[cfg(target_arch = "x86_64")]
pub use four::Quad;
pub use four::{Four, Plain};
pub use lanes::{Lanes, MOST_LANES};

use pulp::Arch;

use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::OnceLock;

/// A number, or several that go through the same operations.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// A truth for each number.
    type Mask: Copy;
    /// The constant `x`, as many times as `self` has numbers.
    fn constant(self, x: f64) -> Self;
    fn sqrt(self) -> Self;
    fn above(self, other: Self) -> Self::Mask;
    /// `self` where the mask holds, `other` where it does not.
    fn where_else(self, mask: Self::Mask, other: Self) -> Self;
    /// Whether it is worth asking if a mask holds at all: a branch costs many lanes more than the work that it saves.
    fn may_skip(mask: Self::Mask) -> bool;

    /// The larger of the two; `x` where `self` is not a number.
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

/// Names of instruction sets: the best that the machine has, or at best the one named.
pub const ARCHS: [&str; 4] = ["best", "avx512", "avx2", "scalar"];

static ARCH: OnceLock<Arch> = OnceLock::new();

/// The instruction set of the inner loops. It changes no bit of the results.
pub fn arch() -> Arch {
    *ARCH.get_or_init(Arch::new)
}

/// Settles what [`arch`] answers, unless it has been asked before.
pub fn choose(name: &str) {
    ARCH.get_or_init(|| at_best(name));
}

/// The best instruction set that the machine has up to the one named.
pub fn at_best(name: &str) -> Arch {
    match (name, Arch::new()) {
        ("scalar", _) => Arch::Scalar,
        #[cfg(target_arch = "x86_64")]
        ("avx2", Arch::V4(v4)) => Arch::V3(*v4),
        (_, best) => best,
    }
}

/// Registers of four numbers, if the instruction set has them.
#[cfg(target_arch = "x86_64")]
pub fn quads(arch: Arch) -> Option<pulp::x86::V3> {
    match arch {
        Arch::V3(v3) => Some(v3),
        Arch::V4(v4) => Some(*v4),
        _ => None,
    }
}

/// Registers of four numbers: not on this machine.
#[cfg(not(target_arch = "x86_64"))]
pub fn quads(_: Arch) -> Option<()> {
    None
}

/// Name of an instruction set.
pub fn name(arch: Arch) -> &'static str {
    match arch {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(_) => "avx512",
        #[cfg(target_arch = "x86_64")]
        Arch::V3(_) => "avx2",
        _ => "scalar",
    }
}
