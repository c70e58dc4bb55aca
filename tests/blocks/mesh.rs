//! Sheets of triangles: what slides, rolls, rests and bounces on them.

use crate::scene::{ROUGH, SMOOTH, Scene, cuboid};
use comminute::rigid::BlockContact;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::PI;

/// Vertices, mm, and triangles.
pub type Triangles = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A mesh as TOML.
pub fn mesh((vertices, triangles): &Triangles, more: &str) -> String {
    let (vertices, triangles) = (vertices.as_flattened(), triangles.as_flattened());
    let at = if more.contains("position_mm") { "" } else { "position_mm = [0.0, 0.0, 0.0]\n" };
    format!("[[block]]\nshape = \"mesh\"\nvertices_mm = {vertices:?}\ntriangles = {triangles:?}\ndriven = true\n{at}{more}\n")
}

/// A ball as TOML, m and m/s.
fn ball(at: [f64; 3], radius: f64, velocity: [f64; 3]) -> String {
    format!("[[grain]]\nposition_m = {at:?}\nradius_m = {radius:?}\nvelocity_m_s = {velocity:?}\n")
}

/// `n` × `m` squares of irregular triangles over a rectangle from `low` to `high`, each vertex placed by `place`.
pub fn grid([n, m]: [u32; 2], low: [f64; 2], high: [f64; 2], place: impl Fn([f64; 2]) -> [f64; 3]) -> Triangles {
    let random = &mut ChaCha8Rng::seed_from_u64(3);
    let mut vertices = Vec::new();
    for (j, i) in (0..=m).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        // those at the borders stay where they are
        let inner = !([0, n].contains(&i) || [0, m].contains(&j));
        let mut at = |k: u32, most: u32, a: usize| {
            let off = if inner { random.random_range(-0.3..0.3) } else { 0.0 };
            low[a] + (high[a] - low[a]) * (f64::from(k) + off) / f64::from(most)
        };
        vertices.push(place([at(i, n, 0), at(j, m, 1)]));
    }
    let mut triangles = Vec::new();
    for (j, i) in (0..m).flat_map(|j| (0..n).map(move |i| (j, i))) {
        let [a, b] = [j * (n + 1) + i, (j + 1) * (n + 1) + i];
        triangles.extend(if (i + j) % 2 == 0 { [[a, a + 1, b + 1], [a, b + 1, b]] } else { [[a, a + 1, b], [a + 1, b + 1, b]] });
    }
    (vertices, triangles)
}

/// Contacts that touch.
fn touching(scene: &Scene) -> Vec<&BlockContact> {
    scene.all().touching().collect()
}

/// Kinetic and potential energy of the first grain, J.
fn energy(scene: &Scene) -> f64 {
    let (g, gravity) = (scene.grains(), scene.model.physics.gravity);
    let ([x, y, z, r], [u, v, w, _], [p, q, s, _]) = (g.pos[0], g.vel[0], g.spin[0]);
    let m = g.mass[0];
    0.5 * m * (u * u + v * v + w * w) + 0.2 * m * r * r * (p * p + q * q + s * s)
        - m * (gravity[0] * x + gravity[1] * y + gravity[2] * z)
}

/// A box slides down a slope of irregular triangles, which is turned with it: by ½ g (sin θ − μ cos θ) t², less what it lacks of speed until its springs have given way.
#[test]
fn a_box_slides_over_triangles_as_on_a_plane() {
    let (angle, friction, g, time) = (40.0_f64, 0.7, 9.81, 1.2);
    let (sine, cosine) = angle.to_radians().sin_cos();
    let floor = grid([37, 5], [-300.0, -200.0], [3000.0, 200.0], |[x, y]| [x, y, 0.0]);
    // along the slope and out of it
    let place = |along: f64, out: f64| [along * cosine + out * sine, 0.0, -along * sine + out * cosine];
    let turned = format!("axis = [0.0, 1.0, 0.0]\nangle_deg = {angle:?}\n");
    let bodies = mesh(&floor, &turned) + &cuboid([100.0, 100.0, 40.0], place(0.0, 20.0), &turned);
    let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -g], &bodies);
    let mut most = 0;
    for _ in 0..120 {
        scene.run(time / 120.0).expect("a run");
        most = most.max(touching(&scene).len());
    }
    let at = scene.block(1).centre;
    let [x, z] = [at[0] * cosine - at[2] * sine, at[0] * sine + at[2] * cosine];
    let t = scene.state.time;
    let way = 0.5 * g * (sine - friction * cosine) * t * t;
    println!("way {x} of {way}: {:e}; height {z}, contacts {most}", x / way - 1.0);
    assert!((x / way - 1.0).abs() < 1e-3, "{x} m for {way} m");
    // on its four corners, wherever they stand
    assert!(most == 4 && (z - 0.02).abs() < 1e-5 && at[1].abs() < 1e-5, "{most} contacts, {at:?}");
}

