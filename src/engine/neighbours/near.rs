//! Listed pairs of grains that do not touch. Only their two ends are stored, as in a crushed assembly they are many times more than the contacts.

use crate::contact::pairs::FREE;
use crate::contact::sweep::difference;
use crate::math::vector::dot;
use crate::parallel::{few, join, middle};
use rayon::slice::ParallelSliceMut;

/// Listed pairs that do not touch, each in a slot.
#[derive(Default)]
pub struct Near {
    /// Indices of both grains, the one with the lower identity first; `FREE` in slots without a pair.
    ends: Vec<[u32; 2]>,
    /// Of each slot: 1 if the pair touches now.
    met: Vec<u8>,
    /// Slots that can be used again.
    free: Vec<u32>,
}

impl Near {
    /// Adds a pair; returns its slot.
    pub fn add(&mut self, first: u32, second: u32) -> u32 {
        if let Some(slot) = self.free.pop() {
            self.ends[slot as usize] = [first, second];
            return slot;
        }
        self.ends.push([first, second]);
        self.met.push(0);
        self.ends.len() as u32 - 1
    }

    /// Removes the pair in a slot.
    pub fn remove(&mut self, slot: usize) {
        self.ends[slot] = [FREE, FREE];
        self.free.push(slot as u32);
    }

    /// Indices of the two grains of the pair in a slot.
    pub fn ends(&self, slot: usize) -> [u32; 2] {
        self.ends[slot]
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.ends.len() - self.free.len()
    }

    /// All pairs: slot and indices of the grains.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, [u32; 2])> + Clone + '_ {
        self.ends.iter().copied().enumerate().filter(|(_, e)| e[0] != FREE)
    }

    /// Both halves of the slots.
    pub fn halves(&mut self) -> (Half<'_>, Half<'_>) {
        Half { ends: &self.ends, met: &mut self.met }.halves()
    }

    /// Writes the slots marked by [`Half::mark_touching`] into `out`.
    pub fn met(&self, out: &mut Vec<u32>) {
        out.clear();
        super::flagged(&self.met, |k, _| out.push(k));
    }

    /// Gives the grains new indices (`place[old index]`) and sorts the pairs in the order in which a loop over grains first comes to them.
    pub fn permute(&mut self, place: &[u32]) {
        let mut keyed: Vec<(u32, u32, [u32; 2])> = self
            .pairs()
            .map(|(_, e)| {
                let [a, b] = e.map(|i| place[i as usize]);
                (a.min(b), a.max(b), [a, b])
            })
            .collect();
        keyed.par_sort_unstable();
        self.ends.clear();
        self.ends.extend(keyed.iter().map(|k| k.2));
        self.met.clear();
        self.met.resize(self.ends.len(), 0);
        self.free.clear();
    }

    /// Memory in use, bytes.
    pub fn bytes(&self) -> usize {
        self.ends.capacity() * 8 + self.met.capacity() + self.free.capacity() * 4
    }
}

/// Listed pairs that do not touch, in a range of slots.
pub struct Half<'a> {
    ends: &'a [[u32; 2]],
    met: &'a mut [u8],
}

impl Half<'_> {
    fn halves(self) -> (Self, Self) {
        let at = middle(self.ends.len());
        let (e0, e1) = self.ends.split_at(at);
        let (m0, m1) = self.met.split_at_mut(at);
        (Half { ends: e0, met: m0 }, Half { ends: e1, met: m1 })
    }

    /// Marks the pairs that touch at the positions `pos` (centre and radius, m); up to `task` pairs make one parallel task. Nothing else is read, so this may
    /// run in parallel with the computation of contact forces.
    pub fn mark_touching(self, pos: &[[f64; 4]], task: usize) {
        if few(self.ends.len(), task) {
            return mark(pos, self.ends, self.met);
        }
        let (left, right) = self.halves();
        join(|| left.mark_touching(pos, task), || right.mark_touching(pos, task));
    }
}

/// Sets `met` to 1 for pairs whose spheres overlap, else to 0.
fn mark(pos: &[[f64; 4]], ends: &[[u32; 2]], met: &mut [u8]) {
    for (&[i, j], met) in ends.iter().zip(met) {
        if i == FREE {
            *met = 0;
            continue;
        }
        let (p, q) = (pos[i as usize], pos[j as usize]);
        let d = difference(p, q);
        let reach = p[3] + q[3];
        *met = u8::from(dot(d, d) < reach * reach);
    }
}
