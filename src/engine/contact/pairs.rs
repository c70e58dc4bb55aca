//! Storage of contacts: one slot for each pair that is close enough to touch soon; slots of pairs that have moved apart are used again. The slots of one
//! grain are found through `neighbours::adjacency`. Reading and writing memory takes most of the time of a large run: force and geometry of a contact therefore
//! fill exactly one cache line, and values that only some runs need are in columns that are empty in the others.

use crate::check::{Checked, below, ensure, lengths, numbers};
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// Both ends of a slot that holds no pair.
pub const FREE: u32 = u32::MAX;

/// Force and geometry of one contact (or of one per SIMD lane); all zero where the pair does not touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(C, align(64))]
pub struct ContactForce<R = f64> {
    /// Tangential force on the first end, N.
    pub tangential: [R; 3],
    /// Normal force, N, positive in compression.
    pub normal_force: R,
    /// Unit vector from the first to the second end.
    pub normal: [R; 3],
    /// Overlap, m; above 0 in contact.
    pub overlap: R,
}

impl ContactForce {
    /// The first half of the cache line: tangential and normal force, N.
    #[inline(always)]
    pub fn first(&self) -> [f64; 4] {
        let [x, y, z] = self.tangential;
        [x, y, z, self.normal_force]
    }

    /// Sets what [`ContactForce::first`] returns.
    #[inline(always)]
    pub fn set_first(&mut self, [x, y, z, normal_force]: [f64; 4]) {
        self.tangential = [x, y, z];
        self.normal_force = normal_force;
    }

    /// The second half: unit normal, and overlap, m.
    #[inline(always)]
    pub fn second(&self) -> [f64; 4] {
        let [x, y, z] = self.normal;
        [x, y, z, self.overlap]
    }

    /// Sets what [`ContactForce::second`] returns.
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

/// One value per slot in the runs that need it; empty in the others.
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

