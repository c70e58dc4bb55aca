//! Parity of the graphics path with f64: rungs 2 (`law.rs`) and 3 (`step.rs`).

mod law;
mod step;

use super::device;
use crate::mpm::law::{Elastic, Law};

/// Whether there is an adapter; without one the test is skipped, loudly, or fails where one is required.
fn adapter(test: &str) -> bool {
    let Some(adapter) = device::available() else {
        assert!(
            std::env::var_os("COMMINUTE_REQUIRE_GPU").is_none(),
            "COMMINUTE_REQUIRE_GPU is set and there is no graphics adapter"
        );
        eprintln!("SKIPPED {test}: no graphics adapter; set COMMINUTE_REQUIRE_GPU=1 to make this a failure");
        return false;
    };
    eprintln!("{test}: on {}", adapter.name);
    true
}

/// Every kind of surface, flow and evolution; the last one jumps at its peak.
fn laws() -> Vec<Law> {
    let mut laws = crate::mpm::law::tests::laws();
    laws.rotate_left(1);
    std::iter::once(Law::Elastic(Elastic::of_young(4.6e6, 0.3))).chain(laws.into_iter().map(Law::DruckerPrager)).collect()
}
