//! Bodies on paths, pushed and held bodies, glue and hinges, against closed forms.

use crate::scene::{FLOOR, ROUGH, SMOOTH, Scene, cuboid, on_one_thread};
use comminute::math::vector::{dot, less, scaled};
use comminute::rig::continuum::State;
use comminute::rigid::{Block, Joint};
use std::f64::consts::PI;

const NO_GRAVITY: [f64; 3] = [0.0; 3];
/// Cement of joints.
const CEMENT: &str = "radius_mm = 20.0\nthickness_mm = 10.0\nE_MPa = 10.0\nnu = 0.25";
/// E A/t of [`CEMENT`], N/m.
const STRETCH: f64 = 10e6 * PI * 0.02 * 0.02 / 0.01;

/// A scene without contacts whose step is a share of the stable one.
fn fine(share: f64, gravity: [f64; 3], bodies: &str) -> Scene {
    Scene::new(&SMOOTH, gravity, &format!("stepping.safety = {share:?}\n{bodies}"))
}

fn joint(state: &State, k: usize) -> &Joint {
    &state.blocks().expect("bodies").drives().expect("drives").joints[k]
}

/// Goes on to a time, s, and looks at every instant when its forces are known, before anything moves.
fn watch(scene: &mut Scene, end: f64, mut look: impl FnMut(&State, &[Block]) + Send) {
    on_one_thread(|| {
        while scene.state.time < end {
            let observe = |state: &mut State, _: &_| {
                look(state, &state.blocks().expect("bodies").blocks);
                Ok(0.0)
            };
            scene.state.advance(&scene.model, &scene.rig, &mut scene.engine, observe).expect("a step");
        }
    });
}

/// A plate that is driven under a brick at rest gives m v²: half of it the brick has in the end, the other half friction took.
#[test]
fn what_drives_a_plate_gives_what_friction_takes() {
    let speed = 0.5;
    let plate = format!("driven = true\nvelocity_m_s = [{speed:?}, 0.0, 0.0]");
    let bodies = cuboid([900.0, 400.0, 100.0], [0.0, 0.0, -50.0], &plate) + &cuboid([60.0; 3], [0.0, 0.0, 29.999], "");
    let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &bodies);
    scene.run(0.3).expect("a run");
    let brick = scene.block(1);
    let (given, whole) = (scene.all().given().expect("a plate that moves"), brick.mass * speed * speed);
    println!("given {given:e} of {whole:e} J, speed {}", brick.velocity[0]);
    assert!((brick.velocity[0] / speed - 1.0).abs() < 1e-3 && (given / whole - 1.0).abs() < 5e-3, "{given} of {whole} J");
    // a plate that stands does no work, and nobody asks
    let still = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &bodies.replace("[0.5, 0.0, 0.0]", "[0.0, 0.0, 0.0]"));
    assert!(still.all().given().is_none());
}

/// A carriage goes along a corner of a path with a brick on it. Its places are those of the table at every step of the run, whatever the step; what drives it has given the motion, the height and
/// what friction took.
#[test]
fn a_block_on_a_path_is_where_the_table_says() {
    for share in [0.8, 0.3] {
        let path = "path_s = [0.0, 0.1, 0.25, 0.4]\npath_mm = [0.0, 0.0, 50.0, 20.0, 0.0, 50.0, 20.0, 30.0, 60.0, 0.0, 30.0, 60.0]\npath_deg = [0.0, 0.0, 30.0, 400.0]";
        let bodies = cuboid([400.0, 400.0, 100.0], [0.0, 0.0, 50.0], path) + &cuboid([60.0; 3], [0.0, 0.0, 130.0], "");
        let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &format!("stepping.safety = {share:?}\n{bodies}"));
        let table: [(f64, [f64; 3]); 4] =
            [(0.0, [0.0, 0.0, 0.05]), (0.1, [0.02, 0.0, 0.05]), (0.25, [0.02, 0.03, 0.06]), (0.4, [0.0, 0.03, 0.06])];
        let mut most = 0.0_f64;
        watch(&mut scene, 0.45, |state, blocks| {
            let t = state.time;
            let at = match table.windows(2).find(|w| w[0].0 <= t && t < w[1].0) {
                Some(w) => {
                    let share = (t - w[0].0) / (w[1].0 - w[0].0);
                    std::array::from_fn(|a| w[0].1[a] + share * (w[1].1[a] - w[0].1[a]))
                }
                None => table[3].1,
            };
            let away = less(blocks[0].centre, at);
            most = most.max(dot(away, away).sqrt());
        });
        assert!(most < 1e-15, "{share}: {most:e} m from the table");
        let turned = scene.block(0).turn;
        // 400° is 40°
        assert!((turned[0].abs() - 20_f64.to_radians().cos()).abs() < 1e-12, "{turned:?}");
        // the brick came along: friction 0.7 bears more than the path asks for
        let brick = scene.block(1).centre;
        assert!((brick[2] - 0.14).abs() < 1e-3, "{brick:?}");
    }
}

