//! Compounds: bodies that are not convex, with balls, points, walls and each other.

use crate::common::Stuff;
use crate::meeting::{come_back, hit, turned};
use crate::mesh::{grid, mesh};
use crate::scene::{FLOOR, ROUGH, SMOOTH, Scene, cuboid};
use comminute::math::vector::{dot, less, scaled};
use comminute::rigid::{BlockContact, Other};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A box between two corners, mm, as a part in TOML.
pub fn part(low: [f64; 3], high: [f64; 3]) -> String {
    let size: [f64; 3] = std::array::from_fn(|a| high[a] - low[a]);
    let middle: [f64; 3] = std::array::from_fn(|a| 0.5 * (high[a] + low[a]));
    format!("[[block.part]]\nshape = \"box\"\nsize_mm = {size:?}\nposition_mm = {middle:?}\n")
}

/// A compound of these parts as TOML, with its centre of mass at `at`, mm.
pub fn compound(parts: &[String], at: [f64; 3], more: &str) -> String {
    format!("[[block]]\nshape = \"compound\"\nposition_mm = {at:?}\n{more}\n{}", parts.concat())
}

/// The same of boxes between corners that do not overlap, where they stand.
fn standing(boxes: &[[[f64; 3]; 2]], more: &str) -> String {
    let (mut volume, mut first) = (0.0, [0.0; 3]);
    for [low, high] in boxes {
        let v = (0..3).map(|a| high[a] - low[a]).product::<f64>();
        volume += v;
        (0..3).for_each(|a| first[a] += 0.5 * v * (low[a] + high[a]));
    }
    let parts: Vec<String> = boxes.iter().map(|[low, high]| part(*low, *high)).collect();
    compound(&parts, first.map(|x| x / volume), more)
}

fn ball(at: [f64; 3], radius: f64, velocity: [f64; 3]) -> String {
    format!("[[grain]]\nposition_m = {at:?}\nradius_m = {radius:?}\nvelocity_m_s = {velocity:?}\n")
}

fn touching(scene: &Scene) -> Vec<&BlockContact> {
    scene.all().touching().collect()
}

/// A ball that slides and begins to roll over joints of three boxes, two of which overlap, does what it does on one box, to rounding.
#[test]
fn a_ball_rolls_over_flush_joints_as_on_one_box() {
    let run = |floor: String| {
        let text = floor + &ball([0.011, 0.013, 0.0099], 0.01, [0.8, 0.3, 0.0]);
        let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &text);
        let mut seen = Vec::new();
        for _ in 0..60 {
            scene.run(0.01).expect("a run");
            assert!(touching(&scene).len() <= 1);
            let g = scene.grains();
            seen.extend([g.pos[0], g.vel[0], g.spin[0]].into_iter().flat_map(|[x, y, z, _]| [x, y, z]));
        }
        (scene.state.continuum.steps(), seen)
    };
    let [low, high] = [[-50.0, -50.0, -100.0], [600.0, 300.0, 0.0]];
    let cut = |from: f64, to: f64| part([from, low[1], low[2]], [to, high[1], high[2]]);
    let middle = [0, 1, 2].map(|a| 0.5 * (low[a] + high[a]));
    let parts = [cut(-50.0, 60.0), cut(60.0, 200.0), cut(150.0, 600.0)];
    let on_parts = run(compound(&parts, middle, "driven = true"));
    let on_box = run(cuboid([650.0, 350.0, 100.0], middle, "driven = true"));
    assert_eq!(on_parts.0, on_box.0, "steps");
    // spins are 60 rad/s; bounces magnify rounding, to 3e-10 with other steps
    let apart = on_parts.1.iter().zip(&on_box.1).map(|(a, b)| (a - b).abs() / b.abs().max(1.0)).fold(0.0, f64::max);
    println!("apart by {apart:e}, x {}", on_parts.1[on_parts.1.len() - 9]);
    assert!(apart < 1e-9 && on_parts.1[on_parts.1.len() - 9] > 0.3, "{apart:e}");
}

