//! Regular packings under small confined compression, against closed forms. The lattice moves affinely from the start, so that by its
//! symmetry every grain inside is in balance at every instant and no waves run.
//!
//! Simple cubic, rows on rows, platens mirror the lattice: overlap ε d, σ = F/d², hence σ = E/(1−ν²) ε^{3/2} / 3 (Hertz) and σ = K_eff ε (linear).
//!
//! Face-centred cubic, square layers, load across them, θ = 45° between branch and load: overlap δ = d ε cos²θ, sliding d ε sin θ cos θ,
//! four contacts per grain and layer: σ_v = 4 (N cos θ + T sin θ)/d², σ_h = 2 (N sin θ − T cos θ)/d², with N Hertz's force and T = 0
//! without friction, T = μ N where the contact slides, T = 4 (G*/E*) tan θ · N where it sticks (Mindlin's stiffness along the Hertz
//! path; Walton 1987).

use crate::common::*;
use std::f64::consts::FRAC_1_SQRT_2;

const D: f64 = 0.01;
const STUFF: Stuff = Stuff { young: 1e9, poisson: 0.3, density: 2500.0, friction: 0.0, restitution: 1.0 };

/// Platen and side stresses of a simple cubic block of `n`³ grains after `strain`.
fn simple_cubic(law: &str, friction: f64, strain: f64) -> [f64; 3] {
    let n = 4;
    let steps = 400;
    let dt = 1e-7;
    let rate = strain / (f64::from(steps) * dt);
    let mut balls = Vec::new();
    for k in 0..n * n * n {
        let at = [k % n, k / n % n, k / n / n].map(|c| D * (f64::from(c) + 0.5));
        balls.push(Ball { at, radius: 0.5 * D, velocity: [0.0, 0.0, -rate * at[2]], ..Ball::default() });
    }
    let size = D * f64::from(n);
    let plane = |a: usize, sign: f64, at: f64, velocity: f64| {
        let mut p = Plane { friction, velocity, ..Plane::default() };
        p.normal[a] = sign;
        p.point[a] = at;
        p
    };
    let walls = [
        plane(2, 1.0, 0.0, 0.0),
        plane(2, -1.0, size, rate * size),
        plane(0, 1.0, 0.0, 0.0),
        plane(0, -1.0, size, 0.0),
        plane(1, 1.0, 0.0, 0.0),
        plane(1, -1.0, size, 0.0),
    ];
    let stuff = Stuff { friction, ..STUFF };
    let mut lab = Lab::new(&assembly_text(&format!("{law}\nstepping.dt_s = {dt:?}"), &stuff, &balls, &walls));
    lab.steps(steps as usize + 1);
    [0, 1, 2].map(|k| lab.state.walls[k].reaction / (size * size))
}

#[test]
fn simple_cubic_packings_have_their_stiffness() {
    for friction in [0.0, 0.5] {
        for strain in [1e-5, 1e-4, 1e-3] {
            let [bottom, top, side] = simple_cubic("contact.law = \"hertz\"", friction, strain);
            // overlaps are differences of lengths, summed over the steps
            let rounding = f64::max(1e-8, 1e-12 / strain);
            let closed = STUFF.plane_modulus() * strain.powf(1.5) / 3.0;
            close("simple cubic, Hertz, bottom", bottom, closed, rounding);
            close("top", top, closed, rounding);
            near("side", side / closed, 0.0, rounding);
            let [bottom, top, side] = simple_cubic("contact.law = \"linear\"\nmaterial.linear.K_eff_MPa = 33.3", friction, strain);
            close("simple cubic, linear, bottom", bottom, 33.3e6 * strain, rounding);
            close("top", top, 33.3e6 * strain, rounding);
            near("side", side / top, 0.0, rounding);
        }
    }
}

