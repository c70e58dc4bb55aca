//! Storage of contacts: one slot per pair that is near enough to touch soon. Slots are re-used; the contacts of a grain are
//! found through `neighbours::adjacency`. ContactHistory is what a large run waits for, so a contact is one cache line, and what only some
//! runs need stands in columns that the others do not have.

use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// First end of a slot that holds no pair.
pub const FREE: u32 = u32::MAX;

/// What a sweep leaves for the grains and for the next sweep. All zero when the pair does not touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub struct ContactForce<R = f64> {
    /// Tangential force on the first end, N.
    pub tangential: [R; 3],
    /// Normal force, N, compression positive.
    pub normal_force: R,
    /// Unit normal from the first to the second end.
    pub normal: [R; 3],
    /// Overlap, m.
    pub overlap: R,
}

impl ContactForce {
    /// The first half: tangential and normal force.
    #[inline(always)]
    pub fn first(&self) -> [f64; 4] {
        let [x, y, z] = self.tangential;
        [x, y, z, self.normal_force]
    }

    #[inline(always)]
    pub fn set_first(&mut self, [x, y, z, normal_force]: [f64; 4]) {
        self.tangential = [x, y, z];
        self.normal_force = normal_force;
    }

    /// The second half: normal and overlap.
    #[inline(always)]
    pub fn second(&self) -> [f64; 4] {
        let [x, y, z] = self.normal;
        [x, y, z, self.overlap]
    }

    #[inline(always)]
    pub fn set_second(&mut self, [x, y, z, overlap]: [f64; 4]) {
        self.normal = [x, y, z];
        self.overlap = overlap;
    }

    /// Force on the first end, N.
    #[inline(always)]
    pub fn force(&self) -> [f64; 3] {
        std::array::from_fn(|a| self.tangential[a] - self.normal_force * self.normal[a])
    }
}

/// A value per slot, in the runs that need it; empty in the others.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Column<T> {
    kept: bool,
    values: Vec<T>,
}

impl<T: Copy + Default> Column<T> {
    fn new(kept: bool) -> Column<T> {
        Column { kept, values: Vec::new() }
    }

    fn push(&mut self) {
        if self.kept {
            self.values.push(T::default());
        }
    }

    fn clear(&mut self, slot: usize) {
        if self.kept {
            self.values[slot] = T::default();
        }
    }

    fn reserve(&mut self, more: usize) {
        if self.kept {
            self.values.reserve_exact(more);
        }
    }

    fn permute(&mut self, order: &[u32]) {
        if self.kept {
            self.values = order.iter().map(|&s| self.values[s as usize]).collect();
        }
    }

    fn bytes(&self) -> usize {
        self.values.capacity() * size_of::<T>()
    }
}

impl<T> Deref for Column<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.values
    }
}

impl<T> DerefMut for Column<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.values
    }
}

/// Which columns a run keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// With the energy ledger.
    pub work: bool,
    /// With rolling friction.
    pub rolling: bool,
    /// With a viscous law.
    pub spring: bool,
    /// With the Hertzian contact area.
    pub load: bool,
    /// With a law that yields.
    pub largest: bool,
}

/// Pairs of grains, or of a grain and a wall (the second end is then the wall's index).
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Pairs {
    /// Indices of both ends; between grains the one with the lower id is first.
    pub ends: Vec<[u32; 2]>,
    pub touch: Vec<ContactForce>,
    /// Work of the last step, J: contact path, slip, viscous, and a lane to spare.
    pub work: Column<[f64; 4]>,
    /// Rolling moment on the first end, N m.
    pub rolling: Column<[f64; 3]>,
    /// Tangential spring force on the first end where it is not the whole tangential force, N.
    pub spring: Column<[f64; 3]>,
    /// Normal force times the area model's weight, where that is not 1: compared with the limits of both grains.
    pub load: Column<f64>,
    /// Largest overlap so far, m, of contacts that yield.
    pub largest: Column<f64>,
    free: Vec<u32>,
}

