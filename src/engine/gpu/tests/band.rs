//! Bands of comparisons with the processor. The tests of the crate and those of the command line share this file.

use super::gpu;

/// The band of a comparison: `software` where the adapter rounds as the processor does, `hardware` where divisions and roots may be some units in the last place off, as Vulkan allows.
pub fn band(software: f64, hardware: f64) -> f64 {
    if gpu::available().is_some_and(|adapter| !adapter.software) { hardware } else { software }
}
