//! Runs a batch of crushing tests of single grains between platens. Each grain has a state of its own, and a whole batch takes
//! seconds, so there is no checkpoint: resuming a stopped batch makes all its tests again, with the same results.

use super::Outcome;
use super::progress_bar::Bar;
use crate::error::{Error, Result};
use crate::interrupt::stop_asked;
use crate::model::{GrainCrushing, Model};
use crate::record::grain_crushing as records;
use crate::rig::grain_crushing::{Test, pair, press};
use crate::scene::estimate::predicted;
use rayon::prelude::*;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// Tests every grain and writes the tables and `summary.json`.
///
/// # Errors
/// [`Error::Interrupted`], a force that is not finite, or a file that cannot be written.
pub fn run(model: &Model, rig: &GrainCrushing, out: &Path, quiet: bool) -> Result<Outcome> {
    let started = Instant::now();
    let tests = press_all(model, rig, out, quiet)?;
    let wall_seconds = started.elapsed().as_secs_f64();
    records::write(out, model, rig, &tests)?;
    let mut summary = summary(model, rig, &tests);
    predicted(model, false).into_iter().for_each(|(key, value)| summary[key] = json!(value));
    summary["wall_seconds"] = json!(wall_seconds);
    summary["threads"] = json!(rayon::current_num_threads());
    summary["version"] = json!(env!("CARGO_PKG_VERSION"));
    summary["host"] = json!(format!("{} {}", std::env::consts::OS, std::env::consts::ARCH));
    Outcome::undrawn(summary, out, model)
}

/// Makes all tests, in parallel; results in the order of the grains' numbers.
fn press_all(model: &Model, rig: &GrainCrushing, out: &Path, quiet: bool) -> Result<Vec<Test>> {
    let bar = Mutex::new(Bar::new(quiet));
    let done = AtomicUsize::new(0);
    let failed = AtomicBool::new(false);
    let count = rig.diameters.len();
    let stop = || stop_asked() || failed.load(Ordering::Relaxed);
    let one = |number: u32| {
        let test = if stop() { Ok(None) } else { press(model, rig, number, stop) };
        failed.fetch_or(test.is_err(), Ordering::Relaxed);
        let n = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Ok(mut bar) = bar.try_lock() {
            bar.show_count(n, count, "grains pressed");
        }
        test
    };
    let tests: Vec<Result<Option<Test>>> = (0..count as u32).into_par_iter().with_max_len(1).map(one).collect();
    let bar = bar.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    // an error is reported before an interruption: it makes the other tests stop
    let mut finished = Vec::with_capacity(count);
    let mut given_up = false;
    for test in tests {
        match test {
            Ok(Some(test)) => finished.push(test),
            Ok(None) => given_up = true,
            Err(e) => return Err(e),
        }
    }
    if given_up {
        let step = finished.iter().map(|t| t.steps).sum();
        return Err(Error::Interrupted { step, out: out.into() });
    }
    bar.finish();
    Ok(finished)
}

fn summary(model: &Model, rig: &GrainCrushing, tests: &[Test]) -> Value {
    let broken = tests.iter().filter(|t| t.broken);
    let largest = |f: &dyn Fn(&Test) -> f64| tests.iter().map(f).fold(0.0, f64::max);
    // a grain that breaks in the first step has passed its limit at an unknown force
    let seated = |t: &Test| t.broken && t.steps == 1;
    let overshoot = |t: &Test| t.limit_force.filter(|_| t.broken && !seated(t)).map_or(0.0, |limit| t.force / limit - 1.0);
    let name = |k: u8| model.physics.materials[usize::from(k)].name.clone();
    let pair = pair(model, rig);
    json!({
        "scene": model.name,
        "kind": "platen",
        "seed": {"packing": model.seeds.packing, "strength": model.seeds.strength},
        "grain": name(rig.grain),
        "platen": rig.platen.map_or("rigid".into(), name),
        "E_star_GPa": 1e-9 * pair.e_eff,
        "area": model.physics.crush.as_ref().map(|c| match c.criterion.word() {
            "hertz_area" => "hertz",
            word => word,
        }),
        "tests": tests.len(),
        "crush_events": broken.clone().count(),
        "censored": tests.len() - broken.count(),
        "broken_on_seating": tests.iter().filter(|t| seated(t)).count(),
        "cannot_break": tests.iter().filter(|t| t.limit_force.is_none()).count(),
        "steps": tests.iter().map(|t| t.steps).sum::<u64>(),
        "largest_overshoot": largest(&overshoot),
        "largest_hertz_deviation": largest(&|t| t.deviation),
        "largest_platen_difference": largest(&|t| t.difference),
        "largest_displacement_over_d": largest(&|t| t.displacement / t.diameter),
        "strength_ratio": strengths(model, tests),
    })
}

/// Mean and coefficient of variation of strength over mean strength of the same size.
fn strengths(model: &Model, tests: &[Test]) -> Value {
    let Some(crush) = &model.physics.crush else { return Value::Null };
    let s = &crush.strength;
    let mean_at = |d: f64| s.sigma_lim0 * engine::breakage::criterion::size_factor(d, s.d0, s.m);
    let ratios: Vec<f64> = tests.iter().map(|t| t.strength / mean_at(t.diameter)).collect();
    super::summary::moments(&ratios)
}