    /// Drops the value of a slot; that of the last slot takes its place.
    fn close_gap(&mut self, slot: usize) {
        if self.kept {
            self.values.swap_remove(slot);
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

    /// Number of values for so many slots.
    fn needs(&self, slots: usize) -> usize {
        if self.kept { slots } else { 0 }
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

/// Which columns of [`Pairs`] a run keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Kept {
    /// Works; with the energy ledger.
    pub work: bool,
    /// Rolling moments; with rolling friction.
    pub rolling: bool,
    /// Forces of the tangential springs; with a viscous law.
    pub spring: bool,
    /// Weighted loads; with a failure criterion that weighs the forces of contacts (Hertz's area).
    pub load: bool,
    /// Largest overlaps; with a law that yields.
    pub largest: bool,
}

/// Calls a method of every [`Column`] of [`Pairs`].
macro_rules! every_column {
    ($pairs:ident.$method:ident($($argument:expr)?)) => {
        $pairs.work.$method($($argument)?);
        $pairs.rolling.$method($($argument)?);
        $pairs.spring.$method($($argument)?);
        $pairs.load.$method($($argument)?);
        $pairs.largest.$method($($argument)?);
    };
}

/// Pairs of grains, or of a grain and a wall; the second end is then the index of the wall. Slot s is entry s of every array.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Pairs {
    /// Indices of both ends. Of two grains the one with the lower identity is first; [`FREE`] where the slot holds no pair.
    pub ends: Vec<[u32; 2]>,
    /// Force and geometry of the last step.
    pub touch: Vec<ContactForce>,
    /// Works of the last step, J ([`super::force::ContactHistory::work`]); the fourth number is unused.
    pub work: Column<[f64; 4]>,
    /// Rolling moment on the first end, N m.
    pub rolling: Column<[f64; 3]>,
    /// Force of the tangential spring on the first end, N, in runs in which it is not the whole tangential force.
    pub spring: Column<[f64; 3]>,
    /// Normal force times the weight of the failure criterion, in runs in which the weight is not 1; compared with the thresholds of both grains.
    pub load: Column<f64>,
    /// Largest overlap so far, m, in runs with a law that yields.
    pub largest: Column<f64>,
    free: Vec<u32>,
}

impl Pairs {
    /// No pairs yet, with these columns.
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

    /// Slots of the pairs that touch, in the order of the identities of their ends; `id` gives the identities for two indices.
    pub fn touching(&self, id: impl Fn([u32; 2]) -> [u32; 2]) -> Vec<usize> {
        let touching = |s: &usize| self.ends[*s][0] != FREE && self.touch[*s].overlap > 0.0;
        let mut slots: Vec<usize> = (0..self.slots()).filter(touching).collect();
        slots.sort_unstable_by_key(|&s| id(self.ends[s]));
        slots
    }

    /// Which columns the run keeps.
    pub fn kept(&self) -> Kept {
        Kept {
            work: self.work.kept,
            rolling: self.rolling.kept,
            spring: self.spring.kept,
            load: self.load.kept,
            largest: self.largest.kept,
        }
    }

    /// The load of a contact that the failure criterion compares with its threshold: the normal force, N, weighted where the criterion has a weight.
    #[inline(always)]
    pub fn load(&self, slot: usize) -> f64 {
        if self.load.is_empty() { self.touch[slot].normal_force } else { self.load[slot] }
    }

    /// Largest overlap so far, m, of a contact whose overlap is now `overlap`; that itself in runs without laws that yield.
    #[inline(always)]
    pub fn largest(&self, slot: usize, overlap: f64) -> f64 {
        if self.largest.is_empty() { overlap } else { self.largest[slot].max(overlap) }
    }

    /// Force of the tangential spring on the first end, N.
    #[inline(always)]
    pub fn spring(&self, slot: usize) -> [f64; 3] {
        if self.spring.is_empty() { self.touch[slot].tangential } else { self.spring[slot] }
    }

    /// Takes a slot for a pair, with an empty history, and returns its number.
    pub fn add(&mut self, first: u32, second: u32) -> u32 {
        if let Some(slot) = self.free.pop() {
            self.ends[slot as usize] = [first, second];
            return slot;
        }
        self.make_room();
        self.ends.push([first, second]);
        self.touch.push(ContactForce::default());
        every_column!(self.push());
        self.ends.len() as u32 - 1
    }

    /// Makes room for more slots: an eighth more, not twice as many, as contacts take most of the memory of a run.
    fn make_room(&mut self) {
        let n = self.ends.len();
        if n == self.ends.capacity() {
            let more = n / 8 + 64;
            self.ends.reserve_exact(more);
            self.touch.reserve_exact(more);
            every_column!(self.reserve(more));
        }
    }

    /// Frees a slot and forgets its history.
    pub fn remove(&mut self, slot: u32) {
        let s = slot as usize;
        self.ends[s] = [FREE, FREE];
        self.touch[s] = ContactForce::default();
        every_column!(self.clear(s));
        self.free.push(slot);
    }

    /// Leaves no slot free: pairs of the last slots move into the free ones. Calls `moved` with the new slot and the ends of each pair that moves.
    pub fn close_gaps(&mut self, mut moved: impl FnMut(u32, [u32; 2])) {
        self.free.sort_unstable();
        // from the last one down, so that whatever moves is a pair
        while let Some(slot) = self.free.pop() {
            let s = slot as usize;
            self.ends.swap_remove(s);
            self.touch.swap_remove(s);
            every_column!(self.close_gap(s));
            if let Some(&ends) = self.ends.get(s) {
                moved(slot, ends);
            }
        }
    }

    /// Checks slots, ends and values. The first ends are grains with the identities `ids`; the second ends are below `second`, and grains as well where `grains`
    /// is true. `kept`: the columns of the run.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, ids: &[u32], second: usize, grains: bool, kept: Kept) -> Checked {
        let Pairs { ends, touch, work, rolling, spring, load, largest, free } = self;
        ensure(self.kept() == kept, || "contacts keep other values than the scene asks for".into())?;
        let n = ends.len();
        lengths("contacts", n, [touch.len()])?;
        for (needs, has) in [
            (work.needs(n), work.len()),
            (rolling.needs(n), rolling.len()),
            (spring.needs(n), spring.len()),
            (load.needs(n), load.len()),
            (largest.needs(n), largest.len()),
        ] {
            lengths("contacts", needs, [has])?;
        }
        numbers("forces of contacts", touch.iter().flat_map(|t| [t.first(), t.second()]).flatten())?;
        numbers("works of contacts", work.as_flattened())?;
        numbers("springs of contacts", rolling.iter().chain(spring.iter()).flatten())?;
        numbers("loads and overlaps of contacts", load.iter().chain(largest.iter()))?;
        let mut taken: Vec<[u32; 2]> = Vec::with_capacity(n);
        for (s, &[i, j]) in ends.iter().enumerate() {
            if i == FREE && j == FREE {
                continue;
            }
            below(format_args!("contact {s} names grain"), i, ids.len())?;
            below(format_args!("contact {s} names"), j, second)?;
            ensure(!grains || ids[i as usize] < ids[j as usize], || format!("the ends of contact {s} are not in their order"))?;
            taken.push([i, j]);
        }
        let used = taken.len();
        taken.sort_unstable();
        taken.dedup();
        ensure(taken.len() == used, || "a contact stands twice".into())?;
        let mut spare = free.clone();
        spare.sort_unstable();
        spare.dedup();
        let all = spare.len() == free.len() && spare.len() == n - used;
        let right = all
            && spare.iter().all(|s| ends.get(*s as usize) == Some(&[FREE, FREE]) && touch[*s as usize] == ContactForce::default());
        ensure(right, || "the list of free places for contacts is not that of the free places".into())
    }

    /// Number of slots, free ones included.
    pub fn slots(&self) -> usize {
        self.ends.len()
    }

    /// Sorts the slots: the new slot k is the old slot `order[k]`, its ends replaced by `renumber` of them. Slots not listed are dropped.
    pub fn permute(&mut self, order: &[u32], renumber: impl Fn([u32; 2]) -> [u32; 2]) {
        self.ends = order.iter().map(|&s| renumber(self.ends[s as usize])).collect();
        self.touch = order.iter().map(|&s| self.touch[s as usize]).collect();
        every_column!(self.permute(order));
        self.free.clear();
    }

    /// Memory reserved, bytes.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_the_last_slots_fill_the_free_ones() {
        let mut pairs = Pairs::new(Kept { load: true, ..Kept::default() });
        for k in 0..6 {
            pairs.add(k, k + 1);
            (pairs.touch[k as usize].overlap, pairs.load[k as usize]) = (f64::from(k), f64::from(10 * k));
        }
        for slot in [1, 5, 3] {
            pairs.remove(slot);
        }
        let mut moved = Vec::new();
        pairs.close_gaps(|slot, ends| moved.push((slot, ends)));
        assert_eq!(moved, [(3, [4, 5]), (1, [4, 5])]);
        assert_eq!(pairs.ends, [[0, 1], [4, 5], [2, 3]]);
        assert_eq!(pairs.touch.iter().map(|t| t.overlap).collect::<Vec<_>>(), [0.0, 4.0, 2.0]);
        assert_eq!((pairs.load.to_vec(), pairs.work.len()), (vec![0.0, 40.0, 20.0], 0));
        assert_eq!(pairs.check(&[0, 1, 2, 3, 4, 5], 6, true, pairs.kept()), Ok(()));
        assert_eq!(pairs.add(0, 2), 3, "a new slot, as none is free");
    }
}
