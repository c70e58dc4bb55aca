//! Impacts of contacts that yield (Thornton 1997): restitution against speed in closed form, energy, momentum.

use super::impact::{impact, on_wall, pair};
use crate::common::*;
use std::f64::consts::FRAC_PI_2;

const QUARTZ: Stuff = Stuff { young: 70e9, poisson: 0.17, density: 2650.0, friction: 0.0, restitution: 1.0 };
const YIELD_PRESSURE: f64 = 2e9;

fn law(yield_pressure: f64) -> String {
    format!("contact.law = \"elasto_plastic\"\nmaterial.contact.yield_pressure_MPa = {:?}", 1e-6 * yield_pressure)
}

/// Restitution at the speed V, x = V_y/V <= 1.
fn thornton(x: f64) -> f64 {
    let x2 = x * x;
    (1.2 * 3f64.sqrt()).sqrt() * (1.0 - x2 / 6.0).sqrt() * (x / (x + 2.0 * (1.2 - 0.2 * x2).sqrt())).powf(0.25)
}

/// Least speed, m/s, at which a contact yields: V_y² = 16/15 (π/2)⁵ p_y⁵ R*³/(E*⁴ m*).
fn yield_speed(young: f64, r_eff: f64, m_eff: f64) -> f64 {
    (16.0 / 15.0 * FRAC_PI_2.powi(5) * YIELD_PRESSURE.powi(5) * r_eff.powi(3) / (young.powi(4) * m_eff)).sqrt()
}

/// The values of the formula as they stand in tables of it.
#[test]
fn the_formula_gives_the_table() {
    for (ratio, e) in [(1.0, 1.0), (2.0, 0.9306259), (10.0, 0.6585583), (100.0, 0.374299)] {
        near(&format!("V/V_y = {ratio}"), thornton(1.0 / ratio), e, 1e-7);
    }
    // far above the yield speed e = 1.185 (V_y/V)^(1/4)
    close("limit", thornton(1e-6), 1.185 * 1e-6f64.powf(0.25), 1e-3);
}

#[test]
fn restitution_falls_with_the_speed_as_in_closed_form() {
    let radii = [0.003, 0.011];
    let [m1, m2] = radii.map(|r| QUARTZ.mass(r));
    let (r_eff, m_eff) = (radii[0] * radii[1] / (radii[0] + radii[1]), m1 * m2 / (m1 + m2));
    for ratio in [0.5, 1.0, 1.5, 2.0, 5.0, 20.0, 100.0] {
        let expected = if ratio <= 1.0 { 1.0 } else { thornton(1.0 / ratio) };
        let speed = ratio * yield_speed(0.5 * QUARTZ.plane_modulus(), r_eff, m_eff);
        let step = 2e-4 * (m_eff / (QUARTZ.plane_modulus() * r_eff)).sqrt();
        let mut lab = pair(&QUARTZ, radii, speed, 100.0 * step, &law(YIELD_PRESSURE));
        near(&format!("two spheres at {ratio} V_y"), impact(&mut lab, radii, true).rebound / speed, expected, 2e-3);
        let speed = ratio * yield_speed(QUARTZ.plane_modulus(), 0.003, m1);
        let step = 2e-2 * (m1 / (QUARTZ.plane_modulus() * 0.003)).sqrt();
        let mut lab = on_wall(&QUARTZ, 0.003, [speed, 0.0, 0.0], [0.0; 3], 0.0, step, &law(YIELD_PRESSURE));
        near(&format!("on a wall at {ratio} V_y"), impact(&mut lab, radii, false).rebound / speed, expected, 2e-3);
    }
}

/// What an impact takes from the motion is what the ledger says that yielding has taken, with the automatic step.
#[test]
fn the_ledger_knows_what_yielding_takes() {
    let radius = 0.004;
    let speed = 8.0 * yield_speed(QUARTZ.plane_modulus(), radius, QUARTZ.mass(radius));
    let ball = Ball { at: [-radius * 1.00001, 0.0, 0.0], radius, velocity: [speed, 0.3 * speed, 0.0], ..Ball::default() };
    let wall = Plane { normal: [-1.0, 0.0, 0.0], friction: 0.2, ..Plane::default() };
    let mut lab = Lab::new(&assembly_text(&law(YIELD_PRESSURE), &Stuff { friction: 0.2, ..QUARTZ }, &[ball], &[wall]));
    let before = lab.balance();
    impact(&mut lab, [radius; 2], false);
    let after = lab.balance();
    let scale = 0.5 * QUARTZ.mass(radius) * speed * speed;
    let taken = after.viscous - before.viscous;
    close("taken by yielding", taken / scale, 1.0 - thornton(1.0 / 8.0).powi(2), 1e-2);
    let (residual, unaccounted) = (after.residual(), after.nonconservative());
    assert!(residual.abs() < 1e-3 * scale && unaccounted.abs() < 1e-2 * scale, "{residual:e}, {unaccounted:e} of {scale:e} J");
}

/// A contact that has yielded unloads along another curve than it has been loaded on, and loads again on that one.
#[test]
fn a_contact_remembers_the_largest_overlap_until_it_opens() {
    let radius = 0.004;
    let speed = 8.0 * yield_speed(QUARTZ.plane_modulus(), radius, QUARTZ.mass(radius));
    let step = 1e-2 * (QUARTZ.mass(radius) / (QUARTZ.plane_modulus() * radius)).sqrt();
    let mut lab = on_wall(&QUARTZ, radius, [speed, 0.0, 0.0], [0.0; 3], 0.0, step, &law(YIELD_PRESSURE));
    impact(&mut lab, [radius; 2], false);
    let kept = lab.state.wall_pairs.largest[0];
    assert!(lab.state.wall_pairs.touch[0].overlap < kept && kept > 0.0, "force ends before the overlap does");
    while lab.position(0)[0] > -radius {
        lab.step();
    }
    lab.steps(2);
    assert_eq!(lab.state.wall_pairs.largest[0], 0.0);
}