/// A box that slides over the joints, with its corners and edges on them, does what it does on one box.
#[test]
fn a_box_slides_over_flush_joints_as_on_one_box() {
    let run = |floor: String| {
        let more = "velocity_m_s = [1.5, 0.2, 0.0]\naxis = [0.0, 0.0, 1.0]\nangle_deg = 20.0\n";
        let text = floor + &cuboid([60.0, 40.0, 30.0], [0.0, 100.0, 14.9999], more);
        let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &text);
        let mut seen = Vec::new();
        for _ in 0..40 {
            scene.run(0.005).expect("a run");
            let b = scene.block(1);
            seen.extend([b.centre, b.velocity, b.spin()].into_iter().flatten());
        }
        (scene.state.continuum.steps(), seen, touching(&scene).len())
    };
    let [low, high] = [[-50.0, -50.0, -100.0], [600.0, 300.0, 0.0]];
    let cut = |from: f64, to: f64| part([from, low[1], low[2]], [to, high[1], high[2]]);
    let middle = [0, 1, 2].map(|a| 0.5 * (low[a] + high[a]));
    let parts = [cut(-50.0, 20.0), cut(20.0, 100.0), cut(60.0, 600.0)];
    let on_parts = run(compound(&parts, middle, "driven = true"));
    let on_box = run(cuboid([650.0, 350.0, 100.0], middle, "driven = true"));
    let apart = on_parts.1.iter().zip(&on_box.1).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!(
        "apart by {apart:e}, steps {} {}, x {}, contacts {} {}",
        on_parts.0,
        on_box.0,
        on_parts.1[on_parts.1.len() - 9],
        on_parts.2,
        on_box.2
    );
    assert!(apart < 1e-9 && on_parts.1[on_parts.1.len() - 9] > 0.1 && on_parts.2 == on_box.2, "{apart:e}");
}

/// A ball in the inner corner of an L rests on two contacts. Under a weight at an angle each leg bears its component.
#[test]
fn a_ball_in_an_inner_corner_rests_on_two_contacts() {
    let stuff = Stuff { friction: 0.0, ..ROUGH };
    let legs = [[[-20.0, -50.0, -20.0], [0.0, 50.0, 100.0]], [[0.0, -50.0, -20.0], [100.0, 50.0, 0.0]]];
    let text = standing(&legs, "driven = true") + &ball([0.01, 0.0, 0.01], 0.01, [0.0; 3]);
    let gravity = [-4.0, 0.0, -9.0];
    let mut scene = Scene::new(&stuff, gravity, &text);
    scene.run(0.3).expect("a run");
    let (touch, weight) = (touching(&scene), scene.grains().mass[0]);
    assert_eq!(touch.len(), 2, "{touch:?}");
    for c in &touch {
        let a = (0..3).find(|&a| c.touch.normal[a].abs() > 0.999_999).expect("along an axis");
        assert!((c.touch.normal_force / weight + gravity[a]).abs() < 1e-4, "{c:?}");
    }
    let force = scene.all().forces(0)[1];
    assert!((0..3).all(|a| (force[a] / weight - gravity[a]).abs() < 1e-4), "{force:?}");
}

