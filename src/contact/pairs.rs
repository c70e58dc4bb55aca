//! Storage of contacts: one slot per pair that is near enough to touch soon. Slots are re-used; the contacts of a grain are
//! found through `neighbours::adjacency`.

use serde::{Deserialize, Serialize};

/// First end of a slot that holds no pair.
pub const FREE: u32 = u32::MAX;

/// What the sweep leaves for the gather, one cache line per contact. All zero when the pair does not touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub struct Touch {
    /// Force on the first grain, N.
    pub force: [f64; 3],
    /// Overlap, m.
    pub overlap: f64,
    /// normal × tangential force; times each grain's own arm it is that grain's torque (same sign for both).
    pub torque: [f64; 3],
    /// Normal force times the area model's weight: compared with the limits of both grains.
    pub load: f64,
}

/// Pairs of grains, or of a grain and a wall (the second end is then the wall's index).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Pairs {
    /// Indices of both ends; between grains the one with the lower id is first.
    pub ends: Vec<[u32; 2]>,
    /// Tangential force on the first end, N, and the tangential stiffness it was last computed with, N/m.
    pub history: Vec<[f64; 4]>,
    pub touch: Vec<Touch>,
    /// Work of the last step, J: contact path, slip, viscous (kept only with the energy ledger).
    pub work: Vec<[f64; 3]>,
    /// Rolling moment on the first end, N m (kept only with rolling friction).
    pub rolling: Vec<[f64; 3]>,
    free: Vec<u32>,
    with_work: bool,
    with_rolling: bool,
}

impl Pairs {
    pub fn new(with_work: bool, with_rolling: bool) -> Pairs {
        Pairs { with_work, with_rolling, ..Pairs::default() }
    }

    /// A slot for the pair, without history.
    pub fn add(&mut self, first: u32, second: u32) -> u32 {
        if let Some(slot) = self.free.pop() {
            let s = slot as usize;
            self.ends[s] = [first, second];
            self.history[s] = [0.0; 4];
            self.touch[s] = Touch::default();
            if self.with_work {
                self.work[s] = [0.0; 3];
            }
            if self.with_rolling {
                self.rolling[s] = [0.0; 3];
            }
            return slot;
        }
        self.make_room();
        self.ends.push([first, second]);
        self.history.push([0.0; 4]);
        self.touch.push(Touch::default());
        if self.with_work {
            self.work.push([0.0; 3]);
        }
        if self.with_rolling {
            self.rolling.push([0.0; 3]);
        }
        self.ends.len() as u32 - 1
    }

    /// Grows by an eighth, not by doubling: slots are most of a run's memory.
    fn make_room(&mut self) {
        let n = self.ends.len();
        if n == self.ends.capacity() {
            let more = n / 8 + 64;
            self.ends.reserve_exact(more);
            self.history.reserve_exact(more);
            self.touch.reserve_exact(more);
            if self.with_work {
                self.work.reserve_exact(more);
            }
            if self.with_rolling {
                self.rolling.reserve_exact(more);
            }
        }
    }

    pub fn remove(&mut self, slot: u32) {
        let s = slot as usize;
        self.ends[s] = [FREE, FREE];
        self.touch[s] = Touch::default();
        if self.with_work {
            self.work[s] = [0.0; 3];
        }
        self.free.push(slot);
    }

    /// Number of slots, free ones included.
    pub fn slots(&self) -> usize {
        self.ends.len()
    }

    /// Slots in the order given; the ends are renumbered by `renumber`. What is not listed is dropped.
    pub fn permute(&mut self, order: &[u32], renumber: impl Fn([u32; 2]) -> [u32; 2]) {
        fn pick<T: Copy>(v: &mut Vec<T>, order: &[u32]) {
            if !v.is_empty() {
                *v = order.iter().map(|&s| v[s as usize]).collect();
            }
        }
        self.ends = order.iter().map(|&s| renumber(self.ends[s as usize])).collect();
        pick(&mut self.history, order);
        pick(&mut self.touch, order);
        pick(&mut self.work, order);
        pick(&mut self.rolling, order);
        self.free.clear();
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        use std::mem::size_of;
        self.ends.capacity() * size_of::<[u32; 2]>()
            + self.history.capacity() * size_of::<[f64; 4]>()
            + self.touch.capacity() * size_of::<Touch>()
            + self.work.capacity() * size_of::<[f64; 3]>()
            + self.rolling.capacity() * size_of::<[f64; 3]>()
            + self.free.capacity() * 4
    }
}