/// A ball that slides and begins to roll over a floor of irregular triangles does what it does on the face of a box, to rounding: the floor is one facet.
#[test]
fn a_ball_on_triangles_does_what_it_does_on_a_face() {
    let run = |floor: String| {
        let text = floor + &ball([0.011, 0.013, 0.0099], 0.01, [0.8, 0.3, 0.0]);
        let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &text);
        let mut seen = Vec::new();
        for _ in 0..30 {
            scene.run(0.02).expect("a run");
            assert!(touching(&scene).len() <= 1);
            let g = scene.grains();
            seen.extend([g.pos[0], g.vel[0], g.spin[0]].into_iter().flat_map(|[x, y, z, _]| [x, y, z]));
        }
        (scene.state.continuum.steps(), seen)
    };
    let on_mesh = run(mesh(&grid([31, 17], [-50.0, -50.0], [600.0, 300.0], |[x, y]| [x, y, 0.0]), ""));
    let on_box = run(cuboid([650.0, 350.0, 100.0], [275.0, 125.0, -50.0], "driven = true"));
    assert_eq!(on_mesh.0, on_box.0, "steps");
    let apart = on_mesh.1.iter().zip(&on_box.1).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("apart by {apart:e}");
    assert!(apart < 1e-9 && on_mesh.1[on_mesh.1.len() - 9] > 0.2, "{apart:e}");
}

