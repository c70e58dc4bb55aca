//! The files at the end of a run of grains: `grains_final.csv` and `summary.json`. Times, host and version stand in
//! `summary.json` only: all other files are the same on every machine.

use super::{Activity, Outcome, Progress, files};
use crate::error::Result;
use crate::model::{Model, Rig};
use crate::record::checkpoint;
use crate::record::cylinder::{BelowLeast, Recorder, WithoutVoids};
use crate::rig::preparation::range::void_ratio;
use crate::scene::Level;
use crate::scene::estimate::predicted;
use engine::breakage::lost_mass::excluded_grains;
use engine::dem::Workspace;
use serde_json::{Map, Value, json};
use std::path::Path;

/// Writes `grains_final.csv` and `summary.json`, and removes the checkpoint.
pub fn finish(model: &Model, out: &Path, progress: &mut Progress, work: &Workspace) -> Result<Outcome> {
    progress.files.sync(out)?;
    files::write_final(out, model, progress)?;
    let summary = summary(model, progress, work);
    let outcome = Outcome::undrawn(summary, out, model)?;
    checkpoint::remove(out)?;
    Ok(outcome)
}

fn summary(model: &Model, progress: &Progress, work: &Workspace) -> Value {
    let state = &progress.state;
    let recorder = &progress.files.recorder;
    let mut s = Map::new();
    let mut put = |key: &str, value: Value| s.insert(key.into(), value);
    put("scene", json!(model.name));
    put("seed", json!({"packing": model.seeds.packing, "strength": model.seeds.strength}));
    put("scale", json!(model.scale));
    put("grains_initial", json!(progress.grains_initial));
    put("grains_final", json!(state.grains.len()));
    put("crush_events", json!(state.crush_events));
    if let Some(crush) = &model.physics.crush {
        let excluded = excluded_grains(state.crush_events, &crush.pattern);
        put("excluded_grains", json!(excluded.paper));
        put("excluded_grains_smallest", json!(excluded.smallest));
        put("strength_ratio_initial", strengths(model, progress));
    }
    put("steps", json!(state.step));
    put("preparation_steps", json!(progress.preparation_steps));
    if let Some(range) = progress.range {
        put("void_ratio_loosest", json!(void_ratio(range.loosest)));
        put("void_ratio_densest", json!(void_ratio(range.densest)));
    }
    if let Activity::Testing(test) = &progress.activity {
        test.summary(&model.rig, recorder, &mut |key, value| {
            put(key, value);
        });
    }
    if model.rig.specimen().is_some() {
        put("max_measured_stress_kPa", json!(recorder.max_stress * 1e-3));
        let end = recorder.at_end;
        put("void_ratio_final", json!(end.void_ratio));
        put("void_ratio_grains_final", json!(end.void_ratio_grains));
        put("void_ratio_star_final", json!(end.void_ratio_star));
        put("porosity_final", json!(end.porosity));
        put("axial_strain_final", json!(end.axial_strain));
        put("hardin_br", json!(end.hardin_br));
        put("einav_br", json!(end.einav_br));
        put("einav_beyond", json!(end.einav_beyond));
        put("least_void_ratio", json!(model.records.least_void_ratio));
        put("below_least_void_ratio", below_least(recorder.below_least));
        if let Some(without) = recorder.without_voids {
            put("without_voids", without_voids(without));
        }
        if let (Some(_), true) = (recorder.below_least, model.records.end_below_least) {
            put("ended_early", json!("void ratio below records.least_void_ratio"));
        }
        put("mass_error", json!(recorder.mass_error));
        if model.records.energy {
            put("energy_error", json!(recorder.energy_error));
            put("energy_nonconservative", json!(recorder.energy_nonconservative));
        }
        put(
            "quasi_static",
            json!({
                "above_kPa": 50.0,
                "largest_platen_difference": recorder.worst[0],
                "largest_distance_from_target": recorder.worst[1],
                "largest_inertial_number": recorder.worst[2],
            }),
        );
        if let Some(initial) = &progress.files.initial {
            put("d50_mm", json!(initial.diameter_at(0.5).map(|d| d * 1e3)));
        }
    }
    if let Activity::Testing(_) = &progress.activity {
        if model.rig.compression().is_some() {
            put("held_every_step", recorder.held.summary());
        }
        if let Some(level) = model.accuracy {
            put("accuracy", recorder.held.against(level));
        }
    }
    if model.physics.crush.is_some() {
        put("breakages", recorder.broken.summary());
    }
    let of_walls = state.walls.iter().map(|w| w.work).sum::<f64>().abs();
    // walls that do no work have no share: a grain that is thrown at one breaks by its own energy
    let growth = if of_walls > 0.0 { state.ledger.growth / of_walls } else { 0.0 };
    if model.records.energy && model.physics.crush.as_ref().is_some_and(|crush| crush.keeps_mass) {
        put("growth_over_wall_work", json!(growth));
    }
    put("warnings", json!(warnings(recorder, growth, model.accuracy)));
    put("energy_rises", json!(state.ledger.rises));
    let lost: f64 = state.lost.iter().map(|l| l.0).sum();
    put("mass_lost_kg", json!(lost));
    // clocks, host and versions
    for (key, value) in predicted(model, progress.preparation_steps == 0) {
        put(key, json!(value));
    }
    put("wall_seconds", json!(progress.seconds));
    put("loading_seconds", json!(progress.loading_seconds));
    put("particle_steps_per_second", json!(progress.grain_steps as f64 / progress.loading_seconds.max(1e-9)));
    put("bytes_per_grain", json!(work.bytes(state) as f64 / state.grains.len().max(1) as f64));
    put("threads", json!(rayon::current_num_threads()));
    put("simd", json!(engine::math::real::name(work.arch)));
    put("version", json!(env!("CARGO_PKG_VERSION")));
    put("host", json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH)));
    Value::Object(s)
}