/// A ball without friction slides to and fro over the shallow inner edge between two plates that rise by a hundredth to both sides and overlap below. Where it touches both,
/// what they have in common counts once: its energy stays.
#[test]
fn a_ball_slides_over_a_shallow_inner_edge_without_loss() {
    let stuff = Stuff { young: 0.1e9, ..SMOOTH };
    let angle = 0.01_f64.to_degrees();
    let plate = |side: f64| {
        // its upper side goes through the origin, by 20 mm beyond it
        let (sine, cosine) = (0.01 * side).sin_cos();
        let at = [80.0 * side * cosine + 20.0 * sine, 0.0, 80.0 * side * sine - 20.0 * cosine].map(|x: f64| x);
        let turn = -side * angle;
        format!(
            "[[block.part]]\nshape = \"box\"\nsize_mm = [200.0, 100.0, 40.0]\nposition_mm = {at:?}\naxis = [0.0, 1.0, 0.0]\nangle_deg = {turn:?}\n"
        )
    };
    let hollow = compound(&[plate(-1.0), plate(1.0)], [0.0; 3], "driven = true");
    // where the edge lies under the centre of mass
    let alone = format!("kind = \"mixture\"\nduration_s = 1.0\n{hollow}[contact]\nlaw = \"hertz\"\n[material]\n{}", stuff.toml());
    let edge = 1e-3 * inside(&alone, [0.0, 0.0, 1.0]);
    let text = hollow + &ball([-0.05, 0.0, edge + 0.01 + 0.05 * 0.01 + 1e-6], 0.01, [0.0; 3]);
    let mut scene = Scene::new(&stuff, [0.0, 0.0, -9.81], &text);
    let energy = |scene: &Scene| {
        let g = scene.grains();
        let ([x, _, z, _], [u, v, w, _], m) = (g.pos[0], g.vel[0], g.mass[0]);
        (0.5 * m * (u * u + v * v + w * w) + m * 9.81 * z + scene.energy() - scene.all().energies([0.0; 3], 0.4)[0], x)
    };
    let swing = scene.grains().mass[0] * 9.81 * 0.05 * 0.01;
    let (start, mut most, mut sides, mut both) = (energy(&scene).0, 0.0_f64, [0.0_f64; 2], 0);
    for _ in 0..1500 {
        scene.run(0.001).expect("a run");
        let (now, x) = energy(&scene);
        most = most.max((now - start).abs() / swing);
        sides = [sides[0].min(x), sides[1].max(x)];
        both += usize::from(touching(&scene).len() == 2);
    }
    println!("energy within {most:e} of the swing, from {sides:?} m, on both plates {both} times");
    // some of its motion is a hop after the edge
    assert!(most < 0.002 && sides[1] > 0.03 && both > 0, "{most:e} {sides:?} {both}");
}

/// A bridge of three boxes stands on the four outer corners of its two feet, each with a quarter of its weight; buried corners do not press.
#[test]
fn a_bridge_stands_on_its_feet() {
    let bridge = [
        [[-100.0, -30.0, 60.0], [100.0, 30.0, 100.0]],
        [[-100.0, -30.0, 0.0], [-70.0, 30.0, 60.0]],
        [[70.0, -30.0, 0.0], [100.0, 30.0, 60.0]],
    ];
    let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &(String::from(FLOOR) + &standing(&bridge, "")));
    scene.run(0.5).expect("a run");
    let (b, touch) = (scene.block(0), touching(&scene));
    // the inner corners of the feet touch too
    assert_eq!(touch.len(), 8, "{touch:?}");
    let volume = 0.2 * 0.06 * 0.04 + 2.0 * 0.03 * 0.06 * 0.06;
    assert!((b.mass / (2500.0 * volume) - 1.0).abs() < 1e-12, "{}", b.mass);
    let on_floor: f64 = touch.iter().map(|c| c.force()[2]).sum();
    assert!((on_floor / (b.mass * 9.81) - 1.0).abs() < 1e-4 && b.kinetic() < 1e-10, "{on_floor}");
    let outer: Vec<f64> = touch.iter().map(|c| c.force()[2] / on_floor).collect();
    assert!(outer.iter().all(|share| (share - 0.125).abs() < 0.01), "{outer:?}");
}

/// The same on a mesh of irregular triangles, turned by 30 degrees.
#[test]
fn a_bridge_stands_on_a_mesh() {
    let bridge = [
        [[-100.0, -30.0, 60.0], [100.0, 30.0, 100.0]],
        [[-100.0, -30.0, 0.0], [-70.0, 30.0, 60.0]],
        [[70.0, -30.0, 0.0], [100.0, 30.0, 60.0]],
    ];
    let floor = mesh(&grid([13, 11], [-200.0, -200.0], [200.0, 200.0], |[x, y]| [x, y, 0.0]), "");
    let text = floor + &standing(&bridge, "angle_deg = 30.0");
    let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &text);
    scene.run(0.5).expect("a run");
    let (b, force, touch) = (scene.block(1), scene.all().forces(1)[3], touching(&scene));
    assert_eq!(touch.len(), 8, "{touch:?}");
    assert!((force[2] / (b.mass * 9.81) - 1.0).abs() < 1e-4 && b.kinetic() < 1e-10, "{force:?}");
    assert!(touch.iter().all(|c| (c.force()[2].abs() / force[2] - 0.125).abs() < 0.01), "{touch:?}");
}