/// A ball rests in an inner corner of one, two and three walls of several triangles: it has as many contacts, and each bears its part of the weight.
#[test]
fn a_ball_in_an_inner_corner_has_a_contact_with_each_wall() {
    let mut corner: Triangles = Default::default();
    for axis in 0..3 {
        // the same vertices along the common sides
        let (vertices, triangles) = grid([4, 4], [0.0; 2], [100.0; 2], |[u, v]| {
            let mut p = [0.0; 3];
            (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
            p
        });
        let first = corner.0.len() as u32;
        corner.0.extend(vertices);
        corner.1.extend(triangles.iter().map(|t| t.map(|k| first + k)));
    }
    for (walls, gravity, at) in [
        (1, [0.0, 0.0, -9.0], [0.05, 0.05, 0.01]),
        (2, [0.0, -4.0, -9.0], [0.05, 0.01, 0.01]),
        (3, [-3.0, -4.0, -9.0], [0.01, 0.01, 0.01]),
    ] {
        let stuff = crate::common::Stuff { friction: 0.0, ..ROUGH };
        let mut scene = Scene::new(&stuff, gravity, &(mesh(&corner, "") + &ball(at, 0.01, [0.0; 3])));
        scene.run(0.3).expect("a run");
        let touch = touching(&scene);
        let force = scene.all().forces(0)[1];
        let weight = scene.grains().mass[0];
        assert_eq!(touch.len(), walls, "{touch:?}");
        for a in 0..3 {
            assert!((force[a] / weight - gravity[a]).abs() < 1e-3, "{force:?}");
        }
        for c in touch {
            // each along an axis, with its component of the weight
            let a = (0..3).find(|&a| c.touch.normal[a].abs() > 0.999_999).expect("an axis");
            assert!((c.touch.normal_force / weight + gravity[a]).abs() < 0.02, "{c:?}");
        }
    }
}

/// A pipe of `sides` sides along y, of inner radius `radius` between its faces, mm.
pub fn pipe(sides: u32, radius: f64, half: f64, slices: u32) -> Triangles {
    let outer = radius / (PI / f64::from(sides)).cos();
    let mut all: Triangles = Default::default();
    for j in 0..=slices {
        for i in 0..sides {
            let angle = 2.0 * PI * (f64::from(i) + 0.25) / f64::from(sides);
            let y = half * (2.0 * f64::from(j) / f64::from(slices) - 1.0);
            all.0.push([outer * angle.cos(), y, outer * angle.sin()]);
        }
    }
    for j in 0..slices {
        for i in 0..sides {
            let at = |i: u32, j: u32| j * sides + i % sides;
            all.1.extend([[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
        }
    }
    all
}

/// A ball rolls to and fro in a pipe, over its many sides, as a pendulum of the length 7/5 (R − r). Its friction goes with it from facet to facet: where contacts on a new facet
/// begin without history it loses twice as much, and where two facets are not shared at their border most of the swing. Where the sides are sharp against the overlap it bounces, and what it loses then
/// is chance (1500 sides, 1 GPa: 0.2 to 15 % for starts that differ by a hundredth), so these pipes are fine enough that it stays on them.
#[test]
fn a_ball_rolls_to_and_fro_in_a_pipe() {
    let (radius, g) = (0.1, 9.81);
    for (sides, young, start, crossings, least) in
        [(1500, 1e7, 0.3_f64, 5, 0.02), (1500, 1e7, 0.31, 5, 0.02), (6000, 1e9, 0.3, 3, 0.0024), (6000, 1e9, 0.31, 3, 0.0024)]
    {
        let stuff = crate::common::Stuff { friction: 0.9, young, ..SMOOTH };
        let r = 0.01;
        let length = radius - r;
        let at = [length * start.sin(), 0.0, -length * start.cos()];
        let text = mesh(&pipe(sides, 1e3 * radius, 50.0, 3), "") + &ball(at, r, [0.0; 3]);
        let mut scene = Scene::new(&stuff, [0.0, 0.0, -g], &text);
        let (before, mut through, mut last) = (energy(&scene), Vec::new(), at[0]);
        let swing = scene.grains().mass[0] * g * length * (1.0 - start.cos());
        let mut most = 0;
        while through.len() < crossings {
            scene.run(2e-4).expect("a run");
            most = most.max(touching(&scene).len());
            let x = scene.grains().pos[0][0];
            if x * last < 0.0 {
                through.push(scene.state.time - 2e-4 * x / (x - last));
            }
            last = x;
        }
        let period = 2.0 * PI * (1.4 * length / g).sqrt() * (1.0 + start * start / 16.0);
        let found = through[crossings - 1] - through[crossings - 3];
        let lost = (before - energy(&scene)) / swing;
        println!("{sides} sides, {young:e} Pa: period {:e} of itself away, lost {lost:e} of the swing", found / period - 1.0);
        assert!(most == 2 && (found / period - 1.0).abs() < 2e-3, "{found} s for {period} s");
        assert!(lost.abs() < least, "{lost}");
    }
}

/// A rotating pipe slides under a ball, outside on its top and inside at its bottom, over facet after facet: the friction stays at its limit all the time, and does not begin anew on
/// a new facet, where it would fall to nothing.
#[test]
fn friction_goes_on_from_facet_to_facet() {
    let friction = 0.2;
    // no dashpots, which take the friction to its limit at once, and steps whose slip is less than its spring can take
    let fine = "stepping.dt_s = 1e-6\n";
    for z in [0.110005, -0.089995] {
        let stuff = crate::common::Stuff { friction, young: 1e7, ..SMOOTH };
        let text = fine.to_string()
            + &mesh(&pipe(1500, 100.0, 50.0, 1), "spin_rad_s = [0.0, 3.0, 0.0]")
            + &ball([0.0003, 0.0, z], 0.01, [0.0; 3]);
        let mut scene = Scene::new(&stuff, [0.0, 0.0, -9.81], &text);
        // let it come down and the friction begin
        scene.run(0.01).expect("a run");
        let (mut least, mut most, mut facets) = (f64::INFINITY, 0.0_f64, std::collections::BTreeSet::new());
        let end = scene.state.time + 0.01;
        while scene.state.time < end {
            // a step
            scene.run(1e-12).expect("a run");
            facets.extend(touching(&scene).iter().map(|c| c.facet));
            let force = scene.all().forces(0)[1];
            let [x, _, z, _] = scene.grains().pos[0];
            let out = [x, z].map(|p| p / f64::hypot(x, z));
            let (across, along) = (force[0] * out[0] + force[2] * out[1], force[2] * out[0] - force[0] * out[1]);
            let across = if z > 0.0 { across } else { -across };
            // while it goes off its dashpot may pull, without friction
            if across < 0.0 {
                (least, most) = (least.min((along / across).abs()), most.max((along / across).abs()));
            }
        }
        println!("at {z}: friction {least} to {most} over {} facets", facets.len());
        // the normals of neighbours differ by 0.004
        assert!(facets.len() > 5 && least > friction - 0.01 && most < friction + 0.01, "{least} to {most}");
    }
}

/// A fixed block with its six faces as triangles, from `low` to `high`, mm, each face divided into `n` × `n` squares.
fn shell(low: [f64; 3], high: [f64; 3], n: u32) -> Triangles {
    let mut all: Triangles = Default::default();
    for (axis, end) in (0..3).flat_map(|axis| [(axis, low), (axis, high)]) {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        let (vertices, triangles) = grid([n, n], [low[u], low[v]], [high[u], high[v]], |[a, b]| {
            let mut p = [0.0; 3];
            (p[axis], p[u], p[v]) = (end[axis], a, b);
            p
        });
        let first = all.0.len() as u32;
        all.0.extend(vertices);
        all.1.extend(triangles.iter().map(|t| t.map(|k| first + k)));
    }
    all
}

/// A ball bounces on a face, an edge and a corner of a meshed block: its energy comes back, and it goes off as from a mirror across the way from the nearest point.
#[test]
fn a_ball_bounces_on_face_edge_and_corner() {
    let sheet = shell([-50.0; 3], [0.0; 3], 4);
    for (what, at, normal) in [
        ("face", [-0.0212, -0.0173, 0.0115], [0.0, 0.0, 1.0]),
        ("edge", [-0.0212, 0.0072, 0.0089], [0.0, 0.0072, 0.0089]),
        ("corner", [0.0061, 0.0068, 0.0066], [0.0061, 0.0068, 0.0066]),
    ] {
        let length = f64::sqrt(normal.iter().map(|x| x * x).sum());
        let normal: [f64; 3] = normal.map(|x| x / length);
        // straight at the nearest point, and without friction along the edge or face as well
        let along = if what == "corner" { 0.0 } else { 0.3 };
        let velocity = [along - normal[0], -normal[1], -normal[2]];
        let mut scene = Scene::new(&SMOOTH, [0.0; 3], &(mesh(&sheet, "") + &ball(at, 0.01, velocity)));
        let (before, mut contacts) = (energy(&scene), 0);
        let mut impulse = [0.0; 3];
        for _ in 0..400 {
            scene.run(1e-5).expect("a run");
            contacts = contacts.max(touching(&scene).len());
            let (force, m) = (scene.all().forces(0)[1], scene.grains().mass[0]);
            impulse = std::array::from_fn(|a| impulse[a] + force[a] / m);
        }
        let [u, v, w, _] = scene.grains().vel[0];
        println!("{what}: energy {:e}, velocity {u} {v} {w}", energy(&scene) / before - 1.0);
        assert!((energy(&scene) / before - 1.0).abs() < 1e-4, "{what}");
        assert_eq!(contacts, 1, "{what}");
        let expected = [along + normal[0], normal[1], normal[2]];
        for (found, expected) in [u, v, w].iter().zip(expected) {
            assert!((found - expected).abs() < 1e-4, "{what}: {:?} for {expected:?}", [u, v, w]);
        }
        // what it presses on the mesh is against its own change of momentum
        let side = impulse.iter().zip(normal).map(|(i, n)| i * n).sum::<f64>();
        assert!(side < 0.0, "{impulse:?}");
    }
}

/// A ball without friction slides to and fro in a bowl of many triangles, over its inner edges and vertices, and keeps its energy: the energy of neighbouring
/// facets is shared where both are touched. With 24 × 24 squares it would lose 9 % without that, with 48 × 48 gain six times what it has.
#[test]
fn a_ball_in_a_fine_bowl_keeps_its_energy() {
    let bowl = |n: u32| {
        grid([n, n], [-60.0; 2], [60.0; 2], |[x, y]| {
            let z: f64 = 100.0 - f64::sqrt(1e4 - x * x - y * y);
            [x, y, z]
        })
    };
    for n in [24, 48] {
        let stuff = crate::common::Stuff { friction: 0.0, young: 1e7, ..SMOOTH };
        let (start, r) = (0.3_f64, 0.01);
        let at = [(0.0995 - r) * start.sin(), 0.003, 0.1 - (0.0995 - r) * start.cos()];
        let mut scene = Scene::new(&stuff, [0.0, 0.0, -9.81], &(mesh(&bowl(n), "") + &ball(at, r, [0.0, 0.1, 0.0])));
        let total = |scene: &Scene| energy(scene) + scene.all().energies(scene.model.physics.gravity, 0.4)[2];
        let (before, swing) = (total(&scene), scene.grains().mass[0] * 9.81 * 0.09 * (1.0 - start.cos()));
        let (mut worst, mut most) = (0.0_f64, 0);
        for _ in 0..1000 {
            scene.run(1e-3).expect("a run");
            worst = worst.max(((total(&scene) - before) / swing).abs());
            most = most.max(touching(&scene).len());
        }
        let p = scene.grains().pos[0];
        println!(
            "bowl {n}: energy changes by {worst:e} of the swing at most, {:e} at last; {most} contacts; {p:?}",
            (total(&scene) - before) / swing
        );
        assert!(p[2] > 0.009, "{p:?}");
        assert!(most > 1, "never two facets");
        assert!(worst < 2e-2, "{worst:e}");
    }
}

/// Rocks and boxes hit a meshed block, turned and aside at random, with corners, edges and faces: their energy comes back.
#[test]
fn blocks_that_hit_a_mesh_keep_their_energy() {
    let sheet = mesh(&shell([-40.0; 3], [40.0; 3], 2), "rounding_mm = 3.0");
    let mut changes = Vec::new();
    for seed in 0..40 {
        let random = &mut ChaCha8Rng::seed_from_u64(500 + seed);
        let mut one = |x: f64| random.random_range(-x..x);
        let turn = format!("axis = [{:?}, {:?}, {:?}]\nangle_deg = {:?}\n", one(1.0), one(1.0), one(1.0), one(180.0));
        let velocity = format!(
            "velocity_m_s = [-1.0, {:?}, {:?}]\nspin_rad_s = [{:?}, {:?}, {:?}]\n",
            one(0.2),
            one(0.2),
            one(5.0),
            one(5.0),
            one(5.0)
        );
        let at = [120.0, one(45.0), one(45.0)];
        let mut scene = Scene::new(&SMOOTH, [0.0; 3], &(sheet.clone() + &cuboid([60.0, 50.0, 70.0], at, &(turn + &velocity))));
        let (before, speed) = (scene.energy(), scene.block(1).velocity);
        for _ in 0..100 {
            scene.run(1.5e-3).unwrap_or_else(|e| panic!("{seed}: {e}"));
        }
        let apart = (0..3).map(|a| (scene.block(1).velocity[a] - speed[a]).powi(2)).sum::<f64>().sqrt();
        if apart > 0.01 {
            changes.push((scene.energy() / before - 1.0, seed));
        }
    }
    let worst = changes.iter().map(|(change, _)| change.abs()).fold(0.0, f64::max);
    let mean = changes.iter().map(|(change, _)| change).sum::<f64>() / changes.len() as f64;
    println!("{} impacts: energy within {worst:e}, mean {mean:e}: {changes:?}", changes.len());
    assert!(changes.len() > 20 && worst < 1e-2 && mean.abs() < 1e-3);
}

/// A box falls flat and tilted on a floor of irregular triangles that lies in two levels, and rests on the edge of the upper one with its weight.
#[test]
fn a_box_rests_over_the_edge_of_a_step() {
    // two levels with a riser between: the box lies on the upper one and reaches over its edge
    let profile = [[-200.0, 0.0], [0.0, 0.0], [0.0, -30.0], [200.0, -30.0]];
    let mut step: Triangles = Default::default();
    for (k, [x, z]) in profile.into_iter().enumerate() {
        for j in 0..=5 {
            step.0.push([x, 60.0 * f64::from(j) - 150.0, z]);
        }
        let first = 6 * k as u32;
        let strip = (0..5).flat_map(|j| [[first + j, first + j + 6, first + j + 7], [first + j, first + j + 7, first + j + 1]]);
        step.1.extend(strip.filter(|_| k < 3));
    }
    for (x, stands) in [(-10.0, true), (10.0, false)] {
        let bodies = mesh(&step, "rounding_mm = 1.0") + &cuboid([100.0, 80.0, 40.0], [x, 0.0, 21.0], "");
        let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &bodies);
        scene.run(0.5).expect("a run");
        let (b, weight) = (scene.block(1), 9.81 * scene.block(1).mass);
        let force = scene.all().forces(0)[3][2];
        println!("{x}: {:?} force {force} of {weight}, {} contacts", b.centre, touching(&scene).len());
        if stands {
            assert!((force / weight + 1.0).abs() < 1e-3 && (b.centre[2] - 0.021).abs() < 1e-4, "{force} N for {weight} N");
        } else {
            assert!(b.centre[2] < 0.015, "{:?}", b.centre);
        }
    }
}

/// A box of points lies on a floor of irregular triangles: it presses on it with its weight.
#[test]
fn points_rest_on_a_mesh_with_their_weight() {
    let floor = grid([7, 9], [-30.0; 2], [90.0; 2], |[x, y]| [x, y, 0.0]);
    let text = format!(
        "kind = \"mixture\"\nduration_s = 9.0\ngravity_m_s2 = [0.0, 0.0, -9.81]\n{}\
         [[body]]\nshape = \"box\"\nmin_mm = [0.0, 0.0, 0.65]\nmax_mm = [40.0, 40.0, 40.65]\n\
         [grid]\ncell_mm = 10.0\npoints_per_edge = 2\nmin_mm = [-30.0, -30.0, -30.0]\nmax_mm = [80.0, 80.0, 70.0]\npic = 0.05\n\
         [damping]\nlocal = 0.3\n[material]\n{}[material.continuum]\nlaw = \"elastic\"\nE_MPa = 1.0\nnu = 0.2\n",
        mesh(&floor, ""),
        crate::common::Stuff { young: 1e7, ..ROUGH }.toml()
    );
    let mut scene = Scene::of(&text);
    scene.run(0.4).expect("a run");
    let totals = scene.state.continuum.totals();
    let (force, weight) = (scene.all().forces(0)[0], 9.81 * totals.mass);
    println!("{force:?} N for {weight} N on {} contacts", touching(&scene).len());
    assert!((force[2] / weight + 1.0).abs() < 5e-3 && force[0].abs() < 1e-3 * weight, "{force:?} N for {weight} N");
    // each of the lowest points on the one facet
    assert_eq!(touching(&scene).len(), 64);
}

/// A ball is carried up by a rotating pipe with friction until it slips, and its angular velocity is that of the pipe over their radii; the pipe keeps its spin.
#[test]
fn a_rotating_pipe_turns_a_ball() {
    let spin = 3.0;
    let stuff = crate::common::Stuff { young: 1e8, friction: 0.5, ..ROUGH };
    // turned about a skew axis and back, so that nothing lies along an axis of the file
    let text =
        mesh(&pipe(180, 100.0, 50.0, 1), &format!("spin_rad_s = [0.0, {spin:?}, 0.0]")) + &ball([0.0, 0.0, -0.09], 0.01, [0.0; 3]);
    let mut scene = Scene::new(&stuff, [0.0, 0.0, -9.81], &text);
    scene.run(1.5).expect("a run");
    let (drum, g) = (scene.block(0), scene.grains());
    let (carried, [p, q, s, _]) = (drum.spin(), g.spin[0]);
    println!("drum {carried:?}, ball {p} {q} {s} at {:?}, {:?}", g.pos[0], drum.turn);
    assert!((carried[1] - spin).abs() < 1e-12 && carried[0] == 0.0 && drum.kinetic() == 0.0);
    // it rolls: where they touch, both move alike
    let [x, y, z, r] = g.pos[0];
    let ([u, _, w, _], far) = (g.vel[0], f64::hypot(x, z));
    let [tx, tz] = [-z / far, x / far];
    let (of_ball, of_drum) = (u * tx + w * tz - q * r, spin * -0.1);
    println!("{of_ball} {of_drum} {p} {s} {y}");
    assert!((of_ball / of_drum - 1.0).abs() < 0.01, "{of_ball} m/s for {of_drum} m/s");
    // half of the angle that the drum has turned by
    let half = 0.5 * spin * scene.state.time;
    assert!((drum.turn[0] - half.cos()).abs() < 1e-6 && (drum.turn[2] - half.sin()).abs() < 1e-6, "{:?}", drum.turn);
}