/// A body pushed by a force moves by F t²/2m, and the work of the force is its kinetic energy.
#[test]
fn a_pushed_body_moves_by_its_force() {
    let mut scene =
        fine(0.8, NO_GRAVITY, &cuboid([100.0; 3], [0.0; 3], "force_N = [3.0, -4.0, 0.0]\ntorque_N_m = [0.0, 0.0, 0.2]"));
    scene.run(1.0).expect("a run");
    let (body, t) = (scene.block(0), scene.state.time);
    let way = [3.0, -4.0, 0.0].map(|f| 0.5 * f * t * t / body.mass);
    assert!((0..3).all(|a| (body.centre[a] - way[a]).abs() < 1e-9 * t), "{:?} {way:?}", body.centre);
    let dt = scene.state.dt;
    // the velocity is that of half a step ago
    assert!((body.spin()[2] - 0.2 * (t - 0.5 * dt) / body.moments[2]).abs() < 1e-9, "{:?}", body.spin());
    let given = scene.all().given().expect("a push");
    assert!((given / body.kinetic() - 1.0).abs() < 2.0 * dt / t, "{given} {}", body.kinetic());
}

/// A footing that may not tilt is pressed on three bricks of unequal distances by a stress: at rest the bricks bear its weight and the stress times its area, and what the push gave is in the contacts and
/// in what friction and the dashpots took.
#[test]
fn a_footing_passes_on_its_weight_and_its_load() {
    let footing = "stress_kPa = [0.0, 0.0, -20.0]\nramp_s = 0.1\nheld = [\"x\", \"y\", \"rotation\"]";
    let bodies = format!("damping.local = 0.3\n{FLOOR}")
        + &cuboid([100.0; 3], [-150.0, 0.0, 50.0], "")
        + &cuboid([100.0; 3], [30.0, 60.0, 50.0], "")
        + &cuboid([100.0; 3], [60.0, -60.0, 50.0], "")
        + &cuboid([500.0, 300.0, 80.0], [0.0, 0.0, 140.0], footing);
    let mut scene = Scene::new(&ROUGH, [0.0, 0.0, -9.81], &bodies);
    scene.run(0.6).expect("a run");
    let load = 20e3 * 0.5 * 0.3;
    let expected = load + scene.block(3).mass * 9.81;
    let on = scene.all().forces(3)[3];
    assert!((on[2] / expected - 1.0).abs() < 1e-4, "{} N for {expected} N", on[2]);
    let body = scene.block(3);
    assert!(body.turn == [1.0, 0.0, 0.0, 0.0] && body.centre[0] == 0.0 && body.velocity[2].abs() < 1e-6, "{body:?}");
    // what holds it bears what the bricks press aside
    let outer = scene.all().outer_force(3, [0.0, 0.0, -9.81], scene.state.time);
    assert!((outer[0] + on[0]).abs() < 1e-9 && (outer[2] + load).abs() < 1e-9, "{outer:?} {on:?}");
    // Hertz's contacts give 2/5 of the load times the way of the ramp; the weight has gone some of the way at once
    let given = scene.all().given().expect("a push");
    let way = 0.14 - body.centre[2];
    assert!(given > 0.3 * load * way && given < 0.5 * load * way, "{given} J over {way} m");
    let moment = scene.state.moment(&scene.rig);
    let fallen = scene.block(3).mass * 9.81 * way;
    let taken = moment.dissipated / (given + fallen);
    assert!(moment.driven_work == Some(given) && (0.0..0.5).contains(&taken), "{taken}: {moment:?}");
    println!("footing: {} N for {expected} N, taken {taken}", on[2]);
}

