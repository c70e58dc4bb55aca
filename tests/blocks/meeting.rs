//! Impacts of two bodies.

use crate::scene::{SMOOTH, Scene, cuboid};
use comminute::rig::continuum::{Engine, State};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A rock of eight corners in space as TOML.
pub fn rock(random: &mut ChaCha8Rng, at: [f64; 3], more: &str) -> String {
    let mut points = Vec::new();
    for k in 0..8 {
        for a in 0..3 {
            let side = if k >> a & 1 == 1 { 1.0 } else { -1.0 };
            points.push(side * random.random_range(20.0..40.0));
        }
    }
    format!("[[block]]\nshape = \"polyhedron\"\npoints_mm = {points:?}\nrounding_mm = 4.0\nposition_mm = {at:?}\n{more}\n")
}

/// Energies came back: each by the leapfrog's error, 1.1e-4 at most, 3e-5 in the mean.
pub fn come_back(changes: &[(f64, u64)]) {
    assert!(changes.len() > 30);
    let mean = changes.iter().map(|(change, _)| change).sum::<f64>() / changes.len() as f64;
    println!("mean {mean:e} most {:e}", changes.iter().map(|c| c.0.abs()).fold(0.0, f64::max));
    assert!(mean.abs() < 4e-5 && changes.iter().all(|(change, _)| change.abs() < 1.5e-4), "mean {mean:e}: {changes:?}");
}

/// Runs two bodies past each other in 150 stretches of `stretch` seconds, and checks their momenta. By what share of itself the energy has changed, if they met: then the
/// second has lost some of its `speed` along −x, m/s.
pub fn hit(seed: u64, bodies: &str, stretch: f64, speed: f64) -> Option<(f64, u64)> {
    let mut scene = Scene::new(&SMOOTH, [0.0; 3], bodies);
    let before = (scene.momenta(), scene.energy());
    let mut touched = false;
    for _ in 0..150 {
        scene.run(stretch).unwrap_or_else(|e| panic!("{seed}: {e}"));
        touched |= scene.block(1).velocity[0] > -0.998 * speed;
    }
    let after = (scene.momenta(), scene.energy());
    for (one, other) in before.0.as_flattened().iter().zip(after.0.as_flattened()) {
        assert!((one - other).abs() < 1e-12, "{seed}: {before:?} {after:?}");
    }
    touched.then_some((after.1 / before.1 - 1.0, seed))
}

/// A turn at random as TOML.
pub fn turned(random: &mut ChaCha8Rng) -> String {
    let mut one = |x: f64| random.random_range(-x..x);
    format!("axis = [{:?}, {:?}, {:?}]\nangle_deg = {:?}\n", one(1.0), one(1.0), one(1.0), one(180.0))
}

/// Two rocks hit each other, turned and aside at random: with corners, edges and faces. Momentum and angular momentum stay to rounding; energy comes back, as
/// forces between corners, edges and faces change without a jump.
#[test]
fn rocks_that_meet_keep_momenta_and_energy() {
    let rocks = |seed| {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let spin: [f64; 3] = std::array::from_fn(|_| random.random_range(-9.0..9.0));
        let aside: [f64; 2] = std::array::from_fn(|_| random.random_range(-25.0..25.0));
        let [first, second] = [turned(random), turned(random)];
        let bodies = rock(random, [0.0; 3], &(first + &format!("spin_rad_s = {spin:?}")))
            + &rock(random, [160.0, aside[0], aside[1]], &(second + "velocity_m_s = [-2.0, 0.0, 0.0]"));
        hit(seed, &bodies, 5e-4, 2.0)
    };
    come_back(&(0..40).filter_map(rocks).collect::<Vec<_>>());
}

/// The same for two boxes with edges as they come, also with steps that become twenty times shorter at first touch.
#[test]
fn boxes_that_meet_keep_momenta_and_energy() {
    let boxes = |seed, safety: f64| {
        let random = &mut ChaCha8Rng::seed_from_u64(100 + seed);
        let aside: [f64; 2] = std::array::from_fn(|_| random.random_range(-25.0..25.0));
        let bodies = format!("stepping.safety = {safety:?}\n")
            + &cuboid([60.0, 70.0, 80.0], [0.0; 3], &turned(random))
            + &cuboid([90.0, 50.0, 60.0], [150.0, aside[0], aside[1]], &(turned(random) + "velocity_m_s = [-0.5, 0.0, 0.0]"));
        hit(seed, &bodies, 2e-3, 0.5)
    };
    for safety in [0.8, 0.05] {
        come_back(&(0..40).filter_map(|seed| boxes(seed, safety)).collect::<Vec<_>>());
    }
}

/// Two boxes that overlap when they begin at rest, with nothing else in the scene, push each other apart: what was stored moves them.
#[test]
fn bodies_that_begin_in_each_other_part_with_what_was_stored() {
    let boxes =
        cuboid([40.0; 3], [0.0; 3], "") + &cuboid([40.0; 3], [12.0, 7.0, 39.5], "axis = [0.0, 0.0, 1.0]\nangle_deg = 20.0\n");
    let mut scene = Scene::new(&SMOOTH, [0.0; 3], &boxes);
    let (mut stored, Scene { model, rig, state, engine }) = (0.0, &mut scene);
    let look = |state: &mut State, _: &Engine| {
        stored = state.blocks().expect("bodies").energies([0.0; 3], 0.4).iter().sum();
        Ok(0.0)
    };
    state.advance(model, rig, engine, look).expect("a step");
    assert!(stored > 1e-3, "{stored} J");
    scene.run(0.005).expect("a run");
    let kinetic: f64 = scene.all().blocks.iter().map(|b| b.kinetic()).sum();
    // 0.34 % less: the leapfrog begins at full force
    assert!((kinetic / stored - 1.0).abs() < 5e-3 && scene.block(1).velocity[2] > 0.0, "{kinetic} of {stored} J");
    let momentum = scene.momenta();
    assert!(momentum.as_flattened().iter().all(|x| x.abs() < 1e-12), "{momentum:?}");
}
