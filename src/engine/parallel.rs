//! Parts of a step on several threads. Threads of rayon soon fall asleep where they find nothing to do, and to wake one costs as much as the forces of a thousand
//! contacts: here a thread that waits looks for other work, and stays awake.
//!
//! What two jobs share goes from one processor core to the other, which costs two to seven times as much as what stays (docs/validation/speed.md). Where a loop
//! over the same data is cut at the same place in every part of a step, the thread that runs the step mostly gets the first half of it, and another the second.

use crate::math::real::MOST_LANES;
use rayon::Yield;
use std::sync::atomic::{AtomicBool, Ordering};

/// Whether `items` are too few for more than one thread, at `task` items per parallel task: up to one and a half tasks.
pub fn few(items: usize, task: usize) -> bool {
    2 * items <= 3 * task || rayon::current_num_threads() == 1
}

/// Where to cut `items` in two, so that the first half fills the lanes of a SIMD register ([`MOST_LANES`]).
pub fn middle(items: usize) -> usize {
    items.div_ceil(2).next_multiple_of(MOST_LANES).min(items)
}

/// Does the job `here` on this thread, and at the same time the job `there` on another that is free, or after it.
pub fn join(here: impl FnOnce() + Send, there: impl FnOnce() + Send) {
    let done = AtomicBool::new(false);
    let here = || {
        here();
        help_until(&done);
    };
    let there = || {
        let _ends = Ends(&done);
        there();
    };
    rayon::join(here, there);
}

/// Does a job on this thread, while another one stays awake and helps where the job has work for it.
pub fn awake(job: impl FnOnce() + Send) {
    let done = AtomicBool::new(false);
    let job = || {
        let _ends = Ends(&done);
        job();
    };
    rayon::join(job, || help_until(&done));
}

/// How often a waiting thread looks for work in vain, some tenths of a millisecond, before it leaves the waiting to rayon. Without an end two steps that share
/// their threads could wait for each other.
const LOOKS: u32 = 4096;
/// After how many looks in vain another process may have the processor core.
const PATIENCE: u32 = 64;

/// Does what other threads leave to be done, until `done`.
fn help_until(done: &AtomicBool) {
    let mut looks = 0;
    while looks < LOOKS && !done.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(Yield::Executed) {
            looks = 0;
            continue;
        }
        looks += 1;
        if looks % PATIENCE == 0 { std::thread::yield_now() } else { std::hint::spin_loop() }
    }
}

/// Says that a job has ended, even if it ended by a panic.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU64;

    fn pool(threads: usize) -> rayon::ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
    }

    /// Adds the numbers of a range, halved down to single numbers.
    fn add(sum: &AtomicU64, from: u64, to: u64) {
        if to - from == 1 {
            sum.fetch_add(from, Ordering::Relaxed);
            return;
        }
        let half = from.midpoint(to);
        join(|| add(sum, from, half), || add(sum, half, to));
    }

    /// Every part of nested jobs is done once, on one thread, on two and on more than the machine has, and by several callers that share their threads.
    #[test]
    fn every_part_is_done_once() {
        for threads in [1, 2, 7] {
            let pool = pool(threads);
            std::thread::scope(|scope| {
                for _ in 0..3 {
                    scope.spawn(|| {
                        for _ in 0..50 {
                            let sum = AtomicU64::new(0);
                            pool.install(|| awake(|| awake(|| add(&sum, 0, 300))));
                            assert_eq!(sum.into_inner(), 299 * 300 / 2);
                        }
                    });
                }
            });
        }
    }

    #[test]
    fn a_panic_keeps_no_thread_waiting() {
        let pool = pool(2);
        let panics = |job: &(dyn Fn() + Sync)| {
            let caught = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| pool.install(job)));
            assert!(caught.is_err());
        };
        panics(&|| awake(|| panic!("here")));
        panics(&|| join(|| panic!("here"), || ()));
        panics(&|| join(|| (), || panic!("there")));
    }

    #[test]
    fn the_middle_fills_the_lanes() {
        assert_eq!([0, 1, 8, 9, 16, 17, 100].map(middle), [0, 1, 8, 8, 8, 16, 56]);
    }
}
