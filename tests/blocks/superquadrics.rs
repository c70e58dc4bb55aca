//! Superquadrics that touch each other, rocks and boxes.

use crate::common::typed::{number, summary};
use crate::meeting::{hit, rock, turned};
use crate::scene::{ROUGH, Scene, cuboid};
use crate::typed::{ROCKS, resumes, run, scene};
use comminute::rigid::Block;
use comminute::rigid::motion::about;
use comminute::shape::{Cuboid, Shape, Superquadric};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A superquadric as TOML.
pub fn superquadric(size: [f64; 3], blockiness: [f64; 2], at: [f64; 3], more: &str) -> String {
    format!("[[block]]\nshape = \"superquadric\"\nsize_mm = {size:?}\nblockiness = {blockiness:?}\nposition_mm = {at:?}\n{more}\n")
}

/// One of random form: exponents of 2 to 8, lengths in proportion up to 3.
fn random_one(random: &mut ChaCha8Rng, at: [f64; 3], more: &str) -> String {
    let size: [f64; 3] = std::array::from_fn(|_| random.random_range(30.0..90.0));
    let blockiness: [f64; 2] = std::array::from_fn(|_| random.random_range(2.0..8.0));
    superquadric(size, blockiness, at, more)
}

/// Superquadrics hit each other, rocks and boxes, turned and aside at random: momentum and angular momentum stay to rounding, energy comes back.
#[test]
fn superquadrics_that_meet_keep_momenta_and_energy() {
    for other in 0..3 {
        let bodies = |seed| {
            let random = &mut ChaCha8Rng::seed_from_u64(1000 * other + seed);
            let spin: [f64; 3] = std::array::from_fn(|_| random.random_range(-9.0..9.0));
            let aside: [f64; 2] = std::array::from_fn(|_| random.random_range(-25.0..25.0));
            let first = turned(random) + &format!("spin_rad_s = {spin:?}");
            let second = turned(random) + "velocity_m_s = [-2.0, 0.0, 0.0]";
            let at = [160.0, aside[0], aside[1]];
            let first = random_one(random, [0.0; 3], &first);
            let second = match other {
                0 => random_one(random, at, &second),
                1 => rock(random, at, &second),
                _ => cuboid([90.0, 50.0, 60.0], at, &second),
            };
            hit(seed, &(first + &second), 5e-4, 2.0)
        };
        let changes: Vec<_> = (0..40).filter_map(bodies).collect();
        let (most, mean) = changes.iter().fold((0.0_f64, 0.0), |(most, sum), c| (most.max(c.0.abs()), sum + c.0));
        println!("{other}: {} met, most {most:e}, mean {:e}", changes.len(), mean / changes.len() as f64);
        assert!(changes.len() > 35 && most < 3e-4, "{changes:?}");
    }
}

/// Two round superquadrics hit each other aside, with spin and friction, as two grains do beside them.
#[test]
fn round_superquadrics_meet_as_grains_do() {
    let mut bodies = String::new();
    for (at, motion) in
        [([0.0, 0.0, 0.0], ""), ([82.0, 31.0, 20.0], "velocity_m_s = [-1.0, 0.2, 0.0]\nspin_rad_s = [3.0, -20.0, 9.0]\n")]
    {
        bodies += &superquadric([80.0; 3], [2.0; 2], at, motion);
        let [x, y, z] = at.map(|x| 1e-3 * x);
        bodies += &format!("[[grain]]\nposition_m = [{x:?}, {:?}, {z:?}]\nradius_m = 0.04\n{motion}", y + 1.0);
    }
    let mut scene = Scene::new(&ROUGH, [0.0; 3], &bodies);
    for _ in 0..20 {
        scene.run(2e-3).expect("a run");
        let grains = scene.grains();
        for k in 0..2 {
            let (block, i) = (scene.block(k), grains.id.iter().position(|id| *id == k as u32).expect("a grain"));
            let place = [0, 1, 2].map(|a| block.centre[a] + if a == 1 { 1.0 } else { 0.0 } - grains.pos[i][a]);
            let motion = [0, 1, 2].map(|a| block.velocity[a] - grains.vel[i][a]);
            let spin = [0, 1, 2].map(|a| block.spin()[a] - grains.spin[i][a]);
            println!("{place:?} {motion:?} {spin:?}");
            assert!(place.iter().all(|x| x.abs() < 1e-9) && motion.iter().all(|x| x.abs() < 1e-7), "{place:?} {motion:?}");
            assert!(spin.iter().all(|x| x.abs() < 1e-5), "{spin:?}");
        }
    }
    assert!(scene.block(1).velocity[0] > -0.7, "{:?}", scene.block(1).velocity);
}

