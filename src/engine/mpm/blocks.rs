//! Sparse storage of the grid: blocks of 4 × 4 (× 4) cells exist only where there are points, and the points are sorted by block, cell and identity.
//!
//! A point belongs to the cell whose number is that of the first node that its shape functions reach. So all points of a cell reach the same nodes,
//! and those of a block a *tile* of 6 × 6 (× 6) nodes. Blocks are in the order of their keys. Everything here can be made again from the points.

use super::points::Points;
use rayon::prelude::*;

/// Number of cells along the edge of a block.
pub const EDGE: usize = 4;
/// Number of nodes along the edge of a tile.
pub const TILE: usize = EDGE + 2;
/// Stands for "no block" or "no node".
pub const NONE: u32 = u32::MAX;
/// Stands for a point that stays in its cell, in place of a key.
pub const STAYS: u64 = u64::MAX;
/// Added to cell coordinates to make them positive: cells from −2²⁰ to 2²⁰ − 1 along each axis have a key.
pub const BIAS: i32 = 1 << 20;
/// Bits of a block's coordinate in its key.
const BITS: u32 = 19;

/// Number of cells of a block in `d` dimensions; also the number of nodes that belong to it.
pub const fn cells(d: usize) -> usize {
    EDGE.pow(d as u32)
}

/// Number of nodes of a tile in `d` dimensions.
pub const fn tile(d: usize) -> usize {
    TILE.pow(d as u32)
}

/// Key of a cell: the key of its block and its number in the block. Points are sorted by these keys.
#[inline(always)]
pub fn cell_key<const D: usize>(cell: [i32; 3]) -> u64 {
    let [x, y, z] = cell.map(|c| (c + BIAS) as u64);
    let (e, bits) = (EDGE as u64, 2 * D as u64);
    let block = ((z / e) << (2 * BITS)) | ((y / e) << BITS) | (x / e);
    let local = (x % e) + e * ((y % e) + if D == 3 { e * (z % e) } else { 0 });
    (block << bits) | local
}

/// Coordinates of the first cell of the block with this key.
pub fn block_corner(key: u64) -> [i32; 3] {
    let mask = (1 << BITS) - 1;
    [key & mask, (key >> BITS) & mask, key >> (2 * BITS)].map(|b| (b as i32) * EDGE as i32 - BIAS)
}

/// Coordinates of the cell with this key.
pub fn cell_at<const D: usize>(key: u64) -> [i32; 3] {
    let (e, local) = (EDGE as i32, (key % cells(D) as u64) as i32);
    let [x, y, z] = block_corner(key >> (2 * D));
    [x + local % e, y + local / e % e, if D == 3 { z + local / (e * e) } else { 0 }]
}

/// Key of the block `by` blocks further along each axis.
fn shifted(key: u64, by: [i64; 3]) -> u64 {
    (key as i64 + by[0] + (by[1] << BITS) + (by[2] << (2 * BITS))) as u64
}

/// The blocks with points, the blocks with nodes, and the links between them.
#[derive(Clone, Debug, Default)]
pub struct CellBlocks {
    /// Keys of the blocks that hold points, in order.
    pub keys: Vec<u64>,
    /// Index of the first point of each cell of each of these blocks; at the end the number of points.
    pub starts: Vec<u32>,
    /// Keys of the blocks that hold nodes, in order.
    pub node_keys: Vec<u64>,
    /// Of each block with points: the (up to eight) blocks of nodes that its tile covers, x changing fastest.
    pub ahead: Vec<[u32; 8]>,
    /// Of each block with nodes: the blocks of points whose tiles cover it, in the same order.
    pub behind: Vec<[u32; 8]>,
    /// Points that change their cell, in the order of their new places.
    movers: Vec<Mover>,
    /// Old indices of these points, in order.
    leavers: Vec<u32>,
    /// Old index of each point in a new order.
    source: Vec<u32>,
    /// Buffers for arrays on the way to a new order.
    spare: Spare,
    /// Buffers for `keys` and `starts`.
    other: (Vec<u64>, Vec<u32>),
}

/// A point that changes its cell; ordered by new cell, then by identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Mover {
    key: u64,
    id: u32,
    from: u32,
}

