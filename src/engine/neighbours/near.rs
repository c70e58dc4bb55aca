//! Pairs that are near enough to touch soon but do not touch: their ends and nothing else, since in a crushed assembly they outnumber the
//! contacts by far.

use crate::contact::chunk::few;
use crate::contact::pairs::FREE;
use crate::contact::sweep::difference;
use crate::math::vector::dot;
use rayon::prelude::*;

#[derive(Default)]
pub struct Near {
    /// Indices of both ends, the one with the lower id first; slots are re-used.
    ends: Vec<[u32; 2]>,
    met: Vec<u8>,
    free: Vec<u32>,
}

impl Near {
    pub fn add(&mut self, first: u32, second: u32) -> u32 {
        if let Some(slot) = self.free.pop() {
            self.ends[slot as usize] = [first, second];
            return slot;
        }
        self.ends.push([first, second]);
        self.met.push(0);
        self.ends.len() as u32 - 1
    }

    pub fn remove(&mut self, slot: usize) {
        self.ends[slot] = [FREE, FREE];
        self.free.push(slot as u32);
    }

    pub fn ends(&self, slot: usize) -> [u32; 2] {
        self.ends[slot]
    }

    /// Number of pairs.
    pub fn len(&self) -> usize {
        self.ends.len() - self.free.len()
    }

    /// All pairs, with their slots.
    pub fn pairs(&self) -> impl Iterator<Item = (usize, [u32; 2])> + Clone + '_ {
        self.ends.iter().copied().enumerate().filter(|(_, e)| e[0] != FREE)
    }

    /// Marks the pairs that touch now, so many to a parallel task.
    pub fn activate_contacts(&mut self, pos: &[[f64; 4]], task: usize) {
        if few(self.ends.len(), task) {
            return mark(pos, &self.ends, &mut self.met);
        }
        self.ends.par_chunks(task).zip(self.met.par_chunks_mut(task)).for_each(|(ends, met)| mark(pos, ends, met));
    }

    /// Slots marked by [`Self::meet`].
    pub fn met(&self, out: &mut Vec<u32>) {
        out.clear();
        super::flagged(&self.met, |k, _| out.push(k));
    }

    /// Renumbers the grains (`place` by old index) and puts pairs in the order in which a pass over grains first meets them.
    pub fn permute(&mut self, place: &[u32]) {
        let mut keyed: Vec<(u32, u32, [u32; 2])> = self
            .pairs()
            .map(|(_, e)| {
                let [a, b] = e.map(|i| place[i as usize]);
                (a.min(b), a.max(b), [a, b])
            })
            .collect();
        keyed.sort_unstable();
        self.ends.clear();
        self.ends.extend(keyed.iter().map(|k| k.2));
        self.met.clear();
        self.met.resize(self.ends.len(), 0);
        self.free.clear();
    }

    pub fn bytes(&self) -> usize {
        self.ends.capacity() * 8 + self.met.capacity() + self.free.capacity() * 4
    }
}

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
