//! Compresses a small specimen of petroleum coke in an oedometer, step by step, and watches its grains break.
//!
//! The scene is that of run H-C-2 of Ciantia et al. (2015), made small: fewer and larger grains, a looser specimen, a lower
//! stress. Prints, at each doubling of the vertical stress, the stress, the void ratio of all dry mass (grains and what
//! breakages have lost), the stress ratio σ_h/σ_v, the number of grains and the breakages. Fails unless every breakage replaces
//! one grain by 14, grains and lost mass together keep the mass, and the void ratio falls from row to row.
//!
//! ```text
//! cargo run --release --example oedometer_step_by_step
//! ```

use comminute::record::specimen;
use comminute::rig::cylinder::{Stresses, space};
use comminute::rig::preparation::Preparation;
use comminute::testing::SpecimenTest;
use comminute::testing::oedometer::{Loading, Phase};
use comminute::{Result, Rig, State, Workspace, scene};

fn main() -> Result<()> {
    let changes = [
        "specimen.scale=4.0",
        "specimen.grains=240",
        "specimen.porosity=0.46",
        "preparation.growth_friction=0.4",
        "preparation.growth_steps=1500",
        "preparation.porosity_tolerance=0.02",
        "loading.settle_steps=500",
        "loading.max_stress_kPa=1000",
    ];
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/experiments/petroleum_coke/h-c-2.toml");
    let model = scene::model(&scene::load(path, &changes.map(String::from))?)?;
    let Rig::Oedometer(rig) = &model.rig else { unreachable!("the scene's kind is oedometer") };

    // grains grow in the ring until the specimen has its porosity and rests under the isotropic stress
    let (mut preparation, mut state) = Preparation::start(&model, &rig.specimen);
    let mut work = Workspace::new(&model.physics, &mut state);
    while !preparation.advance(&model, &rig.specimen, &mut state, &mut work)? {}
    println!("specimen of {} grains, made in {} steps", state.grains.len(), preparation.steps());

    // the test begins with the same grains at rest
    let (grains, ring) = specimen::at_rest(&state, &model.physics.materials);
    let (mut loading, mut state) = Loading::start(&model, rig, grains, ring)?;
    let mut work = Workspace::new(&model.physics, &mut state);
    let density = model.physics.materials[0].density;
    let (grains_before, mass_before) = (state.grains.len() as u64, dry_mass(&state));

    println!("σ_v (kPa)   void ratio   σ_h/σ_v   grains   breakages   steps");
    let (mut next, mut rows) = (10e3, Vec::new());
    while !loading.is_over() {
        // the closure sees the state when the forces of this instant are known, before the grains move
        loading.advance(&model, rig, &mut state, &mut work, &mut |loading, state, _| {
            let stresses = Stresses::of(state);
            if matches!(loading.phase, Phase::Load(_) | Phase::Hold(_)) && stresses.vertical() >= next {
                let void_ratio = space(state).volume() / (dry_mass(state) / density) - 1.0;
                println!(
                    "{:9.1}   {void_ratio:10.4}   {:7.3}   {:6}   {:9}   {:5}",
                    1e-3 * stresses.vertical(),
                    stresses.horizontal / stresses.vertical(),
                    state.grains.len(),
                    state.crush_events,
                    state.step,
                );
                rows.push(void_ratio);
                next = 2.0 * stresses.vertical();
            }
            Ok(())
        })?;
        // `work.breakages` holds the breakages of this step: each grain with its force and its
        // strength
        if let Some(first) = work.breakages.first().filter(|first| first.event == 1) {
            println!("first breakage: a grain of {:.1} mm at {:.0} N", 1e3 * first.diameter, first.force);
        }
    }

    assert!(state.crush_events > 0, "nothing broke");
    assert_eq!(state.grains.len() as u64, grains_before + 13 * state.crush_events, "one grain becomes 14");
    let change = dry_mass(&state) / mass_before - 1.0;
    assert!(change.abs() < 1e-12, "the dry mass has changed by {change:e} of itself");
    assert!(rows.len() > 4 && rows.windows(2).all(|pair| pair[1] < pair[0]), "void ratios that do not fall: {rows:?}");
    Ok(())
}

/// Mass of the grains and of what breakages have lost, kg.
fn dry_mass(state: &State) -> f64 {
    state.grains.mass_and_volume().0 + state.lost.iter().map(|(mass, _)| mass).sum::<f64>()
}
