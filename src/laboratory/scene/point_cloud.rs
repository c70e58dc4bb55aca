//! Material points from a CSV file: `x_m,y_m,z_m` (or `_mm`) and an optional `volume_m3` (or `_mm3`); lines that begin with `#` are comments.

use super::files::{bounded_columns, read_text};
use super::layers::Layer;
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

fn read(path: &Path) -> Result<(Vec<f64>, Vec<f64>)> {
    let text = read_text(path)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let wrong = |key: &str, value: Option<String>, message: String| Error::input(path.display(), key, value, message);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let broken = |e: csv::Error| wrong("", None, e.to_string());
    let header = reader.headers().map_err(broken)?;
    bounded_columns(path, header.len())?;
    let header: Vec<String> = header.iter().map(String::from).collect();
    let mut places: [Option<(usize, f64)>; 4] = [None; 4];
    for (column, name) in header.iter().enumerate() {
        let Some((_, what, si)) = COLUMNS.iter().find(|c| c.0 == name) else {
            return Err(wrong(
                name,
                None,
                "unknown column; there must be x_m, y_m, z_m (or _mm), and may be volume_m3 (or _mm3)".into(),
            ));
        };
        if places[*what].replace((column, *si)).is_some() {
            return Err(wrong(name, None, "this quantity has two columns".into()));
        }
    }
    if let Some(missing) = (0..3).find(|&a| places[a].is_none()) {
        return Err(wrong("", None, format!("has no column {}_m (or _mm)", ["x", "y", "z"][missing])));
    }
    let (mut positions, mut volumes) = (Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record.map_err(broken)?;
        if positions.len() == 3 * MOST {
            return Err(wrong("", None, format!("must hold at most {MOST} points")));
        }
        for (what, place) in places.iter().enumerate() {
            let Some((column, si)) = *place else { continue };
            let cell = record.get(column).unwrap_or("");
            let value = cell.parse::<f64>().ok().filter(|x| x.is_finite() && (what < 3 || *x > 0.0));
            let Some(value) = value else {
                let line = record.position().map_or(0, csv::Position::line);
                let allowed = if what < 3 { "must be a finite number" } else { "must be a number > 0" };
                let place = format!("{} line {line}", path.display());
                return Err(Error::input(place, header[column].as_str(), Some(cell.into()), allowed));
            };
            if what < 3 { positions.push(value * si) } else { volumes.push(value * si) }
        }
    }
    if positions.is_empty() {
        return Err(wrong("", None, "holds no points below its header".into()));
    }
    Ok((positions, volumes))
}
