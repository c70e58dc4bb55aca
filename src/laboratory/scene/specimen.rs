//! Makes [`Specimen`] from the keys of a specimen.

use super::material::Named;
use super::view::View;
use crate::gradation::mean_cubed_diameter;
use crate::model::{Preparation, Specimen, WallFriction};
use std::f64::consts::PI;

/// Keys that give the density directly.
pub const DENSITIES: [&str; 3] = ["specimen.porosity", "specimen.void_ratio", "specimen.height_mm"];

const ONE_DENSITY: &str = "must have porosity, void_ratio, relative_density or height_mm, one of them";

impl View<'_> {
    /// The specimen of an oedometer or a triaxial test.
    pub fn specimen(&self, of: &Named) -> Option<Specimen> {
        let gradation = self.gradation(of)?;
        let diameter = self.si("specimen.diameter_mm");
        let grains = self.number_of_grains(of, &gradation)?;
        let solid = grains as f64 * PI / 6.0 * mean_cubed_diameter(&gradation);
        let mut specimen = Specimen {
            diameter,
            grains,
            porosity: f64::NAN,
            relative_density: self.relative_density(),
            range: None,
            gradation,
            wall_friction: WallFriction {
                bottom: self.si("walls.friction.bottom"),
                top: self.si("walls.friction.top"),
                cylinder: self.si("walls.friction.cylinder"),
            },
            isotropic_stress: self.si("specimen.isotropic_stress_kPa"),
            preparation: Preparation {
                growth_friction: self.number("preparation.growth_friction"),
                growth_steps: self.whole("preparation.growth_steps")?,
                damping: self.si("preparation.damping"),
                porosity_tolerance: self.si("preparation.porosity_tolerance"),
                max_steps: self.whole("preparation.max_steps")?,
            },
            servo_gain: self.si("loading.servo_gain"),
            settle_steps: self.whole("loading.settle_steps").unwrap_or(0),
        };
        specimen.porosity = match specimen.relative_density {
            Some(density) => super::reach::estimated(&specimen).porosity(density),
            None => self.porosity(solid, diameter)?,
        };
        self.room(&specimen);
        Some(specimen)
    }

    /// The relative density, where the scene states one.
    fn relative_density(&self) -> Option<f64> {
        const KEY: &str = "specimen.relative_density";
        let density = self.number(KEY)?;
        self.check(
            self.number("preparation.growth_friction").is_none(),
            KEY,
            "needs preparation.growth_friction = \"auto\": a relative density refers to the range of specimens that are made in this way",
        );
        self.check(DENSITIES.iter().all(|k| self.number(k).is_none()), "specimen", ONE_DENSITY);
        Some(density)
    }

    /// Number of grains: as stated, or from the dry mass.
    fn number_of_grains(&self, of: &Named, gradation: &[(f64, f64)]) -> Option<usize> {
        let mass = self.number("specimen.dry_mass_g").map(|grams| 1e-3 * grams);
        match (self.whole("specimen.grains"), mass) {
            (Some(grains), None) => usize::try_from(grains).ok(),
            (None, Some(mass)) => {
                let one = self.si(&of.key("grain.density_kg_m3")) * PI / 6.0 * mean_cubed_diameter(gradation);
                let grains = (mass / one).round();
                if !(1.0..=1e8).contains(&grains) {
                    self.refuse("specimen.dry_mass_g", format!("would be {grains:.0} grains; must be 1 to 100 million"));
                    return None;
                }
                Some(grains as usize)
            }
            _ => {
                self.refuse("specimen", "must have grains or dry_mass_g, one of them");
                None
            }
        }
    }

    /// Porosity, as said or from the void ratio or the height.
    fn porosity(&self, solid: f64, diameter: f64) -> Option<f64> {
        let mut given = DENSITIES.iter().filter_map(|k| self.number(k).map(|value| (*k, value)));
        let (Some((key, value)), None) = (given.next(), given.next()) else {
            self.refuse("specimen", ONE_DENSITY);
            return None;
        };
        let porosity = match key {
            "specimen.void_ratio" => value / (1.0 + value),
            "specimen.height_mm" => 1.0 - solid / (0.25 * PI * diameter * diameter * value),
            _ => value,
        };
        let possible = porosity > 0.0 && porosity < 1.0;
        self.check(
            possible,
            key,
            format!("is a porosity of {porosity:.3}: the grains alone fill {:.4} mm", 4e3 * solid / (PI * diameter * diameter)),
        );
        possible.then_some(porosity)
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
