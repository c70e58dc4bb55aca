//! Superquadrics on meshes and compounds: they slide, roll, bounce and hit.

use crate::common::Stuff;
use crate::common::typed::{number, summary};
use crate::compound::{compound, letter_u, part};
use crate::meeting::{hit, turned};
use crate::mesh::{grid, mesh, pipe};
use crate::scene::{ROUGH, SMOOTH, Scene, cuboid};
use crate::superquadrics::superquadric;
use crate::typed::{resumes, run, scene};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// An ellipsoid and a block as TOML, with half of their height, m.
const EGG: ([f64; 3], [f64; 2]) = ([60.0, 40.0, 30.0], [2.0; 2]);
const BRICK: ([f64; 3], [f64; 2]) = ([60.0, 40.0, 30.0], [6.0; 2]);

/// Places, velocities and spins of the second body at so many times.
fn motion(scene: &mut Scene, times: usize, stretch: f64) -> Vec<f64> {
    let mut seen = Vec::new();
    for _ in 0..times {
        scene.run(stretch).expect("a run");
        let b = scene.block(1);
        seen.extend([b.centre, b.velocity, b.spin()].into_iter().flatten());
    }
    seen
}

/// Largest difference of two motions.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Superquadrics that may not turn stay on a slope below the angle of friction, and slide beyond it by ½ g (sin θ − μ cos θ) t², on a mesh of many triangles.
#[test]
fn superquadrics_slide_on_a_mesh_as_friction_says() {
    for (size, blockiness) in [EGG, BRICK] {
        for (angle, n) in [(32.0_f64, 19), (40.0, 19)] {
            let (sine, cosine) = angle.to_radians().sin_cos();
            let floor = mesh(&grid([n, 5], [-100.0, -100.0], [400.0, 100.0], |[x, y]| [x, y, 0.0]), "");
            let text = floor + &superquadric(size, blockiness, [0.0, 0.0, 14.999], "angle_deg = 30.0\nheld = [\"rotation\"]\n");
            let mut scene = Scene::new(&ROUGH, [9.81 * sine, 0.0, -9.81 * cosine], &text);
            scene.run(0.3).expect("a run");
            let (x, t) = (scene.block(1).centre[0], scene.state.time);
            let way = 0.5 * 9.81 * (sine - ROUGH.friction * cosine).max(0.0) * t * t;
            println!("{blockiness:?} {angle} {n}: {x} m for {way} m");
            if way > 0.0 {
                assert!((x / way - 1.0).abs() < 5e-3, "{x} m for {way} m");
            } else {
                assert!(x.abs() < 1e-5, "{x} m");
            }
            assert_eq!(scene.all().touching().count(), 1);
        }
    }
}

/// A free superquadric that rolls and rocks over a floor of many triangles, or over joints of a compound, moves as on two triangles and as on one box.
#[test]
fn superquadrics_roll_over_triangles_and_joints_as_on_one_face() {
    let [low, high] = [[-50.0, -100.0, -100.0], [400.0, 200.0, 0.0]];
    let triangles = |n: [u32; 2]| mesh(&grid(n, [low[0], low[1]], [high[0], high[1]], |[x, y]| [x, y, 0.0]), "");
    let cut = |from: f64, to: f64| part([from, low[1], low[2]], [to, high[1], high[2]]);
    let middle = [0, 1, 2].map(|a| 0.5 * (low[a] + high[a]));
    let parts = compound(&[cut(low[0], 20.0), cut(20.0, 60.0), cut(50.0, high[0])], middle, "driven = true");
    let whole = cuboid([0, 1, 2].map(|a| high[a] - low[a]), middle, "driven = true");
    let soft = Stuff { young: 1e8, ..ROUGH };
    for (size, blockiness) in [EGG, BRICK] {
        let body = superquadric(size, blockiness, [0.0, 0.0, 14.999], "velocity_m_s = [0.8, 0.2, 0.0]\nangle_deg = 20.0\n");
        let run = |floor: &String| motion(&mut Scene::new(&soft, [0.0, 0.0, -9.81], &(floor.clone() + &body)), 8, 0.01);
        for (what, floors) in [("triangles", [triangles([31, 17]), triangles([1, 1])]), ("parts", [parts.clone(), whole.clone()])] {
            let [many, one] = floors.each_ref().map(run);
            let (way, apart) = (one[one.len() - 9], apart(&many, &one));
            println!("{what} {blockiness:?}: apart by {apart:e} after {way} m");
            // rounding of a normal of 1e-16 moves the lowest place of a brick that lies flat by its fifth root
            let same = if what == "parts" && blockiness[0] > 2.0 { 1e-2 } else { 1e-6 };
            assert!(apart < same && way > 0.03, "{what} {blockiness:?}: {apart:e}, {way}");
        }
    }
}