/// Largest overlap over the smaller radius above which the summary warns.
const DEEP: f64 = 0.5;

/// Work of growing daughters over the work of the walls above which the summary warns.
const GROWN: f64 = 0.25;

/// Warnings for the reader of the results. `growth`: work of growing daughters over the work of the walls; `accuracy`: the level that the scene asks for. The texts stand in
/// `summary.json`, whose bytes the golden runs compare.
fn warnings(recorder: &Recorder, growth: f64, accuracy: Option<&Level>) -> Vec<String> {
    let mut warnings = recorder.broken.warnings();
    if let Some(level) = accuracy.filter(|level| recorder.held.keeps(level) == Some(false)) {
        warnings.push(level.warning());
    }
    if recorder.deepest > DEEP {
        warnings.push(format!(
            "the deepest contact overlapped by {:.2} of the smaller grain's radius: fragments below the comminution limit cannot break and are pressed into \
             larger grains; contacts are soft for these forces (material.elastic, material.linear)",
            recorder.deepest
        ));
    }
    warnings.extend(recorder.without_voids.map(|w| w.in_words()));
    if growth > GROWN {
        warnings.push(format!(
            "daughters that grew did {growth:.1} times the work of the walls: stresses and the void ratio beyond yield are theirs too; crushing.lost_mass = \"points\" \
             keeps the mass without this"
        ));
    }
    warnings
}

/// The record at which the void ratio first fell below `records.least_void_ratio`; null where it never did.
fn below_least(below: Option<BelowLeast>) -> Value {
    below.map_or(
        Value::Null,
        |b| json!({"sigma_v_kPa": b.sigma_v * 1e-3, "axial_strain": b.axial_strain, "void_ratio": b.void_ratio}),
    )
}

/// The record at which `void_ratio_star` first fell below 0. A run in which it never did has no such entry.
fn without_voids(w: WithoutVoids) -> Value {
    json!({
        "last_with_voids_kPa": w.last_with_voids * 1e-3,
        "sigma_v_kPa": w.sigma_v * 1e-3,
        "axial_strain": w.axial_strain,
        "porosity_star": w.porosity_star,
    })
}

/// Mean and coefficient of variation of strength over mean strength of the same size, of the grains at the start.
fn strengths(model: &Model, progress: &Progress) -> Value {
    let Some(crush) = &model.physics.crush else { return Value::Null };
    let radii: Vec<f64> = match (&model.rig, model.rig.specimen()) {
        (_, Some(specimen)) => crate::packing::radii(specimen, model.seeds.packing),
        (Rig::Assembly(rig), _) => rig.grains.iter().map(|g| g.radius).collect(),
        _ => return Value::Null,
    };
    let ratios: Vec<f64> = radii
        .iter()
        .take(progress.grains_initial)
        .enumerate()
        .map(|(k, &r)| {
            let d = 2.0 * r;
            let lineage = engine::math::random::lineage_root(k as u32);
            let mean = crush.strength.sigma_lim0 * engine::breakage::criterion::size_factor(d, crush.strength.d0, crush.strength.m);
            crush.strength.draw(model.seeds.strength, lineage, d) / mean
        })
        .collect();
    moments(&ratios)
}

/// Mean and coefficient of variation.
pub fn moments(ratios: &[f64]) -> Value {
    let n = ratios.len().max(1) as f64;
    let mean = ratios.iter().sum::<f64>() / n;
    let variance = ratios.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / n;
    json!({"mean": mean, "coefficient_of_variation": variance.sqrt() / mean})
}
