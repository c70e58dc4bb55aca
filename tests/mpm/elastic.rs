//! Closed forms of linear elasticity.

use crate::common::*;
use comminute::mpm::{Dimension, Settings, ShapeFunctions, Transfer, Wall};
use std::f64::consts::PI;

const OPEN: Wall = Wall::Open;
const SYMMETRY: Wall = Wall::Symmetry;

/// A strip one cell wide between smooth walls, held at x = 0 and free at the other end.
fn strip(cell: f64, length: u32) -> Settings {
    let mut s = settings(Dimension::PlaneStrain, cell, [length, 1, 1]);
    s.walls = [SYMMETRY, OPEN, SYMMETRY, SYMMETRY, OPEN, OPEN];
    s
}

/// Period and relative change of kinetic energy plus stress work of the first axial mode after two periods, with cells of `cell` m.
/// Bar fixed at x = 0, free at L, v = v0 sin(πx/2L): ω₁ = (π/2L)√(E/ρ); L = 25, E = 100, ρ = 1, v0 = 0.1 give a period of 10 s.
fn bar(cell: f64, shape: ShapeFunctions) -> (f64, f64) {
    let mut s = strip(cell, (30.0 / cell) as u32);
    s.shape = shape;
    let points = fill(&s, [[0.0; 3], [25.0, cell, 0.0]], 2, 1.0, |_| true, |[x, ..]| [0.1 * (PI * x / 50.0).sin(), 0.0, 0.0]);
    let mut c = continuum(s, elastic(100.0, 0.0), points);
    let dt = 0.2 * cell / 10.0;
    let start = c.totals().kinetic;
    let (mut last, mut zeros) = (0.0, vec![]);
    for k in 1..=(20.0 / dt).round() as u64 {
        c.step(dt).unwrap();
        let v = c.totals().momentum[0];
        if last * v < 0.0 {
            zeros.push((k as f64 - v / (v - last)) * dt);
        }
        last = v;
    }
    let t = c.totals();
    (2.0 * (zeros[3] - zeros[0]) / 3.0, (t.kinetic + c.stress_work()) / start - 1.0)
}

#[test]
fn a_bar_vibrates_with_its_frequency_and_keeps_its_energy() {
    for (cell, shape, in_period, in_energy) in [
        (1.0, ShapeFunctions::BSpline, 0.02, 0.01),
        (0.5, ShapeFunctions::BSpline, 0.01, 0.01),
        (0.5, ShapeFunctions::Gimp { half_width: 0.25 }, 0.01, 0.01),
    ] {
        let (period, energy) = bar(cell, shape);
        println!("bar, cell {cell}, {shape:?}: period {period} s of 10, energy changed by {energy:e}");
        assert!((period / 10.0 - 1.0).abs() < in_period && energy.abs() < in_energy);
    }
}

/// A bell of velocity parts into two that run with c = √(M/ρ); E = 10 MPa, ν = 0.3, ρ = 2000: 82.041265 m/s.
#[test]
fn a_compression_wave_has_its_speed() {
    let s = strip(0.1, 200);
    let bell = |x: f64| (-(x - 5.0) * (x - 5.0)).exp();
    let points = fill(&s, [[0.0; 3], [19.0, 0.1, 0.0]], 2, 2000.0, |_| true, |[x, ..]| [1e-3 * bell(x), 0.0, 0.0]);
    let mut c = continuum(s, elastic(10e6, 0.3), points);
    let (dt, n) = (2e-4, 500_u32);
    steps(&mut c, dt, n.into());
    let points = c.points();
    // beyond the middle between the reflection of the other half and this one
    let ahead = (0..points.len()).filter(|&i| points.position[i][0] > 9.5);
    let (p, px) =
        ahead.fold((0.0, 0.0), |(p, px), i| (p + points.velocity[i][0], px + points.velocity[i][0] * points.position[i][0]));
    let speed = (px / p - 5.0) / (f64::from(n) * dt);
    println!("wave: {speed} m/s of 82.041265");
    assert!((speed / 82.041_265 - 1.0).abs() < 2e-3);
}

