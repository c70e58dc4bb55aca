//! The range of porosities that a specimen can have: both ends of the way of `path.rs`. The range is measured once, by
//! making the loosest and the densest specimen, and kept in a file of the user's cache.

use super::path::{Path, Wish};
use super::porosity;
use crate::cache;
use crate::error::Error;
use crate::interrupt::stop_asked;
use crate::model::{Model, Specimen};
use engine::check::{Checked, ensure};
use engine::dem::Workspace;
use serde::{Deserialize, Serialize};

/// Porosities of the loosest and the densest specimen of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Porosity of the loosest specimen.
    pub loosest: f64,
    /// Porosity of the densest specimen.
    pub densest: f64,
}

/// Seed of the specimens that are made to measure a range. It does not follow the seed of the run: all runs of one scene have one
/// range.
const SEED: u64 = 1;
/// Version of the way. A change of [`super::path`] that changes its ends must raise this number; files of other versions are not
/// read.
const WAY: u32 = 3;
/// Kind of its files in the cache.
const KIND: &str = "range";

impl Range {
    /// Checks a range from a checkpoint.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn check(&self) -> Checked {
        let ordered = 0.0 < self.densest && self.densest <= self.loosest && self.loosest < 1.0;
        ensure(ordered, || format!("porosities from {} to {} are no range", self.densest, self.loosest))
    }

    /// Porosity of a specimen of relative density D_r = (e_max - e) / (e_max - e_min), with e its void ratio.
    pub fn porosity(&self, relative_density: f64) -> f64 {
        let (loose, dense) = (void_ratio(self.loosest), void_ratio(self.densest));
        let e = loose - relative_density * (loose - dense);
        e / (1.0 + e)
    }

    /// The nearest porosity of the range, where `porosity` lies outside of the range by more than the relative tolerance; else
    /// `None`.
    pub fn nearest(&self, porosity: f64, tolerance: f64) -> Option<f64> {
        let nearest = porosity.clamp(self.densest, self.loosest);
        ((porosity - nearest).abs() > tolerance * porosity).then_some(nearest)
    }
}

/// Void ratio e = n / (1 - n) of a porosity n.
pub fn void_ratio(porosity: f64) -> f64 {
    porosity / (1.0 - porosity)
}

/// The range of the specimen from the cache; `None` where it has not been measured.
pub fn known(model: &Model, rig: &Specimen) -> Option<Range> {
    let range: Range = cache::read(KIND, &depends_on(model, rig))?;
    range.check().is_ok().then_some(range)
}

/// Measures the range of the specimen by making the loosest and the densest, and writes the range into the cache.
///
/// # Errors
/// A specimen that does not come to rest; a stop from outside.
pub fn measure(model: &Model, rig: &Specimen) -> Result<Range, Error> {
    let mut model = model.clone();
    model.seeds.packing = SEED;
    let range = Range { loosest: end(&model, rig, Wish::Loosest)?, densest: end(&model, rig, Wish::Densest)? };
    cache::keep(KIND, &depends_on(&model, rig), range);
    Ok(range)
}

/// Turns the relative density of the model's specimen into a porosity. The range comes from the cache or is measured now. Gives
/// the range; `None` where the model has no relative density.
///
/// # Errors
/// Those of [`measure`].
pub fn settle(model: &mut Model) -> Result<Option<Range>, Error> {
    let Some((rig, density)) = model.rig.specimen().and_then(|rig| Some((rig, rig.relative_density?))) else { return Ok(None) };
    let range = known(model, rig).map_or_else(|| measure(model, rig), Ok)?;
    if let Some(rig) = model.rig.specimen_mut() {
        rig.porosity = range.porosity(density);
        rig.relative_density = None;
        rig.range = Some(range);
    }
    Ok(Some(range))
}

/// Porosity at one end of the way.
fn end(model: &Model, rig: &Specimen, wish: Wish) -> Result<f64, Error> {
    let (mut path, mut state) = Path::start(model, rig, wish);
    let mut work = Workspace::new(&model.physics, &mut state);
    while !path.advance(model, rig, &mut state, &mut work)? {
        if stop_asked() {
            return Err(Error::Cut { doing: "the range of void ratios was measured" });
        }
    }
    Ok(porosity(&state))
}

/// Everything that the range depends on, as text, the program's version included. Target and seed of the scene are not in it.
fn depends_on(model: &Model, rig: &Specimen) -> String {
    let p = &rig.preparation;
    format!(
        "comminute {} way {} diameter {:?} grains {} gradation {:?} walls {:?} stress {:?} growth {} damping {:?} servo {:?} material {:?} contact {:?} stepping {:?} gravity {:?}",
        env!("CARGO_PKG_VERSION"),
        WAY,
        rig.diameter,
        rig.grains,
        rig.gradation,
        rig.wall_friction,
        rig.isotropic_stress,
        p.growth_steps,
        p.damping,
        rig.servo_gain,
        model.physics.materials,
        model.physics.contact,
        model.physics.stepping,
        model.physics.gravity,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::host::{Host, within};
    use std::sync::Arc;

    /// Nothing is kept of a range that is measured in part, and no error of the run's is told: it was stopped.
    #[test]
    fn a_measurement_can_be_stopped() {
        let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/petroleum_coke/h-c-2.toml");
        let model = crate::scene::model(&crate::scene::load(root, &[]).expect("a scene")).expect("a model");
        let host = Arc::new(Host::default());
        host.ask_to_stop();
        let found = within(Some(host), || measure(&model, model.rig.specimen().expect("a specimen")));
        let told = found.expect_err("stopped");
        assert!(matches!(told, Error::Cut { .. }) && told.exit_code() == 130, "{told}");
    }
}
