//! The speed of the case of `mpm` on the graphics device.

use super::mpm::mpm_case;
use engine::gpu;
use engine::mpm::Transfer;
use laboratory::error::Result;
use std::time::Instant;
use table::median;

/// Measured speed on the graphics device.
#[derive(Clone, Debug)]
pub struct GpuSpeed {
    /// Name of the graphics adapter.
    pub adapter: String,
    /// Number of points.
    pub points: usize,
    /// Point-steps per second of each block.
    pub blocks: Vec<f64>,
    /// Memory on the device for each point with its share of the grid, bytes.
    pub bytes_per_point: f64,
    /// What one step takes.
    pub step: gpu::StepWork,
}

impl GpuSpeed {
    /// Median point-steps per second.
    pub fn median(&self) -> f64 {
        median(&self.blocks)
    }
}

/// Steps `points` points on the graphics device: `repeats` blocks of `steps` steps after `warm_up`, each one batch.
///
/// # Errors
/// No adapter, not enough memory, a lost point.
pub fn mpm_gpu_speed(points: usize, [warm_up, steps]: [u64; 2], repeats: usize) -> Result<GpuSpeed> {
    let (c, dt) = mpm_case(points, Transfer::Blend { pic: 0.0 })?;
    let count = c.points().len();
    let mut device = gpu::DeviceContinuum::new(&c)?;
    device.steps(warm_up, dt)?;
    let mut blocks = Vec::new();
    for _ in 0..repeats {
        let since = Instant::now();
        device.steps(steps, dt)?;
        blocks.push(count as f64 * steps as f64 / since.elapsed().as_secs_f64());
    }
    let adapter = gpu::available().map_or_else(String::new, |a| a.name);
    let (bytes_per_point, step) = (device.bytes() as f64 / count as f64, device.step_work());
    Ok(GpuSpeed { adapter, points: count, blocks, bytes_per_point, step })
}
