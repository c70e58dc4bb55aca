//! How long each pass takes on the device, by its own clock: two timestamps for each dispatch. The device waits for the processor after each step, so a step takes longer
//! than without the clock; what lies between the two timestamps does not.

use super::device::{Device, refused};
use super::passes::Passes;
use super::plan::Dispatch;
use crate::error::Result;
use serde::Serialize;
use wgpu::BufferUsages as Usage;

/// What one pass has taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PassTime {
    /// Name of the pass: the entry point of the shaders.
    pub pass: &'static str,
    /// Number of its dispatches.
    pub times: u64,
    /// Their time in total, s.
    pub seconds: f64,
}

/// Timestamps of the dispatches of a submission, and what passes have taken so far.
pub struct Clock {
    stamps: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// Length of a tick, s.
    tick: f64,
    pub taken: Vec<PassTime>,
}

/// Dispatches between two looks at the timestamps, of which there are two for each.
const DISPATCHES: usize = wgpu::QUERY_SET_MAX_QUERIES as usize / 2;
const STAMP: u64 = size_of::<u64>() as u64;

impl Clock {
    /// A clock for the device.
    ///
    /// # Errors
    /// The adapter has no timestamps.
    pub fn new(device: &Device) -> Result<Clock> {
        if !device.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Err(refused("adapter", &device.adapter.name, "has no timestamps, so its passes cannot be timed"));
        }
        let count = wgpu::QUERY_SET_MAX_QUERIES;
        let descriptor = wgpu::QuerySetDescriptor { label: Some("clock"), ty: wgpu::QueryType::Timestamp, count };
        let resolved = device.empty("clock", u64::from(count) * STAMP, Usage::QUERY_RESOLVE | Usage::COPY_SRC);
        let tick = 1e-9 * f64::from(device.queue.get_timestamp_period());
        Ok(Clock { stamps: device.device.create_query_set(&descriptor), resolved, tick, taken: Vec::new() })
    }

    /// Makes these dispatches once, waits for them and adds what they took.
    ///
    /// # Errors
    /// The device is lost.
    pub fn run(&mut self, device: &Device, passes: &Passes, dispatches: &[Dispatch], step: u64) -> Result<()> {
        for part in dispatches.chunks(DISPATCHES) {
            let mut encoder = device.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            for (k, dispatch) in (0..).zip(part) {
                let timestamp_writes = Some(wgpu::ComputePassTimestampWrites {
                    query_set: &self.stamps,
                    beginning_of_pass_write_index: Some(2 * k),
                    end_of_pass_write_index: Some(2 * k + 1),
                });
                let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes };
                passes.encode(&mut encoder.begin_compute_pass(&descriptor), std::slice::from_ref(dispatch), 1);
            }
            let count = 2 * part.len() as u32;
            encoder.resolve_query_set(&self.stamps, 0..count, &self.resolved, 0);
            device.queue.submit([encoder.finish()]);
            let bytes = device.read(&[(&self.resolved, u64::from(count) * STAMP)], step)?;
            let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
            for (dispatch, pair) in part.iter().zip(ticks.chunks_exact(2)) {
                self.add(dispatch.pass, self.tick * pair[1].saturating_sub(pair[0]) as f64);
            }
        }
        Ok(())
    }

    fn add(&mut self, pass: &'static str, seconds: f64) {
        let at = self.taken.iter().position(|taken| taken.pass == pass).unwrap_or_else(|| {
            self.taken.push(PassTime { pass, times: 0, seconds: 0.0 });
            self.taken.len() - 1
        });
        self.taken[at].times += 1;
        self.taken[at].seconds += seconds;
    }
}
