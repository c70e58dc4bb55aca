//! The storage of contacts cut into chunks that threads work on, and the reading and writing of one contact, or of one in each SIMD lane.

use super::force::ContactHistory;
use super::law::Law;
use super::pairs::{ContactForce, Pairs};
use crate::math::real::{Lanes, Real};
use crate::parallel::{few, join, middle};
use pulp::Simd;

/// Contacts per parallel task.
pub const TASK: usize = 256;

/// A range of slots of [`Pairs`]: this range of each of its arrays. Columns that the run does not keep are empty.
pub struct Chunk<'a> {
    /// [`Pairs::ends`]
    pub ends: &'a [[u32; 2]],
    /// [`Pairs::touch`]
    pub touch: &'a mut [ContactForce],
    /// [`Pairs::work`]
    pub work: &'a mut [[f64; 4]],
    rolling: &'a mut [[f64; 3]],
    spring: &'a mut [[f64; 3]],
    load: &'a mut [f64],
    largest: &'a mut [f64],
}

impl<'a> Chunk<'a> {
    /// All slots.
    pub fn all(p: &'a mut Pairs) -> Chunk<'a> {
        Chunk {
            ends: &p.ends,
            touch: &mut p.touch,
            work: &mut p.work,
            rolling: &mut p.rolling,
            spring: &mut p.spring,
            load: &mut p.load,
            largest: &mut p.largest,
        }
    }

    /// One slot.
    pub fn one(p: &'a mut Pairs, slot: u32) -> Chunk<'a> {
        let (_, from) = Chunk::all(p).halves(slot as usize);
        from.halves(1).0
    }

    /// The slots before `at`, and the slots from `at` on.
    pub fn halves(self, at: usize) -> (Chunk<'a>, Chunk<'a>) {
        fn cut<T>(v: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
            v.split_at_mut(at.min(v.len()))
        }
        let (e0, e1) = self.ends.split_at(at);
        let (t0, t1) = cut(self.touch, at);
        let (w0, w1) = cut(self.work, at);
        let (r0, r1) = cut(self.rolling, at);
        let (s0, s1) = cut(self.spring, at);
        let (l0, l1) = cut(self.load, at);
        let (o0, o1) = cut(self.largest, at);
        (
            Chunk { ends: e0, touch: t0, work: w0, rolling: r0, spring: s0, load: l0, largest: o0 },
            Chunk { ends: e1, touch: t1, work: w1, rolling: r1, spring: s1, load: l1, largest: o1 },
        )
    }

    /// Whether the run keeps works. Without slots it makes no difference.
    pub fn keeps_works(&self) -> bool {
        !self.work.is_empty()
    }

    /// Whether the run keeps weighted loads. Without slots it makes no difference.
    pub fn keeps_loads(&self) -> bool {
        !self.load.is_empty()
    }

    /// The history of the contact in slot `s` under the law `L`. `EXTRA`: the run may have rolling moments or weighted loads.
    #[inline(always)]
    pub fn read<L: Law, const EXTRA: bool>(&self, s: usize) -> ContactHistory {
        ContactHistory {
            touch: self.touch[s],
            spring: if L::VISCOUS { Some(self.spring[s]) } else { None },
            rolling: if EXTRA { self.rolling.get(s).copied() } else { None },
            load: if EXTRA { self.load.get(s).copied() } else { None },
            largest: if L::PLASTIC { Some(self.largest[s]) } else { None },
            work: None,
        }
    }

    /// Writes the history of the contact in slot `s`; what it does not hold stays as it is.
    #[inline(always)]
    pub fn write(&mut self, s: usize, m: ContactHistory) {
        self.touch[s] = m.touch;
        for (column, value) in [(&mut *self.spring, m.spring), (&mut *self.rolling, m.rolling)] {
            if let Some(value) = value {
                column[s] = value;
            }
        }
        if let Some([path, slip, viscous]) = m.work {
            self.work[s] = [path, slip, viscous, 0.0];
        }
        if let Some(load) = m.load {
            self.load[s] = load;
        }
        if let Some(largest) = m.largest {
            self.largest[s] = largest;
        }
    }

    /// [`Chunk::read`] of several slots at once: lane k takes the slot `slot(k)`.
    #[inline(always)]
    pub fn read_lanes<S: Simd, L: Law, const EXTRA: bool>(
        &self,
        simd: S,
        slot: impl Fn(usize) -> usize,
    ) -> ContactHistory<Lanes<S>> {
        let [x, y, z, normal_force] = Lanes::columns(simd, |k| self.touch[slot(k)].first());
        let [nx, ny, nz, overlap] = Lanes::columns(simd, |k| self.touch[slot(k)].second());
        let vectors = |column: &[[f64; 3]]| {
            let [x, y, z, _] = Lanes::columns(simd, |k| {
                let [x, y, z] = column[slot(k)];
                [x, y, z, 0.0]
            });
            [x, y, z]
        };
        ContactHistory {
            touch: ContactForce { tangential: [x, y, z], normal_force, normal: [nx, ny, nz], overlap },
            spring: if L::VISCOUS { Some(vectors(self.spring)) } else { None },
            rolling: if EXTRA && !self.rolling.is_empty() { Some(vectors(self.rolling)) } else { None },
            // the load of the last step is never read; the value only says that the run keeps loads
            load: if EXTRA && !self.load.is_empty() { Some(overlap) } else { None },
            largest: if L::PLASTIC { Some(Lanes::columns(simd, |k| [self.largest[slot(k)]; 4])[0]) } else { None },
            work: None,
        }
    }

    /// [`Chunk::write`] of several slots at once: lane k goes to the slot `slot(k)`.
    #[inline(always)]
    pub fn write_lanes<S: Simd>(&mut self, simd: S, slot: impl Fn(usize) -> usize, m: &ContactHistory<Lanes<S>>) {
        let ContactForce { tangential: [x, y, z], normal_force, normal: [nx, ny, nz], overlap } = m.touch;
        Lanes::rows(simd, [x, y, z, normal_force], |k, row| self.touch[slot(k)].set_first(row));
        Lanes::rows(simd, [nx, ny, nz, overlap], |k, row| self.touch[slot(k)].set_second(row));
        for (column, value) in [(&mut *self.spring, m.spring), (&mut *self.rolling, m.rolling)] {
            if let Some([x, y, z]) = value {
                Lanes::rows(simd, [x, y, z, x], |k, [x, y, z, _]| column[slot(k)] = [x, y, z]);
            }
        }
        if let Some([path, slip, viscous]) = m.work {
            Lanes::rows(simd, [path, slip, viscous, path.constant(0.0)], |k, row| self.work[slot(k)] = row);
        }
        if let Some(load) = m.load {
            Lanes::rows(simd, [load; 4], |k, [load, ..]| self.load[slot(k)] = load);
        }
        if let Some(largest) = m.largest {
            Lanes::rows(simd, [largest; 4], |k, [largest, ..]| self.largest[slot(k)] = largest);
        }
    }
}

/// Runs `body` on the slots, cut into chunks of at most `task` slots that run in parallel; on all at once in one thread where there are [`few`].
pub fn for_each_chunk(slots: Chunk<'_>, task: usize, body: impl Fn(Chunk<'_>) + Sync) {
    if few(slots.ends.len(), task) { body(slots) } else { split(slots, task, &body) }
}

/// Runs `body` on a range of slots: halves it until a part has at most `task` slots, and runs the halves in parallel.
fn split(part: Chunk<'_>, task: usize, body: &(impl Fn(Chunk<'_>) + Sync)) {
    let n = part.ends.len();
    if n <= task {
        return body(part);
    }
    let (left, right) = part.halves(middle(n));
    join(|| split(left, task, body), || split(right, task, body));
}