/// Two glued cubes, pushed apart by a force that is given at once: they swing about F/k with the period of reduced mass and stiffness, and force times way is motion and stretch at every instant.
#[test]
fn two_glued_cubes_swing_with_their_period_and_keep_their_energy() {
    let (first, second) = ("force_N = [0.0, 0.0, -40.0]", "force_N = [0.0, 0.0, 40.0]");
    let glue =
        format!("[[joint]]\nkind = \"glue\"\nblocks = [0, 1]\nposition_mm = [0.0, 0.0, 50.0]\naxis = [0.0, 0.0, 1.0]\n{CEMENT}\n");
    let bodies = cuboid([100.0; 3], [0.0; 3], first) + &cuboid([100.0; 3], [0.0, 0.0, 100.0], second) + &glue;
    let mut scene = fine(0.02, NO_GRAVITY, &bodies);
    let mass = 0.5 * 2500.0 * 1e-3;
    let period = 2.0 * PI * (mass / STRETCH).sqrt();
    let (mut passes, mut last, mut most, mut error) = (Vec::new(), None::<[f64; 2]>, 0.0_f64, 0.0_f64);
    let mut before = [0.0; 2];
    watch(&mut scene, 10.2 * period, |state, blocks| {
        let t = state.time;
        let stretch = blocks[1].centre[2] - blocks[0].centre[2] - 0.1;
        most = most.max(stretch);
        // rises through the mean
        let off = stretch - 40.0 / STRETCH;
        if let Some([at, was]) = last
            && was < 0.0
            && off >= 0.0
        {
            passes.push(at + (t - at) * was / (was - off));
        }
        last = Some([t, off]);
        // the kinetic energy of the last half step, and the mean of the others at both ends of that step
        let kinetic: f64 = blocks.iter().map(|b| b.kinetic()).sum();
        let now = [state.blocks().and_then(|all| all.given()).expect("a push"), 0.5 * STRETCH * stretch * stretch];
        let [given, stored] = [0, 1].map(|k| 0.5 * (now[k] + before[k]));
        error = error.max((given - kinetic - stored).abs());
        before = now;
    });
    let measured = (passes[9] - passes[0]) / 9.0;
    let scale = 40.0 * 80.0 / STRETCH;
    assert!((measured / period - 1.0).abs() < 1e-4, "{measured} s for {period} s");
    assert!((most * STRETCH / 80.0 - 1.0).abs() < 1e-4, "{most}");
    assert!(error < 1e-3 * scale, "{error:e} of {scale:e} J");
    let middle = scene.block(0).centre[2] + scene.block(1).centre[2] - 0.1;
    assert!(middle.abs() < 1e-15, "{middle:e}");
    println!("glue: period 1 + {:.2e}, energy {:.2e}", measured / period - 1.0, error / scale);
}

/// Cubes whose glue has a strength, drawn apart slowly: they part when the force is strength times area, once, and the records have what it had stored. Then they may touch again.
#[test]
fn glue_breaks_at_its_strength_times_its_area() {
    let (strength, area) = (0.05e6, PI * 0.02 * 0.02);
    let glue = format!(
        "[[joint]]\nkind = \"glue\"\nblocks = [1, 0]\nposition_mm = [0.0, 0.0, 50.0]\naxis = [0.0, 0.0, 1.0]\ndamping = 0.2\ntension_MPa = 0.05\n{CEMENT}\n"
    );
    let bodies = cuboid([100.0; 3], [0.0; 3], "driven = true")
        + &cuboid([100.0; 3], [0.0, 0.0, 99.9], "force_N = [0.0, 0.0, 100.0]\nramp_s = 1.0")
        + &glue;
    let mut scene = fine(0.2, NO_GRAVITY, &bodies);
    let mut force = 0.0;
    watch(&mut scene, 1.0, |state, _| {
        if joint(state, 0).broken.is_none() {
            force = joint(state, 0).now.load[0];
        }
    });
    let broken = joint(&scene.state, 0).broken.expect("broken");
    let limit = strength * area;
    assert!(force <= limit && (force / limit - 1.0).abs() < 2e-3, "{force} N for {limit} N");
    // the ramp gets there at limit/100 s; the cube lags behind by little
    assert!((broken / (limit / 100.0) - 1.0).abs() < 0.02, "{broken} s");
    println!("breaks: force before 1 − {:.1e}, time 1 + {:.1e}", 1.0 - force / limit, broken / (limit / 100.0) - 1.0);
    let released = joint(&scene.state, 0).released;
    assert!((released / (0.5 * limit * limit / STRETCH) - 1.0).abs() < 5e-3, "{released} J");
    assert!(scene.block(1).velocity[2] > 0.0 && scene.all().touching().count() == 0);
}