/// Superquadrics that are dropped on a floor of a mesh and of a compound jump back with the energy that they had.
#[test]
fn superquadrics_bounce_on_meshes_and_compounds() {
    let stuff = Stuff { young: 1e9, ..SMOOTH };
    let roof = mesh(&grid([4, 2], [-200.0, -200.0], [200.0, 200.0], |[x, y]| [x, y, -0.3 * x.abs()]), "");
    let hollow = mesh(&grid([4, 2], [-200.0, -200.0], [200.0, 200.0], |[x, y]| [x, y, 0.02 * x.abs()]), "");
    let halves = [part([-200.0, -200.0, -100.0], [0.0, 200.0, 0.0]), part([0.0, -200.0, -100.0], [200.0, 200.0, 0.0])];
    let joint = compound(&halves, [0.0, 0.0, -50.0], "driven = true");
    for (what, floor) in [("roof", roof), ("hollow", hollow), ("joint", joint)] {
        for (size, blockiness) in [EGG, BRICK] {
            for seed in 0..2 {
                let random = &mut ChaCha8Rng::seed_from_u64(seed);
                let at = [random.random_range(-10.0..10.0), 0.0, 60.0];
                let more = turned(random) + "velocity_m_s = [0.0, 0.1, -0.5]\nspin_rad_s = [3.0, -2.0, 1.0]\n";
                let mut scene =
                    Scene::new(&stuff, [0.0, 0.0, -9.81], &(floor.clone() + &superquadric(size, blockiness, at, &more)));
                // of the floor, which stands
                let [_, floor, _] = scene.all().energies([0.0, 0.0, -9.81], 0.4);
                let own = scene.block(1).mass * 9.81 * scene.block(1).centre[2];
                let (before, floor) = (scene.energy() - (floor - own), floor - own);
                scene.run(0.12).expect("a run");
                while scene.all().touching().next().is_some() {
                    scene.run(1e-5).expect("a run");
                }
                let change = (scene.energy() - floor) / before - 1.0;
                println!("{what} {blockiness:?} {seed}: {change:e}");
                assert!(change.abs() < 1e-2 && scene.block(1).velocity[2] != -0.5, "{what} {blockiness:?} {seed}: {change:e}");
            }
        }
    }
}

/// Superquadrics hit a free U of three parts: momentum and angular momentum stay to rounding, energy comes back.
#[test]
fn superquadrics_that_hit_compounds_keep_momenta_and_energy() {
    let bodies = |seed| {
        let random = &mut ChaCha8Rng::seed_from_u64(2000 + seed);
        let aside: [f64; 2] = std::array::from_fn(|_| random.random_range(-30.0..30.0));
        let (size, blockiness) = if seed % 2 == 0 { EGG } else { BRICK };
        let [one, other] = [turned(random), turned(random) + "velocity_m_s = [-1.0, 0.0, 0.0]"];
        let rounded = seed % 3 == 0;
        let text = letter_u([0.0; 3], &one, rounded) + &superquadric(size, blockiness, [130.0, aside[0], aside[1]], &other);
        hit(seed, &text, 1e-3, 1.0)
    };
    let changes: Vec<_> = (0..16).filter_map(bodies).collect();
    let most = changes.iter().map(|(change, _)| change.abs()).fold(0.0, f64::max);
    println!("{} met, energy within {most:e}: {changes:?}", changes.len());
    assert!(changes.len() > 10 && most < 2e-3, "{changes:?}");
}

