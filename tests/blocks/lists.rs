//! Lists of what is near change no bit of a result, however old they are.

use crate::meeting::{rock, turned};
use crate::scene::{FLOOR, ROUGH, Scene, cuboid, on_one_thread};
use crate::superquadrics::superquadric;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Ten bodies that fall on each other: rocks, boxes and superquadrics.
fn heap() -> Scene {
    let random = &mut ChaCha8Rng::seed_from_u64(3);
    let at = |k: usize| [150.0 * (k % 2) as f64 + 7.0 * (k % 3) as f64, 8.0 * (k % 4) as f64, 80.0 + 150.0 * (k / 2) as f64];
    let bodies = (0..10).map(|k| {
        // the two columns towards each other, the upper ones faster
        let (aside, down) = (2.0 - 4.0 * (k % 2) as f64, 1.0 + 3.0 * (k / 2) as f64);
        let more = turned(random) + &format!("velocity_m_s = [{aside:?}, 0.0, {:?}]\n", -down);
        match k % 5 {
            1 => cuboid([60.0, 50.0, 70.0], at(k), &more),
            3 => superquadric([60.0, 50.0, 70.0], [4.0, 3.0], at(k), &more),
            _ => rock(random, at(k), &more),
        }
    });
    let bodies: String = bodies.collect();
    Scene::new(&ROUGH, [0.0, 0.0, -9.81], &(bodies + FLOOR))
}

/// The motion of all bodies after 60 ms, to the bit, and how many contacts touched, summed over all steps. What is not saved is dropped after every `drop` steps.
fn fall(drop: u32) -> (Vec<u64>, usize) {
    let (mut scene, mut step, mut touched) = (heap(), 0, 0);
    on_one_thread(|| {
        while scene.state.time < 0.06 {
            scene.state.advance(&scene.model, &scene.rig, &mut scene.engine, |_, _| Ok(0.0)).unwrap_or_else(|e| panic!("{e}"));
            (step, touched) = (step + 1, touched + scene.all().touching().count());
            if step % drop == 0 {
                let saved = postcard::to_stdvec(&scene.state.mixture).expect("written");
                scene.state.mixture = postcard::from_bytes(&saved).expect("read");
            }
        }
    });
    let of = |b: &comminute::rigid::Block| [&b.centre[..], &b.turn, &b.velocity, &b.momentum].concat();
    let bits = scene.all().blocks.iter().flat_map(|b| of(b).into_iter().map(f64::to_bits)).collect();
    println!("{step} steps, {touched} contacts in sum");
    (bits, touched)
}

/// Each pair's sites are sought when its own bodies have moved, and each place looked at when it may touch. Sought and looked at in every step, and now and then, everything is the same.
#[test]
fn a_heap_falls_alike_however_old_its_lists_are() {
    let (kept, touched) = fall(u32::MAX);
    assert!(touched > 500, "{touched} contacts");
    assert!(kept == fall(1).0, "lists made anew in every step");
    assert!(kept == fall(37).0, "lists made anew now and then");
}
