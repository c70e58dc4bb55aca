//! A run from its scene, as `comminute run` makes it: looks at the folder, checks disk and memory, settles the density, and runs.

use super::{Backend, Found, Outcome, ResumeOptions, RunRequest, choose, in_pool, look, occupied, resume, run, settle};
use crate::error::{Error, Result};
use crate::machine::free_memory;
use crate::model::Model;
use crate::rig::preparation::range::void_ratio;
use crate::scene::{self, Scene};
use std::path::{Path, PathBuf};

/// What [`run_scene`] needs to know beside the scene.
#[derive(Clone, Debug, Default)]
pub struct SceneOptions {
    /// Output folder; `None`: that of the scene ([`Scene::default_out`]).
    pub out: Option<PathBuf>,
    /// Number of threads; `None`: one for each core. Results do not depend on it.
    pub threads: Option<usize>,
    /// Backend that computes the steps of a continuum; `None`: the processor, or what a begun run had.
    pub backend: Option<Backend>,
    /// Overwrite the run that the folder holds.
    pub force: bool,
    /// Do only what is left of the run: nothing if the folder holds it finished, the rest if it holds a checkpoint, else all of it. A
    /// run of another scene is overwritten with `force` only.
    pub left: bool,
    /// Stop with a checkpoint after this many steps, preparation included ([`RunRequest::stop_after`]).
    pub stop_after: Option<u64>,
    /// Show no progress, tell nothing.
    pub quiet: bool,
    /// [`RunRequest::json`].
    pub json: bool,
}

/// What a person is told before a run begins.
#[derive(Clone, Debug, PartialEq)]
pub enum Word {
    /// What the run will be.
    Note(String),
    /// What speaks against it.
    Warning(String),
}

/// Makes the run of a scene, or what is left of it. Tells what it finds before the run begins. Figures are not drawn ([`Outcome::draw`]), and no page is written ([`Outcome::report`]).
///
/// # Errors
/// A folder that holds another run, not enough disk or memory, a specimen that cannot be made; the errors of [`run`](fn@run) and [`resume`].
pub fn run_scene(scene: &Scene, options: SceneOptions, tell: &mut dyn FnMut(Word)) -> Result<Outcome> {
    let mut model = scene::model(scene)?;
    let SceneOptions { out, threads, backend, mut force, left, stop_after, quiet, json } = options;
    let out = out.unwrap_or_else(|| scene.default_out());
    if left {
        let found = look(&out, scene, &model)?;
        let options = ResumeOptions { threads, quiet, json, stop_after, backend };
        match found {
            Found::Finished(summary) => {
                let report = model.records.report && !out.join(super::REPORT).is_file();
                return Ok(Outcome { summary, out, draw: false, report });
            }
            Found::Undrawn(summary) => return Ok(Outcome { summary, out, draw: true, report: model.records.report }),
            Found::Unfinished => return resume(&out, options),
            Found::Busy => return Err(Error::Busy { path: out }),
            Found::Other(what) if !force => return Err(Error::Other { path: out, what }),
            Found::Broken | Found::Other(_) => force = true,
            Found::Nothing => {}
        }
    }
    free(&out, force)?;
    let outline = scene::outline(scene)?;
    let estimate = scene::estimate(&outline, None);
    scene::enough_disk(&outline, &estimate, &out)?;
    drop(outline);
    let backend = choose(backend.unwrap_or_default(), &model)?;
    if !quiet {
        if let Some(why) = &backend.why {
            tell(Word::Note(format!("backend {}: {why}", backend.name())));
        }
        let crowded = scene::crowded(&estimate, free_memory());
        estimate.warnings.into_iter().chain(crowded).for_each(|warning| tell(Word::Warning(warning)));
    }
    if !quiet && !scene::is_given_its_specimen(scene) {
        scene::reach(&model).and_then(|reach| scene::doubt(&model, &reach)).into_iter().for_each(|doubt| tell(Word::Note(doubt)));
    }
    settle_density(scene, &mut model, threads, &mut |word| {
        if !quiet {
            tell(word)
        }
    })?;
    run(RunRequest {
        model,
        scene_resolved: scene::resolved(scene),
        out,
        force,
        threads,
        specimen: scene.specimen(),
        quiet,
        json,
        stop_after,
        backend,
    })
}

/// Turns the density that the scene asks for into the porosity of the model's specimen, where it is to be made, and tells from what.
///
/// # Errors
/// A density that these grains cannot have; a range that cannot be measured.
pub(super) fn settle_density(scene: &Scene, model: &mut Model, threads: Option<usize>, tell: &mut dyn FnMut(Word)) -> Result<()> {
    let reach = in_pool(threads, || Ok(scene::sure_reach(scene, model, true)))?;
    let (Some(reach), None) = (reach, scene.specimen()) else { return Ok(()) };
    scene::within_reach(scene, model, &reach)?;
    reach.settle(model);
    if let Some(density) = model.rig.specimen().and_then(|rig| rig.relative_density) {
        let measuring = if reach.measured { "" } else { " (measured now, once for these grains)" };
        tell(Word::Note(format!("relative density {density}: a share of the range of void ratios{measuring}")));
    }
    if let Some(range) = settle(model, threads)? {
        let n = model.rig.specimen().map_or(f64::NAN, |rig| rig.porosity);
        let [e, dense, loose] = [n, range.densest, range.loosest].map(void_ratio);
        tell(Word::Note(format!("void ratio {e:.3}, between {dense:.3} and {loose:.3} (measured)")));
    }
    Ok(())
}

/// Refuses a folder that holds anything but the message of a run that failed, unless `force`.
fn free(out: &Path, force: bool) -> Result<()> {
    if out.is_file() {
        return Err(Error::input(out.display(), "", None, "is a file; a run needs a folder"));
    }
    match std::fs::read_dir(out) {
        Ok(_) if occupied(out) && !force => Err(Error::Exists { path: out.into() }),
        Ok(_) => Ok(()),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(source) => Err(Error::Read { path: out.into(), source }),
    }
}
