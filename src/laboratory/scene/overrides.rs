//! Overrides: texts `key=value` from the caller, each of which replaces one value of the scene as read from files.

use super::files::material_file;
use super::layers::{Layer, Origin};
use super::schema::parse_literal;
use crate::error::{Error, OVERRIDE, Result};
use std::path::Path;
use toml::{Table, Value};

/// Lays the override `text` (`loading.max_stress_kPa=2000`, `wall[0].friction=0.2`) over `layer`. A value that is not TOML, such as
/// a word without quotes, is taken as text. Paths in an override are relative to the working folder, not to the
/// folder of the scene. `material=FILE` and `materials.NAME=FILE` replace a whole material.
///
/// # Errors
/// A text that is no `key=value`, a key that leads into a value that holds no keys, a list entry that does not exist, a material
/// file that cannot be read. Whether the key is known and the value allowed is checked later ([`super::validate`]).
pub fn apply(layer: &mut Layer, text: &str) -> Result<()> {
    let place = format!("{OVERRIDE}{text}");
    let fail = |message: &str| Error::input(&place, "", None, message);
    let (key, value) = text.split_once('=').ok_or_else(|| fail("must be KEY=VALUE, as in loading.max_stress_kPa=2000"))?;
    let (key, value) = (key.trim(), value.trim());
    if value.is_empty() {
        return Err(fail("has no value after '='"));
    }
    let path = steps(key).ok_or_else(|| fail("is not a key: write table.key or list[0].key"))?;
    let value = parse_literal(value).unwrap_or_else(|| Value::String(value.into()));
    if key == "base" {
        return Err(fail("base may stand only in a file"));
    }
    if let (true, Value::String(file)) = (names_material(key), &value) {
        layer.mount(key, material_file(Path::new(file))?);
        return Ok(());
    }
    if path.iter().any(|s| matches!(s, Step::Entry(_))) {
        enter(&mut layer.table, &path, value).map_err(|m| fail(&m))?;
        let (place, key) = (place.clone(), key.to_string());
        layer.note(&key.clone(), Origin { place, key });
        return Ok(());
    }
    let mut upper = Layer::default();
    enter(&mut upper.table, &path, value).map_err(|m| fail(&m))?;
    blocked(&layer.table, &path).map_err(|m| fail(&m))?;
    for (end, _) in key.match_indices('.').chain([(key.len(), "")]) {
        let key = key[..end].to_string();
        let place = place.clone();
        upper.note(&key.clone(), Origin { place, key });
    }
    layer.merge(upper, "by --set");
    Ok(())
}

/// Whether `key` is that of a whole material: `material` or `materials.NAME`.
fn names_material(key: &str) -> bool {
    key == "material" || key.strip_prefix("materials.").is_some_and(|n| !n.contains('.'))
}

/// A part of a key.
#[derive(Debug, PartialEq)]
enum Step {
    /// Name of a value in a table.
    Name(String),
    /// Index of an entry of a list, from 0.
    Entry(usize),
}

/// The parts of a dotted key, `wall[2].friction`; `None` where `key` is not a key.
fn steps(key: &str) -> Option<Vec<Step>> {
    let mut out = Vec::new();
    for part in key.split('.') {
        let (name, mut rest) = part.split_at(part.find('[').unwrap_or(part.len()));
        if name.is_empty() || name.contains(char::is_whitespace) {
            return None;
        }
        out.push(Step::Name(name.into()));
        while let Some(inner) = rest.strip_prefix('[') {
            let (index, after) = inner.split_once(']')?;
            out.push(Step::Entry(index.parse().ok()?));
            rest = after;
        }
        if !rest.is_empty() {
            return None;
        }
    }
    Some(out)
}

/// Checks that `path`, up to its last part, leads through tables only, as far as they exist.
///
/// # Errors
/// The message that a value on the way is a list or a single value.
fn blocked(table: &Table, path: &[Step]) -> std::result::Result<(), String> {
    let mut here = table;
    let mut walked = String::new();
    for step in &path[..path.len() - 1] {
        let Step::Name(name) = step else {
            return Ok(());
        };
        walked = super::layers::join(&walked, name);
        match here.get(name) {
            Some(Value::Table(next)) => here = next,
            Some(Value::Array(_)) => {
                return Err(format!("{walked} is a list: write {walked}[0].key"));
            }
            Some(_) => return Err(format!("{walked} is a single value and holds no keys")),
            None => return Ok(()),
        }
    }
    Ok(())
}

/// Sets the value at `path`, with new tables where they are missing.
///
/// # Errors
/// The message that a list, its entry or a table on the way does not exist.
fn enter(table: &mut Table, path: &[Step], value: Value) -> std::result::Result<(), String> {
    let Some((Step::Name(first), rest)) = path.split_first() else {
        return Err("is not a key".into());
    };
    let mut slot = table.entry(first.clone()).or_insert_with(|| Value::Table(Table::new()));
    for step in rest {
        slot = match (step, slot) {
            (Step::Name(name), Value::Table(t)) => t.entry(name.clone()).or_insert_with(|| Value::Table(Table::new())),
            (Step::Entry(i), Value::Array(list)) => {
                let count = list.len();
                list.get_mut(*i).ok_or_else(|| format!("there is no entry {i}: the list has {count}"))?
            }
            (Step::Entry(_), _) => return Err("[ ] stands behind a key that holds no list".into()),
            (Step::Name(name), _) => return Err(format!("{name} is not in a table")),
        };
    }
    *slot = value;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_names_and_entries() {
        let name = |s: &str| Step::Name(s.into());
        assert_eq!(steps("a.b"), Some(vec![name("a"), name("b")]));
        assert_eq!(steps("wall[2].friction"), Some(vec![name("wall"), Step::Entry(2), name("friction")]));
        for bad in ["", ".a", "a.", "a b", "a[", "a[x]", "a[0]b", "[0]"] {
            assert_eq!(steps(bad), None, "{bad}");
        }
    }

    #[test]
    fn an_override_says_where_it_was_written() {
        let mut layer = Layer::default();
        apply(&mut layer, "loading.rate = 0.1").expect("valid");
        assert_eq!(layer.table["loading"]["rate"], Value::Float(0.1));
        assert_eq!(layer.origin("loading.rate").place, "override loading.rate = 0.1");
        apply(&mut layer, "contact.law=linear").expect("valid");
        assert_eq!(layer.table["contact"]["law"].as_str(), Some("linear"));
        assert!(apply(&mut layer, "loading.rate.x=1").is_err());
    }
}
