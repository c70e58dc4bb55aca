//! Reads grains from a CSV file. Columns `x_m,y_m,z_m` (centre) and `r_m` (radius) are needed, columns of velocity, spin and
//! material are optional; lines that begin with `#` are comments.

use super::files::{bounded_columns, read_text};
use super::layers::{Layer, Origin};
use super::suggest::nearest;
use crate::columns::mapped;
use crate::error::{Error, Result};
use std::path::Path;
use toml::{Table, Value};

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Column {
    /// A component of a vector: key of the vector in `[[grain]]`, index of the component 0 to 2, and factor from the column's unit
    /// to SI.
    Vector(&'static str, usize, f64),
    /// The radius, m, after multiplication with the factor; the factor of a diameter contains 1/2.
    Radius(f64),
    /// The name of the material.
    Material,
    /// A column that runs write and that a scene does not use.
    Ignored,
}

const IGNORED: [&str; 4] = ["generation", "lineage", "id", "strength_MPa"];
const LENGTHS: [(&str, f64); 3] = [("", 1.0), ("_m", 1.0), ("_mm", 1e-3)];
/// Most grains of a file: as many as a scene can list, each with 25 signs between its values.
pub const MOST: usize = super::files::MOST_VALUES / 14;
const NEEDED: &str = "x_m, y_m, z_m and r_m (or _mm; without a unit: m)";

/// Replaces the key `grains_csv` of a free scene by the list `grain` that its file holds. Other scenes are left as they are.
///
/// # Errors
/// A file that cannot be read; a mistake in the file, with line and column; `grains_csv` beside `[[grain]]`.
pub fn grains(layer: &mut Layer) -> Result<()> {
    let free = layer.table.get("kind").and_then(Value::as_str) == Some("assembly");
    let Some(Value::String(name)) = layer.table.get("grains_csv").cloned().filter(|_| free) else {
        return Ok(());
    };
    let origin = layer.origin("grains_csv");
    if layer.table.contains_key("grain") {
        let message = "must not stand beside [[grain]]";
        return Err(Error::input(origin.place, origin.key, Some(name), message));
    }
    let list = read(Path::new(&name)).map_err(|e| match e {
        Error::Input { place, key, message, .. } if key.is_empty() && place == name => {
            Error::input(origin.place, origin.key, Some(format!("{name:?}")), message)
        }
        other => other,
    })?;
    layer.table.remove("grains_csv");
    layer.table.insert("grain".into(), Value::Array(list));
    layer.note("grain", Origin { place: name, key: "grain".into() });
    Ok(())
}

/// The grains of the file, each as an entry of `[[grain]]`.
fn read(path: &Path) -> Result<Vec<Value>> {
    let text = read_text(path)?;
    let text = mapped(path, text.strip_prefix('\u{feff}').unwrap_or(&text))?;
    let text = text.as_ref();
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let broken = |e: csv::Error| Error::input(at(path, text, e.position()), "", None, cause(&e));
    let header = reader.headers().map_err(broken)?;
    bounded_columns(path, header.len())?;
    let header: Vec<String> = header.iter().map(String::from).collect();
    let columns = columns(path, &header)?;
    let mut grains = Vec::new();
    for record in reader.records() {
        let record = record.map_err(broken)?;
        let place = at(path, text, record.position());
        if grains.len() == MOST {
            return Err(Error::input(path.display(), "", None, format!("must hold at most {MOST} grains")));
        }
        grains.push(grain(&place, &header, &columns, &record)?);
    }
    if grains.is_empty() {
        let message = "holds no grains below its header";
        return Err(Error::input(path.display(), "", None, message));
    }
    Ok(grains)
}

/// The file and the line of a record, for messages. The reader's `position` is where it began to look for the record; the comments
/// and empty lines between there and the record are counted here.
fn at(path: &Path, text: &str, position: Option<&csv::Position>) -> String {
    let Some(position) = position else {
        return path.display().to_string();
    };
    let start = usize::try_from(position.byte()).unwrap_or(0);
    let rest = text.get(start..).unwrap_or("");
    let skipped = rest.lines().take_while(|line| line.is_empty() || line.starts_with('#')).count();
    let line = position.line() + skipped as u64;
    format!("{} line {line}", path.display())
}

fn cause(e: &csv::Error) -> String {
    match e.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => format!("has {len} values; the header has {expected_len}"),
        _ => e.to_string(),
    }
}

