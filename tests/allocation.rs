//! The step loop asks for no memory once it is warm: a quiet assembly, between and across looks at the stable step.

#![allow(unsafe_code)] // the allocator that counts

mod common;

use comminute::mpm::Transfer;
use common::*;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts requests while asked to.
struct Counting;

static REQUESTS: AtomicU64 = AtomicU64::new(0);

// SAFETY: hands everything to the system's allocator
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        REQUESTS.fetch_add(1, Ordering::Relaxed);
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// A pressed frictional oedometer without crushing, on its way up.
#[test]
fn a_quiet_step_allocates_nothing() {
    for (name, sets) in [
        ("hertz", vec![]),
        ("linear, no ledger", vec!["contact.law=linear", "records.energy=false"]),
        ("crushing watched", vec!["crushing.enabled=true", "material.strength.fixed_angle.sigma_lim0_MPa=1e5"]),
    ] {
        // a wide skin: no searches while it is watched
        let mut sets: Vec<String> = sets.into_iter().map(String::from).collect();
        sets.push("stepping.skin=0.5".into());
        let model = model(&oedometer_text(150, 100.0, ""), &sets);
        let (prepared, _) = prepare(&model, |_, _| ());
        let mut press = Press::new(model, &prepared);
        for _ in 0..1500 {
            press.step();
        }
        let before = REQUESTS.load(Ordering::Relaxed);
        for _ in 0..256 {
            press.step();
        }
        let requests = REQUESTS.load(Ordering::Relaxed) - before;
        // none per step; what is left is the rig's look at the platen's speed limit every 64
        println!("{name}: {requests} requests in 256 steps");
        assert!(requests <= 8, "{name}: {requests} requests in 256 steps");
    }
    shared_among_threads();
    a_continuum();
}

/// Material points that cross cells, on one thread and on two.
fn a_continuum() {
    for (threads, transfer) in [(1, Transfer::Blend { pic: 0.0 }), (2, Transfer::Affine)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        let requests = pool.install(|| {
            let (mut c, dt) = comminute::bench::mpm_case(8000, transfer).expect("a case");
            let mut step = || c.step(dt).expect("no point is lost");
            (0..100).for_each(|_| step());
            let before = REQUESTS.load(Ordering::Relaxed);
            (0..128).for_each(|_| step());
            REQUESTS.load(Ordering::Relaxed) - before
        });
        println!("continuum, {threads} threads: {requests} requests in 128 steps");
        assert!(requests <= 8, "continuum, {threads} threads: {requests} requests in 128 steps");
    }
}

/// Enough grains and contacts for several tasks per sweep.
fn shared_among_threads() {
    let stuff = Stuff { young: 1e8, poisson: 0.2, density: 2000.0, friction: 0.3, restitution: 1.0 };
    let balls: Vec<Ball> = (0..12 * 12 * 12)
        .map(|k| Ball { at: [k % 12, k / 12 % 12, k / 144].map(|c| 0.0199 * f64::from(c)), radius: 0.01, ..Ball::default() })
        .collect();
    let text = assembly_text("stepping.skin = 0.5\ndamping.local = 0.1", &stuff, &balls, &[]);
    let requests = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads").install(|| {
        let mut lab = Lab::new(&text);
        lab.steps(200);
        let before = REQUESTS.load(Ordering::Relaxed);
        lab.steps(256);
        REQUESTS.load(Ordering::Relaxed) - before
    });
    println!("two threads: {requests} requests in 256 steps");
    assert!(requests <= 8, "two threads: {requests} requests in 256 steps");
}