/// Balls are thrown at a free U, many between its legs: momentum and angular momentum of both stay to rounding, energy comes back.
#[test]
fn balls_thrown_at_a_compound_keep_momenta_and_energy() {
    let mut changes = Vec::new();
    for seed in 0..30 {
        let random = &mut ChaCha8Rng::seed_from_u64(seed);
        let aside: [f64; 2] = std::array::from_fn(|_| random.random_range(-0.04..0.04));
        let body = letter_u([0.0; 3], &format!("axis = [1.0, {:?}, 0.3]\nangle_deg = 20.0", aside[0]), seed % 2 == 0);
        let speed = 0.5;
        let text = body + &ball([aside[0], 0.4 * aside[1], 0.09], 0.012, [0.0, 0.0, -speed]);
        let mut scene = Scene::new(&SMOOTH, [0.0; 3], &text);
        let all = |scene: &Scene| {
            let ([p, l], g) = (scene.momenta(), scene.grains());
            let ([x, y, z, _], [u, v, w, _], m) = (g.pos[0], g.vel[0], g.mass[0]);
            let own = scaled([u, v, w], m);
            let energy = scene.energy() + 0.5 * dot(own, [u, v, w]);
            let about = comminute::math::vector::cross([x, y, z], own);
            ([std::array::from_fn(|a| p[a] + own[a]), std::array::from_fn(|a| l[a] + about[a])], energy)
        };
        let before: ([[f64; 3]; 2], f64) = all(&scene);
        scene.run(0.35).unwrap_or_else(|e| panic!("{seed}: {e}"));
        let after = all(&scene);
        for (one, other) in before.0.as_flattened().iter().zip(after.0.as_flattened()) {
            assert!((one - other).abs() < 1e-12, "{seed}: {before:?} {after:?}");
        }
        if (scene.grains().vel[0][2] + speed).abs() > 1e-3 * speed {
            changes.push((after.1 / before.1 - 1.0, seed));
        }
    }
    println!("{} met: {changes:?}", changes.len());
    assert!(changes.len() > 20 && changes.iter().all(|(change, _)| change.abs() < 3e-4), "{changes:?}");
}

/// A free compound of three parts tumbles: its angular momentum stays to the bit, its energy swings by the leapfrog's error only.
#[test]
fn a_free_compound_tumbles() {
    let parts = [part([0.0; 3], [60.0, 20.0, 20.0]), part([0.0; 3], [20.0, 40.0, 20.0]), part([0.0; 3], [20.0, 20.0, 90.0])];
    let text = compound(&parts, [0.0; 3], "spin_rad_s = [10.0, 40.0, -5.0]\nvelocity_m_s = [1.0, 2.0, 3.0]");
    let far = ball([9.0, 9.0, 9.0], 0.01, [0.0; 3]);
    let mut scene = Scene::new(&SMOOTH, [0.0; 3], &(text + &far));
    let (start, energy) = (scene.momenta(), scene.block(0).kinetic());
    let mut most = 0.0_f64;
    for _ in 0..40 {
        scene.run(0.01).expect("a run");
        most = most.max((scene.block(0).kinetic() / energy - 1.0).abs());
    }
    assert_eq!(scene.block(0).momentum, start[1]);
    println!("energy {most:e}");
    assert!(most < 1e-4, "{most:e}");
}

/// A plus sign of two bars, of boxes.
fn plus_sign(at: [f64; 3], more: &str) -> String {
    compound(&[part([-60.0, -15.0, -15.0], [60.0, 15.0, 15.0]), part([-15.0, -60.0, -15.0], [15.0, 60.0, 15.0])], at, more)
}