/// Vertical and horizontal stress of a face-centred cubic block after `strain`. Its outermost grains are so heavy that they keep their
/// affine motion; what those in the middle of its faces bear is the stress.
fn face_centred(law: &str, friction: f64, strain: f64, steps: usize) -> [f64; 2] {
    let (n, layers) = (6, 7);
    let dt = 1e-7;
    let rate = strain / (steps as f64 * dt);
    let mut balls: Vec<Ball> = Vec::new();
    for k in 0..layers {
        let (count, shift) = if k % 2 == 0 { (n, 0.0) } else { (n - 1, 0.5) };
        for j in 0..count {
            for i in 0..count {
                let at = [D * (f64::from(i) + shift), D * (f64::from(j) + shift), D * FRAC_1_SQRT_2 * f64::from(k)];
                balls.push(Ball { at, radius: 0.5 * D, velocity: [0.0, 0.0, -rate * at[2]], ..Ball::default() });
            }
        }
    }
    let places: Vec<[f64; 3]> = balls.iter().map(|b| b.at).collect();
    let neighbours = |at: [f64; 3]| places.iter().filter(|p| (length(minus(**p, at)) / D - 1.0).abs() < 1e-6).count();
    for b in &mut balls {
        b.material = Some(if neighbours(b.at) == 12 { "light" } else { "heavy" });
    }
    let named = |name: &str, density: f64| {
        let stuff = Stuff { friction, density, ..STUFF };
        let toml = stuff.toml() + "linear.K_eff_MPa = 33.3\n";
        toml.lines().map(|l| format!("materials.{name}.{l}\n")).collect::<String>()
    };
    let head = format!("{law}\nstepping.dt_s = {dt:?}\nrecords.energy = false\n{}{}", named("light", 2500.0), named("heavy", 1e13));
    let mut lab = Lab::new(&assembly_text_of(&head, &balls, &[]));
    lab.steps(steps);
    let find = |at: [f64; 3]| places.iter().position(|p| length(minus(*p, at)) < 1e-6 * D).expect("a grain there") as u32;
    let middle = D * f64::from(n / 2 - 1);
    let top = find([middle, middle, D * FRAC_1_SQRT_2 * f64::from(layers - 1)]);
    let side = find([D * f64::from(n - 1), middle, D * FRAC_1_SQRT_2 * 2.0]);
    let inside = find([middle, middle, D * FRAC_1_SQRT_2 * 2.0]);
    let [top, side, inside] = lab.watch([top, side, inside]);
    let bears = length(top.force);
    assert!(length(inside.force) < 1e-6 * bears, "a grain inside is in balance: {:?} of {bears}", inside.force);
    assert!(length(inside.torque) < 1e-6 * bears * D, "a grain inside does not turn");
    [top.force[2] / (D * D), side.force[0] / (D * D * 2.0f64.sqrt())]
}

#[test]
fn face_centred_packings_have_their_stiffness() {
    let c = FRAC_1_SQRT_2;
    let strain: f64 = 1e-5;
    let e_pair = 0.5 * STUFF.plane_modulus();
    let g_pair = STUFF.shear() / (2.0 * (2.0 - STUFF.poisson));
    let overlap = D * strain * c * c;
    let normal = 4.0 / 3.0 * e_pair * (0.25 * D).sqrt() * overlap.powf(1.5);
    let sticking = 4.0 * g_pair / e_pair;
    for (what, friction, ratio) in [("frictionless", 0.0, 0.0), ("sliding", 0.3, 0.3), ("sticking", 10.0, sticking)] {
        let [v, h] = face_centred("contact.law = \"hertz\"", friction, strain, 20_000);
        close(&format!("{what}, vertical"), v, 4.0 * normal * c * (1.0 + ratio) / (D * D), 1e-4);
        close(&format!("{what}, horizontal"), h, 2.0 * normal * c * (1.0 - ratio) / (D * D), 3e-4);
    }
    // linear: N = 2 K_eff D1 D2/(D1 + D2) δ, T = α_S k_N s with s = d ε sin θ cos θ = δ, so T = α_S N
    let normal = 33.3e6 * D * overlap;
    for (what, friction, ratio) in [("frictionless", 0.0, 0.0), ("sliding", 0.1, 0.1), ("sticking", 10.0, 0.25)] {
        let [v, h] = face_centred("contact.law = \"linear\"", friction, strain, 1000);
        close(&format!("linear, {what}, vertical"), v, 4.0 * normal * c * (1.0 + ratio) / (D * D), 1e-4);
        close(&format!("linear, {what}, horizontal"), h, 2.0 * normal * c * (1.0 - ratio) / (D * D), 1e-4);
    }
}