/// Overlaps of ellipsoids in closed form: along their axes with each other, and turned on the side of a box.
#[test]
fn ellipsoids_overlap_as_closed_forms_say() {
    let egg = |half: [f64; 3]| Block::new(Shape::Superquadric(Superquadric { half, blockiness: [2.0; 2] }), 1.0, 0);
    let (halves, others) = ([0.3, 0.2, 0.15], [0.25, 0.3, 0.2]);
    for a in 0..3 {
        let (first, mut second) = (egg(halves), egg(others));
        second.centre[a] = halves[a] + others[a] - 1e-3;
        assert!((first.overlap(&second) - 1e-3).abs() < 1e-12, "{}", first.overlap(&second));
    }
    for angle in [0.1, 0.5, 1.2] {
        let mut egg = egg(halves);
        egg.turn = about([0.0, 1.0, 0.0], angle);
        let table = Block::new(Shape::Box(Cuboid { half: [1.0, 1.0, 0.1] }), 1.0, 0);
        let high = ((halves[0] * angle.sin()).powi(2) + (halves[2] * angle.cos()).powi(2)).sqrt();
        egg.centre = [0.05, -0.1, 0.1 + high - 1e-3];
        assert!((egg.overlap(&table) - 1e-3).abs() < 1e-10, "{angle}: {}", egg.overlap(&table));
    }
}

/// A ball that is a superquadric rolls down the side of a driven box by 5/14 g sin θ t²: its friction has a history.
#[test]
fn a_round_superquadric_rolls_down_a_box() {
    let angle = 0.2_f64;
    let gravity = [9.81 * angle.sin(), 0.0, -9.81 * angle.cos()];
    let bodies = cuboid([3000.0, 400.0, 100.0], [1000.0, 0.0, -50.0], "driven = true")
        + &superquadric([80.0; 3], [2.0; 2], [0.0, 0.0, 39.999], "");
    let mut scene = Scene::new(&ROUGH, gravity, &bodies);
    scene.run(0.5).expect("a run");
    let ball = scene.block(1);
    let (way, known) = (ball.centre[0], 5.0 / 14.0 * gravity[0] * scene.state.time.powi(2));
    println!("{way} {known}");
    assert!((way / known - 1.0).abs() < 1e-3, "{way} {known}");
    assert!((ball.spin()[1] * 0.04 / ball.velocity[0] - 1.0).abs() < 1e-3 && ball.centre[1].abs() < 1e-9);
}

/// A run with superquadrics that was stopped while they touch goes on to the same bytes on two threads.
#[test]
fn superquadrics_resume_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let text = ROCKS.replacen("shape = \"box\"\n", "shape = \"superquadric\"\nblockiness = [4.0, 6.0]\n", 1).replacen(
        "[material]",
        &superquadric(
            [30.0, 44.0, 20.0],
            [2.0, 3.5],
            [40.0, 70.0, 150.0],
            "angle_deg = 40.0\nvelocity_m_s = [0.0, 0.0, -1.0]\n[material]",
        ),
        1,
    );
    let whole = run(folder.path(), &text, "whole", &["--threads", "1"]);
    let steps = number(&summary(&whole), "steps") as u64;
    resumes(&whole, &scene(folder.path(), &text), &[2 * steps / 3], &["blocks.csv", "history.csv"]);
}