/// A U of three boxes that end on each other, and of three rounded polyhedra whose hulls have faces in common.
pub fn letter_u(at: [f64; 3], more: &str, rounded: bool) -> String {
    let boxes = [
        [[-50.0, -15.0, -20.0], [50.0, 15.0, 0.0]],
        [[-50.0, -15.0, 0.0], [-30.0, 15.0, 60.0]],
        [[30.0, -15.0, 0.0], [50.0, 15.0, 60.0]],
    ];
    let hull = |[low, high]: [[f64; 3]; 2]| {
        let points: Vec<f64> = (0..8).flat_map(|k| [0, 1, 2].map(|a| if k >> a & 1 == 1 { high[a] } else { low[a] })).collect();
        format!("[[block.part]]\nshape = \"polyhedron\"\nrounding_mm = 4.0\npoints_mm = {points:?}\n")
    };
    let parts: Vec<String> = boxes.into_iter().map(|b| if rounded { hull(b) } else { part(b[0], b[1]) }).collect();
    compound(&parts, at, more)
}

/// Four tapered legs from one place.
fn tetrapod(at: [f64; 3], more: &str) -> String {
    let points: Vec<f64> = [[-3.0, 12.0], [60.0, 8.0]]
        .iter()
        .flat_map(|[z, h]| [[-h, -h, *z], [*h, -h, *z], [-h, *h, *z], [*h, *h, *z]])
        .flatten()
        .collect();
    let leg = |turn: &str| format!("[[block.part]]\nshape = \"polyhedron\"\nrounding_mm = 4.0\npoints_mm = {points:?}\n{turn}");
    let side = |axis: [f64; 2]| leg(&format!("axis = [{:?}, {:?}, 0.0]\nangle_deg = 109.471\n", axis[0], axis[1]));
    compound(&[leg(""), side([1.0, 0.0]), side([-0.5, 0.866_025]), side([-0.5, -0.866_025])], at, more)
}

/// Compounds hit each other, turned and aside at random: momentum and angular momentum stay to rounding and energy comes back as with convex bodies.
#[test]
fn compounds_that_meet_keep_momenta_and_energy() {
    for (kind, first, count) in [(0, 200_u64, 40), (1, 300, 40), (2, 400, 8), (3, 500, 8)] {
        let all = |seed| {
            let random = &mut ChaCha8Rng::seed_from_u64(first + seed);
            let aside: [f64; 2] = std::array::from_fn(|_| random.random_range(-30.0..30.0));
            let at = [190.0, aside[0], aside[1]];
            let [one, other] = [turned(random), turned(random) + "velocity_m_s = [-0.5, 0.0, 0.0]"];
            let body = |at: [f64; 3], more: &str| match kind {
                0 => plus_sign(at, more),
                1 | 2 => letter_u(at, more, kind == 1),
                _ => tetrapod(at, more),
            };
            let bodies = body([0.0; 3], &one) + &body(at, &other);
            hit(seed, &bodies, 2.5e-3, 0.5)
        };
        let changes = (0..count).filter_map(all).collect::<Vec<_>>();
        let mean = changes.iter().map(|c| c.0).sum::<f64>() / changes.len() as f64;
        println!("{kind}: {} met, mean {mean:e}, most {:e}", changes.len(), changes.iter().map(|c| c.0.abs()).fold(0.0, f64::max));
        if count > 30 {
            come_back(&changes);
        }
        assert!(changes.len() > 6 && changes.iter().all(|(change, _)| change.abs() < 3e-4), "{kind}: {changes:?}");
    }
}

