//! A pressed chain of equal grains between two walls under the linear law (eq. 13): contacts are springs k = 2 K_eff r, walls springs 2 k.
//! By mirroring, the modes are u_j = sin((j − ½) κ), κ = p π / n, with ω = 2 √(k/m) sin(κ/2); the leapfrog's own frequency is exactly
//! that of sin(ω' dt / 2) = ω dt / 2.

use crate::common::*;
use std::f64::consts::PI;

const K_EFF: f64 = 33.3e6;
const R: f64 = 0.005;
const STUFF: Stuff = Stuff { young: 1e9, poisson: 0.3, density: 2650.0, friction: 0.5, restitution: 1.0 };

/// A chain of `n` grains along x, overlapping by 1 % of the radius, with the velocities given.
fn chain(n: usize, dt: f64, velocity: impl Fn(usize) -> f64) -> (Lab, Vec<f64>) {
    let spacing = 2.0 * R * (1.0 - 0.005);
    let at: Vec<f64> = (0..n).map(|j| spacing * (j as f64 + 0.5)).collect();
    let balls: Vec<Ball> =
        (0..n).map(|j| Ball { at: [at[j], 0.0, 0.0], radius: R, velocity: [velocity(j), 0.0, 0.0], ..Ball::default() }).collect();
    let walls = [
        Plane { normal: [1.0, 0.0, 0.0], ..Plane::default() },
        Plane { normal: [-1.0, 0.0, 0.0], point: [spacing * n as f64, 0.0, 0.0], ..Plane::default() },
    ];
    let head = format!("contact.law = \"linear\"\nmaterial.linear.K_eff_MPa = {:?}\nstepping.dt_s = {dt:?}", K_EFF * 1e-6);
    (Lab::new(&assembly_text(&head, &STUFF, &balls, &walls)), at)
}

/// Every mode swings with its own frequency, over many periods.
#[test]
fn a_linear_chain_swings_in_its_modes() {
    let n = 12;
    let own = (2.0 * K_EFF * R / STUFF.mass(R)).sqrt();
    let dt = 0.05 / own;
    for p in [1, 2, 5, 11] {
        let kappa = p as f64 * PI / n as f64;
        let shape = |j: usize| ((j as f64 + 0.5) * kappa).sin();
        let omega = 2.0 * own * (0.5 * kappa).sin();
        let discrete = 2.0 / dt * (0.5 * omega * dt).asin();
        let amplitude = 1e-3 * R;
        // a leapfrog that starts from rest positions with v0 has the amplitude v0 dt / sin(ω' dt)
        let speed = amplitude * (discrete * dt).sin() / dt;
        let (mut lab, at) = chain(n, dt, |j| speed * shape(j));
        for _ in 0..4000 {
            lab.step();
            let phase = (discrete * lab.state.time).sin();
            for (j, x) in at.iter().enumerate() {
                let u = lab.position(j as u32)[0] - x;
                assert!(
                    (u - amplitude * shape(j) * phase).abs() < 1e-8 * amplitude,
                    "mode {p}, grain {j}, step {}: {u:e}",
                    lab.state.step
                );
            }
        }
        assert!(omega * lab.state.time > 20.0, "several periods");
    }
}

/// A push runs along the chain with the speed of long waves, d √(k/m): its front (half of the steady velocity) reaches grain j at j d / c,
/// dispersion keeping it behind by a part that grows as j^(1/3).
#[test]
fn a_push_runs_along_a_chain_with_the_speed_of_sound() {
    let n = 400;
    let own = (2.0 * K_EFF * R / STUFF.mass(R)).sqrt();
    let (dt, v) = (0.1 / own, 1e-4);
    let (mut lab, _) = chain(n, dt, |_| 0.0);
    // the wall pushes: grain 0 sees a wall that moves with v from now on
    lab = {
        let mut model = lab.model;
        let comminute::model::Rig::Assembly(rig) = &mut model.rig else { unreachable!() };
        rig.walls[0].drive = comminute::boundary::Drive::Velocity(v);
        Lab::of(model)
    };
    let mut arrival = [0.0f64; 2];
    let watched = [100u32, 300];
    while arrival[1] == 0.0 {
        lab.step();
        for (a, j) in arrival.iter_mut().zip(watched) {
            if *a == 0.0 && lab.velocity(j)[0] > 0.5 * v {
                *a = lab.state.time;
            }
        }
        assert!(lab.state.time * own < 400.0, "the push does not arrive");
    }
    close("time from grain 100 to 300", (arrival[1] - arrival[0]) * own, 200.0, 1e-2);
}