/// A column under its own weight between smooth walls is an oedometer: E = 10 MPa, ν = 0.3, ρ = 2000, H = 1, g = 9.81 give M = 13.461538 MPa,
/// a settlement ρgH²/2M of 0.00072874286 m, σz = ρg(H − z), and K0 = 0.42857143.
#[test]
fn a_column_settles_as_an_oedometer() {
    for (dimension, shape) in [
        (Dimension::PlaneStrain, ShapeFunctions::BSpline),
        (Dimension::Space, ShapeFunctions::BSpline),
        (Dimension::PlaneStrain, ShapeFunctions::Gimp { half_width: 0.25 }),
    ] {
        for floor in [SYMMETRY, Wall::Friction { friction: 0.0 }, Wall::Stick] {
            let (cell, n) = (0.05, 20);
            let mut s = settings(dimension, cell, [1, n + 2, 1]);
            s.walls = SMOOTH;
            (s.walls[2], s.walls[3]) = (floor, OPEN);
            (s.gravity, s.damping, s.shape) = ([0.0, -9.81, 0.0], 0.4, shape);
            let width = if dimension == Dimension::Space { cell } else { 0.0 };
            let points = fill(&s, [[0.0; 3], [cell, 1.0, width]], 2, 2000.0, |_| true, |_| [0.0; 3]);
            let start = points.clone();
            let mut c = continuum(s, elastic(10e6, 0.3), points);
            let dt = c.stable_step(0.4);
            steps(&mut c, dt, 3000);
            let points = c.points();
            let (rho_g, m) = (2000.0 * 9.81, 13.461_538e6);
            let (mut in_stress, mut in_settlement, mut in_k0): (f64, f64, f64) = (0.0, 0.0, 0.0);
            for i in 0..points.len() {
                let z = start.position[points.id[i] as usize][1];
                let settled = z - points.position[i][1];
                in_settlement = in_settlement.max((settled - rho_g / m * (z - 0.5 * z * z)).abs() / (0.5 * rho_g / m));
                in_stress = in_stress.max((points.stress[i][1] + rho_g * (1.0 - z)).abs() / rho_g);
                in_k0 = in_k0.max((points.stress[i][0] - 3.0 / 7.0 * points.stress[i][1]).abs() / rho_g);
            }
            let weight = c.totals().mass * 9.81;
            let in_reaction = c.wall_force()[2][1] / weight - 1.0;
            println!(
                "column, {dimension:?}, {shape:?}, {floor:?}: stress {in_stress:e}, settlement {in_settlement:e}, K0 {in_k0:e}, reaction {in_reaction:e}, kinetic {:e}",
                c.totals().kinetic
            );
            assert!(in_stress < 0.02 && in_settlement < 0.01 && in_k0 < 1e-3 && in_reaction.abs() < 1e-3);
        }
    }
}

/// Uniform gradient of velocity, points at random: every point sees it exactly, edges included, when points carry affine fields.
#[test]
fn a_uniform_strain_is_seen_exactly() {
    let a = [[0.3, -0.2, 0.5], [0.1, 0.4, -0.6], [0.7, -0.1, 0.2]];
    let field = |x: [f64; 3]| a.map(|row: [f64; 3]| row[0] * x[0] + row[1] * x[1] + row[2] * x[2]);
    let mut random = 1_u64;
    let mut draw = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / (1_u64 << 24) as f64
    };
    let mut s = settings(Dimension::Space, 0.1, [10, 10, 10]);
    s.transfer = Transfer::Affine;
    let mut points = fill(&s, [[0.3; 3], [0.7; 3]], 2, 1000.0, |_| true, |_| [0.0; 3]);
    for i in 0..points.len() {
        let x: [f64; 3] = std::array::from_fn(|_| 0.3 + 0.4 * draw());
        let v = field(x);
        points.position[i][..3].copy_from_slice(&x);
        points.velocity[i][..3].copy_from_slice(&v);
    }
    // λ = 0, 2G = E: stress over E is strain
    let mut c = continuum(s, elastic(1e-6, 0.0), points);
    c.points_mut().affine.fill(std::array::from_fn(|column| std::array::from_fn(|row| a[row][column])));
    // the field itself changes by A² Δt in the step
    let dt = 1e-9;
    c.step(dt).unwrap();
    let exact = [a[0][0], a[1][1], a[2][2], 0.5 * (a[0][1] + a[1][0]), 0.5 * (a[1][2] + a[2][1]), 0.5 * (a[0][2] + a[2][0])];
    let mut worst: f64 = 0.0;
    for stress in &c.points().stress {
        for k in 0..6 {
            worst = worst.max((stress[k] / 1e-6 / dt - exact[k]).abs());
        }
    }
    println!("uniform strain: worst rate {worst:e} 1/s of 0.7");
    assert!(worst < 3e-9);
}

