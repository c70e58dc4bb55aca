//! Reads scene and material files, together with their base files and the materials that they name.

use super::layers::{Layer, join, shown};
use super::sources::spread_sources;
use super::suggest::nearest;
use crate::error::{Error, Result};
use std::fs;
use std::path::{Component, Path, PathBuf};
use toml::{Table, Value};

/// Most files of which each is the base of the one before.
const MOST_BASES: usize = 32;
/// Length of the longest text file that is read, bytes.
const LONGEST: u64 = 64 << 20;
/// Most values of a scene or material file, and half as many signs between values: reading them takes some 600 MB and a second.
pub const MOST_VALUES: usize = 2_000_000;
/// Most keys of a file, those in lists of tables not counted: every key of a scene with 100 materials.
const MOST_KEYS: usize = 10_000;
/// Characters of a line that a message shows.
const LONGEST_LINE: usize = 200;
/// Length of the longest `source`, bytes: each value below it gets a copy.
const LONGEST_SOURCE: usize = 4096;

/// Reads the scene file `path` and merges it with its base files and materials.
///
/// # Errors
/// A file that cannot be read, is not TOML, or is based on itself.
pub fn scene_file(path: &Path) -> Result<Layer> {
    file(path, &mut Vec::new())
}

/// Reads a scene from `text` and merges it with its base files and materials. Paths in the text are relative to the folder of
/// `path`, and messages name `path` as the file; there need not be such a file.
///
/// # Errors
/// As of [`scene_file`].
pub fn scene_text(path: &Path, text: &str) -> Result<Layer> {
    let path = tidy(path);
    let table = parse(&path, text)?;
    resolve(table, &path, "", &mut vec![path.clone()])
}

/// Reads the material file `path` and merges it with its base files.
///
/// # Errors
/// As of [`scene_file`].
pub fn material_file(path: &Path) -> Result<Layer> {
    file(path, &mut Vec::new())
}

/// Reads a scene or material file with all that it refers to. `below`: the files that are being read and lead to this one.
fn file(path: &Path, below: &mut Vec<PathBuf>) -> Result<Layer> {
    let path = tidy(path);
    let text = read_text(&path)?;
    if below.contains(&path) {
        let chain: Vec<String> = below.iter().map(|p| p.display().to_string()).collect();
        let message = format!("is based on itself ({} → this file)", chain.join(" → "));
        return Err(Error::input(path.display(), "", None, message));
    }
    if below.len() == MOST_BASES {
        let message = format!("is at the end of a chain of more than {MOST_BASES} files of which each is based on the next");
        return Err(Error::input(path.display(), "", None, message));
    }
    below.push(path.clone());
    let table = parse(&path, &text)?;
    let layer = resolve(table, &path, "", below)?;
    below.pop();
    Ok(layer)
}

/// Merges the table at the key `at` of the file `path` (`""`: the whole file) with its base and its materials, and makes the paths
/// of data files in the table relative to the working folder. The `description` of a base is left out, and so is
/// its `name` in a scene.
fn resolve(mut table: Table, path: &Path, at: &str, below: &mut Vec<PathBuf>) -> Result<Layer> {
    let mut base = match table.remove("base") {
        Some(Value::String(name)) => file_near(path, &join(at, "base"), &name, below)?,
        Some(other) => {
            let message = "must be the path of a file, in quotes";
            return Err(wrong(path, &join(at, "base"), &other, message));
        }
        None => Layer::default(),
    };
    if at.is_empty() {
        base.table.remove("description");
        if is_scene(&base.table) || is_scene(&table) {
            base.table.remove("name");
        }
    }
    spread_sources(&mut table, None);
    if let Some(Value::String(name)) = table.get_mut("grains_csv") {
        *name = beside(path, name).display().to_string();
    }
    for (list, key) in [("body", "points_csv"), ("block", "mesh_file"), ("block", "path_csv"), ("block_set", "outlines_csv")] {
        for entry in table.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten() {
            if let Some(Value::String(name)) = entry.get_mut(key) {
                *name = beside(path, name).display().to_string();
            }
        }
    }
    if let Some(Value::String(name)) = table.get_mut("specimen").and_then(|t| t.get_mut("file")) {
        *name = beside(path, name).display().to_string();
    }
    let mut materials = Vec::new();
    if let Some(value) = table.remove("material").filter(|_| at.is_empty()) {
        materials.push(("material".to_string(), value));
    }
    if let Some(Value::Table(named)) = table.get_mut("materials").filter(|_| at.is_empty()) {
        for (name, value) in std::mem::take(named) {
            materials.push((format!("materials.{name}"), value));
        }
    }
    let mut own = Layer::of(table, &path.display().to_string(), at);
    for (key, value) in materials {
        let (layer, replaces) = material(value, path, &key, below)?;
        if replaces {
            base.remove(&key);
        }
        own.mount(&key, layer);
    }
    let by = path.file_name().unwrap_or_default().to_string_lossy();
    base.merge(own, &format!("in {by}"));
    Ok(base)
}

