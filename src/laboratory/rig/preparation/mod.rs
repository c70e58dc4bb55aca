//! Preparation of a cylindrical specimen of a given porosity. There are two ways: `stated` grows the radii with the friction
//! that the scene states (`preparation.growth_friction`), as in Ciantia et al. (2015); `path` densifies one loose specimen step
//! by step and stops at the target, which needs no friction from the user.

mod drive;
pub(crate) mod path;
pub mod range;
pub(crate) mod stated;

use crate::error::Error;
use crate::model::{Model, Specimen};
use crate::packing;
use crate::rig::cylinder::{self, CYLINDER, space, walls};
use crate::rig::growth;
use engine::check::{self, Checked, ensure};
use engine::dem::physics::Physics;
use engine::dem::{State, Workspace};
use engine::grains::{Grains, sphere_volume};
use path::{Path, Wish};
use serde::{Deserialize, Serialize};
use stated::Stated;

/// The state of a preparation; with the [`State`] of the grains it is all that a restart needs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Preparation {
    /// With a stated friction during growth.
    Stated(Stated),
    /// On the way from the loosest to the densest specimen.
    Path(Box<Path>),
}

impl Preparation {
    /// The first state: small grains at random places in a cylinder that is larger than the specimen.
    pub fn start(model: &Model, rig: &Specimen) -> (Preparation, State) {
        if let Some(friction) = rig.preparation.growth_friction {
            let (stated, state) = Stated::start(model, rig, friction);
            return (Preparation::Stated(stated), state);
        }
        let (path, state) = Path::start(model, rig, Wish::Porosity(rig.porosity));
        (Preparation::Path(Box::new(path)), state)
    }

    /// One step. True when the specimen is ready: at rest at its porosity and isotropic stress.
    ///
    /// # Errors
    /// [`Error::Stalled`]: the porosity cannot be reached, or the specimen does not come to rest.
    pub fn advance(&mut self, model: &Model, rig: &Specimen, state: &mut State, work: &mut Workspace) -> Result<bool, Error> {
        match self {
            Preparation::Stated(stated) => stated.advance(model, rig, state, work),
            Preparation::Path(path) => path.advance(model, rig, state, work),
        }
    }

    /// Checks a preparation from a checkpoint, with its grains.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self, model: &Model, rig: &Specimen, state: &State) -> Checked {
        match self {
            Preparation::Stated(stated) => stated.check(model, rig, state),
            Preparation::Path(path) => path.check(model, rig, state),
        }
    }

    /// Name of the present stage, for the progress bar.
    pub fn stage(&self) -> &'static str {
        match self {
            Preparation::Stated(stated) => stated.stage.name(),
            Preparation::Path(path) => path.stage.name(),
        }
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        match self {
            Preparation::Stated(stated) => stated.steps,
            Preparation::Path(path) => path.steps,
        }
    }
}

/// Final radii by id, m, and the first state: grains of [`growth::START`] times their size at random places in a cylinder in
/// which the grown grains will have the porosity `porosity`. `friction` is the friction coefficient while they grow.
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

/// Checks one state of the grains of a preparation: those of the specimen, none of them broken. `radii` are their final radii by id, m.
fn check_state(physics: &Physics, rig: &Specimen, radii: &[f64], state: &State) -> Checked {
    cylinder::check(physics, rig, state, false)?;
    check::lengths("grains of the specimen", radii.len(), [state.grains.len(), state.grains.next_id as usize])
}

/// Checks the final radii of a preparation and its place in time: `growth` are the steps of growth done.
fn check_growth(model: &Model, rig: &Specimen, radii: &[f64], growth: Option<u64>) -> Checked {
    ensure(*radii == packing::radii(rig, model.seeds.packing), || "the grains are not those of the scene".into())?;
    ensure(growth.is_none_or(|n| n < rig.preparation.growth_steps), || "growth goes on beyond its end".into())
}

/// Whether each of the walls `held` bears the stress `stress`, Pa, within [`growth::STRESS_AT_REST`].
fn bears(state: &State, held: &[usize], stress: f64) -> bool {
    let size = space(state);
    held.iter().all(|&k| {
        let area = if k == CYLINDER { size.shell_area() } else { size.platen_area() };
        (state.walls[k].reaction / area / stress - 1.0).abs() < growth::STRESS_AT_REST
    })
}

/// Porosity of the grains in the space between the walls. The volume of overlaps is not subtracted from that of the grains.
pub fn porosity(state: &State) -> f64 {
    let (_, volume) = state.grains.mass_and_volume();
    1.0 - volume / space(state).volume()
}
