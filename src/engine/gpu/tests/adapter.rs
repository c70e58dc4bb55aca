//! Whether tests of the graphics path can run. The tests of the crate and those of the command line share this file.

use super::gpu;

/// Whether there is an adapter; without one the test is skipped, loudly, or fails where one is required.
pub fn adapter(test: &str) -> bool {
    let Some(adapter) = gpu::available() else {
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
