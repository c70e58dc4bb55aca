//! The range of densities that can be reached: both ends of the way ([`super::path`]) of a specimen, found once and kept in a file of the user's cache.

use super::path::{Path, Wish};
use super::porosity;
use crate::error::Error;
use crate::interrupt::stop_asked;
use crate::model::{Model, Specimen};
use crate::record::specimen::checksum;
use engine::dem::Workspace;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Porosities of the loosest and the densest specimen of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Range {
    pub loosest: f64,
    pub densest: f64,
}

/// Seed of the packing whose ends are measured: specimens of one scene have one range, whatever their own.
const SEED: u64 = 1;
/// Number of the way that is taken, to be raised with every change of [`super::path`]'s ends: ranges of before are not read.
const WAY: u32 = 3;
/// What the names of its files in the cache begin with.
const PREFIX: &str = "range-";

/// A file of the cache.
#[derive(Serialize, Deserialize)]
struct Kept {
    /// All that the range depends on, in words: two that share a name are told apart.
    of: String,
    range: Range,
}

impl Range {
    /// Porosity at a relative density D_r = (e_max - e) / (e_max - e_min).
    pub fn porosity(&self, relative_density: f64) -> f64 {
        let (loose, dense) = (void_ratio(self.loosest), void_ratio(self.densest));
        let e = loose - relative_density * (loose - dense);
        e / (1.0 + e)
    }

    /// The nearest porosity that can be reached, where `porosity` lies outside by more than the tolerance.
    pub fn nearest(&self, porosity: f64, tolerance: f64) -> Option<f64> {
        let nearest = porosity.clamp(self.densest, self.loosest);
        ((porosity - nearest).abs() > tolerance * porosity).then_some(nearest)
    }
}

/// Void ratio of a porosity.
pub fn void_ratio(porosity: f64) -> f64 {
    porosity / (1.0 - porosity)
}

/// The range of the scene's specimen as it was measured before, or none.
pub fn known(model: &Model, rig: &Specimen) -> Option<Range> {
    let of = depends_on(model, rig);
    let text = std::fs::read_to_string(file(&of)?).ok()?;
    let kept: Kept = serde_json::from_str(&text).ok()?;
    let sound = 0.0 < kept.range.densest && kept.range.densest <= kept.range.loosest && kept.range.loosest < 1.0;
    (sound && kept.of == of).then_some(kept.range)
}

/// Measures the range of the scene's specimen: makes the loosest and the densest. What is found is kept where there is a cache.
///
/// # Errors
/// A specimen that does not come to rest, or a stop from outside.
pub fn measure(model: &Model, rig: &Specimen) -> Result<Range, Error> {
    let mut model = model.clone();
    model.seeds.packing = SEED;
    let range = Range { loosest: end(&model, rig, Wish::Loosest)?, densest: end(&model, rig, Wish::Densest)? };
    let of = depends_on(&model, rig);
    if let Some(path) = file(&of) {
        // a cache that cannot be written is none
        let _ = keep(&path, &Kept { of, range });
    }
    Ok(range)
}

/// Turns a relative density into the porosity that it is, by the range as it was measured before or by measuring it. The range, if there was one to turn.
///
/// # Errors
/// As [`measure`].
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
            return Err(Error::Failed { step: path.steps, what: "stopped while the range of void ratios was measured".into() });
        }
    }
    Ok(porosity(&state))
}

/// Everything that the ends of the way depend on, the program's version included; the target is none of it, nor is the seed.
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

/// Where the range is kept: `COMMINUTE_CACHE`, or the folder for caches of the user's system.
fn file(of: &str) -> Option<PathBuf> {
    let of_system = || {
        let own = |key: &str| std::env::var_os(key).filter(|v| !v.is_empty()).map(PathBuf::from);
        let base = own("XDG_CACHE_HOME").or_else(|| own("LOCALAPPDATA")).or_else(|| own("HOME").map(|home| home.join(".cache")));
        base.map(|base| base.join("comminute"))
    };
    let folder = std::env::var_os("COMMINUTE_CACHE").map(PathBuf::from).or_else(of_system)?;
    Some(folder.join(format!("{PREFIX}{:016x}.json", checksum(of))))
}

/// Writes a file of the cache whole, under its name only when it is complete.
fn keep(path: &std::path::Path, kept: &Kept) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let unfinished = path.with_extension(format!("{}.tmp", std::process::id()));
    std::fs::write(&unfinished, serde_json::to_string_pretty(kept)?)?;
    std::fs::rename(&unfinished, path)
}
