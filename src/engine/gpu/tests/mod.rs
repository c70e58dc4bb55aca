//! Parity of the graphics path with f64: rungs 2 (`law.rs`) and 3 (`step.rs`, `faces.rs`).

mod adapter;
mod faces;
mod law;
mod step;

pub use adapter::adapter;

use crate::gpu;
use crate::mpm::law::{Elastic, Law};

/// Every kind of surface, flow and evolution; the last one jumps at its peak.
fn laws() -> Vec<Law> {
    let mut laws = crate::mpm::law::tests::laws();
    laws.rotate_left(1);
    std::iter::once(Law::Elastic(Elastic::of_young(4.6e6, 0.3))).chain(laws.into_iter().map(Law::DruckerPrager)).collect()
}