/// What each column holds, by the names of the header.
fn columns(path: &Path, header: &[String]) -> Result<Vec<Column>> {
    let known = known();
    let wrong = |key: &str, message: String| Error::input(path.display(), key, None, message);
    let mut columns = Vec::with_capacity(header.len());
    for name in header {
        let Some((_, column)) = known.iter().find(|(k, _)| k == name) else {
            let near = nearest(name, known.iter().map(|(k, _)| k.as_str()));
            let hint = match near {
                Some(near) => format!("did you mean {near}?"),
                None if name.contains(';') => "columns are separated by commas".into(),
                None => {
                    format!("there must be {NEEDED}, and may be vx_m_s, vy_m_s, vz_m_s, wx_rad_s, wy_rad_s, wz_rad_s, material")
                }
            };
            return Err(wrong(name, format!("unknown column; {hint}")));
        };
        let again = columns.iter().any(|c| same(c, column));
        if again && *column != Column::Ignored {
            return Err(wrong(name, "this quantity has two columns".into()));
        }
        columns.push(*column);
    }
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        let here = |c: &Column| matches!(c, Column::Vector("position_m", i, _) if *i == k);
        if !columns.iter().any(here) {
            return Err(wrong("", format!("has no column {axis}_m; there must be {NEEDED}")));
        }
    }
    if !columns.iter().any(|c| matches!(c, Column::Radius(_))) {
        return Err(wrong("", format!("has no column r_m; there must be {NEEDED}")));
    }
    Ok(columns)
}

/// Whether two columns hold the same quantity, in whatever unit.
fn same(a: &Column, b: &Column) -> bool {
    match (a, b) {
        (Column::Vector(n, i, _), Column::Vector(m, j, _)) => n == m && i == j,
        (Column::Radius(_), Column::Radius(_)) => true,
        _ => a == b,
    }
}

/// All names that a column may have, and what a column of that name holds.
fn known() -> Vec<(String, Column)> {
    let mut known = Vec::new();
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        for (suffix, si) in LENGTHS {
            known.push((format!("{axis}{suffix}"), Column::Vector("position_m", k, si)));
        }
        for (letter, suffix, key) in [("v", "_m_s", "velocity_m_s"), ("w", "_rad_s", "spin_rad_s")] {
            known.push((format!("{letter}{axis}{suffix}"), Column::Vector(key, k, 1.0)));
            known.push((format!("{letter}{axis}"), Column::Vector(key, k, 1.0)));
        }
    }
    for (suffix, si) in LENGTHS {
        known.push((format!("r{suffix}"), Column::Radius(si)));
        known.push((format!("radius{suffix}"), Column::Radius(si)));
        known.push((format!("d{suffix}"), Column::Radius(0.5 * si)));
        known.push((format!("diameter{suffix}"), Column::Radius(0.5 * si)));
    }
    known.push(("material".into(), Column::Material));
    known.extend(IGNORED.map(|name| (name.to_string(), Column::Ignored)));
    known
}

/// One grain, as an entry of `[[grain]]`, from a record. `place`: file and line, for messages.
fn grain(place: &str, header: &[String], columns: &[Column], record: &csv::StringRecord) -> Result<Value> {
    let mut vectors = [("position_m", [0.0; 3]), ("velocity_m_s", [0.0; 3]), ("spin_rad_s", [0.0; 3])];
    let mut grain = Table::new();
    for ((name, column), text) in header.iter().zip(columns).zip(record) {
        let number = || match text.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => {
                let message = "must be a finite number";
                Err(Error::input(place, name.as_str(), Some(text.into()), message))
            }
        };
        match *column {
            Column::Vector(key, k, si) => {
                let value = number()? * si;
                let slot = vectors.iter_mut().find(|(name, _)| *name == key);
                if let Some((_, vector)) = slot {
                    vector[k] = value;
                }
            }
            Column::Radius(si) => {
                let radius = number()?;
                if radius <= 0.0 {
                    let message = "must be > 0";
                    return Err(Error::input(place, name.as_str(), Some(text.into()), message));
                }
                grain.insert("radius_m".into(), Value::Float(radius * si));
            }
            Column::Material => {
                if !text.is_empty() {
                    grain.insert("material".into(), Value::String(text.into()));
                }
            }
            Column::Ignored => {}
        }
    }
    for (key, vector) in vectors {
        let list = vector.map(Value::Float).to_vec();
        grain.insert(key.into(), Value::Array(list));
    }
    Ok(Value::Table(grain))
}
