//! From the keys of an oedometer to [`Oedometer`].

use super::material::Named;
use super::view::View;
use crate::gradation::mean_cubed_diameter;
use crate::model::{Loading, Oedometer, Preparation, WallFriction};
use std::f64::consts::PI;

impl View<'_> {
    pub fn oedometer(&self, of: &Named) -> Option<Oedometer> {
        let gradation = self.gradation(of)?;
        let oedometer = Oedometer {
            diameter: self.si("specimen.diameter_mm"),
            grains: usize::try_from(self.whole("specimen.grains")?).ok()?,
            porosity: self.si("specimen.porosity"),
            gradation,
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
            loading: self.loading(),
        };
        self.room(&oedometer);
        Some(oedometer)
    }

    fn loading(&self) -> Loading {
        let mut stages = vec![self.si("loading.max_stress_kPa")];
        stages.extend(self.numbers("loading.stages_kPa"));
        let loading = Loading {
            stages,
            rate: self.si("loading.rate"),
            sigma_ref: self.si("loading.sigma_ref_kPa"),
            pace: (self.text("loading.programme") == "adaptive").then(|| self.si("loading.pace")),
            servo_gain: self.si("loading.servo_gain"),
            max_inertial_number: self.si("loading.max_inertial_number"),
            max_lag: self.si("loading.max_lag"),
            settle_steps: self.whole("loading.settle_steps").unwrap_or(0),
        };
        let isotropic = self.si("specimen.isotropic_stress_kPa");
        let (kpa, sigma_ref) = (1e-3 * isotropic, 1e-3 * loading.sigma_ref);
        self.check(
            loading.stages[0] > isotropic,
            "loading.max_stress_kPa",
            format!("must be > {kpa}, the isotropic stress at the start"),
        );
        self.check(
            isotropic >= loading.sigma_ref,
            "specimen.isotropic_stress_kPa",
            format!("must be >= {sigma_ref}, the reference stress of eq. 18"),
        );
        let low = loading.stages.iter().any(|s| *s < loading.sigma_ref);
        self.check(!low, "loading.stages_kPa", format!("must all be >= {sigma_ref}, the reference stress of eq. 18"));
        let idle = loading.stages.windows(2).any(|w| w[0] == w[1]);
        self.check(!idle, "loading.stages_kPa", "must each differ from the stress before it");
        loading
    }

    /// The grains must fit between the walls.
    fn room(&self, o: &Oedometer) {
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
pub fn solid_volume(o: &Oedometer) -> f64 {
    o.grains as f64 * PI / 6.0 * mean_cubed_diameter(&o.gradation)
}

/// Height of the specimen at its porosity, m, expected from the gradation.
pub fn height(o: &Oedometer) -> f64 {
    solid_volume(o) / ((1.0 - o.porosity) * PI * o.diameter * o.diameter / 4.0)
}
