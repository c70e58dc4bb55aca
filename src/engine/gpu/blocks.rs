//! Blocks of the grid that have a slot in the memory of the device; `blocks.wgsl` says what slots are.

use super::bounds::{BLOCK, WIDE};
use super::layout::{cell_groups, share};
use super::state::{cell_number, cell_place};
use crate::mpm::Settings;

/// Cells of a block along each axis.
const ALONG: [u32; 3] = [4, 4, 2];
/// Largest numbers of nodes along each axis: the places of cells are kept in 11, 11 and 10 bits.
const MOST: [u32; 3] = [2048, 2048, 1024];
/// Place of the block of a slot that has none.
const NOWHERE: u32 = u32::MAX;
/// Slots beyond twice as many as are in use at the start.
const SPARE: u32 = 1024;
/// The claims of a block: it has a slot; the blocks around it have slots.
const HELD: u32 = 1;
const RINGED: u32 = 2;

/// Blocks of the domain along each axis: those of its nodes, of which there are two more than of its cells.
fn along(settings: &Settings) -> [u32; 3] {
    std::array::from_fn(|a| (settings.cells[a] + 3).div_ceil(ALONG[a]))
}

/// Largest numbers of cells along each axis where `settings` has more.
pub fn too_wide(settings: &Settings) -> Option<[u32; 3]> {
    let most = MOST.map(|n| n - 3);
    (0..3).any(|a| settings.cells[a] > most[a]).then_some(most)
}

/// The block of the cell or node at a place.
fn block_number(along: [u32; 3], at: [u32; 3]) -> u32 {
    let [x, y, z]: [u32; 3] = std::array::from_fn(|a| at[a] / ALONG[a]);
    x + along[0] * (y + along[1] * z)
}

/// Index in memory of the cell, or of the node, at a place. `table`: the slots of the blocks.
pub fn index(settings: &Settings, table: &[u32], at: [u32; 3]) -> u32 {
    let [x, y, z]: [u32; 3] = std::array::from_fn(|a| at[a] % ALONG[a]);
    table[block_number(along(settings), at) as usize] * BLOCK as u32 + x + 4 * (y + 4 * z)
}

/// The greatest common divisor.
fn common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// Which blocks have slots.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// Blocks of the domain along each axis.
    pub along: [u32; 3],
    /// Number of slots that there is memory for.
    pub slots: u32,
    /// Number of slots in use, with slot 0, which belongs to no block.
    pub used: u32,
    /// For each block its slot, 0 where it has none.
    table: Vec<u32>,
    /// Numbers of the blocks with points.
    occupied: Vec<u32>,
}

impl Blocks {
    /// Those with points in one of these cells, numbers in the domain, and those around them; and more than twice as many slots.
    pub fn of(settings: &Settings, cells: impl Iterator<Item = u32>) -> Blocks {
        let along = along(settings);
        let mut table = vec![0; along.iter().product::<u32>() as usize];
        let mut blocks = Blocks { along, slots: 0, used: 1, table: Vec::new(), occupied: Vec::new() };
        let mut occupied: Vec<u32> = cells.map(|cell| block_number(along, cell_place(cell))).collect();
        occupied.sort_unstable();
        occupied.dedup();
        for block in &occupied {
            let at = blocks.place(*block);
            let around = |a: usize| at[a].saturating_sub(1)..=(at[a] + 1).min(along[a] - 1);
            for z in around(2) {
                for y in around(1) {
                    for x in around(0) {
                        table[(x + along[0] * (y + along[1] * z)) as usize] = 1;
                    }
                }
            }
        }
        for slot in table.iter_mut().filter(|held| **held == 1) {
            *slot = blocks.used;
            blocks.used += 1;
        }
        // an even number, as many as all blocks could need at most
        blocks.slots = (2 * blocks.used + SPARE).min(table.len() as u32 + 1).next_multiple_of(2);
        (blocks.table, blocks.occupied) = (table, occupied);
        blocks
    }

    /// As many more slots as for so many times the points.
    pub fn for_more(mut self, times: f64) -> Blocks {
        let grown = |slots: u32| (f64::from(slots) * times.max(1.0)).min(f64::from(self.count()) + 1.0) as u32;
        (self.used, self.slots) = (grown(self.used), grown(self.slots));
        self
    }

    /// Pairs of slots between those of neighbouring workgroups, so that a run of workgroups has its share of the slots in use: about the golden section of all pairs, and
    /// without a common divisor with their number.
    pub fn stride(&self) -> u32 {
        let pairs = self.slots / 2;
        // the product with a number of a pair fits into 32 bits
        if !(3..=1 << 16).contains(&pairs) {
            return 1;
        }
        let first = (0.618 * f64::from(pairs)) as u32;
        (first..pairs).find(|stride| common_divisor(*stride, pairs) == 1).unwrap_or(1)
    }

    /// Number of blocks of the domain.
    pub fn count(&self) -> u32 {
        self.along.iter().product()
    }

    fn place(&self, block: u32) -> [u32; 3] {
        [block % self.along[0], block / self.along[0] % self.along[1], block / (self.along[0] * self.along[1])]
    }

    /// The words of the buffer `blocks`.
    pub fn words(&self) -> Vec<u32> {
        let mut words = self.table.clone();
        words.resize(self.table.len() + self.slots as usize, NOWHERE);
        for (block, slot) in (0..).zip(&self.table).filter(|(_, slot)| **slot != 0) {
            words[self.table.len() + *slot as usize] = cell_number(self.place(block));
        }
        words
    }

    /// The words of the buffer `counts`, for points in these cells, numbers in the domain: numbers of points of each cell, then of each group of cells, then the claims.
    pub fn counts(&self, settings: &Settings, cells: impl Iterator<Item = u32>) -> Vec<u32> {
        let all = BLOCK as u32 * self.slots;
        let groups = cell_groups(all);
        let mut counts = vec![0; (all + groups) as usize];
        for cell in cells {
            let k = index(settings, &self.table, cell_place(cell));
            counts[k as usize] += 1;
            counts[(all + k / (share(all) * WIDE as u32)) as usize] += 1;
        }
        let first = counts.len();
        counts.extend(self.table.iter().map(|slot| if *slot == 0 { 0 } else { HELD }));
        self.occupied.iter().for_each(|block| counts[first + *block as usize] |= RINGED);
        counts
    }
}
