//! Lets two equal spheres of quartz collide head-on and measures the coefficient of restitution: relative speed after the
//! impact over that before.
//!
//! Prints two tables. In the first one the contact law is Hertz's with viscous damping: the restitution that the scene sets
//! beside the measured one, which does not depend on the speed. In the second one contacts yield (`elasto_plastic`): the
//! measured restitution falls with the speed, beside the closed form of Thornton (1997, J. Appl.
//! Mech. 64, 383). Fails if a measured value differs by more than 0.002.
//!
//! ```text
//! cargo run --release --example two_grains_collide
//! ```

use comminute::rig::assembly;
use comminute::{Result, Rig, Workspace, scene};
use std::f64::consts::{FRAC_PI_2, PI};

/// Radius of both spheres, m.
const RADIUS: f64 = 0.005;
/// Density, kg/m³, Young's modulus, Pa, and Poisson ratio of quartz.
const DENSITY: f64 = 2650.0;
const YOUNG: f64 = 70e9;
const POISSON: f64 = 0.17;
/// Pressure in the middle of a contact at which the second law yields, Pa.
const YIELD_PRESSURE: f64 = 2e9;

fn main() -> Result<()> {
    println!("Hertz with viscous damping (hertz_viscous)\n  speed (m/s)   restitution set   measured");
    for set in [0.3, 0.6, 0.9] {
        for speed in [0.01, 1.0, 10.0] {
            let measured = restitution(speed, &format!("contact.law = \"hertz_viscous\"\nmaterial.contact.restitution = {set:?}"))?;
            println!("  {speed:11}   {set:15}   {measured:8.5}");
            assert!((measured - set).abs() < 2e-3, "the restitution is {measured}, not {set}");
        }
    }

    let yields_from = yield_speed();
    println!("\nContacts that yield (elasto_plastic), V_y = {yields_from:.4} m/s\n  speed / V_y   closed form   measured");
    let law = format!("contact.law = \"elasto_plastic\"\nmaterial.contact.yield_pressure_MPa = {:?}", 1e-6 * YIELD_PRESSURE);
    for ratio in [0.5, 2.0, 10.0, 50.0] {
        let measured = restitution(ratio * yields_from, &law)?;
        let expected = thornton(ratio);
        println!("  {ratio:11}   {expected:11.5}   {measured:8.5}");
        assert!((measured - expected).abs() < 2e-3, "the restitution is {measured}, not {expected}");
    }
    Ok(())
}

/// Coefficient of restitution of the two spheres at the relative speed `speed`, m/s; `law` holds the lines of the scene that
/// choose the contact law.
fn restitution(speed: f64, law: &str) -> Result<f64> {
    let (half_gap, half_speed) = (1e-6 * RADIUS, 0.5 * speed);
    let time_step = duration_of_impact(speed) / 2000.0;
    let text = format!(
        r#"
kind = "assembly" # grains and walls that the scene lists
steps = 100000
{law}
material.name = "quartz"
material.grain.density_kg_m3 = {DENSITY:?}
material.elastic.E_GPa = {:?}
material.elastic.nu = {POISSON:?}
material.contact.friction = 0.3
stepping.dt_s = {time_step:?}

[[grain]]
position_m = [{:?}, 0.0, 0.0]
radius_m = {RADIUS:?}
velocity_m_s = [{half_speed:?}, 0.0, 0.0]

[[grain]]
position_m = [{:?}, 0.0, 0.0]
radius_m = {RADIUS:?}
velocity_m_s = [{:?}, 0.0, 0.0]
"#,
        1e-9 * YOUNG,
        -RADIUS - half_gap,
        RADIUS + half_gap,
        -half_speed,
    );
    let model = scene::model(&scene::from_text(&text, ".", &[])?)?;
    let Rig::Assembly(rig) = &model.rig else { unreachable!("the scene's kind is assembly") };
    let mut state = assembly::start(&model, rig);
    let mut work = Workspace::new(&model.physics, &mut state);
    loop {
        assembly::advance(&model, &mut state, &mut work, |_, _| Ok(()))?;
        // each array of the grains holds four numbers a grain: x, y, z and one more (`Grains`)
        let [left, right] = if state.grains.pos[0][0] < state.grains.pos[1][0] { [0, 1] } else { [1, 0] };
        let gap = state.grains.pos[right][0] - state.grains.pos[left][0] - 2.0 * RADIUS;
        let leaving = state.grains.vel[right][0] - state.grains.vel[left][0];
        if gap > 0.0 && leaving > 0.0 {
            return Ok(leaving / speed);
        }
    }
}

/// Modulus E*, Pa, radius R*, m, and mass m*, kg, of two equal spheres in contact.
fn reduced() -> (f64, f64, f64) {
    let mass = DENSITY * 4.0 / 3.0 * PI * RADIUS.powi(3);
    (0.5 * YOUNG / (1.0 - POISSON * POISSON), 0.5 * RADIUS, 0.5 * mass)
}

/// Duration of an elastic impact at the relative speed `speed`, s: 2.943 δ/v with Hertz's largest overlap δ = (15 m* v²/(16 E*
/// √R*))^(2/5).
fn duration_of_impact(speed: f64) -> f64 {
    let (modulus, radius, mass) = reduced();
    let overlap = (15.0 * mass * speed * speed / (16.0 * modulus * radius.sqrt())).powf(0.4);
    2.943 * overlap / speed
}

/// Least relative speed, m/s, at which the contact yields: V_y² = 16/15 (π/2)⁵ p_y⁵ R*³/(E*⁴ m*).
fn yield_speed() -> f64 {
    let (modulus, radius, mass) = reduced();
    (16.0 / 15.0 * FRAC_PI_2.powi(5) * YIELD_PRESSURE.powi(5) * radius.powi(3) / (modulus.powi(4) * mass)).sqrt()
}

/// Thornton's restitution at `ratio` times the yield speed.
fn thornton(ratio: f64) -> f64 {
    let x = 1.0 / ratio.max(1.0);
    (1.2 * 3f64.sqrt()).sqrt() * (1.0 - x * x / 6.0).sqrt() * (x / (x + 2.0 * (1.2 - 0.2 * x * x).sqrt())).powf(0.25)
}
