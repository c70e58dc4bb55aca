//! Densities that a scene's specimen can have: measured before, or estimated; and the refusal of others.

use super::Scene;
use super::estimate::median;
use super::specimen::{DENSITIES, solid_volume};
use super::view::View;
use crate::error::{Error, Result};
use crate::model::{Model, Specimen};
use crate::rig::preparation::range::{self, Range, void_ratio};
use serde::Serialize;
use std::f64::consts::PI;

/// The range of void ratios of a scene's specimen.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Reach {
    pub void_ratio_densest: f64,
    pub void_ratio_loosest: f64,
    /// Whether the program has made both specimens; otherwise an estimate.
    pub measured: bool,
    #[serde(skip)]
    pub range: Range,
}

impl Reach {
    fn new(range: Range, measured: bool) -> Reach {
        Reach { void_ratio_densest: void_ratio(range.densest), void_ratio_loosest: void_ratio(range.loosest), measured, range }
    }

    /// Gives a specimen of stated relative density the porosity that it is in this range, and every specimen the range where it is measured.
    pub fn settle(&self, model: &mut Model) {
        let Some(rig) = model.rig.specimen_mut() else { return };
        if let Some(density) = rig.relative_density {
            rig.porosity = self.range.porosity(density);
        }
        rig.range = self.measured.then_some(self.range);
    }
}

/// Grains up to which `check` makes both specimens where only an estimate puts a target outside: some seconds.
const FEW: usize = 2000;

/// The range as it is known without making a specimen; none where the scene states the friction while growing, whose own range is another one.
pub fn reach(model: &Model) -> Option<Reach> {
    let rig = model.rig.specimen().filter(|o| o.preparation.growth_friction.is_none())?;
    Some(range::known(model, rig).map_or_else(|| Reach::new(estimated(rig), false), |range| Reach::new(range, true)))
}

/// Makes the loosest and the densest specimen to see how dense they are; none as in [`reach`].
///
/// # Errors
/// A specimen that cannot be made.
pub fn measured_reach(model: &Model) -> Result<Option<Reach>> {
    let Some(rig) = model.rig.specimen().filter(|o| o.preparation.growth_friction.is_none()) else { return Ok(None) };
    Ok(Some(Reach::new(range::measure(model, rig)?, true)))
}

/// As [`reach`], but measured where an estimate puts the scene's target outside and the specimen is not given: `always`, or for few grains only. An estimate refuses nothing.
/// Where an end of the range cannot be made the estimate stands.
pub fn sure_reach(scene: &Scene, model: &Model, always: bool) -> Option<Reach> {
    let estimate = reach(model);
    let doubtful = estimate.as_ref().is_some_and(|reach| doubt(model, reach).is_some());
    let few = model.rig.specimen().is_some_and(|rig| rig.grains <= FEW);
    if doubtful && (always || few) && !is_given_its_specimen(scene) { measured_reach(model).unwrap_or(estimate) } else { estimate }
}

/// Refuses a target outside the measured range, with the nearest that works and its key.
///
/// # Errors
/// Such a target.
pub fn within_reach(scene: &Scene, model: &Model, reach: &Reach) -> Result<()> {
    let Some(rig) = model.rig.specimen().filter(|o| o.relative_density.is_none()) else { return Ok(()) };
    let view = View::of(&scene.layer);
    if is_given_its_specimen(scene) || !reach.measured {
        return Ok(());
    }
    let Some(nearest) = reach.range.nearest(rig.porosity, rig.preparation.porosity_tolerance) else { return Ok(()) };
    let key = DENSITIES.into_iter().find(|k| view.get(k).is_some()).unwrap_or(DENSITIES[0]);
    let value = match key {
        "specimen.void_ratio" => void_ratio(nearest),
        "specimen.height_mm" => 1e3 * solid_volume(rig) / ((1.0 - nearest) * 0.25 * PI * rig.diameter * rig.diameter),
        _ => nearest,
    };
    let message = format!(
        "is a void ratio of {:.3}, and grains like these can be brought to {:.3} to {:.3} (measured): the nearest that works is {key} = {value:.4}",
        void_ratio(rig.porosity),
        reach.void_ratio_densest,
        reach.void_ratio_loosest
    );
    view.refuse(key, message);
    Error::all(view.into_errors())
}

/// Whether the scene begins with a specimen from a file, which is not made again.
pub fn is_given_its_specimen(scene: &Scene) -> bool {
    View::of(&scene.layer).get("specimen.file").is_some()
}

/// Says where a target lies that only an estimate puts outside.
pub fn doubt(model: &Model, reach: &Reach) -> Option<String> {
    let rig = model.rig.specimen().filter(|o| o.relative_density.is_none())?;
    let outside = reach.range.nearest(rig.porosity, rig.preparation.porosity_tolerance).is_some();
    (outside && !reach.measured).then(|| {
        format!(
            "the void ratio asked for, {:.3}, may be outside of the range that can be made ({:.3} to {:.3}, estimated); the run measures the range before it begins",
            void_ratio(rig.porosity),
            reach.void_ratio_densest,
            reach.void_ratio_loosest
        )
    })
}

/// The range, by a fit to twenty specimens of figures/specimens (Cu 1.3 to 4.8, 550 to 3600 grains, friction 0.5; small ones of nearly one size under stress are up to 0.035 denser): wider gradations are denser, and so are specimens that are wide and high against their grains.
pub fn estimated(o: &Specimen) -> Range {
    let uniformity = (size(o, 0.6) / size(o, 0.1)).ln();
    let height = solid_volume(o) / (0.6 * PI * o.diameter * o.diameter / 4.0);
    let d = median(&o.gradation);
    // share of the specimen within a median grain of a wall
    let walls = 2.0 * d / o.diameter + d / height;
    let at = |[bulk, wide, wall]: [f64; 3]| (bulk - wide * uniformity + wall * walls).clamp(0.05, 0.95);
    Range { loosest: at(LOOSEST), densest: at(DENSEST) }
}

/// Porosity of a uniform, endless specimen, its fall with ln(Cu), and its rise with the share of grains at walls.
const LOOSEST: [f64; 3] = [0.455, 0.097, 0.113];
const DENSEST: [f64; 3] = [0.390, 0.106, 0.162];

/// Diameter, m, of which the share `finer` of the mass is finer.
fn size(o: &Specimen, finer: f64) -> f64 {
    let between = o.gradation.windows(2).find(|w| w[1].1 >= finer);
    between.map_or(f64::NAN, |w| w[0].0 + (finer - w[0].1) / (w[1].1 - w[0].1) * (w[1].0 - w[0].0))
}