/// A hook hangs in a hook that is held: under gravity it stays, and the upper one bears its weight. Their convex hulls could not.
#[test]
fn a_hook_holds_a_hook() {
    // a U that is held upside down is no hook: the upper one opens upwards, the lower one, turned by a quarter about the vertical and upside down, hangs in it
    let held = "driven = true";
    let hangs = "axis = [1.0, 1.0, 0.0]\nangle_deg = 180.0\n";
    for rounded in [false, true] {
        let alone = letter_u([0.0; 3], held, rounded) + "[contact]\nlaw = \"hertz_viscous\"\n[material]\n" + &ROUGH.toml();
        // one bottom on the other, a micrometre apart
        let high = 2.0 * inside(&format!("kind = \"mixture\"\nduration_s = 1.0\n{alone}"), [0.0, 0.0, 1.0]) + 1e-3;
        let text = letter_u([0.0; 3], held, rounded) + &letter_u([0.0, 0.0, high], hangs, rounded);
        let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &text);
        let start = scene.block(1).centre;
        scene.run(0.6).expect("a run");
        let (b, weight) = (scene.block(1), scene.block(1).mass * 9.81);
        let force = scene.all().forces(1)[3];
        let moved = less(b.centre, start);
        println!("{rounded}: moved {:e}, force {:e}, kinetic {:e}", dot(moved, moved).sqrt(), force[2] / weight - 1.0, b.kinetic());
        assert!((force[2] / weight - 1.0).abs() < 1e-3 && dot(moved, moved).sqrt() < 1e-3 && b.kinetic() < 1e-8, "{b:?}");
        // the hulls of both are deep in each other
        let reach = b.solid().reach();
        assert!(start[2].abs() < 0.7 * reach, "{start:?} {reach}");
    }
}

/// How high the inner side of a body's bottom, open towards `up`, lies over its centre of mass, mm. `body`: the body at the origin, not turned, with the keys of the scene around it.
fn inside(body: &str, up: [f64; 3]) -> f64 {
    let scene = Scene::of(body);
    let block = scene.block(0);
    let (mut low, mut high) = (-0.04, 0.04);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let out = block.solid().nearest(block.pose(0.0).within(scaled(up, middle))).distance > 0.0;
        *(if out { &mut high } else { &mut low }) = middle;
    }
    1e3 * high
}

/// A material of the plane whose contacts are springs, N/m per metre of depth.
fn spring(k: f64, restitution: f64, friction: f64) -> String {
    format!(
        "[contact]\nlaw = \"spring\"\n[material]\nname = \"stuff\"\ngrain.density_kg_m3 = 2500.0\nelastic.E_GPa = 1.0\nelastic.nu = 0.2\ncontact.friction = {friction:?}\n\
         contact.restitution = {restitution:?}\nspring.k_n_N_m = {k:?}\nspring.k_t_N_m = {:?}\n",
        0.5 * k
    )
}

/// Polygons that are not convex (Jiang et al. 2020), of polygons that overlap or share a side, rods and discs, hit each other in the plane.
#[test]
fn outlines_that_are_not_convex_keep_momenta_and_energy() {
    let polygon =
        |points: &[f64], r: f64| format!("[[block.part]]\nshape = \"polygon\"\npoints_mm = {points:?}\nrounding_mm = {r:?}\n");
    let shapes = [
        // a hexagram of two triangles (Fig. 3), an arrow head, a V of two rods, three discs
        vec![polygon(&[-35.0, -20.0, 35.0, -20.0, 0.0, 40.0], 3.0), polygon(&[-35.0, 20.0, 0.0, -40.0, 35.0, 20.0], 3.0)],
        vec![polygon(&[0.0, 0.0, 60.0, -30.0, 20.0, 0.0], 4.0), polygon(&[0.0, 0.0, 20.0, 0.0, 60.0, 30.0], 4.0)],
        vec![polygon(&[0.0, 0.0, 50.0, 30.0], 7.0), polygon(&[0.0, 0.0, -40.0, 40.0], 7.0)],
        vec![polygon(&[0.0, 0.0], 20.0), polygon(&[30.0, 0.0], 15.0), polygon(&[10.0, 30.0], 18.0)],
    ];
    let mut changes = Vec::new();
    for (k, (first, second)) in (0..4).flat_map(|i| (i..4).map(move |j| (i, j))).enumerate() {
        for seed in 0..5 {
            let mut random = ChaCha8Rng::seed_from_u64(500 + 17 * k as u64 + seed);
            let mut one = |x: f64| random.random_range(-x..x);
            let mut block = |shape: usize, at: [f64; 2], v: f64| {
                let more = format!(
                    "angle_deg = {:?}\nvelocity_m_s = [{v:?}, 0.0, 0.0]\nspin_rad_s = [0.0, 0.0, {:?}]",
                    one(180.0),
                    one(9.0)
                );
                compound(&shapes[shape], [at[0], at[1], 0.0], &more)
            };
            let bodies = block(first, [0.0; 2], 0.0) + &block(second, [130.0, 3.0 * seed as f64 - 6.0], -1.5);
            let mut scene = Scene::of(&format!(
                "kind = \"mixture\"\nduration_s = 9.0\ngrid.plane_strain = true\nstepping.dt_s = 4e-6\n{bodies}\n{}",
                spring(3e8, 1.0, 0.0)
            ));
            let before = (scene.momenta(), scene.energy());
            scene.run(0.12).unwrap_or_else(|e| panic!("{k} {seed}: {e}"));
            let after = (scene.momenta(), scene.energy());
            assert!((scene.block(1).velocity[0] + 1.5).abs() > 1e-3, "{k} {seed}: they missed");
            for (one, other) in before.0.as_flattened().iter().zip(after.0.as_flattened()) {
                assert!((one - other).abs() < 1e-12, "{k} {seed}: {before:?} {after:?}");
            }
            for b in &scene.all().blocks {
                assert!(b.centre[2] == 0.0 && b.velocity[2] == 0.0 && b.spin()[..2] == [0.0; 2], "{b:?}");
            }
            changes.push(after.1 / before.1 - 1.0);
        }
    }
    let mean = changes.iter().sum::<f64>() / changes.len() as f64;
    println!("mean {mean:e}, most {:e}", changes.iter().map(|c: &f64| c.abs()).fold(0.0, f64::max));
    // with a step that does not change when they touch: a quarter of that with half the step
    assert!(mean.abs() < 1e-4 && changes.iter().all(|change| change.abs() < 1e-3), "mean {mean:e}: {changes:?}");
}