/// A free cube that is pushed by a table, up and down and past its end: its momentum is the area under the straight lines between the rows, and the work on it is its kinetic energy.
#[test]
fn a_push_follows_its_table() {
    let push = "force_N = [8.0, 0.0, -4.0]\npush_s = [0.1, 0.2, 0.4, 0.5]\npush_share = [0.5, 1.0, -1.0, 0.25]";
    let mut scene = fine(0.2, NO_GRAVITY, &cuboid([100.0; 3], [0.0; 3], push));
    // before the first row, three trapezia, after the last
    for (more, area) in [(0.1, 0.05), (0.4, 0.05 + 0.075 + 0.0 - 0.0375), (0.1, 0.0875 + 0.025)] {
        scene.run(more).expect("a run");
        let end = scene.state.time;
        let (b, drive) = (scene.block(0), &scene.all().drives().expect("drives").bodies[0]);
        let kick = area / b.mass;
        assert!(
            (b.velocity[0] - 8.0 * kick).abs() < 2e-3 * kick && (b.velocity[2] + 4.0 * kick).abs() < 2e-3 * kick,
            "{end}: {b:?}"
        );
        assert!((drive.of_push / b.kinetic() - 1.0).abs() < 5e-3, "{end}: {} {}", drive.of_push, b.kinetic());
    }
}

/// Glue breaks in bending where N/A + M R/I is its strength: a cube held by its side, loaded by a force on its centre. Its shear strength is far off.
#[test]
fn a_glued_bracket_breaks_in_bending() {
    let (arm, r) = (0.05, 0.02_f64);
    let strength = 0.2e6;
    let glue = format!(
        "[[joint]]\nkind = \"glue\"\nblocks = [0]\nposition_mm = [-50.0, 0.0, 0.0]\naxis = [1.0, 0.0, 0.0]\ndamping = 0.3\ntension_MPa = 0.2\nshear_MPa = 9.0\n{CEMENT}\n"
    );
    // M = F arm, I/R = π R³/4
    let limit = strength * 0.25 * PI * r * r * r / arm;
    for (share, holds) in [(0.97, true), (1.03, false)] {
        let push = format!("force_N = [0.0, 0.0, {:?}]\nramp_s = 1.0", -share * limit);
        let mut scene = fine(0.4, NO_GRAVITY, &(cuboid([100.0; 3], [0.0; 3], &push) + &glue));
        scene.run(1.5).expect("a run");
        assert_eq!(joint(&scene.state, 0).broken.is_none(), holds, "{share}");
        if holds {
            let now = joint(&scene.state, 0).now;
            assert!((now.load[2] / (share * limit * arm) - 1.0).abs() < 2e-3, "{now:?}");
            assert!((now.utilisation / share - 1.0).abs() < 2e-3, "{now:?}");
            // the end sinks by F (arm²/(E I/t) + 1/(G A/t))
            let (bend, shear) = (STRETCH * r * r / 4.0, STRETCH / 2.5);
            let sinks = share * limit * (arm * arm / bend + 1.0 / shear);
            assert!((scene.block(0).centre[2] / -sinks - 1.0).abs() < 5e-3, "{:?} {sinks}", scene.block(0).centre);
        } else {
            assert!(scene.block(0).centre[2] < -0.01);
        }
    }
}

