//! What the user wrote: scene and material files with overrides ([`load`]), and the one gate from there to a
//! [`Model`] ([`model`]).

mod accuracy;
mod assembly;
mod bed;
mod block_sets;
mod blocks;
mod bodies;
mod breakable;
mod calibrate;
mod check;
mod compounds;
mod continuum;
mod continuum_estimate;
mod continuum_rig;
mod crushing;
mod crushing_estimate;
mod driven;
mod duration;
pub(crate) mod estimate;
mod files;
mod grain_crushing;
mod growth;
mod import;
mod keys;
mod layers;
pub(crate) mod material;
mod memory;
mod mesh_file;
mod mixture;
pub(crate) mod number_file;
mod outline_file;
mod output;
mod overrides;
mod point_cloud;
mod provenance;
mod reach;
mod schema;
mod sources;
mod specimen;
mod suggest;
mod validate;
pub(crate) mod view;
mod write;

pub use accuracy::{Level, Overruled, Platens, Promise, accuracy_overruled, set_by_accuracy};
pub use calibrate::{Calibrated, Prior};
pub use check::{Checked, check, in_json};
pub use continuum::{ContinuumMaterial, continuum};
pub use continuum_estimate::Points;
pub(crate) use continuum_estimate::wave_step;
pub use crushing_estimate::CrushingStress;
pub use estimate::{Estimate, SpecimenEstimate, estimate};
pub use files::{bounded_columns, read_bytes, read_text, read_text_up_to};
pub use import::MOST as MOST_GRAINS;
pub use keys::{KEYS, LIST_TABLES, reference as key_reference};
pub use layers::shown;
pub use memory::{OF_MEMORY, fits};
#[cfg(test)]
pub(crate) use mesh_file::stl;
pub use output::{Output, crowded, enough_disk, lacking};
pub use provenance::{Assumption, Decision, assumptions, decisions};
pub use reach::{Reach, doubt, is_given_its_specimen, measured_reach, reach, sure_reach, within_reach};
pub use schema::Key;

use crate::error::{Error, Result};
use crate::machine;
use crate::model::Model;
use layers::Layer;
use std::path::{Path, PathBuf};
use toml::Value;

/// Name of the file of a run that repeats it.
pub const RESOLVED: &str = "scene.resolved.toml";

/// Name of the file of a run that holds the specimen before loading.
pub const SPECIMEN: &str = "specimen.csv";

/// A scene as written, with its base, material, imported grains, overrides and defaults: every key is known and in its
/// own range, and nothing is said yet about whether they agree.
#[derive(Clone, Debug)]
pub struct Scene {
    path: PathBuf,
    layer: Layer,
}

impl Scene {
    /// The file it was read from.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Name for legends and records.
    pub fn name(&self) -> &str {
        self.text("name")
    }

    /// One line about the scene.
    pub fn description(&self) -> &str {
        self.text("description")
    }

    /// The run folder when none is asked for: `runs/` and the name of the scene file.
    pub fn default_out(&self) -> PathBuf {
        let resolved = self.path.file_name().is_some_and(|n| n == RESOLVED);
        let stem = self.path.file_stem().and_then(|s| s.to_str());
        Path::new("runs").join(stem.filter(|_| !resolved).unwrap_or(self.name()))
    }

    /// The prepared specimen that the scene begins with, if it names one.
    pub fn specimen(&self) -> Option<PathBuf> {
        self.layer.table.get("specimen")?.get("file")?.as_str().map(PathBuf::from)
    }

    /// The value at a dotted key, as in `loading.max_stress_kPa` or `wall[0].friction`, in the unit of the key; every default is there.
    /// `None` where the scene has no such value.
    pub fn get(&self, key: &str) -> Option<&Value> {
        view::View::of(&self.layer).get(key)
    }

    fn text(&self, key: &str) -> &str {
        self.layer.table.get(key).and_then(Value::as_str).unwrap_or("")
    }
}

/// Read the scene file `path` and lay the overrides `sets` (`key=value`) over it.
///
/// # Errors
/// Every mistake in files and overrides, with file, key, value and what is allowed.
pub fn load(path: impl AsRef<Path>, sets: &[String]) -> Result<Scene> {
    let path = path.as_ref();
    complete(path, files::scene_file(path)?, sets)
}

