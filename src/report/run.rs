//! One run for its page: what was run, what was found, what to doubt.

use super::frames;
use super::links::link;
use super::log::{logs, tables};
use super::pictures::pictures;
use laboratory::error::{Error, Result};
use laboratory::run::{SUMMARY, resumable, words};
use laboratory::scene::{self, RESOLVED, Scene};
use serde_json::{Value, json};
use std::path::Path;

/// Entries of `summary.json` by which the quality of a run is judged: path, meaning, unit.
const QUALITY: [(&str, &str, &str); 19] = [
    (
        "/held_every_step/largest_platen_difference",
        "Largest difference of the platens' stresses, over their mean, in any step",
        "–",
    ),
    (
        "/held_every_step/largest_distance_from_target",
        "Largest difference of the stress from its target, over the target, in any step",
        "–",
    ),
    ("/held_every_step/largest_inertial_number", "Largest inertial number, in any step", "–"),
    ("/held_every_step/above_kPa", "Least vertical stress of the steps that count", "kPa"),
    ("/held_every_step/waited_steps", "Steps in which the target waited for the stress", ""),
    ("/quasi_static/largest_platen_difference", "Largest difference of the platens' stresses, over their mean, at records", "–"),
    (
        "/quasi_static/largest_distance_from_target",
        "Largest difference of the stress from its target, over the target, at records",
        "–",
    ),
    ("/quasi_static/largest_inertial_number", "Largest inertial number, at records", "–"),
    ("/accuracy/level", "Accuracy that the scene asks for", ""),
    ("/accuracy/kept", "Whether the platens were as close to balance as that asks for", ""),
    ("/energy_error", "Energy that the ledger misses, over the work of the walls", "–"),
    ("/energy_nonconservative", "Energy that contacts gave or took without a potential, over the work of the walls", "–"),
    ("/energy_rises", "Breakages after which more elastic energy was stored around than before", ""),
    ("/growth_over_wall_work", "Work of growing daughters over the work of the walls", "–"),
    ("/mass_error", "Error of the dry mass, over the mass", "–"),
    ("/dissipated_share", "Share of the energy given that was dissipated", "–"),
    ("/account_error", "Energy that the account misses, over the energy given", "–"),
    ("/largest_hertz_deviation", "Largest deviation of a force from Hertz", "–"),
    ("/largest_overshoot", "Largest excess of a force over its limit at breakage", "–"),
];

/// A run for its page.
pub struct Shown {
    /// Everything but the snapshots' numbers.
    pub value: Value,
    /// The snapshots' numbers, each in base 64, in the order in which `value` counts them.
    pub blobs: Vec<String>,
    /// What a reader must know of a run that is not finished.
    pub note: Option<String>,
}

/// Reads the run in `dir` for a page at `page`, which calls it `name`; at most `snapshots` of its snapshots.
///
/// # Errors
/// Records that are damaged.
pub fn shown(dir: &Path, name: &str, page: &Path, snapshots: usize) -> Result<Shown> {
    let summary = read_summary(dir)?;
    let resolved = scene::read_text(&dir.join(RESOLVED))?;
    let scene = scene::load(dir.join(RESOLVED), &[]);
    let kind = kind(&resolved);
    let note = match summary.as_ref() {
        _ if resumable(dir) => {
            Some("the run is not finished: the page shows what it has left so far; comminute resume goes on with it".to_string())
        }
        None => Some("the run is not finished and has no checkpoint: the page shows what it has left".to_string()),
        Some(_) => None,
    };
    let known = summary.clone().unwrap_or(Value::Null);
    let frames = frames::frames(dir, snapshots, resolved.lines().any(|line| line == "plane_strain = true"))?;
    let quality: Vec<Value> = QUALITY
        .iter()
        .filter_map(|(path, what, unit)| Some(json!([what, known.pointer(path).filter(|v| !v.is_null())?, unit])))
        .collect();
    let value = json!({
        "name": name,
        "folder": link(page, dir),
        "kind": kind,
        "description": scene.as_ref().map(Scene::description).unwrap_or_default(),
        "note": note,
        "closing": if summary.is_some() { words::closing(&known) } else { Vec::new() },
        "warnings": ([words::warnings(&known), words::doubts(&known)].concat()),
        "sources": sources(&scene),
        "quality": quality,
        "summary": flat(&known),
        "scene": resolved,
        "files": {
            "summary": summary.as_ref().map(|_| link(page, &dir.join(SUMMARY))),
            "scene": link(page, &dir.join(RESOLVED)),
        },
        "tables": tables(dir, page)?,
        "logs": logs(dir, &kind)?,
        "pictures": if frames.blobs.is_empty() { pictures(dir)? } else { Vec::new() },
        "frames": frames.value,
    });
    Ok(Shown { value, blobs: frames.blobs, note })
}

/// The content of `summary.json`; `None` for a run that has none.
fn read_summary(dir: &Path) -> Result<Option<Value>> {
    let path = dir.join(SUMMARY);
    if !path.is_file() {
        return Ok(None);
    }
    let text = scene::read_text(&path)?;
    let damaged = |e: serde_json::Error| Error::input(path.display(), "", None, format!("is damaged: {e}"));
    serde_json::from_str(&text).map(Some).map_err(damaged)
}

/// The kind of a resolved scene; empty if it has none.
fn kind(resolved: &str) -> String {
    let line = resolved.lines().find_map(|line| line.strip_prefix("kind = "));
    line.map_or_else(String::new, |word| word.trim().trim_matches('"').to_string())
}

/// Assumed values and open matters of a scene; why they are not known, where it cannot be read.
fn sources(scene: &Result<Scene>) -> Value {
    match scene {
        Ok(scene) => json!({ "assumed": scene::assumptions(scene), "decisions": scene::decisions(scene) }),
        Err(error) => json!({ "unknown": error.to_string() }),
    }
}

/// Every entry of a summary that is no list of texts, with the names of nested ones joined by points.
fn flat(summary: &Value) -> Vec<(String, Value)> {
    fn add(name: &str, value: &Value, found: &mut Vec<(String, Value)>) {
        match value {
            Value::Object(inner) => {
                for (key, value) in inner {
                    add(&if name.is_empty() { key.clone() } else { format!("{name}.{key}") }, value, found);
                }
            }
            Value::Array(inner) if name != "warnings" => {
                for (i, value) in inner.iter().enumerate() {
                    add(&format!("{name}.{}", i + 1), value, found);
                }
            }
            Value::Array(_) | Value::Null => {}
            value => found.push((name.into(), value.clone())),
        }
    }
    let mut found = Vec::new();
    add("", summary, &mut found);
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_entries_have_the_names_of_their_ways() {
        let summary = json!({ "a": 1, "b": { "c": [2.5, { "d": "x" }], "none": null }, "warnings": ["w"] });
        let want = [("a", json!(1)), ("b.c.1", json!(2.5)), ("b.c.2.d", json!("x"))];
        assert_eq!(flat(&summary), want.map(|(k, v)| (k.to_string(), v)));
    }
}