/// A rotating pipe slides under an ellipsoid that stands, over facet after facet: its friction stays at the limit, and does not begin anew on a new facet.
#[test]
fn friction_of_a_superquadric_goes_on_from_facet_to_facet() {
    let friction = 0.2;
    let stuff = Stuff { friction, young: 1e7, ..SMOOTH };
    let text = String::from("stepping.dt_s = 1e-6\n")
        + &mesh(&pipe(750, 100.0, 50.0, 1), "spin_rad_s = [0.0, 6.0, 0.0]")
        + &superquadric([30.0, 24.0, 20.0], [2.0; 2], [0.3, 0.0, 110.005], "held = [\"x\", \"y\", \"rotation\"]\n");
    let mut scene = Scene::new(&stuff, [0.0, 0.0, -9.81], &text);
    // let it come down and the friction begin
    scene.run(0.004).expect("a run");
    let (mut least, mut most, mut facets) = (f64::INFINITY, 0.0_f64, std::collections::BTreeSet::new());
    let end = scene.state.time + 0.006;
    while scene.state.time < end {
        scene.run(1e-12).expect("a step");
        facets.extend(scene.all().touching().map(|c| c.facet));
        let force = scene.all().forces(1)[3];
        if force[2] > 0.0 {
            (least, most) = (least.min((force[0] / force[2]).abs()), most.max((force[0] / force[2]).abs()));
        }
    }
    println!("friction {least} to {most} over {} facets", facets.len());
    // the normals of neighbours differ by 0.008
    assert!(facets.len() > 3 && least > friction - 0.01 && most < friction + 0.01, "{least} to {most}");
}

/// What is pressed so deep on a mesh that its core would be cut ends the run.
#[test]
fn a_superquadric_pressed_through_a_mesh_ends_the_run() {
    let soft = Stuff { young: 1e5, ..ROUGH };
    let floor = mesh(&grid([3, 3], [-100.0; 2], [100.0; 2], |[x, y]| [x, y, 0.0]), "");
    let text = floor + &superquadric(BRICK.0, BRICK.1, [0.0, 0.0, 15.1], "velocity_m_s = [0.0, 0.0, -20.0]");
    let ended = Scene::new(&soft, [0.0; 3], &text).run(0.01);
    assert!(ended.as_ref().is_err_and(|told| told.contains("blocks 0 and 1 overlap by")), "{ended:?}");
}

/// A run with superquadrics on a mesh and on a compound that was stopped while they touch goes on to the same bytes on two threads.
#[test]
fn superquadrics_on_facets_resume_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let bowl = mesh(&grid([6, 6], [-80.0; 2], [80.0; 2], |[x, y]| [x, y, 0.004 * (x * x + y * y)]), "rounding_mm = 1.0");
    let text = format!(
        "kind = \"mixture\"\nduration_s = 0.07\ngravity_m_s2 = [0.0, 0.0, -9.81]\n{bowl}{}{}{}[contact]\nlaw = \"hertz_viscous\"\n[records]\nrows = 100\nfigures = false\n[material]\n{}",
        letter_u([0.0, 0.0, 95.0], "axis = [1.0, 0.2, 0.0]\nangle_deg = 50.0\nvelocity_m_s = [0.0, 0.0, -0.4]\n", false),
        superquadric([30.0, 24.0, 20.0], [2.0; 2], [5.0, 20.0, 170.0], "velocity_m_s = [0.0, 0.0, -1.0]\n"),
        superquadric([30.0, 24.0, 20.0], [4.0, 6.0], [-45.0, -45.0, 40.0], "angle_deg = 20.0\n"),
        Stuff { young: 1e8, ..ROUGH }.toml()
    );
    let whole = run(folder.path(), &text, "whole", &["--threads", "1"]);
    let steps = number(&summary(&whole), "steps") as u64;
    resumes(&whole, &scene(folder.path(), &text), &[2 * steps / 3], &["blocks.csv", "history.csv"]);
}
