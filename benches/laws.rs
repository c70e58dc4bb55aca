//! One update of a law at a point: elastic, yielding, and with a strength that changes.

use comminute::mpm::law::{DruckerPrager, Evolution, InternalVariables, Law, Parameters, Sym};
use comminute::mpm::rotate_jaumann;
use comminute::scene;
use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::Path;

const PRESSED: Sym = [-5e4, -5e4, -5e4, 0.0, 0.0, 0.0];

fn fines() -> Law {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("materials/li2023_fines.toml");
    scene::continuum(&path, &[]).unwrap_or_else(|e| panic!("{e}")).law
}

/// The same with a friction angle that stays.
fn constant(law: &Law) -> Law {
    let Law::DruckerPrager(law) = law else { panic!("the law of the fines") };
    Law::DruckerPrager(DruckerPrager::new(Parameters { friction: Evolution::Constant(0.5), ..*law.parameters() }))
}

/// A state at yield: the law strained until it has this much plastic strain.
fn yielding(law: &Law, plastic: f64) -> (Sym, InternalVariables) {
    let mut state = (PRESSED, InternalVariables::default());
    while state.1.plastic < plastic {
        state = law.update(state.0, SHEARED, state.1);
    }
    state
}

const SHEARED: Sym = [4e-6, 4e-6, -1e-5, 1e-6, -2e-6, 5e-7];
const SWELLING: Sym = [1e-6, 1e-6, 1e-6, 1e-7, 0.0, 0.0];

fn laws(c: &mut Criterion) {
    let mut group = c.benchmark_group("one point");
    let changing = fines();
    let steady = constant(&changing);
    let elastic = Law::Elastic(changing.elastic());
    let of = |plastic: f64| yielding(&changing, plastic);
    let cases = [
        ("linear elastic", &elastic, (PRESSED, InternalVariables::default()), SHEARED),
        ("Drucker-Prager, elastic point", &steady, (PRESSED, InternalVariables::default()), SHEARED),
        ("Drucker-Prager, yielding", &steady, yielding(&steady, 1e-3), SHEARED),
        ("Drucker-Prager, apex", &steady, ([0.0; 6], InternalVariables::default()), SWELLING),
        ("eq. 43, elastic point", &changing, (PRESSED, InternalVariables::default()), SHEARED),
        ("eq. 43, yielding, hardening", &changing, of(0.01), SHEARED),
        ("eq. 43, yielding, softening", &changing, of(0.05), SHEARED),
        ("eq. 43, yielding, residual", &changing, of(0.9), SHEARED),
    ];
    for (name, law, (stress, memory), dstrain) in cases {
        group.bench_function(name, |b| {
            b.iter(|| law.update(black_box(stress), black_box(dstrain), black_box(memory)));
        });
    }
    group.bench_function("rotation", |b| b.iter(|| rotate_jaumann(black_box(PRESSED), black_box([1e-5, -2e-5, 3e-5]))));
}

criterion_group!(benches, laws);
criterion_main!(benches);
