//! Records of a triaxial test: when rows are due, and the test's own columns.

use super::{Phase, Shearing};
use crate::model::Triaxial;
use crate::record::cylinder::{Due, Moment, Recorder};
use crate::rig::cylinder::{Stresses, space};
use engine::dem::State;

impl Recorder {
    /// The record of a triaxial test that is due now; `None`: none is.
    pub fn due_in_shear(&mut self, rig: &Triaxial, shearing: &Shearing, state: &State) -> Option<Due> {
        let shear = &rig.shear;
        let strain = shearing.axial_strain(state);
        let level = (strain / shear.record_every + 1e-9).floor() as i64;
        let passed = shear.record_at.iter().filter(|&&at| at <= strain).count();
        let (full, row) = match (shearing.phase, self.last) {
            (Phase::Settle, _) => (false, false),
            (Phase::Shear, None) | (Phase::Done, _) => (true, true),
            (Phase::Shear, Some((_, last))) => (passed > self.next_at, level > last),
        };
        if !(full || row) {
            return None;
        }
        self.last = Some((0, level));
        self.next_at = passed;
        Some(if full { Due::Full } else { Due::Row })
    }
}

/// The measures of a triaxial test for a row of the history. Strains are compression positive; the volumetric strain is that of
/// the space between the walls.
pub fn moment(rig: &Triaxial, shearing: &Shearing, state: &State) -> Moment {
    let (s, size) = (Stresses::of(state), space(state));
    let (height, radius) = shearing.start;
    let (v, h) = (s.vertical(), s.horizontal);
    let relative = size.radius / radius;
    let volumetric = 1.0 - size.height / height * relative * relative;
    Moment {
        stage: "shear",
        target: rig.specimen.isotropic_stress,
        held: h,
        start_height: height,
        own: vec![
            ("radial_strain", (1.0 - relative).into()),
            ("volumetric_strain", volumetric.into()),
            ("diameter_mm", (2e3 * size.radius).into()),
            ("stress_ratio", (3.0 * (v - h) / (v + 2.0 * h)).into()),
            ("friction_angle_deg", ((v - h) / (v + h)).asin().to_degrees().into()),
        ],
    }
}