impl Pairs {
    pub fn new(kept: Kept) -> Pairs {
        Pairs {
            work: Column::new(kept.work),
            rolling: Column::new(kept.rolling),
            spring: Column::new(kept.spring),
            load: Column::new(kept.load),
            largest: Column::new(kept.largest),
            ..Pairs::default()
        }
    }

    /// Slots of the pairs that touch, in the order of their ends' identities.
    pub fn touching(&self, id: impl Fn([u32; 2]) -> [u32; 2]) -> Vec<usize> {
        let touching = |s: &usize| self.ends[*s][0] != FREE && self.touch[*s].overlap > 0.0;
        let mut slots: Vec<usize> = (0..self.slots()).filter(touching).collect();
        slots.sort_unstable_by_key(|&s| id(self.ends[s]));
        slots
    }

    /// Which columns there are.
    pub fn kept(&self) -> Kept {
        Kept {
            work: self.work.kept,
            rolling: self.rolling.kept,
            spring: self.spring.kept,
            load: self.load.kept,
            largest: self.largest.kept,
        }
    }

    /// The load that counts for breakage.
    #[inline(always)]
    pub fn load(&self, slot: usize) -> f64 {
        if self.load.is_empty() { self.touch[slot].normal_force } else { self.load[slot] }
    }

    /// Largest overlap so far, m, of a contact whose overlap is now `overlap`.
    #[inline(always)]
    pub fn largest(&self, slot: usize, overlap: f64) -> f64 {
        if self.largest.is_empty() { overlap } else { self.largest[slot].max(overlap) }
    }

    /// Tangential spring force on the first end, N.
    #[inline(always)]
    pub fn spring(&self, slot: usize) -> [f64; 3] {
        if self.spring.is_empty() { self.touch[slot].tangential } else { self.spring[slot] }
    }

    /// A slot for the pair, without history.
    pub fn add(&mut self, first: u32, second: u32) -> u32 {
        if let Some(slot) = self.free.pop() {
            self.ends[slot as usize] = [first, second];
            return slot;
        }
        self.make_room();
        self.ends.push([first, second]);
        self.touch.push(ContactForce::default());
        self.work.push();
        self.rolling.push();
        self.spring.push();
        self.load.push();
        self.largest.push();
        self.ends.len() as u32 - 1
    }

    /// Grows by an eighth, not by doubling: slots are most of a run's memory.
    fn make_room(&mut self) {
        let n = self.ends.len();
        if n == self.ends.capacity() {
            let more = n / 8 + 64;
            self.ends.reserve_exact(more);
            self.touch.reserve_exact(more);
            self.work.reserve(more);
            self.rolling.reserve(more);
            self.spring.reserve(more);
            self.load.reserve(more);
            self.largest.reserve(more);
        }
    }

    /// Frees a slot and forgets its history.
    pub fn remove(&mut self, slot: u32) {
        let s = slot as usize;
        self.ends[s] = [FREE, FREE];
        self.touch[s] = ContactForce::default();
        self.work.clear(s);
        self.rolling.clear(s);
        self.spring.clear(s);
        self.load.clear(s);
        self.largest.clear(s);
        self.free.push(slot);
    }

    /// Number of slots, free ones included.
    pub fn slots(&self) -> usize {
        self.ends.len()
    }

    /// Slots in the order given; the ends are renumbered by `renumber`. What is not listed is dropped.
    pub fn permute(&mut self, order: &[u32], renumber: impl Fn([u32; 2]) -> [u32; 2]) {
        self.ends = order.iter().map(|&s| renumber(self.ends[s as usize])).collect();
        self.touch = order.iter().map(|&s| self.touch[s as usize]).collect();
        self.work.permute(order);
        self.rolling.permute(order);
        self.spring.permute(order);
        self.load.permute(order);
        self.largest.permute(order);
        self.free.clear();
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.ends.capacity() * size_of::<[u32; 2]>()
            + self.touch.capacity() * size_of::<ContactForce>()
            + self.work.bytes()
            + self.rolling.bytes()
            + self.spring.bytes()
            + self.load.bytes()
            + self.largest.bytes()
            + self.free.capacity() * 4
    }
}
