//! Sizes of the buffers that a continuum needs on the device, known before anything is allocated.

use super::blocks::Blocks;
use super::bounds::{BLOCK, PLATES, TILE};
use super::device::refused;
use super::layout::{BatchState, cell_groups, groups, nodes_on_walls, wall_kinds};
use super::state::entries;
use crate::error::Result;
use crate::mpm::Settings;

/// Size of each buffer, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BufferSizes {
    pub state: u64,
    pub nodes: u64,
    pub starts: u64,
    pub counts: u64,
    pub blocks: u64,
    pub touching: u64,
    pub batch: u64,
}

impl BufferSizes {
    /// For `points` material points, with or without loading plates; the grid has as many blocks as there are slots.
    pub fn of(settings: &Settings, blocks: &Blocks, points: u64, plates: bool) -> BufferSizes {
        let [x, y] = groups(u32::try_from(points).unwrap_or(u32::MAX));
        let (slots, table) = (u64::from(blocks.slots), u64::from(blocks.count()));
        let cells = BLOCK as u64 * slots;
        BufferSizes {
            state: 16 * entries(points as usize, plates) as u64,
            // three planes of the nodes, and the tiles
            nodes: 16 * (3 * cells + TILE as u64 * slots),
            starts: 4 * (cells + 1 + points),
            counts: 4 * (cells + u64::from(cell_groups(cells as u32)) + table),
            blocks: 4 * (table + slots),
            // an entry for each node on a wall; a buffer is never empty
            touching: 16 * nodes_on_walls(settings.cells, &wall_kinds(settings)).max(1),
            // the state, the force on each point, and sums over workgroups of points
            batch: size_of::<BatchState>() as u64
                + 16
                + if plates { 16 * points + 16 * PLATES as u64 * (u64::from(x) * u64::from(y)) } else { 0 },
        }
    }

    /// Size of all buffers, bytes.
    pub fn sum(&self) -> u64 {
        self.state + self.nodes + self.starts + self.counts + self.blocks + self.touching + self.batch
    }

    /// Compares the sizes with the limits of the device.
    ///
    /// # Errors
    /// A buffer is larger than the device allows; the message has its size and the limit.
    pub fn check(&self, limits: &wgpu::Limits) -> Result<()> {
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        for (what, bytes, most, advice) in [
            ("memory of the points", self.state, most, "use fewer points"),
            ("memory of the grid", self.nodes, most, "use larger cells"),
            ("memory of the platens", self.batch, most, "use fewer points"),
            ("memory of the cells", self.counts.max(self.starts), most, "use a smaller domain or larger cells"),
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
