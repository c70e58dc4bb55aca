//! Superquadrics on meshes and compounds.

use crate::common::Stuff;
use crate::compound::{compound, part};
use crate::mesh::{Triangles, grid, mesh};
use crate::meeting::{rock, turned};
use crate::scene::{SMOOTH, Scene, cuboid};
use crate::superquadrics::superquadric;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn strip(profile: &[[f64; 2]], width: f64, reversed: bool) -> Triangles {
    let mut all: Triangles = Default::default();
    for [x, z] in profile {
        all.0.extend([-width, width].map(|y| [*x, y, *z]));
    }
    for k in 0..profile.len() as u32 - 1 {
        let k = if reversed { profile.len() as u32 - 2 - k } else { k };
        all.1.extend([[2 * k, 2 * k + 1, 2 * k + 3], [2 * k, 2 * k + 3, 2 * k + 2]]);
    }
    all
}

#[test]
fn x_measure() {
    let flush = {
        let [low, high] = [[-300.0, -300.0, -100.0], [300.0, 300.0, 0.0]];
        let cut = |from: f64, to: f64| part([from, low[1], low[2]], [to, high[1], high[2]]);
        compound(&[cut(-300.0, 0.0), cut(0.0, 300.0)], [0.0, 0.0, -50.0], "driven = true")
    };
    let one = cuboid([600.0, 600.0, 100.0], [0.0, 0.0, -50.0], "driven = true");
    let rise = 300.0 * f64::tan(5f64.to_radians());
    let crease = mesh(&strip(&[[-300.0, rise], [0.0, 0.0], [300.0, rise]], 300.0, false), "rounding_mm = 1.0");
    let crease_back = mesh(&strip(&[[-300.0, rise], [0.0, 0.0], [300.0, rise]], 300.0, true), "rounding_mm = 1.0");
    let shallow = mesh(&strip(&[[-300.0, 0.01 * rise], [0.0, 0.0], [300.0, 0.01 * rise]], 300.0, false), "rounding_mm = 1.0");
    let edge = mesh(&strip(&[[-300.0, -300.0], [0.0, 0.0], [300.0, -300.0]], 300.0, false), "rounding_mm = 1.0");
    let ridge = mesh(&strip(&[[-300.0, -0.1 * rise], [0.0, 0.0], [300.0, -0.1 * rise]], 300.0, false), "rounding_mm = 1.0");
    for (name, floor) in [("one", one), ("flush", flush), ("crease", crease), ("crease_back", crease_back), ("shallow", shallow), ("edge", edge), ("ridge", ridge)] {
        for body in ["egg", "flat egg", "block", "rock", "box", "grain"] {
            let mut changes = Vec::new();
            let began = std::time::Instant::now();
            let mut steps = 0;
            for seed in 0..6 {
                let random = &mut ChaCha8Rng::seed_from_u64(seed);
                let more = turned(random);
                let spin: [f64; 3] = std::array::from_fn(|_| random.random_range(-5.0..5.0));
                let x = random.random_range(-20.0..20.0);
                let more = more + &format!("velocity_m_s = [{:?}, 0.1, -0.5]\nspin_rad_s = {spin:?}\n", -0.02 * x);
                let at = [x, 0.0, 60.0];
                let text = match body {
                    "egg" => superquadric([60.0, 40.0, 30.0], [2.0; 2], at, &more),
                    "flat egg" => superquadric([80.0, 60.0, 20.0], [2.0; 2], at, &more),
                    "block" => superquadric([60.0, 40.0, 30.0], [6.0; 2], at, &more),
                    "rock" => rock(random, at, &more),
                    "box" => cuboid([60.0, 40.0, 30.0], at, &more),
                    _ => format!("[[grain]]\nposition_m = {:?}\nradius_m = 0.02\nvelocity_m_s = [{:?}, 0.1, -0.5]\n", at.map(|x| 1e-3 * x), -0.02 * x),
                };
                let stuff = Stuff { young: 1e9, ..SMOOTH };
                let mut scene = Scene::new(&stuff, [0.0, 0.0, -9.81], &(floor.clone() + &text));
                let energy = |scene: &Scene| {
                    let mut sum = scene.energy();
                    let g = scene.grains();
                    for i in 0..g.len() {
                        let ([_, _, z, _], [u, v, w, _], m) = (g.pos[i], g.vel[i], g.mass[i]);
                        sum += 0.5 * m * (u * u + v * v + w * w) + m * 9.81 * z;
                    }
                    sum
                };
                let before = energy(&scene);
                let mut left = false;
                for _ in 0..40 {
                    if let Err(e) = scene.run(0.01) {
                        println!("{name} {body} {seed}: {e}");
                        break;
                    }
                }
                left |= body != "grain" && scene.block(1).centre[0].abs() > 0.28;
                steps += scene.state.continuum.steps();
                changes.push(if left { f64::NAN } else { energy(&scene) / before - 1.0 });
            }
            let most = changes.iter().filter(|c| !c.is_nan()).fold(0.0_f64, |m, c| m.max(c.abs()));
            println!("{name:12} {body:9} most {most:.2e}  {:?} {:.1} us/step", changes.iter().map(|c: &f64| format!("{c:.1e}")).collect::<Vec<_>>(), 1e6 * began.elapsed().as_secs_f64() / steps as f64);
        }
    }
    _ = grid;
}
