//! Material points from a CSV file: `x_m,y_m,z_m` (or `_mm`) and an optional `volume_m3` (or `_mm3`); lines that begin with `#` are comments.

use super::layers::Layer;
use super::number_file::Format;
use crate::error::{Error, Result};
use std::path::Path;
use toml::Value;

/// Columns, what they are, and the SI value of their unit.
const COLUMNS: [(&str, usize, f64); 8] = [
    ("x_m", 0, 1.0),
    ("y_m", 1, 1.0),
    ("z_m", 2, 1.0),
    ("x_mm", 0, 1e-3),
    ("y_mm", 1, 1e-3),
    ("z_mm", 2, 1e-3),
    ("volume_m3", 3, 1.0),
    ("volume_mm3", 3, 1e-9),
];

/// Most points of a file: as many as a scene can list.
const MOST: usize = super::files::MOST_VALUES / 5;

/// Replaces `points_csv` of each body by what its file holds, so that a resolved scene needs no other file.
pub fn points(layer: &mut Layer) -> Result<()> {
    let count = layer.table.get("body").and_then(Value::as_array).map_or(0, Vec::len);
    for i in 0..count {
        let origin = layer.origin(&format!("body[{i}].points_csv"));
        let Some(body) = layer.table.get_mut("body").and_then(|b| b.get_mut(i)).and_then(Value::as_table_mut) else { continue };
        let Some(Value::String(name)) = body.get("points_csv").cloned() else { continue };
        if body.contains_key("points_m") {
            return Err(Error::input(origin.place, origin.key, Some(name), "must not stand beside points_m"));
        }
        let (positions, volumes) = read(Path::new(&name))?;
        body.remove("points_csv");
        body.insert("points_m".into(), list(positions));
        if !volumes.is_empty() {
            body.insert("volumes_m3".into(), list(volumes));
        }
    }
    Ok(())
}

fn list(values: Vec<f64>) -> Value {
    Value::Array(values.into_iter().map(Value::Float).collect())
}

/// Positions, m, one after the other, and volumes, m³; no volumes where the file has none.
fn read(path: &Path) -> Result<(Vec<f64>, Vec<f64>)> {
    let words = "x_m, y_m, z_m (or _mm), and may be volume_m3 (or _mm3)";
    let table =
        Format::<4> { columns: &COLUMNS, needed: 3, positive: 3, label: "", rows: "points", words, most: MOST }.read(path)?;
    let positions = table.rows.iter().flat_map(|row| [row.numbers[0], row.numbers[1], row.numbers[2]]).collect();
    let volumes = if table.has[3] { table.rows.iter().map(|row| row.numbers[3]).collect() } else { Vec::new() };
    Ok((positions, volumes))
}
