//! Preparation of a cylindrical specimen: with the friction while growing that the scene states, or on the way from the loosest to the densest.

mod drive;
pub(crate) mod path;
pub mod range;
pub(crate) mod stated;

use crate::error::Error;
use crate::model::{Model, Specimen};
use crate::packing;
use crate::rig::cylinder::{CYLINDER, space, walls};
use crate::rig::growth;
use engine::dem::{State, Workspace};
use engine::grains::{Grains, sphere_volume};
use path::{Path, Wish};
use serde::{Deserialize, Serialize};
use stated::Stated;

/// Progress of a preparation; with the [`State`] it is all that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Preparation {
    Stated(Stated),
    Path(Box<Path>),
}

impl Preparation {
    /// The first state: grains at a fraction of their size, at random in a cylinder with some room.
    pub fn start(model: &Model, rig: &Specimen) -> (Preparation, State) {
        if let Some(friction) = rig.preparation.growth_friction {
            let (stated, state) = Stated::start(model, rig, friction);
            return (Preparation::Stated(stated), state);
        }
        let (path, state) = Path::start(model, rig, Wish::Porosity(rig.porosity));
        (Preparation::Path(Box::new(path)), state)
    }

    /// One step. True when the specimen is ready.
    pub fn advance(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
        match self {
            Preparation::Stated(stated) => stated.advance(model, rig, state, work),
            Preparation::Path(path) => path.advance(model, rig, state, work),
        }
    }

    /// What it is doing, for a person to read.
    pub fn stage(&self) -> &'static str {
        match self {
            Preparation::Stated(stated) => stated.stage.name(),
            Preparation::Path(path) => path.stage.name(),
        }
    }

    /// Steps so far.
    pub fn steps(&self) -> u64 {
        match self {
            Preparation::Stated(stated) => stated.steps,
            Preparation::Path(path) => path.steps,
        }
    }
}

/// Final radii by id, m, and the first state: grains at a fraction of their size, at random in a cylinder in which they will leave so many pores.
fn scattered(model: &Model, rig: &Specimen, porosity: f64, friction: f64) -> (Vec<f64>, State) {
    let radii = packing::radii(rig, model.seeds.packing);
    let volume: f64 = radii.iter().map(|&r| sphere_volume(r)).sum();
    let radius = 0.5 * rig.diameter;
    let height = packing::height_for(porosity, volume, radius);
    let points = packing::random_points(radius, height, &radii, model.seeds.packing);
    let mut grains = Grains::default();
    for (&r, &p) in radii.iter().zip(&points) {
        grains.add(p, growth::START * r, 0, &model.physics.materials);
    }
    let mut state = State::new(&model.physics, grains, walls(rig, radius, 0.0, height), false);
    state.friction = Some(friction);
    state.damping = rig.preparation.damping;
    state.stability_interval = 1;
    (radii, state)
}

/// Whether these walls bear a stress, Pa, as nearly as at rest.
fn bears(state: &State, held: &[usize], stress: f64) -> bool {
    let size = space(state);
    held.iter().all(|&k| {
        let area = if k == CYLINDER { size.shell_area() } else { size.platen_area() };
        (state.walls[k].reaction / area / stress - 1.0).abs() < growth::STRESS_AT_REST
    })
}

/// Porosity of the grains in the space between the walls (overlaps not subtracted).
pub fn porosity(state: &State) -> f64 {
    let (_, volume) = state.grains.mass_and_volume();
    1.0 - volume / space(state).volume()
}
