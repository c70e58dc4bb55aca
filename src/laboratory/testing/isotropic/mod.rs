//! Isotropic compression of a cylindrical specimen of grains. The bottom platen is fixed; the top platen and the cylinder hold
//! the same stress under servo. The stress goes through the stages of the scene: first loading, then unloading and reloading.
//!
//! The load programme is the adaptive one of the oedometer ([`super::oedometer`]): the nearer the stresses are to the target, the
//! faster the target changes.

mod scene;

use super::SpecimenTest;
use super::oedometer::{Loading, stage_name};
use crate::error::Error;
use crate::model::{Compression, Model, Specimen};
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::record::quasi_static::Instant;
use crate::rig::cylinder::{CYLINDER, Stresses, space};
use crate::scene::material::Named;
use crate::scene::view::View;
use engine::boundary::{CylinderSpace, servo_speed};
use engine::check::Checked;
use engine::dem::{State, Workspace};
use engine::grains::Grains;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// The state of the test: that of its programme.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Isotropic(Loading);

/// Largest radial strain rate of the cylinder over the largest axial strain rate.
const SHELL: f64 = 1.0;

impl SpecimenTest for Isotropic {
    type Rig = Compression;

    fn start(model: &Model, rig: &Compression, grains: Grains, size: CylinderSpace) -> Result<(Isotropic, State), Error> {
        let (loading, state) = SpecimenTest::start(model, rig, grains, size)?;
        Ok((Isotropic(loading), state))
    }

    fn programme(&mut self, model: &Model, rig: &Compression, state: &mut State, work: &Workspace) -> Result<(), Error> {
        self.0.programme(model, rig, state, work)
    }

    fn servo(&mut self, rig: &Compression, state: &mut State) {
        self.0.servo(rig, state);
        let (size, loading) = (space(state), &self.0);
        let shell = &mut state.walls[CYLINDER];
        let (force, most) = (loading.target * size.shell_area(), SHELL * loading.limit * size.radius / size.height);
        shell.speed = servo_speed(force, shell.reaction, shell.stiffness, rig.specimen.servo_gain, state.dt, most);
    }

    fn settles(&self) -> bool {
        self.0.settles()
    }

    fn check(&self, model: &Model, rig: &Compression, state: &State) -> Checked {
        self.0.check(model, rig, state)
    }

    fn is_over(&self) -> bool {
        self.0.is_over()
    }

    fn due(&self, model: &Model, rig: &Compression, recorder: &mut Recorder, state: &State) -> Option<Due> {
        self.0.due(model, rig, recorder, state)
    }

    fn held(&self, rig: &Compression, state: &State) -> Option<Instant> {
        self.0.held(rig, state)
    }

    /// Strains are compression positive; volumetric strain is that of the space between the walls.
    fn moment(&self, rig: &Compression, state: &State) -> Moment {
        let (s, size) = (Stresses::of(state), space(state));
        let (height, radius) = self.0.start;
        let relative = size.radius / radius;
        Moment {
            stage: stage_name(&self.0, rig),
            target: self.0.target,
            held: s.vertical(),
            start_height: height,
            own: vec![
                ("radial_strain", (1.0 - relative).into()),
                ("volumetric_strain", (1.0 - size.height / height * relative * relative).into()),
                ("diameter_mm", (2e3 * size.radius).into()),
            ],
        }
    }

    fn target(&self) -> Option<f64> {
        self.0.target()
    }

    fn describe(&self, rig: &Compression, state: &State) -> (f64, String) {
        self.0.describe(rig, state)
    }

    fn summary(&self, rig: &Compression, _: &Recorder, put: &mut dyn FnMut(&str, Value)) {
        let largest = rig.loading.stages.iter().copied().fold(rig.specimen.isotropic_stress, f64::max);
        put("max_stress_kPa", json!(largest * 1e-3));
        put("diameter_mm", json!(2e3 * self.0.start.1));
        put("height_mm", json!(1e3 * self.0.start.0));
    }

    fn specimen(rig: &Compression) -> &Specimen {
        &rig.specimen
    }

    fn specimen_mut(rig: &mut Compression) -> &mut Specimen {
        &mut rig.specimen
    }

    fn largest_stress(rig: &Compression) -> f64 {
        rig.loading.stages.iter().copied().fold(0.0, f64::max)
    }

    fn of_scene(view: &View<'_>, named: &[Named]) -> Option<Compression> {
        view.isotropic(named)
    }
}
