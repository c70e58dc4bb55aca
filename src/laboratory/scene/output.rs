//! How much disk the files of a run take, from the settings of its records, before it is started.

use crate::error::{Error, Result};
use crate::machine::size;
use crate::model::{Compression, Model, Rig, Subject};
use serde::Serialize;
use std::path::Path;

/// Files that do not grow with the run: the scene, the summary, lists of snapshots, bytes.
const FIXED: f64 = 100e3;
/// Figures, bytes, and what each grain or point adds to the drawing of the specimen.
const FIGURES: [f64; 2] = [4e6, 250.0];
/// A row of each table, bytes; measured 160 to 610 for histories, 150 to 180 for tracks, 235 for breakages, 30 to 100 in a batch.
const HISTORY: f64 = 650.0;
const TRACK: f64 = 180.0;
const BREAKAGE: f64 = 240.0;
const GRADATION: f64 = 6e3;
const TEST: f64 = 140.0;
/// A curve of a platen test, bytes.
const CURVE: f64 = 100e3;
/// A grain or point of a snapshot and its share of the walls, of the contacts as a table, and of the specimens as tables, bytes; measured
/// 140 to 170, and 60 to 220.
const SNAPSHOT: f64 = 180.0;
const CONTACTS: f64 = 700.0;
const SPECIMENS: f64 = 300.0;
/// A grain or point of the two checkpoints that are kept and of the one that is being written, bytes; measured 75 to 320 in one.
const CHECKPOINTS: f64 = 3.0 * 320.0;
/// Axial strain that a compression by stages is taken to reach.
const STRAIN: f64 = 0.45;

/// Files that a run is expected to leave.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Output {
    /// Rows of the history.
    pub rows: f64,
    /// Snapshots of all grains and points.
    pub snapshots: f64,
    /// Size of all files together, figures and checkpoints included, MB.
    #[serde(rename = "total_MB")]
    pub total_mb: f64,
}

/// Estimates the files of a run that makes `steps` steps, begins with `start` grains and points, and ends with `end`.
pub fn output(model: &Model, steps: f64, start: f64, end: f64) -> Output {
    let records = &model.records;
    let broken = (end - start).max(0.0);
    let [rows, snapshots, others] = match &model.rig {
        Rig::Oedometer(rig) | Rig::Isotropic(rig) => {
            let full = 2.0 + records.at.len() as f64 + rig.loading.stages.len() as f64;
            [full + compression(model, rig, broken), full, full * GRADATION]
        }
        Rig::Triaxial(rig) => {
            let full = 2.0 + rig.shear.record_at.len() as f64;
            [full + rig.shear.axial_strain / rig.shear.record_every, full, full * GRADATION]
        }
        Rig::Assembly(rig) => {
            let rows = steps / rig.record_every as f64 + 2.0;
            [rows, 2.0, rows * rig.tracks.len() as f64 * TRACK]
        }
        Rig::GrainCrushing(rig) => [0.0, 0.0, start * TEST + rig.curves.len() as f64 * CURVE],
        Rig::Continuum(rig) => [f64::from(rig.rows) + 1.0, f64::from(rig.frames) + 1.0, 0.0],
    };
    let each = if records.snapshots { SNAPSHOT } else { 0.0 } + if records.contacts { CONTACTS } else { 0.0 };
    let figures = if records.figures { FIGURES[0] + FIGURES[1] * end } else { 0.0 };
    let kept = if matches!(model.rig, Rig::GrainCrushing(_)) { 0.0 } else { SPECIMENS + CHECKPOINTS };
    let bytes = FIXED + rows * HISTORY + others + snapshots * each * end + broken * BREAKAGE + kept * end + figures;
    Output { rows, snapshots: if each > 0.0 { snapshots } else { 0.0 }, total_mb: 1e-6 * bytes }
}

