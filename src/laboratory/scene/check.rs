//! What the run of a scene would be, before it is started.

use super::{
    Estimate, Scene, accuracy_overruled, assumptions, crowded, decisions, doubt, estimate, fits, is_given_its_specimen, lacking,
    measured_reach, outline, set_by_accuracy, sure_reach, within_reach,
};
use crate::error::{Error, Result};
use crate::machine::{Pace, free_disk, free_memory};
use crate::model::Model;
use serde_json::{Value, json};

/// A scene that can be run.
#[derive(Debug)]
pub struct Checked {
    /// The outline of its model ([`outline`]).
    pub model: Model,
    /// What the run would be, with all that speaks against it.
    pub estimate: Estimate,
}

/// Validates a scene and says what its run would be. `range`: the range of void ratios that can be made of its grains is measured (seconds to
/// minutes) and kept in the user's cache. `pace`: how fast this machine is, asked for when the scene is known to be valid.
///
/// # Errors
/// Values that do not agree; a specimen that cannot be made; a range that this scene does not have.
pub fn check(scene: &Scene, range: bool, pace: impl FnOnce() -> Result<Option<Pace>>) -> Result<Checked> {
    let mut model = outline(scene)?;
    let reach = if range { measured_reach(&model)? } else { sure_reach(scene, &model, false) };
    if range && reach.is_none() {
        let what = "has to be \"auto\", of an oedometer or a triaxial test, for a range to be measured";
        return Err(Error::input(scene.path().display(), "preparation.growth_friction", None, what));
    }
    if let Some(reach) = &reach {
        within_reach(scene, &model, reach)?;
        reach.settle(&mut model);
    }
    let mut estimate = estimate(&model, pace()?);
    let made = reach.as_ref().filter(|_| !is_given_its_specimen(scene));
    estimate.warnings.extend(made.and_then(|r| doubt(&model, r)));
    estimate.void_ratio_range = reach;
    if is_given_its_specimen(scene) {
        estimate.seconds -= std::mem::take(&mut estimate.preparation_seconds);
    }
    let free = free_memory();
    let short = fits(scene, &model, free).err().map(|e| e.to_string()).or_else(|| crowded(&estimate, free));
    let disk = free_disk(&scene.default_out()).and_then(|free| lacking(&model, &estimate, free as f64));
    estimate.warnings.extend(short.into_iter().chain(disk));
    Ok(Checked { model, estimate })
}

/// What [`check`] found, as `comminute check --json` prints it.
pub fn in_json(scene: &Scene, model: &Model, estimate: &Estimate) -> Value {
    json!({
        "scene": model.name,
        "description": scene.description(),
        "out": scene.default_out(),
        "materials": model.physics.materials.iter().map(|m| &m.name).collect::<Vec<_>>(),
        "crushing": model.physics.crush.is_some(),
        "seed": model.seeds,
        "estimate": estimate,
        "assumed": assumptions(scene),
        "decisions": decisions(scene),
        "accuracy": model.accuracy.map(|level| json!({
            "level": level.word,
            "promise": level.promise,
            "sets": set_by_accuracy(scene),
            "overruled": accuracy_overruled(scene),
        })),
    })
}
