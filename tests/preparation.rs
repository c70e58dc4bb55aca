//! Preparation of specimens that are hard to make.

mod common;

use comminute::model::Model;
use comminute::rig::preparation::{Preparation, porosity};
use comminute::step::Work;
use common::*;

/// 160 grains, as dense as asked and as exact.
fn small(porosity: f64, tolerance: f64, seed: u32) -> Model {
    let sets = [
        format!("specimen.porosity={porosity}"),
        format!("preparation.porosity_tolerance={tolerance}"),
        "preparation.growth_friction=0.4".into(),
        format!("seed.packing={seed}"),
    ];
    model(&oedometer_text(160, 8.0, ""), &sets)
}

/// Without its retry this one ends 0.3 % too dense.
#[test]
fn a_pressing_that_was_too_strong_is_taken_back() {
    let (state, _) = prepare(&small(0.444, 0.003, 5), |_, _| ());
    assert!((porosity(&state) / 0.444 - 1.0).abs() <= 0.003, "{}", porosity(&state));
}

#[test]
fn a_porosity_out_of_reach_is_told_as_such() {
    let model = small(0.42, 0.004, 17);
    let Some(rig) = model.rig.specimen() else { panic!("a specimen") };
    let (mut preparation, mut state) = Preparation::start(&model, rig);
    let mut work = Work::new(&model, &mut state);
    let error = loop {
        match preparation.advance(&model, rig, &mut state, &mut work) {
            Ok(ready) => assert!(!ready, "prepared at {}", porosity(&state)),
            Err(e) => break e.to_string(),
        }
    };
    assert!(error.contains("cannot make so few grains as dense as asked") && error.contains("target 0.4200"), "{error}");
}
