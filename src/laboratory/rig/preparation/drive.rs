//! How walls move while a specimen is made on the way from loose to dense: strain that all grains share, and a servo.

use crate::model::Specimen;
use crate::rig::cylinder::{CYLINDER, Stresses, TOP, inertial_time, space};
use crate::rig::growth;
use engine::boundary::servo_speed;
use engine::dem::{State, Workspace};
use serde::{Deserialize, Serialize};

/// Inertial number of strain on the way: as fast as a packing without friction can follow under [`super::path`]'s stress.
const INERTIAL: f64 = 1e-2;
/// Steps between looks at the time scale of rearrangement.
const LOOK: u64 = 16;

/// Speeds that walls are given.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Drive {
    /// Largest strain in one unit of time (0: not yet known).
    pub rate: f64,
}

/// Mean of the walls' normal stresses, Pa.
pub fn mean_stress(state: &State) -> f64 {
    let s = Stresses::of(state);
    (s.top + s.bottom + s.horizontal) / 3.0
}

impl Drive {
    /// Strain rate at which grains under `stress` are rearranged.
    pub fn at(state: &State, stress: f64) -> Drive {
        Drive { rate: INERTIAL / inertial_time(state, stress) }
    }

    /// Strains the specimen and its walls alike in one step, `along` its axis and `across` it, compression positive: what a platen alone would press together
    /// next to itself is shared by all.
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

    /// Top and cylinder towards `asked`, Pa.
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