/// A column of four glued cubes hangs from the world: each joint bears what is below it, and the lowest sinks by the sum of the stretches.
#[test]
fn a_column_of_glued_cubes_hangs_with_its_weight() {
    let mut bodies = String::new();
    for k in 0..4 {
        bodies += &cuboid([100.0; 3], [0.0, 0.0, -50.0 - 100.0 * f64::from(k)], "");
    }
    for k in 0..4 {
        let ends = if k == 0 { "[0]".into() } else { format!("[{}, {k}]", k - 1) };
        bodies += &format!(
            "[[joint]]\nkind = \"glue\"\nblocks = {ends}\nposition_mm = [0.0, 0.0, {:?}]\naxis = [0.0, 0.0, 1.0]\ndamping = 0.5\n{CEMENT}\n",
            -100.0 * f64::from(k)
        );
    }
    let mut scene = fine(0.5, [0.0, 0.0, -9.81], &format!("damping.local = 0.2\n{bodies}"));
    scene.run(1.5).expect("a run");
    let weight = 2500.0 * 1e-3 * 9.81;
    let mut sinks = 0.0;
    for k in 0..4 {
        let tension = joint(&scene.state, k).now.load[0];
        let expected = f64::from(4 - k as u32) * weight;
        assert!((tension / expected - 1.0).abs() < 1e-4, "{k}: {tension} {expected}");
        sinks += expected / STRETCH;
    }
    let sank = -0.35 - scene.block(3).centre[2];
    assert!((sank / sinks - 1.0).abs() < 1e-3, "{sank} {sinks}");
    println!("column sinks by 1 + {:.1e}", sank / sinks - 1.0);
}

/// A physical pendulum on a hinge, let go at 60°: its period is 2 π √(I/m g l) times 2 K(sin 30°)/π to 0.1 %, its energy stays, and it does not leave its plane.
#[test]
fn a_pendulum_on_a_hinge_has_its_period() {
    for kind in ["hinge\"\naxis = [0.0, 1.0, 0.0]", "ball\""] {
        let (length, g) = (0.2, 9.81);
        let (sine, cosine) = (60_f64.to_radians().sin(), 60_f64.to_radians().cos());
        // a bar along its own z, whose end is at the origin, turned by −60° about y: its centre is at (sin, 0, −cos) of its half length
        let half = 0.5 * length;
        let at = scaled([sine, 0.0, -cosine], 1e3 * half);
        let bar = cuboid([40.0, 60.0, 1e3 * length], at, "axis = [0.0, 1.0, 0.0]\nangle_deg = -60.0");
        let pin = "radius_mm = 10.0\nthickness_mm = 10.0\nE_MPa = 20.0";
        let bodies = format!("{bar}[[joint]]\nkind = \"{kind}\nblocks = [0]\nposition_mm = [0.0, 0.0, 0.0]\n{pin}\n");
        let mut scene = fine(0.5, [0.0, 0.0, -g], &bodies);
        let mass = scene.block(0).mass;
        let inertia = mass * (length * length + 0.04 * 0.04) / 12.0 + mass * half * half;
        // complete elliptic integral by the arithmetic-geometric mean
        let (mut a, mut b) = (1.0_f64, 30_f64.to_radians().cos());
        for _ in 0..10 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        let period = 2.0 * PI * (inertia / (mass * g * half)).sqrt() / a;
        let start = scene.block(0).centre[2] * mass * g;
        let (mut passes, mut last) = (Vec::new(), [0.0, scene.block(0).centre[0]]);
        let (mut error, mut before) = (0.0_f64, None::<f64>);
        watch(&mut scene, 5.2 * period, |state, blocks| {
            let (t, x) = (state.time, blocks[0].centre[0]);
            if last[1] > 0.0 && x <= 0.0 {
                passes.push(last[0] + (t - last[0]) * last[1] / (last[1] - x));
            }
            last = [t, x];
            let now = blocks[0].centre[2] * mass * g + joint(state, 0).now.stored;
            if let Some(before) = before {
                error = error.max((blocks[0].kinetic() + 0.5 * (now + before) - start).abs());
            }
            before = Some(now);
        });
        let measured = (passes[4] - passes[0]) / 4.0;
        assert!((measured / period - 1.0).abs() < 1e-3, "{kind}: {measured} s for {period} s");
        let swing = mass * g * half * (1.0 - cosine);
        assert!(error < 1e-3 * swing, "{kind}: {error:e} of {swing:e} J");
        let out = scene.block(0).centre[1].abs();
        assert!(out < 1e-12, "{kind}: {out:e}");
        println!("{kind:?}: period {measured} / {period} = 1 + {:.2e}, energy {:.2e}", measured / period - 1.0, error / swing);
    }
}