/// Buffers, one for each type of array.
#[derive(Clone, Debug, Default)]
struct Spare {
    numbers: Vec<[f64; 4]>,
    triples: Vec<[f64; 3]>,
    memory: Vec<super::law::InternalVariables>,
    scalars: Vec<f64>,
    ids: Vec<u32>,
    laws: Vec<u8>,
}

impl CellBlocks {
    /// Number of blocks with points.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Number of the block with this key; `None` if it has no points.
    pub fn find(&self, key: u64) -> Option<usize> {
        self.keys.binary_search(&key).ok()
    }

    /// Indices of the points of block `b` in `d` dimensions.
    pub fn points(&self, b: usize, d: usize) -> std::ops::Range<usize> {
        self.starts[b * cells(d)] as usize..self.starts[(b + 1) * cells(d)] as usize
    }

    /// Sorts all points by the cell keys that `key_of` gives for their positions, whatever their order is now. `forces`: entries of external forces of the
    /// points, sorted along if there are any.
    pub fn sort<const D: usize>(&mut self, points: &mut Points, forces: &mut [u32], key_of: impl Fn(&[f64; 4]) -> u64) {
        let n = points.len();
        let mut order: Vec<Mover> =
            (0..n).map(|i| Mover { key: key_of(&points.position[i]), id: points.id[i], from: i as u32 }).collect();
        order.par_sort_unstable();
        self.keys.clear();
        self.keys.extend(order.iter().map(|m| m.key >> (2 * D)));
        self.keys.dedup();
        self.starts.clear();
        self.starts.resize(self.keys.len() * cells(D) + 1, 0);
        let mut at = 0;
        for (b, &key) in self.keys.iter().enumerate() {
            for c in 0..cells(D) {
                self.starts[b * cells(D) + c] = at as u32;
                let key = (key << (2 * D)) | c as u64;
                while at < n && order[at].key == key {
                    at += 1;
                }
            }
        }
        self.starts[self.keys.len() * cells(D)] = n as u32;
        self.source.clear();
        self.source.extend(order.iter().map(|m| m.from));
        if self.source.iter().enumerate().any(|(k, &from)| k as u32 != from) {
            permute(points, 0, &self.source, &mut self.spare);
            if forces.len() == n {
                array(forces, 0, &self.source, &mut self.spare.ids);
            }
        }
        self.link::<D>();
    }

    /// Moves the points that have left their cells to their new places. `target`: key of the new cell of each of them, `STAYS` for others; `left`: number of
    /// such points of each block. Returns whether the set of blocks has changed.
    pub fn resort<const D: usize>(&mut self, points: &mut Points, target: &[u64], left: &[u32]) -> bool {
        self.movers.clear();
        self.leavers.clear();
        for b in (0..self.len()).filter(|&b| left[b] > 0) {
            for i in self.points(b, D).filter(|&i| target[i] != STAYS) {
                self.movers.push(Mover { key: target[i], id: points.id[i], from: i as u32 });
                self.leavers.push(i as u32);
            }
        }
        if self.movers.is_empty() {
            return false;
        }
        self.movers.sort_unstable();
        let new_blocks = self.movers.iter().any(|m| self.keys.binary_search(&(m.key >> (2 * D))).is_err());
        if new_blocks {
            self.add_blocks::<D>();
        }
        self.merge::<D>(points);
        if new_blocks {
            self.link::<D>();
        }
        new_blocks
    }

    /// Adds the blocks to which points move, and removes blocks without points.
    fn add_blocks<const D: usize>(&mut self) {
        let (keys, starts) = (&mut self.other.0, &mut self.other.1);
        keys.clear();
        let occupied = |b: &usize| self.starts[b * cells(D)] < self.starts[(b + 1) * cells(D)];
        keys.extend((0..self.keys.len()).filter(occupied).map(|b| self.keys[b]));
        keys.extend(self.movers.iter().map(|m| m.key >> (2 * D)));
        keys.sort_unstable();
        keys.dedup();
        starts.clear();
        let mut old = 0;
        for &key in keys.iter() {
            while old < self.keys.len() && self.keys[old] < key {
                old += 1;
            }
            let from = old * cells(D);
            if self.keys.get(old) == Some(&key) {
                starts.extend_from_slice(&self.starts[from..from + cells(D)]);
            } else {
                starts.resize(starts.len() + cells(D), self.starts[from]);
            }
        }
        starts.extend(self.starts.last());
        std::mem::swap(&mut self.keys, &mut self.other.0);
        std::mem::swap(&mut self.starts, &mut self.other.1);
    }

