//! Closed forms of linear elasticity.
use crate::common::*;
use comminute::mpm::{Dimension, ShapeFunctions, Transfer, Wall};
use std::f64::consts::PI;

/// Bar fixed at x = 0 and free at L, v = v0 sin(πx/2L): ω1 = (π/2L) √(E/ρ). L 25, E 100, ρ 1, v0 0.1: period 10 s, tip amplitude 0.159155 m.
#[test]
fn a_bar_vibrates_with_its_frequency_and_keeps_its_energy() {
    let mut s = settings(Dimension::PlaneStrain, 0.5, [60, 1, 1]);
    s.walls = [Wall::Symmetry, Wall::Open, Wall::Symmetry, Wall::Symmetry, Wall::Open, Wall::Open];
    let v0 = 0.1;
    let mode = |x: f64| (PI * x / 50.0).sin();
    let p = fill(&s, [[0.0; 3], [25.0, 0.5, 0.0]], 2, 1.0, |_| true, |[x, ..]| [v0 * mode(x), 0.0, 0.0]);
    let mut c = continuum(s, elastic(100.0, 0.0), p);
    let (dt, n) = (0.01, 2000);
    let start = c.totals().kinetic;
    let mut last = 0.0;
    let mut crossings = vec![];
    for k in 1..=n {
        c.step(dt).unwrap();
        let v = c.totals().momentum[0];
        if last > 0.0 && v <= 0.0 || last < 0.0 && v >= 0.0 {
            crossings.push((k as f64 - v / (v - last)) * dt);
        }
        last = v;
    }
    println!("{crossings:?}");
    let period = 2.0 * (crossings[3] - crossings[0]) / 3.0;
    let t = c.totals();
    println!(
        "period {period}, energy {} {} of {start}, sum {}",
        t.kinetic,
        c.stress_work(),
        (t.kinetic + c.stress_work()) / start - 1.0
    );
    let _ = (Transfer::Affine, ShapeFunctions::BSpline);
    assert!((period / 10.0 - 1.0).abs() < 0.01);
}