/// A box full of points at uniform stress between smooth walls stays as it is.
#[test]
fn a_uniform_stress_is_in_equilibrium() {
    for shape in [ShapeFunctions::BSpline, ShapeFunctions::Gimp { half_width: 0.25 }] {
        let mut s = settings(Dimension::Space, 0.1, [5, 5, 5]);
        (s.walls, s.shape) = (SMOOTH, shape);
        let mut points = fill(&s, [[0.0; 3], [0.5; 3]], 2, 1000.0, |_| true, |_| [0.0; 3]);
        points.stress.fill([-1e5, -2e5, -3e5, 0.0, 0.0, 0.0]);
        let mut c = continuum(s, elastic(10e6, 0.3), points);
        let dt = c.stable_step(0.5);
        steps(&mut c, dt, 100);
        let fastest = c.points().velocity.iter().flat_map(|v| [v[0], v[1], v[2]]).fold(0.0_f64, |a, v| a.max(v.abs()));
        let reaction = c.wall_force().map(|f| f.iter().map(|f| f.abs()).fold(0.0, f64::max));
        println!("uniform stress, {shape:?}: fastest {fastest:e} m/s after {:e} s, walls {reaction:?} N", 100.0 * dt);
        // 1e5 Pa over 1000 kg/m³ and 0.1 m would accelerate by 1000 m/s²
        assert!(fastest < 1e-12 * 1000.0 * 100.0 * dt);
        for (side, exact) in [1e5, 1e5, 2e5, 2e5, 3e5, 3e5].into_iter().enumerate() {
            assert!((reaction[side] / (0.25 * exact) - 1.0).abs() < 1e-10);
        }
    }
}

/// What is left of the angular momentum of a spinning elastic disk after one turn, and its largest stress over ρω²R².
/// ω = 1 rad/s, R = 1 m, ρ = 1000 kg/m³, E = 1 MPa.
fn disk(transfer: Transfer) -> (f64, f64) {
    let mut s = settings(Dimension::PlaneStrain, 0.2, [16, 16, 1]);
    s.transfer = transfer;
    let inside = |[x, y, _]: [f64; 3]| (x - 1.6) * (x - 1.6) + (y - 1.6) * (y - 1.6) < 1.0;
    let points = fill(&s, [[0.0; 3], [3.2, 3.2, 0.0]], 2, 1000.0, inside, |[x, y, _]| [1.6 - y, x - 1.6, 0.0]);
    let mut c = continuum(s, elastic(1e6, 0.3), points);
    if transfer == Transfer::Affine {
        c.points_mut().affine.fill([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0; 3]]);
    }
    let start = c.totals().angular_momentum[2];
    let n = 4000;
    steps(&mut c, 2.0 * PI / f64::from(n), n as u64);
    let stress = c.points().stress.iter().flatten().fold(0.0_f64, |a, s| a.max(s.abs()));
    (c.totals().angular_momentum[2] / start, stress / 1000.0)
}

/// Affine fields keep it to rounding, FLIP loses some and rings, PIC loses all.
#[test]
fn a_spinning_disk_keeps_its_angular_momentum_with_affine_fields() {
    let blends = [0.0, 0.001, 0.01, 1.0].map(|pic| disk(Transfer::Blend { pic }));
    let affine = disk(Transfer::Affine);
    println!("disk after one turn, angular momentum and stress/ρω²R²: APIC {affine:?}, PIC share 0, 0.001, 0.01, 1: {blends:?}");
    assert!((affine.0 - 1.0).abs() < 1e-12 && affine.1 < 1.0, "APIC");
    assert!(blends[0].0 > 0.8 && blends[0].0 < 1.0, "FLIP");
    assert!(blends[3].0.abs() < 0.01, "PIC");
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
        s.walls[2] = Wall::Friction { friction };
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