    /// Number of the cell with this key, counted through all blocks.
    fn cell_of<const D: usize>(&self, key: u64) -> usize {
        let b = self.keys.binary_search(&(key >> (2 * D))).expect("movers have blocks");
        b * cells(D) + (key as usize & (cells(D) - 1))
    }

    /// Merges the points that move (in their new order) with those that stay. Only the range from the first to the last change is rewritten.
    fn merge<const D: usize>(&mut self, points: &mut Points) {
        // of several cells with the same start only the last one has points
        let holder = |starts: &[u32], i: u32| starts.partition_point(|&s| s <= i) - 1;
        let (first, last) = (self.leavers[0], self.leavers[self.leavers.len() - 1]);
        let (low, high) = (self.movers[0].key, self.movers[self.movers.len() - 1].key);
        let low = self.cell_of::<D>(low).min(holder(&self.starts, first));
        let high = self.cell_of::<D>(high).max(holder(&self.starts, last));
        let from = self.starts[low];
        let CellBlocks { keys, starts, movers, leavers, source, .. } = self;
        let (mut movers, mut leavers) = (movers.iter().peekable(), leavers.iter().peekable());
        source.clear();
        // old start of the cell at hand; `starts` is overwritten meanwhile
        let mut start = from;
        for c in low..=high {
            let key = (keys[c / cells(D)] << (2 * D)) | (c % cells(D)) as u64;
            let end = starts[c + 1];
            starts[c] = from + source.len() as u32;
            let mut i = start;
            loop {
                let mover = movers.peek().filter(|m| m.key == key);
                match (mover, leavers.peek()) {
                    (None, None) => break source.extend(i..end),
                    (None, Some(&&l)) if l >= end => break source.extend(i..end),
                    (_, Some(&&l)) if l == i && i < end => {
                        leavers.next();
                        i += 1;
                    }
                    (Some(m), _) if i == end || m.id < points.id[i as usize] => {
                        source.push(m.from);
                        movers.next();
                    }
                    _ => {
                        source.push(i);
                        i += 1;
                    }
                }
            }
            start = end;
        }
        permute(points, from as usize, &self.source, &mut self.spare);
    }

    /// Finds the blocks of nodes, and the links between blocks of points and blocks of nodes.
    fn link<const D: usize>(&mut self) {
        let around = |k: usize| [(k & 1) as i64, (k >> 1 & 1) as i64, (k >> 2) as i64];
        let count = 1 << D;
        self.node_keys.clear();
        for k in 0..count {
            self.node_keys.extend(self.keys.iter().map(|&key| shifted(key, around(k))));
        }
        self.node_keys.sort_unstable();
        self.node_keys.dedup();
        let (keys, node_keys) = (&self.keys, &self.node_keys);
        let find = |keys: &[u64], key: u64| keys.binary_search(&key).map_or(NONE, |b| b as u32);
        self.ahead.clear();
        self.ahead.extend(
            keys.iter()
                .map(|&key| std::array::from_fn(|k| if k < count { find(node_keys, shifted(key, around(k))) } else { NONE })),
        );
        self.behind.clear();
        self.behind.extend(
            node_keys.iter().map(|&key| {
                std::array::from_fn(|k| if k < count { find(keys, shifted(key, around(k).map(|a| -a))) } else { NONE })
            }),
        );
    }

    /// Calls `visit` with the indices of the points of the cells from `low` to `high` (both included), for a row of cells at a time.
    pub fn visit<const D: usize>(&self, low: [i32; 3], high: [i32; 3], mut visit: impl FnMut(std::ops::Range<usize>)) {
        let edge = EDGE as i32;
        let span = |a: usize| if a < D { low[a].div_euclid(edge)..=high[a].div_euclid(edge) } else { 0..=0 };
        for bz in span(2) {
            for by in span(1) {
                for bx in span(0) {
                    let corner = [bx * edge, by * edge, bz * edge];
                    let Ok(b) = self.keys.binary_search(&(cell_key::<D>(corner) >> (2 * D))) else { continue };
                    // range of cells of this block
                    let of = |a: usize| {
                        let (from, to) = (low[a].max(corner[a]) - corner[a], high[a].min(corner[a] + edge - 1) - corner[a]);
                        if a < D { from as usize..to as usize + 1 } else { 0..1 }
                    };
                    for z in of(2) {
                        for y in of(1) {
                            let row = b * cells(D) + EDGE * (y + EDGE * z);
                            let x = of(0);
                            visit(self.starts[row + x.start] as usize..self.starts[row + x.end] as usize);
                        }
                    }
                }
            }
        }
    }

