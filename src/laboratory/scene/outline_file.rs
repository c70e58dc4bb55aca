//! Outlines of bodies from a CSV file: `outline,x,y` in the plane, `outline,x,y,z` in space. Rows with the same name make one outline; lengths are in any unit, as each body is
//! made in the size that its set draws. Lines that begin with `#` are comments.

use super::layers::{Layer, shown};
use super::number_file::{Format, at};
use crate::error::{Error, Result};
use std::path::Path;
use toml::Value;

/// Most corners of a file: as many as a scene can list.
const MOST: usize = super::files::MOST_VALUES / 5;
/// Columns of places; the last only in space.
const COLUMNS: [(&str, usize, f64); 3] = [("x", 0, 1.0), ("y", 1, 1.0), ("z", 2, 1.0)];

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
    let words = "outline, x and y, and in space z";
    let table = Format::<3> { columns: &COLUMNS, needed: 2, positive: 3, label: "outline", rows: "outlines", words, most: MOST }
        .read(path)?;
    let (mut names, mut corners): (Vec<&str>, Vec<usize>) = Default::default();
    for row in &table.rows {
        let name = row.label.as_str();
        match (names.last() == Some(&name), corners.last_mut()) {
            (true, Some(count)) => *count += 1,
            _ if names.contains(&name) => {
                return Err(at(path, row.line, "outline", name, "comes again after another one: its rows must stand together"));
            }
            _ => {
                names.push(name);
                corners.push(1);
            }
        }
    }
    Ok((corners, table.rows.iter().map(|row| row.numbers).collect()))
}
