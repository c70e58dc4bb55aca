//! Closed forms of linear elasticity.

use crate::common::*;
use comminute::mpm::{Dimension, GridWall, Settings, ShapeFunctions, Transfer};
use comminute::verify::{bar, block, column, disk, patch, wave};
use std::f64::consts::PI;

#[test]
fn a_bar_vibrates_with_its_frequency_and_keeps_its_energy() {
    for (cells, method) in [(25, block::FLIP), (50, block::FLIP), (50, block::GIMP), (50, block::APIC)] {
        let [period, energy] = bar::vibrate(method, cells).unwrap().errors[..] else { panic!() };
        println!("bar, {cells} cells, {method:?}: period {period:e}, energy {energy:e}");
        assert!(period.abs() < 2e-3 && energy.abs() < 1e-3);
    }
}

#[test]
fn a_compression_wave_has_its_speed() {
    for method in [block::FLIP, block::GIMP, block::APIC] {
        let [speed, momentum] = wave::travel(method, 10).unwrap().errors[..] else { panic!() };
        println!("wave, {method:?}: speed {speed:e}, momentum {momentum:e}");
        assert!(speed.abs() < 2e-3 && momentum.abs() < 1e-4);
    }
}

/// A column under its own weight between smooth walls is an oedometer.
#[test]
fn a_column_settles_as_an_oedometer() {
    for (dimension, method, in_stress) in [
        (Dimension::PlaneStrain, block::FLIP, 3e-3),
        (Dimension::Space, block::FLIP, 3e-3),
        (Dimension::PlaneStrain, block::GIMP, 2e-2),
    ] {
        for floor in [GridWall::Symmetry, GridWall::Friction { friction: 0.0 }, GridWall::Stick] {
            let [stress, settlement, k0, reaction] = column::settle(method, dimension, floor, 20).unwrap().errors[..] else {
                panic!()
            };
            println!(
                "column, {dimension:?}, {method:?}, {floor:?}: stress {stress:e}, settlement {settlement:e}, K0 {k0:e}, reaction {reaction:e}"
            );
            assert!(stress < in_stress && settlement < 2e-3 && k0 < 1e-9 && reaction.abs() < 1e-3);
        }
    }
}

/// Uniform gradient of velocity, points at random: every point sees it exactly, edges included, when points carry affine fields.
#[test]
fn a_uniform_strain_is_seen_exactly() {
    let worst = patch::gradient(4).unwrap().errors[0];
    println!("uniform strain: worst rate {worst:e}");
    assert!(worst < 4e-9);
}

/// A box full of points at uniform stress between smooth walls stays as it is.
#[test]
fn a_uniform_stress_is_in_equilibrium() {
    for method in [block::FLIP, block::GIMP] {
        let [fastest, walls] = patch::equilibrium(method, 5).unwrap().errors[..] else { panic!() };
        println!("uniform stress, {method:?}: fastest {fastest:e}, walls {walls:e}");
        assert!(fastest < 1e-12 && walls < 1e-10);
    }
}

/// Affine fields keep it to rounding, FLIP loses some and rings, PIC loses all.
#[test]
fn a_spinning_disk_keeps_its_angular_momentum_with_affine_fields() {
    let [affine, flip, pic] = [block::APIC, block::FLIP, block::PIC].map(|m| disk::spin(m, 5).unwrap().errors);
    println!("disk after one turn, angular momentum, stress, largest stress/ρω²R²: APIC {affine:?}, FLIP {flip:?}, PIC {pic:?}");
    assert!(affine[0].abs() < 1e-12 && affine[1] < 0.1 && affine[2] < 1.0, "APIC");
    assert!(flip[0] > -0.2 && flip[0] < 0.0, "FLIP");
    assert!((1.0 + pic[0]).abs() < 0.01, "PIC");
}

