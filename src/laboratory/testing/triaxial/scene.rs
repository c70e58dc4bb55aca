//! Makes [`Shear`] from the keys of a triaxial test.

use crate::model::Shear;
use crate::scene::view::View;

impl View<'_> {
    /// The shear programme of the scene.
    pub fn shear(&self) -> Shear {
        Shear {
            axial_strain: self.si("loading.axial_strain"),
            inertial_number: self.si("loading.inertial_number"),
            record_every: self.number("records.every_strain").unwrap_or(0.001),
            record_at: self.numbers("records.at_strain"),
        }
    }
}
