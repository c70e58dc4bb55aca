//! Outlines of bodies from a CSV file: `outline,x,y` in the plane, `outline,x,y,z` in space. Rows with the same name make one outline; lengths are in any unit, as each body is
//! made in the size that its set draws. Lines that begin with `#` are comments.

use super::files::{bounded_columns, read_text};
use super::layers::{Layer, shown};
use crate::error::{Error, Result};
use std::path::Path;
use toml::Value;

/// Most corners of a file: as many as a scene can list.
const MOST: usize = super::files::MOST_VALUES / 5;
/// Columns that a file may have, the last only in space.
const COLUMNS: [&str; 4] = ["outline", "x", "y", "z"];

/// Number of corners of each outline, and all corners one after the other.
type Outlines = (Vec<usize>, Vec<[f64; 3]>);

/// Replaces `outlines_csv` of each set of bodies by what its file holds, so that a resolved scene needs no other file.
///
/// # Errors
/// A file that cannot be read; a mistake in it, with line and column; `outlines_csv` beside what it stands for.
pub fn outlines(layer: &mut Layer) -> Result<()> {
    let count = layer.table.get("block_set").and_then(Value::as_array).map_or(0, Vec::len);
    for i in 0..count {
        let origin = layer.origin(&format!("block_set[{i}].outlines_csv"));
        let Some(set) = layer.table.get_mut("block_set").and_then(|s| s.get_mut(i)).and_then(Value::as_table_mut) else { continue };
        let Some(Value::String(name)) = set.get("outlines_csv").cloned() else { continue };
        let wrong =
            |message: &str| Err(Error::input(&origin.place, &origin.key, Some(shown(&Value::String(name.clone()))), message));
        if set.contains_key("outline_points") || set.contains_key("outline_corners") {
            return wrong("must not stand beside outline_points and outline_corners");
        }
        let (corners, points) = read(Path::new(&name))?;
        set.remove("outlines_csv");
        let corners = corners.into_iter().map(|n| Value::Integer(n as i64));
        set.insert("outline_corners".into(), Value::Array(corners.collect()));
        set.insert("outline_points".into(), Value::Array(points.into_iter().flatten().map(Value::Float).collect()));
    }
    Ok(())
}

fn read(path: &Path) -> Result<Outlines> {
    let text = read_text(path)?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let wrong = |key: &str, message: String| Error::input(path.display(), key, None, message);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let broken = |e: csv::Error| wrong("", e.to_string());
    let header = reader.headers().map_err(broken)?;
    bounded_columns(path, header.len())?;
    let mut places: [Option<usize>; 4] = [None; 4];
    for (column, name) in header.iter().enumerate() {
        let Some(what) = COLUMNS.iter().position(|c| *c == name) else {
            return Err(wrong(name, "unknown column; there must be outline, x and y, and in space z".into()));
        };
        if places[what].replace(column).is_some() {
            return Err(wrong(name, "stands there twice".into()));
        }
    }
    let [Some(outline), Some(x), Some(y), z] = places else {
        let missing = (0..3).find(|&k| places[k].is_none()).map_or("", |k| COLUMNS[k]);
        return Err(wrong("", format!("has no column {missing}; there must be outline, x and y, and in space z")));
    };
    let (mut names, mut corners, mut points): (Vec<String>, Vec<usize>, Vec<[f64; 3]>) = Default::default();
    for record in reader.records() {
        let record = record.map_err(broken)?;
        let at = || format!("{} line {}", path.display(), record.position().map_or(0, csv::Position::line));
        if points.len() == MOST {
            return Err(wrong("", format!("must hold at most {MOST} corners")));
        }
        let of = |column: usize, key: &str| {
            let cell = record.get(column).unwrap_or("");
            let value = cell.parse::<f64>().ok().filter(|x| x.is_finite());
            value.ok_or_else(|| Error::input(at(), key, Some(cell.into()), "must be a finite number"))
        };
        let point = [of(x, "x")?, of(y, "y")?, z.map_or(Ok(0.0), |z| of(z, "z"))?];
        let name = record.get(outline).unwrap_or("");
        match (names.last().map(String::as_str) == Some(name), corners.last_mut()) {
            (true, Some(count)) => *count += 1,
            _ if names.iter().any(|other| other == name) => {
                return Err(Error::input(
                    at(),
                    "outline",
                    Some(name.into()),
                    "comes again after another one: its rows must stand together",
                ));
            }
            _ => {
                names.push(name.into());
                corners.push(1);
            }
        }
        points.push(point);
    }
    if points.is_empty() {
        return Err(wrong("", "holds no outlines below its header".into()));
    }
    Ok((corners, points))
}