/// The material at `key` of the file `path`: a file that is named there, or a table. The flag is true where it replaces the
/// material of a base as a whole, false where only the keys of the table do.
fn material(value: Value, path: &Path, key: &str, below: &mut Vec<PathBuf>) -> Result<(Layer, bool)> {
    match value {
        Value::String(name) => Ok((file_near(path, key, &name, below)?, true)),
        Value::Table(table) => {
            let replaces = table.contains_key("base");
            Ok((resolve(table, path, key, below)?, replaces))
        }
        other => {
            let message = "must be the path of a material file, in quotes, or a table";
            Err(wrong(path, key, &other, message))
        }
    }
}

/// Reads the file `name`, which stands at `key` of the file `path`.
///
/// # Errors
/// As of [`scene_file`]; where there is no such file, the error names `key` of `path`.
fn file_near(path: &Path, key: &str, name: &str, below: &mut Vec<PathBuf>) -> Result<Layer> {
    let target = beside(path, name);
    if !target.exists() {
        let value = Value::String(name.into());
        return Err(wrong(path, key, &value, &missing(&target)));
    }
    file(&target, below)
}

fn is_scene(table: &Table) -> bool {
    table.contains_key("kind")
}

fn wrong(path: &Path, key: &str, value: &Value, message: &str) -> Error {
    Error::input(path.display(), key, Some(shown(value)), message)
}

/// Reads a text file in UTF-8.
///
/// # Errors
/// `path` is a folder, does not exist, cannot be read, is longer than 64 MiB or is not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    read_text_up_to(path, LONGEST)
}

/// Reads a text file in UTF-8 that may have `longest` bytes, for tables with a row for each grain.
///
/// # Errors
/// As [`read_text`], with that length.
pub fn read_text_up_to(path: &Path, longest: u64) -> Result<String> {
    String::from_utf8(read_up_to(path, longest)?).map_err(|e| {
        let at = e.utf8_error().valid_up_to();
        Error::input(path.display(), "", None, format!("is not UTF-8 text (byte {at})"))
    })
}

/// Refuses a table of more than 1000 columns.
///
/// # Errors
/// The number of columns of the file `path` is larger.
pub fn bounded_columns(path: &Path, columns: usize) -> Result<()> {
    const MOST: usize = 1000;
    if columns > MOST {
        return Err(Error::input(path.display(), "", None, format!("must have at most {MOST} columns; it has {columns}")));
    }
    Ok(())
}

/// Reads a file.
///
/// # Errors
/// `path` is a folder, does not exist, cannot be read or is longer than 64 MiB.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    read_up_to(path, LONGEST)
}

fn read_up_to(path: &Path, longest: u64) -> Result<Vec<u8>> {
    if path.is_dir() {
        return Err(Error::input(path.display(), "", None, "is a folder, not a file"));
    }
    if !path.exists() {
        return Err(Error::input(path.display(), "", None, missing(path)));
    }
    let too_long = || Error::input(path.display(), "", None, format!("must be at most {} MiB long", longest >> 20));
    table::read_up_to(path, longest).map_err(Error::read(path))?.ok_or_else(too_long)
}

