//! Limits of the machine, with which the speed of the stages of a step is compared (a roofline).

use engine::math::real::{self, Lanes};
use pulp::{Simd, WithSimd};
use rayon::prelude::*;
use std::hint::black_box;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

/// Measured limits of a number of threads together.
#[derive(Clone, Copy, Debug)]
pub struct Machine {
    /// Number of threads.
    pub threads: usize,
    /// Bytes per second read and written in a triad a = b + s c far larger than the caches.
    pub bandwidth: f64,
    /// Multiplications and additions of f64 per second, not fused, in the widest registers in use.
    pub flops: f64,
}

/// Numbers in each array of the triad: 3 × 64 MB.
const TRIAD: usize = 8 << 20;
/// Number of rounds; the best one counts.
const ROUNDS: usize = 5;
/// How often a thread looks for what the other sends in a round trip, some milliseconds: all others may be at work elsewhere.
const PATIENCE: u32 = 1 << 20;
/// Number of multiply-adds in one chain.
const CHAIN: usize = 1 << 21;

impl Machine {
    /// Measures on the calling thread's pool.
    pub fn measure() -> Machine {
        Machine { threads: rayon::current_num_threads(), bandwidth: bandwidth(), flops: flops() }
    }

    /// For a stage that does `work` per grain in `seconds` per grain: operations per second over
    /// the machine's limit, and bytes per second over its bandwidth. The second share is above 1
    /// where caches hold the packing.
    pub fn shares(&self, work: Demand, seconds: f64) -> [f64; 2] {
        [work.operations / seconds / self.flops, work.bytes / seconds / self.bandwidth]
    }
}

/// What a stage of a step has to do per grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Additions, multiplications, divisions and roots, each counted once.
    pub operations: f64,
    /// Bytes read and written, each cache line counted once.
    pub bytes: f64,
}

/// Operations of one contact (Hertz, without ledger) in `contact::force`, and of one end of a
/// contact in the pass over grains.
const CONTACT: f64 = 145.0;
const END: f64 = 30.0;
/// Operations of one grain in the pass over grains.
const GRAIN: f64 = 60.0;

impl Demand {
    /// Demand of the stage of contacts, with so many contacts per grain.
    pub fn contacts(per_grain: f64) -> Demand {
        // per contact: its two ends, and its data read and written; per grain: position, velocity,
        // spin
        Demand { operations: CONTACT * per_grain, bytes: (8.0 + 2.0 * 64.0) * per_grain + 3.0 * 32.0 }
    }

    /// Demand of the pass over grains.
    pub fn grains(contacts_per_grain: f64) -> Demand {
        // per contact: its data, and a link at each end; per grain: position, velocity, spin read
        // and written, reference, place of the links
        let bytes = (64.0 + 2.0 * 4.0) * contacts_per_grain + 6.0 * 32.0 + 16.0 + 12.0;
        Demand { operations: 2.0 * END * contacts_per_grain + GRAIN, bytes }
    }
}

fn bandwidth() -> f64 {
    let (b, c) = (vec![1.0f64; TRIAD], vec![2.0f64; TRIAD]);
    let mut a = vec![0.0f64; TRIAD];
    let part = TRIAD / rayon::current_num_threads();
    let best = (0..ROUNDS).map(|_| {
        let since = Instant::now();
        a.par_chunks_mut(part).zip(b.par_chunks(part)).zip(c.par_chunks(part)).for_each(|((a, b), c)| {
            for ((a, b), c) in a.iter_mut().zip(b).zip(c) {
                *a = b + 3.0 * c;
            }
        });
        black_box(&a);
        since.elapsed().as_secs_f64()
    });
    // four arrays: a cache line of `a` is read before it is written
    (4 * TRIAD * size_of::<f64>()) as f64 / best.fold(f64::INFINITY, f64::min)
}

/// Time for a number to go from one thread of the calling thread's pool to another and back, s; the shortest of some rounds. `None` on one thread.
/// Where two threads share a cache it is about 50 ns, else several times as long, and a virtual machine may be moved from one to the other at any time.
pub fn round_trip() -> Option<f64> {
    const TRIPS: u32 = 2000;
    if rayon::current_num_threads() < 2 {
        return None;
    }
    let round = || {
        // odd: sent by the first thread; even: sent back
        let number = AtomicU32::new(0);
        let pass = |first: u32| {
            for trip in 0..TRIPS {
                let mut looks = 0;
                while number.load(Ordering::Acquire) != 2 * trip + first {
                    looks += 1;
                    if looks > PATIENCE {
                        return None;
                    }
                    std::hint::spin_loop();
                }
                number.store(2 * trip + first + 1, Ordering::Release);
            }
            Some(())
        };
        let since = Instant::now();
        let (here, there) = rayon::join(|| pass(0), || pass(1));
        here.and(there).map(|()| since.elapsed().as_secs_f64() / f64::from(TRIPS))
    };
    (0..ROUNDS).filter_map(|_| round()).reduce(f64::min)
}

fn flops() -> f64 {
    let threads = rayon::current_num_threads();
    let best = (0..ROUNDS).map(|_| {
        let since = Instant::now();
        let operations: usize = (0..threads).into_par_iter().map(|_| real::arch().dispatch(Chains)).sum();
        operations as f64 / since.elapsed().as_secs_f64()
    });
    best.fold(0.0, f64::max)
}

/// Independent chains of multiplications and additions, enough of them to hide their latency;
/// returns the number of operations.
struct Chains;

impl WithSimd for Chains {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> usize {
        const CHAINS: usize = 12;
        let (factor, term) = (Lanes::constants(simd, 0.999_999), Lanes::constants(simd, 1e-6));
        let mut x = [Lanes::constants(simd, black_box(1.0)); CHAINS];
        for _ in 0..CHAIN {
            for x in &mut x {
                *x = *x * factor + term;
            }
        }
        for x in x {
            black_box(x.first());
        }
        2 * CHAIN * CHAINS * Lanes::<S>::COUNT
    }
}
