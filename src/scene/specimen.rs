//! From the keys of a specimen to [`Specimen`].

use super::material::Named;
use super::view::View;
use crate::gradation::mean_cubed_diameter;
use crate::model::{Preparation, Specimen, WallFriction};
use std::f64::consts::PI;

impl View<'_> {
    /// The specimen of an oedometer or a triaxial test.
    pub fn specimen(&self, of: &Named) -> Option<Specimen> {
        let specimen = Specimen {
            diameter: self.si("specimen.diameter_mm"),
            grains: usize::try_from(self.whole("specimen.grains")?).ok()?,
            porosity: self.si("specimen.porosity"),
            gradation: self.gradation(of)?,
            wall_friction: WallFriction {
                bottom: self.si("walls.friction.bottom"),
                top: self.si("walls.friction.top"),
                cylinder: self.si("walls.friction.cylinder"),
            },
            isotropic_stress: self.si("specimen.isotropic_stress_kPa"),
            preparation: Preparation {
                growth_friction: self.si("preparation.growth_friction"),
                growth_steps: self.whole("preparation.growth_steps")?,
                damping: self.si("preparation.damping"),
                porosity_tolerance: self.si("preparation.porosity_tolerance"),
                max_steps: self.whole("preparation.max_steps")?,
            },
            servo_gain: self.si("loading.servo_gain"),
            settle_steps: self.whole("loading.settle_steps").unwrap_or(0),
        };
        self.room(&specimen);
        Some(specimen)
    }

    /// The grains must fit between the walls.
    fn room(&self, o: &Specimen) {
        let largest = o.gradation.last().map_or(0.0, |p| p.0);
        self.check(
            o.diameter > largest,
            "specimen.diameter_mm",
            format!("must be > {}, the largest grain at this scale", 1e3 * largest),
        );
        let height = height(o);
        self.check(
            height > largest,
            "specimen.grains",
            format!("would stand {:.1} mm high, less than the largest grain ({} mm)", 1e3 * height, 1e3 * largest),
        );
    }
}

/// Volume of the grains, m^3, expected from the gradation.
pub fn solid_volume(o: &Specimen) -> f64 {
    o.grains as f64 * PI / 6.0 * mean_cubed_diameter(&o.gradation)
}

/// Height of the specimen at its porosity, m, expected from the gradation.
pub fn height(o: &Specimen) -> f64 {
    solid_volume(o) / ((1.0 - o.porosity) * PI * o.diameter * o.diameter / 4.0)
}