/// Rows of a compression by stages: so many for each decade of stress, and those by strain and by breakages.
fn compression(model: &Model, rig: &Compression, broken: f64) -> f64 {
    let loading = &rig.loading;
    let before = std::iter::once(rig.specimen.isotropic_stress).chain(loading.stages.iter().copied());
    let decades: f64 = before.zip(&loading.stages).map(|(from, to)| (to / from).log10().abs()).sum();
    let strain = loading.row_strain.map_or(0.0, |every| STRAIN / every);
    let events = loading.row_events.map_or(0.0, |every| broken / every as f64);
    decades * f64::from(model.records.per_decade) + strain + events
}

/// Refuses a run whose files take more than the disk of the folder `out` has free.
///
/// # Errors
/// The folder, with the size of the files and what is free; nothing where the system does not say.
pub fn enough_disk(model: &Model, estimate: &super::Estimate, out: &Path) -> Result<()> {
    let Some(free) = crate::machine::free_disk(out) else { return Ok(()) };
    match lacking(model, estimate, free as f64) {
        None => Ok(()),
        Some(message) => Err(Error::input(out.display(), "", None, message)),
    }
}

/// What is said of a disk that has not enough free, bytes; `None` where it has.
pub fn lacking(model: &Model, estimate: &super::Estimate, free: f64) -> Option<String> {
    let needed = 1e6 * estimate.output.total_mb;
    let keys = match model.rig.subject() {
        Subject::Continuum(_) => "records.rows, records.frames, records.snapshots",
        Subject::Assembly(_) => "records.every, records.tracks, records.snapshots",
        Subject::GrainCrushing(_) => "records.curves, batch.grains",
        Subject::Specimen(_) => "records.at_kPa, records.every_strain, records.snapshots",
    };
    (needed > free).then(|| {
        format!(
            "the run leaves some {} of files, and {} are free on this disk: use another folder, or record less ({keys})",
            size(needed),
            size(free)
        )
    })
}

/// A warning where the run of a model may take more memory than there is free once grains have broken; `None` where it fits.
pub fn crowded(estimate: &super::Estimate, free: Option<u64>) -> Option<String> {
    let (needed, free) = (1e6 * estimate.memory_mb, free? as f64);
    (needed > free)
        .then(|| format!("the run takes some {} of memory at its end, and {} are free on this machine", size(needed), size(free)))
}

#[cfg(test)]
mod tests {
    use crate::scene;

    /// The estimate of a scene of the repository.
    fn of(name: &str, sets: &[&str]) -> (crate::model::Model, scene::Estimate) {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../experiments/").to_string() + name;
        let sets: Vec<String> = sets.iter().map(|s| (*s).into()).collect();
        let model = scene::outline(&scene::load(path, &sets).expect("a scene")).expect("a model");
        let estimate = scene::estimate(&model, None);
        (model, estimate)
    }

    #[test]
    fn files_grow_with_what_is_recorded() {
        let mb = |name: &str, sets: &[&str]| of(name, &[sets, &["records.figures=false"]].concat()).1.output.total_mb;
        let continuum = "mpm/oedometer.toml";
        let [few, many] = ["5", "500"].map(|n| mb(continuum, &[&format!("records.frames={n}")]));
        assert!(many > 20.0 * few, "{few} {many}");
        assert!(mb(continuum, &["records.frames=500", "records.snapshots=false"]) < 0.2 * many);
        let free = "free/box_settling.toml";
        assert!(mb(free, &["records.every=1"]) > 5.0 * mb(free, &["records.every=100"]));
        let (rows, oedometer) = (of("petroleum_coke/h-c-2.toml", &["loading.max_stress_kPa=1000"]).1.output.rows, 147.0);
        assert!((0.5 * oedometer..2.0 * oedometer).contains(&rows), "{rows}");
    }

    #[test]
    fn a_small_disk_is_told_with_numbers() {
        let (model, estimate) = of("mpm/oedometer.toml", &["records.frames=10000", "records.rows=100000"]);
        assert_eq!(super::lacking(&model, &estimate, 1e15), None);
        let told = super::lacking(&model, &estimate, 1e6).expect("too small");
        assert!(told.contains("1.00 MB are free") && told.contains("records.frames"), "{told}");
    }
}