#[cfg(test)]
mod tests {
    use super::super::pairs::Kept;
    use super::*;
    use std::sync::Mutex;

    /// Sizes of the parts of a sweep over `n` slots by `threads` threads; each part marks its slots.
    fn parts(n: u32, threads: usize) -> (Vec<usize>, Vec<f64>) {
        let mut pairs = Pairs::new(Kept { load: true, ..Kept::default() });
        for k in 0..n {
            pairs.add(k, k + 1);
        }
        let sizes = Mutex::new(Vec::new());
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            for_each_chunk(Chunk::all(&mut pairs), 16, |part| {
                sizes.lock().expect("no panic").push(part.ends.len());
                for ((touch, load), [i, _]) in part.touch.iter_mut().zip(part.load).zip(part.ends) {
                    touch.overlap += 1.0 + f64::from(*i);
                    *load += touch.overlap;
                }
            });
        });
        assert!(pairs.touch.iter().zip(&*pairs.load).all(|(touch, load)| touch.overlap == *load));
        (sizes.into_inner().expect("no panic"), pairs.load.to_vec())
    }

    /// Every slot is computed once, in parts of at most a task where there are more than one and a half tasks and two threads, otherwise in one part.
    #[test]
    fn a_sweep_is_cut_into_tasks() {
        for (n, threads, whole) in [(1, 2, true), (24, 2, true), (25, 2, false), (100, 2, false), (100, 1, true)] {
            let (sizes, marks) = parts(n, threads);
            assert_eq!(marks, (1..=n).map(f64::from).collect::<Vec<_>>());
            assert_eq!(sizes.len() == 1, whole, "{n} {threads}");
            assert!(whole || sizes.iter().all(|size| *size <= 16) && sizes.iter().sum::<usize>() == n as usize, "{sizes:?}");
        }
    }

    #[test]
    fn a_slot_can_be_computed_alone() {
        let mut pairs = Pairs::new(Kept { load: true, ..Kept::default() });
        for k in 0..5 {
            pairs.add(k, k + 1);
        }
        let one = Chunk::one(&mut pairs, 3);
        assert_eq!((one.ends, one.touch.len(), one.load.len(), one.work.len()), (&[[3, 4]][..], 1, 1, 0));
    }
}
