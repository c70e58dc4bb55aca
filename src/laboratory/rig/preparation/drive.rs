//! The motion of the walls in [`super::path`]: a uniform strain of the whole specimen, and a stress servo.

use crate::model::Specimen;
use crate::rig::cylinder::{CYLINDER, Stresses, TOP, inertial_time, space};
use crate::rig::growth;
use engine::boundary::servo_speed;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};

/// Inertial number of the uniform strain: as fast as a packing without friction can follow under the stress of [`super::path`].
const INERTIAL: f64 = 1e-2;
/// Steps between two updates of the strain rate under servo.
const LOOK: u64 = 16;

/// The strain rate at which a specimen is strained.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Drive {
    /// Largest strain rate, 1/s; 0 as long as it has not been found.
    pub rate: f64,
}

/// Mean of the stresses on top, bottom and cylinder, Pa.
pub fn mean_stress(state: &State) -> f64 {
    let s = Stresses::of(state);
    (s.top + s.bottom + s.horizontal) / 3.0
}

impl Drive {
    /// The strain rate of inertial number [`INERTIAL`] under `stress`, Pa.
    pub fn at(state: &State, stress: f64) -> Drive {
        Drive { rate: INERTIAL / inertial_time(state, stress) }
    }

    /// Strains grains and walls by the same amount in one step, at the rates `along` the axis and `across` it, 1/s, compression
    /// positive. A platen that moved alone would compress only the grains next to it.
    pub fn strain(along: f64, across: f64, state: &mut State, work: &mut Workspace) {
        let size = space(state);
        let (z, xy) = (along * state.dt, across * state.dt);
        for p in &mut state.grains.pos {
            *p = [p[0] - xy * p[0], p[1] - xy * p[1], p[2] - z * (p[2] - size.bottom), p[3]];
        }
        state.walls[TOP].speed = along * size.height;
        state.walls[CYLINDER].speed = across * size.radius;
        work.grown(&state.grains);
    }

    /// Moves the top platen and the cylinder under servo towards the stress `asked`, Pa; `steps` counts the steps of the stage.
    pub fn servo(&mut self, asked: f64, steps: u64, rig: &Specimen, state: &mut State) {
        let size = space(state);
        if steps.is_multiple_of(LOOK) {
            state.reference_stress = Stresses::of(state).top.clamp(rig.isotropic_stress, asked.max(rig.isotropic_stress));
            self.rate = growth::INERTIAL / inertial_time(state, state.reference_stress);
        }
        let walls = [(TOP, size.platen_area(), size.height), (CYLINDER, size.shell_area(), size.radius)];
        for (k, area, length) in walls {
            let w = &mut state.walls[k];
            w.speed = servo_speed(asked * area, w.reaction, w.stiffness, rig.servo_gain, state.dt, self.rate * length);
        }
    }
}