    /// Index of the node with these coordinates, counted through the blocks of nodes; `None` if no block holds it.
    pub fn node<const D: usize>(&self, node: [i32; 3]) -> Option<u32> {
        let key = cell_key::<D>(node);
        let b = self.node_keys.binary_search(&(key >> (2 * D))).ok()?;
        Some((b * cells(D)) as u32 + (key as u32 & (cells(D) as u32 - 1)))
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        let s = &self.spare;
        8 * (self.keys.capacity()
            + self.node_keys.capacity()
            + self.other.0.capacity()
            + s.scalars.capacity()
            + s.memory.capacity())
            + 4 * (self.starts.capacity() + self.leavers.capacity() + self.source.capacity() + self.other.1.capacity())
            + 4 * s.ids.capacity()
            + s.laws.capacity()
            + 32 * (self.ahead.capacity() + self.behind.capacity() + s.numbers.capacity())
            + 16 * self.movers.capacity()
            + 24 * s.triples.capacity()
    }
}

/// Sorts all arrays of points: the places from `first` on get the points with the old indices `source`.
fn permute(points: &mut Points, first: usize, source: &[u32], spare: &mut Spare) {
    array(&mut points.position, first, source, &mut spare.numbers);
    array(&mut points.velocity, first, source, &mut spare.numbers);
    parts::<_, 2>(pulp::bytemuck::cast_slice_mut(&mut points.stress), first, source, &mut spare.triples);
    array(&mut points.memory, first, source, &mut spare.memory);
    array(&mut points.initial_volume, first, source, &mut spare.scalars);
    array(&mut points.initial_porosity, first, source, &mut spare.scalars);
    array(&mut points.law, first, source, &mut spare.laws);
    array(&mut points.id, first, source, &mut spare.ids);
    if !points.affine.is_empty() {
        parts::<_, 3>(pulp::bytemuck::cast_slice_mut(&mut points.affine), first, source, &mut spare.triples);
    }
    if !points.transport_velocity.is_empty() {
        array(&mut points.transport_velocity, first, source, &mut spare.triples);
    }
    if !points.faces.is_empty() {
        parts::<_, 2>(pulp::bytemuck::cast_slice_mut(&mut points.faces), first, source, &mut spare.triples);
    }
}

/// Number of points of one parallel task.
const TASK: usize = 4096;

/// Sorts one array; arguments as of [`permute`].
fn array<T: Copy + Default + Send + Sync>(values: &mut [T], first: usize, source: &[u32], spare: &mut Vec<T>) {
    fetch(source, spare, values.len(), values, |values, from| values[from]);
    values[first..first + source.len()].copy_from_slice(&spare[..source.len()]);
}

/// Sorts an array of entries with `N` parts, one part after the other, which needs smaller buffers.
fn parts<T: Copy + Default + Send + Sync, const N: usize>(values: &mut [T], first: usize, source: &[u32], spare: &mut Vec<T>) {
    for part in 0..N {
        fetch(source, spare, values.len() / N, values, |values, from| values[from * N + part]);
        for (k, value) in spare[..source.len()].iter().enumerate() {
            values[(first + k) * N + part] = *value;
        }
    }
}

/// Copies the values with the old indices `source` into the buffer `spare`.
fn fetch<T: Copy + Default + Send + Sync>(
    source: &[u32],
    spare: &mut Vec<T>,
    room: usize,
    values: &[T],
    of: impl Fn(&[T], usize) -> T + Sync,
) {
    if spare.len() < source.len() {
        // as large as it can ever be needed, so that memory is taken once
        spare.resize(room, T::default());
    }
    let spare = &mut spare[..source.len()];
    if source.len() <= TASK {
        for (to, &from) in spare.iter_mut().zip(source) {
            *to = of(values, from as usize);
        }
    } else {
        spare.par_chunks_mut(TASK).zip(source.par_chunks(TASK)).for_each(|(to, from)| {
            for (to, &from) in to.iter_mut().zip(from) {
                *to = of(values, from as usize);
            }
        });
    }
}
