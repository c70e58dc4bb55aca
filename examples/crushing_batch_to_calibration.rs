//! Crushes single grains of silica sand between two steel platens in the engine, and finds the law of their strength from the
//! crushing forces alone.
//!
//! The engine draws each grain's strength from σ_lim,0 (d/d0)^(-3/m) times a truncated normal number with the coefficient of
//! variation var. (Ciantia et al. 2015, eqs 6, 7, 16; Table 1). The calibration gets diameters and forces and the angle θ0 of
//! eq. 16, as it would from a laboratory. Prints σ_lim,0, m and var.: given, found by maximum likelihood, and their 95 %
//! intervals. Fails if an interval does not hold the given value.
//!
//! ```text
//! cargo run --release --example crushing_batch_to_calibration
//! ```

use comminute::calibrate::grains::area::Area;
use comminute::calibrate::grains::data::{Data, Grain};
use comminute::calibrate::grains::fit::{Fit, Intervals};
use comminute::calibrate::grains::spread::Spread;
use comminute::rig::grain_crushing::press;
use comminute::{Result, Rig, scene};
use std::f64::consts::PI;

/// Contact angle θ0 of the scene's material, rad (Table 1).
const THETA0: f64 = PI / 24.0;

fn main() -> Result<()> {
    // 50 grains of each of the sizes 1, 2, 4 and 8 mm
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/platen/silica.toml");
    let model = scene::model(&scene::load(path, &["batch.grains=50".into()])?)?;
    let Rig::GrainCrushing(rig) = &model.rig else { unreachable!("the scene's kind is platen") };

    let mut grains = Vec::new();
    for number in 0..rig.diameters.len() as u32 {
        // each test has its own state; the closure could end a test early by returning true
        let Some(test) = press(&model, rig, number, || false)? else { unreachable!("no test is ended early") };
        grains.push(Grain { diameter: test.diameter, force: test.force, censored: !test.broken, series: 0 });
    }
    println!("{} grains pressed, {} broke", grains.len(), grains.iter().filter(|g| !g.censored).count());

    let Some(crush) = &model.physics.crush else { unreachable!("grains of the scene can break") };
    let given = &crush.strength;
    let data = Data { path: "batch".into(), grains, series: vec![String::new()], notes: Vec::new() };
    let fit = Fit::new(&data, Area::fixed_angle(Some(THETA0)), Spread::TruncatedNormal, given.d0)
        .with_intervals(&data, Intervals::Profile);

    println!("                  given      found   95 % interval");
    for (name, given, found) in
        [("σ_lim,0 (MPa)", 1e-6 * given.sigma_lim0, fit.sigma_lim0_mpa()), ("m", given.m, fit.m()), ("var.", given.var, fit.var())]
    {
        let number = |value: Option<f64>| value.unwrap_or(f64::NAN);
        println!(
            "{name:13} {given:9.4} {:10.4}   {:.4} to {:.4}",
            number(found.estimate),
            number(found.lower),
            number(found.upper)
        );
        assert!(found.width().is_some() && found.holds(given), "the interval of {name} does not hold {given}");
    }
    Ok(())
}
