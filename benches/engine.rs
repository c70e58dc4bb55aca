//! The hot loops by themselves, on the bench's packing of 5 000 grains (made on first use, kept in `runs/bench`).

use comminute::bench::{self, Case, Packing};
use comminute::contact::ContactLaw;
use comminute::dem;
use comminute::dem::event;
use comminute::dem::{State, Workspace, gather};
use comminute::model::Model;
use comminute::mpm::Transfer;
use comminute::neighbours::adjacency::Entry;
use comminute::neighbours::{Neighbours, Pools};
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use std::convert::Infallible;
use std::hint::black_box;
use std::path::Path;

const GRAINS: usize = 5000;
/// A step so small that nothing moves: the loops then see the same state each time.
const STILL: f64 = 1e-18;

fn packing() -> Packing {
    bench::packing(Case::Uniform, GRAINS, Path::new("runs/bench"), |text| eprintln!("{text}")).expect("the packing can be made")
}

/// A state after some steps.
fn ready(model: &Model, packing: &Packing) -> (State, Workspace) {
    let (mut state, mut work) = bench::start(model, packing, false);
    for _ in 0..500 {
        let Ok(()) = dem::step(&model.physics, &mut state, &mut work, |_, _| Ok::<(), Infallible>(()));
    }
    (state, work)
}

fn loops(c: &mut Criterion) {
    let packing = packing();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let mut group = c.benchmark_group("5000 grains, 1 thread");
    group.throughput(Throughput::Elements(GRAINS as u64));

    for (name, law) in [("hertz", ContactLaw::Hertz), ("hertz_viscous", ContactLaw::HertzViscous), ("linear", ContactLaw::Linear)] {
        let model = bench::model(Case::Uniform, GRAINS, law, bench::SKIN);
        let (mut state, mut work) = ready(&model, &packing);
        state.dt = STILL;
        group.bench_function(format!("contacts, {name}"), |b| {
            one.install(|| b.iter(|| dem::contacts(&model.physics, &mut state, &mut work)));
        });
    }

    let model = bench::model(Case::Uniform, GRAINS, ContactLaw::Hertz, bench::SKIN);
    let (state, mut work) = ready(&model, &packing);
    let mut still = state.clone();
    still.dt = STILL;
    group.bench_function("gather and advance", |b| {
        one.install(|| b.iter(|| gather::advance(&model.physics, &mut still, &mut work)));
    });
    still.crushing = true;
    group.bench_function("gather and advance, judging every grain", |b| {
        one.install(|| b.iter(|| gather::advance(&model.physics, &mut still, &mut work)));
    });
    let mut moving = state.clone();
    group.bench_function("whole step", |b| {
        one.install(|| {
            b.iter(|| {
                let Ok(()) = dem::step(&model.physics, &mut moving, &mut work, |_, _| Ok::<(), Infallible>(()));
            });
        });
    });
    group.finish();
}

fn neighbours(c: &mut Criterion) {
    let packing = packing();
    let model = bench::model(Case::Uniform, GRAINS, ContactLaw::Hertz, bench::SKIN);
    let (mut state, mut work) = ready(&model, &packing);
    let mut group = c.benchmark_group("neighbours, 5000 grains");
    let mut i = 0;
    group.bench_function("search of one grain", |b| {
        b.iter(|| {
            i = (i + 617) % GRAINS;
            let State { grains, wall_pairs, .. } = &mut state;
            work.neighbours.refresh(i, grains, wall_pairs);
        });
    });
    group.bench_function("lists anew", |b| {
        b.iter(|| {
            let State { grains, walls, pairs, wall_pairs, .. } = &mut state;
            black_box(Neighbours::new(grains, walls, &mut Pools { pairs, wall_pairs }, bench::SKIN))
        });
    });
    group.bench_function("memory order", |b| b.iter(|| dem::reorder(&mut state, &mut work)));
    group.finish();
}

fn crushing(c: &mut Criterion) {
    let packing = packing();
    let model = bench::breakable(&bench::model(Case::Uniform, GRAINS, ContactLaw::Hertz, bench::SKIN)).expect("a pattern of 14");
    let (state, _) = ready(&model, &packing);
    let mut i = 0;
    c.bench_function("one grain into 14, 5000 grains", |b| {
        b.iter_batched(
            || {
                let mut state = state.clone();
                let mut work = Workspace::new(&model.physics, &mut state);
                // one before, so that the arrays have room
                let mut out = Vec::with_capacity(2);
                let mut next = || loop {
                    i = (i + 617) % GRAINS;
                    let loaded = |e: Entry| !e.is_wall() && state.pairs.touch[e.slot()].overlap > 0.0;
                    if work.neighbours.contacts.of(i).any(loaded) {
                        return i as u32;
                    }
                };
                let (first, second) = (next(), next());
                event::break_grains(&model.physics, &mut state, &mut work.neighbours, &work.table, &[], &[first], &mut out);
                (state, work, second, out)
            },
            |(mut state, mut work, i, mut out)| {
                event::break_grains(&model.physics, &mut state, &mut work.neighbours, &work.table, &[], &[i], &mut out);
                (state, work, out)
            },
            BatchSize::PerIteration,
        );
    });
}

fn continuum(c: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
    let mut group = c.benchmark_group("64000 material points, 1 thread");
    for (name, transfer) in [("FLIP", Transfer::Blend { pic: 0.0 }), ("APIC", Transfer::Affine)] {
        let (mut continuum, dt) = bench::mpm_case(64_000, transfer).expect("the case is sound");
        group.throughput(Throughput::Elements(continuum.points().len() as u64));
        group.bench_function(format!("whole step, {name}"), |b| {
            one.install(|| b.iter(|| continuum.step(dt).expect("no point is lost")));
        });
    }
    group.finish();
}

criterion_group! {
    name = engine;
    config = Criterion::default().sample_size(30).warm_up_time(std::time::Duration::from_secs(1)).measurement_time(std::time::Duration::from_secs(3));
    targets = loops, neighbours, crushing, continuum
}
criterion_main!(engine);