/// Bodies that a joint holds do not touch, however deep they stand in each other; when the glue has broken they begin to touch without a force.
#[test]
fn joined_bodies_touch_only_when_their_glue_has_broken() {
    let glue = format!(
        "[[joint]]\nkind = \"glue\"\nblocks = [0, 1]\nposition_mm = [0.0, 0.0, 45.0]\naxis = [0.0, 0.0, 1.0]\nshear_MPa = 0.02\n{CEMENT}\n"
    );
    // 5 mm deep, which no contact would bear
    let bodies = cuboid([100.0; 3], [0.0; 3], "driven = true")
        + &cuboid([100.0; 3], [0.0, 0.0, 99.0], "force_N = [60.0, 0.0, 0.0]\nramp_s = 0.2\nheld = [\"rotation\", \"y\", \"z\"]")
        + &glue;
    let mut scene = fine(0.3, NO_GRAVITY, &bodies);
    let mut touched = 0;
    watch(&mut scene, 0.4, |state, _| {
        if joint(state, 0).broken.is_none() {
            touched += state.blocks().expect("bodies").touching().count();
        }
    });
    assert!(touched == 0 && joint(&scene.state, 0).broken.is_some());
    assert!(scene.block(1).centre[2] == 0.099 && scene.block(1).centre[0] > 1e-3);
    // held along z: what it was born in bears nothing
    assert!(scene.all().forces(1)[3][2].abs() < 1e-6, "{:?}", scene.all().forces(1));
}

/// In plane strain a disc hangs on a hinge as on a thread that turns with it: the period of a compound pendulum, small swings.
#[test]
fn a_disc_swings_on_a_hinge_in_plane_strain() {
    let spring = "[contact]\nlaw = \"spring\"\n[material]\nname = \"stuff\"\ngrain.density_kg_m3 = 2500.0\nelastic.E_GPa = 1.0\nelastic.nu = 0.2\ncontact.friction = 0.0\nspring.k_n_N_m = 1e8\nspring.k_t_N_m = 5e7\n";
    let (r, g) = (0.05, 9.81);
    let text = format!(
        "kind = \"mixture\"\nduration_s = 99.0\ngravity_m_s2 = [0.0, -{g:?}, 0.0]\ngrid.plane_strain = true\nstepping.safety = 0.5\n\
         [[block]]\nshape = \"polygon\"\npoints_mm = [0.0, 0.0]\nrounding_mm = 50.0\nposition_mm = [10.0, -200.0, 0.0]\n\
         [[joint]]\nkind = \"hinge\"\nblocks = [0]\nposition_mm = [0.0, 0.0, 0.0]\nradius_mm = 10.0\nthickness_mm = 10.0\nE_MPa = 20.0\n{spring}"
    );
    let mut scene = Scene::of(&text);
    let arm = (0.01_f64.powi(2) + 0.2 * 0.2).sqrt();
    let amplitude = (0.01_f64 / 0.2).atan();
    let period = 2.0 * PI * ((0.5 * r * r + arm * arm) / (g * arm)).sqrt() * (1.0 + amplitude * amplitude / 16.0);
    let (mut passes, mut last) = (Vec::new(), [0.0, 0.01]);
    watch(&mut scene, 4.2 * period, |state, blocks| {
        let (t, x) = (state.time, blocks[0].centre[0]);
        if last[1] > 0.0 && x <= 0.0 {
            passes.push(last[0] + (t - last[0]) * last[1] / (last[1] - x));
        }
        last = [t, x];
    });
    let measured = (passes[3] - passes[0]) / 3.0;
    assert!((measured / period - 1.0).abs() < 1e-3, "{measured} s for {period} s");
    println!("disc: period 1 + {:.1e}", measured / period - 1.0);
}
