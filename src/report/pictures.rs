//! Figures that are no curves, as they were drawn: for runs without snapshots, which have no view in three dimensions.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use laboratory::error::{Error, Result};
use laboratory::run::FIGURES;
use serde_json::{Value, json};
use std::path::Path;

/// Longest file that is shown, bytes.
const LONGEST: u64 = 20_000_000;

/// The figures that have no chart: name of the file, and what it shows.
const PICTURES: [(&str, &str); 5] = [
    ("specimen", "Specimen"),
    ("points", "Points of the continuum"),
    ("section", "Section"),
    ("bodies", "Rigid bodies"),
    ("force_chains", "Normal forces of contacts"),
];

/// The pictures that the run in `dir` has drawn, each with its title and its address, which holds all of it.
///
/// # Errors
/// A file that cannot be read.
pub fn pictures(dir: &Path) -> Result<Vec<Value>> {
    let mut found = Vec::new();
    for (name, title) in PICTURES {
        let path = dir.join(FIGURES).join(format!("{name}.svg"));
        if !path.is_file() {
            continue;
        }
        if let Some(svg) = table::read_up_to(&path, LONGEST).map_err(Error::read(&path))? {
            found.push(
                json!({ "name": name, "title": title, "address": format!("data:image/svg+xml;base64,{}", STANDARD.encode(svg)) }),
            );
        }
    }
    Ok(found)
}
