//! Shoots a grain at an elastic ball of the same mass that is made of material points, and follows the momentum of both (Li et
//! al. 2023, section 3.1).
//!
//! Grain and points touch by the run's contact law; each side makes steps of its own length. Prints the velocity of the grain
//! and the mean velocity of the points in the course of the impact: the grain nearly stops, the points go on. Fails unless mass
//! and momentum of both together are kept to rounding and the ball of points takes over at least 70 % of the velocity.
//!
//! ```text
//! cargo run --release --example mixture
//! ```

use comminute::rig::continuum::{Engine, Phase, State};
use comminute::{Result, Rig, scene};

fn main() -> Result<()> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/mixture/ball_impact.toml");
    let model = scene::model(&scene::load(path, &[])?)?;
    let Rig::Continuum(rig) = &model.rig else { unreachable!("the scene's kind is mixture") };

    let mut state = State::start(&model, rig)?;
    let mut engine = Engine::of_grains(&mut state, &model, rig);
    let (mass, momentum) = total(&state);
    println!("{} points; grain and points {mass:.4} kg, momentum {:.5} kg m/s", state.continuum.points().len(), momentum[2]);

    println!("time (ms)   grain (m/s)   points (m/s)");
    let mut next = 0.0;
    while state.phase != Phase::Done {
        // the closure sees the state when the forces of this instant are known; the number that it
        // returns matters to a graphics device only
        state.advance(&model, rig, &mut engine, |state, _| {
            if state.time >= next {
                let [grain, points] = velocities(state);
                println!("{:9.3}   {grain:11.4}   {points:12.4}", 1e3 * state.time);
                next += 0.25e-3;
            }
            Ok(1.0)
        })?;
    }

    let (mass_after, momentum_after) = total(&state);
    let [grain, points] = velocities(&state);
    assert_eq!(mass_after, mass, "the mass has changed");
    for (after, before) in momentum_after.iter().zip(momentum) {
        assert!((after - before).abs() < 1e-12 * momentum[2].abs(), "the momentum has changed: {momentum:?}, {momentum_after:?}");
    }
    assert!(grain.abs() < 1.5 && points < -3.5, "the points have not taken over the grain's velocity: {grain} and {points} m/s");
    Ok(())
}

/// Mass, kg, and momentum, kg m/s, of grains and points together.
fn total(state: &State) -> (f64, [f64; 3]) {
    let Some(mixture) = &state.mixture else { unreachable!("the scene has a grain") };
    mixture.mass_and_momentum(&state.continuum)
}

/// Vertical velocity of the grain, and of all points together, m/s.
fn velocities(state: &State) -> [f64; 2] {
    let Some(mixture) = &state.mixture else { unreachable!("the scene has a grain") };
    let points = state.continuum.totals();
    [mixture.grains.grains.vel[0][2], points.momentum[2] / points.mass]
}