/// The table of a text in TOML of a bounded size.
///
/// # Errors
/// As of [`read`]; too many keys, or a `source` that is too long.
fn parse(path: &Path, text: &str) -> Result<Table> {
    // each value but the first of a list stands behind one of these
    let values = text.bytes().filter(|b| matches!(b, b'=' | b',' | b'[' | b'{' | b'.')).count();
    if values > 2 * MOST_VALUES {
        let message = format!("must have at most {MOST_VALUES} values");
        return Err(Error::input(path.display(), "", None, message));
    }
    let table = read(path, text)?;
    let mut left = MOST_KEYS;
    match bounded(&table, "", &mut left) {
        None => Ok(table),
        Some((key, message)) => Err(Error::input(path.display(), key, None, message)),
    }
}

/// The first key of a table with what is wrong about its size; `left` counts down the keys that there may be.
fn bounded(table: &Table, at: &str, left: &mut usize) -> Option<(String, String)> {
    for (name, value) in table {
        let key = join(at, name);
        let Some(less) = left.checked_sub(1) else {
            return Some((String::new(), format!("must have at most {MOST_KEYS} keys, those in lists of tables not counted")));
        };
        *left = less;
        let found = match value {
            Value::Table(inner) => bounded(inner, &key, left),
            Value::Array(list) => list
                .iter()
                .filter_map(Value::as_table)
                .enumerate()
                .find_map(|(i, entry)| bounded(entry, &format!("{key}[{i}]"), &mut MOST_KEYS.clone())),
            Value::String(text) if (name == "source" || at.ends_with("source")) && text.len() > LONGEST_SOURCE => {
                Some((key, format!("must be at most {LONGEST_SOURCE} bytes long; it has {}", text.len())))
            }
            _ => None,
        };
        if found.is_some() {
            return found;
        }
    }
    None
}

/// The table of a text in TOML. Errors name the file `path`, the line and what is written there.
fn read(path: &Path, text: &str) -> Result<Table> {
    toml::from_str(text.strip_prefix('\u{feff}').unwrap_or(text)).map_err(|e: toml::de::Error| {
        let line = e.span().map_or(String::new(), |span| {
            let line = text[..span.start.min(text.len())].matches('\n').count() + 1;
            let written: String = text.lines().nth(line - 1).unwrap_or("").trim().chars().take(LONGEST_LINE).collect();
            format!("line {line} (`{written}`): ")
        });
        let mut message = e.message().trim().replace('\n', ", ");
        if message.contains("type string with a dotted key") {
            message += "; to change single values of a material write [material] with base = \"…\"";
        }
        Error::input(path.display(), "", None, format!("{line}not TOML: {message}"))
    })
}

/// Message that there is no file `path`, with the file of a similar name in the same folder if there is one.
fn missing(path: &Path) -> String {
    let wanted = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    let Ok(entries) = fs::read_dir(folder) else {
        return format!("no such file (there is no folder {})", folder.display());
    };
    let mut names: Vec<String> = entries.flatten().filter_map(|e| e.file_name().into_string().ok()).collect();
    names.sort();
    match nearest(wanted, names.iter().map(String::as_str)) {
        Some(name) => format!("no such file; did you mean {}?", tidy(&folder.join(name)).display()),
        None => "no such file".into(),
    }
}

/// The path `name`, which is relative to the folder of the file `path`, as a path relative to the working folder.
fn beside(path: &Path, name: &str) -> PathBuf {
    tidy(&path.parent().unwrap_or(Path::new("")).join(name))
}

/// The path without `.` and `x/..`: `experiments/../materials/x.toml` becomes `materials/x.toml`.
fn tidy(path: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(out.components().next_back(), Some(Component::Normal(_))) => {
                out.pop();
            }
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_shown_as_a_person_would_write_them() {
        assert_eq!(tidy(Path::new("experiments/coke/../../materials/./x.toml")), Path::new("materials/x.toml"));
        assert_eq!(tidy(Path::new("../x.toml")), Path::new("../x.toml"));
    }
}