/// Read a scene from its text in TOML and lay the overrides `sets` (`key=value`) over it. Paths in the text are relative to
/// `folder`; messages call the text `scene` in that folder. The scene's name is `scene` where the text gives none.
///
/// # Errors
/// Every mistake in text, files and overrides, with file, key, value and what is allowed.
pub fn from_text(text: &str, folder: impl AsRef<Path>, sets: &[String]) -> Result<Scene> {
    let path = folder.as_ref().join("scene");
    complete(&path, files::scene_text(&path, text)?, sets)
}

/// The scene of the file `path` as read, with overrides, imported grains and defaults.
fn complete(path: &Path, mut layer: Layer, sets: &[String]) -> Result<Scene> {
    // a whole material first, so that its own values can be overridden in any order
    let (whole, rest): (Vec<_>, Vec<_>) = sets.iter().partition(|s| s.starts_with("material="));
    for set in whole.into_iter().chain(rest) {
        overrides::apply(&mut layer, set)?;
    }
    if !layer.table.contains_key("name") {
        layer.table.insert("name".into(), Value::String(stem(path)));
    }
    accuracy::fill(&mut layer);
    import::grains(&mut layer)?;
    point_cloud::points(&mut layer)?;
    mesh_file::meshes(&mut layer)?;
    outline_file::outlines(&mut layer)?;
    driven::paths(&mut layer)?;
    validate::validate(&mut layer)?;
    material::fill_d50(&mut layer.table);
    crushing::fill(&mut layer.table);
    Ok(Scene { path: path.to_path_buf(), layer })
}

/// The run that the scene describes, in SI units; refuses what does not agree, and what does not fit into the memory that is free.
///
/// # Errors
/// Values that do not agree; more points or grains than there is memory for, before any of them is made.
pub fn model(scene: &Scene) -> Result<Model> {
    let (outline, complete) = made(scene, view::View::outlining(&scene.layer))?;
    memory::fits(scene, &outline, machine::free_memory())?;
    if complete { Ok(outline) } else { Ok(made(scene, view::View::of(&scene.layer))?.0) }
}

/// The model of a scene for estimates: where a scene has many points, or grains at random places, only some of them are made, and
/// [`crate::model::continuum::MpmTest::left_out`] has the number of the others. It takes a second and some hundred megabytes at
/// most, whatever the scene says.
///
/// # Errors
/// Values that do not agree, but for what only the points that are left out would show.
pub fn outline(scene: &Scene) -> Result<Model> {
    Ok(made(scene, view::View::outlining(&scene.layer))?.0)
}

/// The model that a view makes, and whether it lacks nothing.
fn made(scene: &Scene, view: view::View) -> Result<(Model, bool)> {
    let model = view.model();
    let complete = !view.incomplete.get();
    Error::all(view.into_errors())?;
    let model = model.ok_or_else(|| Error::input(scene.path.display(), "", None, "is not a complete scene"))?;
    Ok((model, complete))
}

/// The scene with every default filled in, its material and grains written out: running it repeats the run.
pub fn resolved(scene: &Scene) -> String {
    let mut table = scene.layer.table.clone();
    // what a calibration may change says nothing about a run
    table.remove("calibrate");
    // a run keeps the specimen it began with beside the scene
    if let Some(file) = table.get_mut("specimen").and_then(|t| t.get_mut("file")) {
        *file = Value::String(SPECIMEN.into());
    }
    write::write(&table)
}

/// Every key of a material file, with those of the files it is based on. Nothing is checked yet.
pub fn material_keys(path: impl AsRef<Path>) -> Result<toml::Table> {
    Ok(files::material_file(path.as_ref())?.table)
}

fn stem(path: &Path) -> String {
    let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or("");
    let plain = |c: char| {
        if c.is_alphanumeric() || "-_.+".contains(c) { c } else { '-' }
    };
    let name: String = stem.chars().map(plain).take(100).collect();
    match name.trim_start_matches('.') {
        "" => "scene".into(),
        name => name.into(),
    }
}
