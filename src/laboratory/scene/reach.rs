//! The range of densities that a scene's specimen can have, measured or estimated; and the refusal of a target outside the range.

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
    /// Void ratio of the densest specimen.
    pub void_ratio_densest: f64,
    /// Void ratio of the loosest specimen.
    pub void_ratio_loosest: f64,
    /// True: the program has made both specimens. False: an estimate.
    pub measured: bool,
    /// The same range as porosities.
    #[serde(skip)]
    pub range: Range,
}

impl Reach {
    fn new(range: Range, measured: bool) -> Reach {
        Reach { void_ratio_densest: void_ratio(range.densest), void_ratio_loosest: void_ratio(range.loosest), measured, range }
    }

    /// Sets the porosity of a specimen whose scene states a relative density, from this range. A measured range becomes that of
    /// the specimen.
    pub fn settle(&self, model: &mut Model) {
        let Some(rig) = model.rig.specimen_mut() else { return };
        if let Some(density) = rig.relative_density {
            rig.porosity = self.range.porosity(density);
        }
        rig.range = self.measured.then_some(self.range);
    }
}

/// Largest number of grains for which [`sure_reach`] measures the range without being asked to: takes some seconds.
const FEW: usize = 2000;

/// The range as far as it is known without making a specimen: from the cache, or estimated. `None` for tests without a specimen
/// of grains, and where the scene states the friction during growth: then the range is another one.
pub fn reach(model: &Model) -> Option<Reach> {
    let rig = model.rig.specimen().filter(|o| o.preparation.growth_friction.is_none())?;
    Some(range::known(model, rig).map_or_else(|| Reach::new(estimated(rig), false), |range| Reach::new(range, true)))
}

/// Measures the range by making the loosest and the densest specimen; `None` as in [`reach`].
///
/// # Errors
/// A specimen that cannot be made.
pub fn measured_reach(model: &Model) -> Result<Option<Reach>> {
    let Some(rig) = model.rig.specimen().filter(|o| o.preparation.growth_friction.is_none()) else { return Ok(None) };
    Ok(Some(Reach::new(range::measure(model, rig)?, true)))
}

/// As [`reach`], but the range is measured if the estimate excludes the scene's target and the specimen does not come from a
/// file: with `always` for any number of grains, else for at most 2000. An estimate alone refuses no target. Where a specimen
/// at an end of the range cannot be made, the estimate is given.
pub fn sure_reach(scene: &Scene, model: &Model, always: bool) -> Option<Reach> {
    let estimate = reach(model);
    let doubtful = estimate.as_ref().is_some_and(|reach| doubt(model, reach).is_some());
    let few = model.rig.specimen().is_some_and(|rig| rig.grains <= FEW);
    if doubtful && (always || few) && !is_given_its_specimen(scene) { measured_reach(model).unwrap_or(estimate) } else { estimate }
}

/// Checks that the target of the scene lies in the measured range. An estimated range refuses nothing.
///
/// # Errors
/// A target outside the range; the message gives the nearest value that works.
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
        "is a void ratio of {:.3}, but specimens of these grains can only have {:.3} to {:.3} (measured): the nearest that works is {key} = {value:.4}",
        void_ratio(rig.porosity),
        reach.void_ratio_densest,
        reach.void_ratio_loosest
    );
    view.refuse(key, message);
    Error::all(view.into_errors())
}

/// Whether the scene begins with a specimen from a file.
pub fn is_given_its_specimen(scene: &Scene) -> bool {
    View::of(&scene.layer).get("specimen.file").is_some()
}

/// A warning for a target that lies outside an estimated range; `None` where there is nothing to warn of.
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

/// Estimates the range from uniformity Cu and size of the specimen, by a fit to twenty specimens of figures/specimens (Cu 1.3 to
/// 4.8, 550 to 3600 grains, friction 0.5; small specimens of nearly one grain size under stress are up to 0.035 denser). Wider
/// gradations are denser, and so are specimens that are large compared with their grains.
pub fn estimated(o: &Specimen) -> Range {
    let uniformity = (size(o, 0.6) / size(o, 0.1)).ln();
    let height = solid_volume(o) / (0.6 * PI * o.diameter * o.diameter / 4.0);
    let d = median(&o.gradation);
    // share of the volume at a distance below half a median grain from the walls
    let walls = 2.0 * d / o.diameter + d / height;
    let at = |[bulk, wide, wall]: [f64; 3]| (bulk - wide * uniformity + wall * walls).clamp(0.05, 0.95);
    Range { loosest: at(LOOSEST), densest: at(DENSEST) }
}

/// Coefficients of the loosest porosity: of an infinite specimen of one grain size, fall with ln(Cu), rise with the share of the
/// volume near walls.
const LOOSEST: [f64; 3] = [0.455, 0.097, 0.113];
/// The same for the densest porosity.
const DENSEST: [f64; 3] = [0.390, 0.106, 0.162];

/// The diameter, m, below which the share `finer` of the mass lies.
fn size(o: &Specimen, finer: f64) -> f64 {
    let between = o.gradation.windows(2).find(|w| w[1].1 >= finer);
    between.map_or(f64::NAN, |w| w[0].0 + (finer - w[0].1) / (w[1].1 - w[0].1) * (w[1].0 - w[0].0))
}