/// An elastic square rests in a trough of three rods that share their ends, and presses with its weight.
#[test]
fn points_in_a_trough_press_with_their_weight() {
    let cell = 200.0 / 51.0;
    let rod = |points: [f64; 4]| format!("[[block.part]]\nshape = \"polygon\"\npoints_mm = {points:?}\nrounding_mm = 5.0\n");
    let parts = [rod([0.0, 0.0, 120.0, 0.0]), rod([0.0, 0.0, 0.0, 60.0]), rod([120.0, 0.0, 120.0, 60.0])];
    let plane = "kind = \"mixture\"\nduration_s = 9.0\ngrid.plane_strain = true\n";
    let alone = compound(&parts, [0.0; 3], "driven = true") + &spring(6e6, 0.1, 0.1);
    let high = inside(&format!("{plane}{alone}"), [0.0, 1.0, 0.0]);
    let mut rest = Scene::of(
        &format!(
            "kind = \"mixture\"\nduration_s = 9.0\ngravity_m_s2 = [0.0, -1.0, 0.0]\n\
             [[body]]\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.0]\nmax_mm = [100.0, 100.0, 0.0]\n{}\
             [grid]\nplane_strain = true\ncell_mm = {cell:?}\npoints_per_edge = 2\nmin_mm = [{:?}, {:?}, 0.0]\nmax_mm = [{:?}, {:?}, 1.0]\npic = 0.02\n{}\n\
             [damping]\nlocal = 0.3\n[material.continuum]\nlaw = \"elastic\"\nE_MPa = 8.8\nnu = 0.2558\n",
            compound(&parts, [50.0, -high, 0.0], "driven = true"),
            -10.0 * cell,
            -15.0 * cell,
            45.0 * cell,
            35.0 * cell,
            spring(6e6, 0.1, 0.1)
        )
        .replace("law = \"spring\"", &format!("law = \"spring\"\npoint_radius_mm = {:?}", 0.25 * cell)),
    );
    rest.run(0.6).expect("a run");
    let total = rest.all().forces(0)[0];
    println!("{total:?}, {high} mm");
    assert!((total[1] + 25.0).abs() < 0.05 && total[0].abs() < 0.01, "{total:?}");
    let on: Vec<&BlockContact> = rest.all().touching().filter(|c| matches!(c.other, Other::Point(_))).collect();
    assert_eq!(on.len(), 51);
    assert!(on.iter().all(|c| c.facet == 0 && c.force()[1] < 0.0));
}