/// A spinning disk that was pressed along x beforehand: the stress turns with the material. After a quarter turn what was σxx is σyy. The
/// disk is so heavy (ω = 1 rad/s against 0.01 Pa) that the stress moves nothing.
#[test]
fn a_stress_turns_with_its_material() {
    let mut s = settings(Dimension::PlaneStrain, 0.2, [16, 16, 1]);
    s.transfer = Transfer::Affine;
    let inside = |[x, y, _]: [f64; 3]| (x - 1.6) * (x - 1.6) + (y - 1.6) * (y - 1.6) < 1.0;
    let mut points = fill(&s, [[0.0; 3], [3.2, 3.2, 0.0]], 2, 1e9, inside, |[x, y, _]| [1.6 - y, x - 1.6, 0.0]);
    points.stress.fill([-0.01, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // next to no stiffness, so that what is left is the turned stress; rigid rotation is free of forces only for a while
    let mut c = continuum(s, elastic(1e-9, 0.0), points);
    c.points_mut().affine.fill([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]]);
    let n = 200;
    steps(&mut c, PI / 40.0 / f64::from(n), n as u64);
    let (sin, cos) = (PI / 40.0).sin_cos();
    let exact = [-0.01 * cos * cos, -0.01 * sin * sin, -0.01 * sin * cos];
    let worst = c.points().stress.iter().map(|s| (s[0] - exact[0]).abs().max((s[1] - exact[1]).abs()).max((s[3] - exact[2]).abs()));
    let worst = worst.fold(0.0, f64::max) / 0.01;
    println!("turned stress: worst {worst:e}");
    assert!(worst < 0.01);
}

/// v = −g t, and with the step's order y falls by g Δt² n (n + 1)/2.
#[test]
fn a_block_falls_freely() {
    for transfer in [FLIP, Transfer::Affine, Transfer::Blend { pic: 0.3 }] {
        let mut s = settings(Dimension::Space, 0.1, [6, 30, 6]);
        (s.gravity, s.transfer) = ([0.0, -9.81, 0.0], transfer);
        let points = fill(&s, [[0.2, 2.0, 0.2], [0.4, 2.3, 0.4]], 2, 1000.0, |_| true, |_| [0.0; 3]);
        let start = points.clone();
        let mut c = continuum(s, elastic(1e5, 0.3), points);
        let (dt, n) = (1e-3, 500);
        steps(&mut c, dt, n);
        let n = n as f64;
        let mut worst: f64 = 0.0;
        for i in 0..c.points().len() {
            let (p, v) = (c.points().position[i], c.points().velocity[i]);
            let fallen = start.position[c.points().id[i] as usize][1] - p[1];
            worst =
                worst.max((fallen / (9.81 * dt * dt * 0.5 * n * (n + 1.0)) - 1.0).abs()).max((v[1] / (-9.81 * n * dt) - 1.0).abs());
        }
        let stress = c.points().stress.iter().flatten().fold(0.0_f64, |a, s| a.max(s.abs()));
        println!("free fall, {transfer:?}: {worst:e}, stress {stress:e} Pa");
        assert!(worst < 1e-11 && stress < 1e-6);
    }
}

/// Two blocks collide off centre with nothing around them.
#[test]
fn momentum_is_kept_to_rounding() {
    for (transfer, shape) in [
        (FLIP, ShapeFunctions::BSpline),
        (Transfer::Affine, ShapeFunctions::BSpline),
        (Transfer::Blend { pic: 0.1 }, ShapeFunctions::Gimp { half_width: 0.25 }),
    ] {
        let mut s = settings(Dimension::Space, 0.1, [20, 20, 20]);
        (s.transfer, s.shape) = (transfer, shape);
        let gap = |x: [f64; 3]| if x[0] < 1.0 { x[1] < 1.2 } else { x[0] > 1.1 && x[1] > 0.9 };
        let v = |x: [f64; 3]| if x[0] < 1.0 { [3.0, 0.5, -0.25] } else { [-1.0, 0.0, 0.125] };
        let points = fill(&s, [[0.6, 0.7, 0.7], [1.5, 1.4, 1.2]], 2, 1000.0, gap, v);
        let mut c = continuum(s, elastic(1e6, 0.3), points);
        let start = c.totals();
        let dt = c.stable_step(0.3);
        steps(&mut c, dt, 150);
        let end = c.totals();
        let scale = (2.0 * start.mass * start.kinetic).sqrt();
        let worst = (0..3).map(|a| (end.momentum[a] - start.momentum[a]).abs() / scale).fold(0.0, f64::max);
        println!("collision, {transfer:?}, {shape:?}: momentum changed by {worst:e}; kinetic {} of {}", end.kinetic, start.kinetic);
        assert!(worst < 1e-13);
        assert!(end.kinetic < 0.95 * start.kinetic, "they have met");
    }
}

/// A block on a slope of 30° with μ = 0.1 (Li et al. 2023, section 3.2, for grains): a = g (sin 30° − μ cos 30°).
#[test]
fn a_block_slides_against_friction() {
    for friction in [0.0, 0.1, 0.3] {
        let mut s = settings(Dimension::PlaneStrain, 0.1, [30, 8, 1]);
        s.walls[2] = GridWall::Friction { friction };
        let (g, angle) = (9.81, PI / 6.0);
        s.gravity = [g * angle.sin(), -g * angle.cos(), 0.0];
        s.transfer = Transfer::Blend { pic: 0.01 };
        let mut points = fill(&s, [[0.5, 0.0, 0.0], [1.1, 0.3, 0.0]], 2, 1800.0, |_| true, |_| [0.2, 0.0, 0.0]);
        // of its weight and of full friction, so that it neither bounces nor has to wait for shear to come down from its top
        for (stress, position) in points.stress.iter_mut().zip(&points.position) {
            stress[1] = -1800.0 * g * angle.cos() * (0.3 - position[1]);
            stress[2] = 0.3 * stress[1];
            stress[3] = -friction * stress[1];
        }
        let mut c = continuum(s, elastic(1e6, 0.3), points);
        let dt = c.stable_step(0.4);
        let n = (0.5 / dt) as u64;
        steps(&mut c, dt, n);
        let t = c.totals();
        let exact = g * (angle.sin() - friction * angle.cos()) * n as f64 * dt;
        let error = (t.momentum[0] / t.mass - 0.2) / exact - 1.0;
        println!("slope, mu {friction}: velocity off by {error:e}");
        assert!(error.abs() < 0.01);
    }
}

#[test]
fn lost_points_are_named() {
    let s = settings(Dimension::Space, 0.1, [10, 10, 10]);
    let flying = |v: [f64; 3]| {
        let points = fill(&s, [[0.2; 3], [0.4; 3]], 2, 1000.0, |_| true, |_| v);
        let mut c = continuum(s.clone(), elastic(1e6, 0.3), points);
        (0..1000).find_map(|_| c.step(1e-3).err()).expect("lost").to_string()
    };
    let outside = flying([3.0, 0.0, 0.0]);
    assert!(outside.contains("point ") && outside.contains("step ") && outside.contains("left the grid"), "{outside}");
    let fast = flying([300.0, 0.0, 0.0]);
    assert_eq!(fast, "step 1: point 0 has passed more than one cell in a step: use a smaller time step");
    let nan = flying([f64::MAX, f64::MAX, 0.0]);
    assert!(nan.contains("step 1: point 0"), "{nan}");
    let mut points = fill(&s, [[0.2; 3], [0.4; 3]], 2, 1000.0, |_| true, |_| [0.0; 3]);
    points.position[5][2] = 1.01;
    let told = comminute::mpm::Continuum::new(s.clone(), elastic(1e6, 0.3), points).unwrap_err().to_string();
    assert!(told.contains("point 5 position") && told.contains("outside of the grid"), "{told}");
    // one point whose field pulls it together by 400/s along each axis
    let one = |x: [f64; 3]| x == [0.225; 3];
    let points = fill(&s, [[0.2; 3], [0.4; 3]], 2, 1000.0, |x| one(x.map(|x| (1e6 * x).round() / 1e6)), |_| [0.0; 3]);
    assert_eq!(points.len(), 1);
    let mut c = continuum(Settings { transfer: Transfer::Affine, ..s }, elastic(1e6, 0.3), points);
    assert!(c.check_step(1.0).unwrap_err().to_string().contains("must be above 0 and at most"));
    c.points_mut().affine.fill([[-400.0, 0.0, 0.0], [0.0, -400.0, 0.0], [0.0, 0.0, -400.0]]);
    let inverted = c.step(3e-3).unwrap_err().to_string();
    assert!(inverted.starts_with("step 1: point 0 is turned inside out"), "{inverted}");
}
