//! Sizes of the buffers that a continuum needs on the device, known before anything is allocated.

use super::bounds::PLATES;
use super::device::refused;
use super::layout::{BatchState, cell_groups, groups};
use super::state::planes;
use crate::error::Result;
use crate::mpm::Settings;

/// Size of each buffer, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSizes {
    pub state: u64,
    pub nodes: u64,
    pub starts: u64,
    pub counts: u64,
    pub order: u64,
    pub touching: u64,
    pub batch: u64,
}

impl BufferSizes {
    /// For `points` material points, with or without loading plates; the grid covers the whole domain.
    pub fn of(settings: &Settings, points: u64, plates: bool) -> BufferSizes {
        let n = settings.cells.map(u128::from);
        let all = |more: u128| n.iter().map(|n| n + more).product::<u128>().min(1 << 40) as u64;
        let (cells, nodes) = (all(1), all(3));
        let [x, y] = groups(u32::try_from(points).unwrap_or(u32::MAX));
        let sides: u64 = n.map(|n| nodes / (n as u64 + 3)).iter().sum();
        BufferSizes {
            state: 16 * planes(plates) as u64 * points,
            nodes: 48 * nodes,
            starts: 4 * (cells + 1),
            counts: 4 * (cells + u64::from(cell_groups(u32::try_from(cells).unwrap_or(u32::MAX)))),
            order: 4 * points,
            touching: 8 * sides,
            // the state, the force on each point, and sums over workgroups of points
            batch: size_of::<BatchState>() as u64
                + 16
                + if plates { 16 * points + 16 * PLATES as u64 * (u64::from(x) * u64::from(y)) } else { 0 },
        }
    }

    /// Size of all buffers, bytes.
    pub fn sum(&self) -> u64 {
        self.state + self.nodes + self.starts + self.counts + self.order + self.touching + self.batch
    }

    /// Compares the sizes with the limits of the device.
    ///
    /// # Errors
    /// A buffer is larger than the device allows; the message has its size and the limit.
    pub fn check(&self, limits: &wgpu::Limits) -> Result<()> {
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        // the grid is limited so that indices fit into 32 bits
        for (what, bytes, most, advice) in [
            ("memory of the points", self.state, most, "use fewer points"),
            ("memory of the grid", self.nodes, most.min(48 << 30), "use a smaller domain or larger cells"),
            ("memory of the platens", self.batch, most, "use fewer points"),
            ("memory of the cells", self.counts, most, "use a smaller domain or larger cells"),
        ] {
            if bytes > most {
                let mib = |bytes: u64| format!("{:.1} MiB", bytes as f64 / 1_048_576.0);
                return Err(refused(
                    what,
                    mib(bytes),
                    format!("is above the device's {}: {advice}, or use the processor", mib(most)),
                ));
            }
        }
        Ok(())
    }
}
