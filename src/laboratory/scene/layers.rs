//! Merges the layers of a scene (a base file, the file itself, overrides) into one table, and remembers for each value where it was
//! written.

use super::keys::RIVALS;
use super::sources::{merge_sources, outdate};
use engine::rigid::Block;
use std::collections::BTreeMap;
use std::ops::Bound;
use std::sync::{Arc, Mutex};
use toml::{Table, Value};

/// Where a value was written.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    /// The file, or `override ` and the text of the override.
    pub place: String,
    /// Dotted key of the value in that place; empty: the whole file.
    pub key: String,
}

/// A table with the origin of each of its values.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    /// The values, in the units of the files.
    pub table: Table,
    /// The origins by the dotted keys of `table`; the key `""` is that of the whole table.
    origins: BTreeMap<String, Origin>,
    /// What has been packed from it; copies of the layer share it.
    pub packed: Packed,
}

/// Sets of bodies that have been packed, each with what it was made from: a command asks for the bodies of a scene several times.
pub type Packed = Arc<Mutex<Vec<(PackedFrom, Vec<Block>)>>>;

/// What the bodies of a set are made from.
#[derive(Clone, Debug, PartialEq)]
pub struct PackedFrom {
    /// Its keys.
    pub table: Table,
    /// Number of the set, and seed.
    pub random: (usize, u64),
    /// Index of its material, and density, kg/m³.
    pub material: (u8, f64),
    /// Whether in plane strain.
    pub flat: bool,
}

impl Layer {
    /// A layer with the values of `table`, all of which were written in the file `place`, below the key `at` (`""`: at the top
    /// level).
    pub fn of(table: Table, place: &str, at: &str) -> Layer {
        let mut origins = BTreeMap::new();
        let mut note = |key: &str| {
            let origin = Origin { place: place.into(), key: join(at, key) };
            origins.insert(key.to_string(), origin);
        };
        note("");
        each_key(&table, "", &mut note);
        Layer { table, origins, packed: Packed::default() }
    }

    /// Where the value at `key` was written. Where no origin of the key is known, as for a missing value, the origin is that of the
    /// nearest table above, with the rest of the key appended.
    pub fn origin(&self, key: &str) -> Origin {
        let mut known = key;
        loop {
            if let Some(origin) = self.origins.get(known) {
                let rest = key[known.len()..].trim_start_matches('.');
                let key = if rest.starts_with('[') { format!("{}{rest}", origin.key) } else { join(&origin.key, rest) };
                return Origin { place: origin.place.clone(), key };
            }
            match known.rfind(['.', '[']) {
                Some(end) => known = &known[..end],
                None if !known.is_empty() => known = "",
                None => {
                    return Origin { place: "scene".into(), key: key.into() };
                }
            }
        }
    }

    /// Sets the origin of the value at `key`, and of everything below it, to `origin`.
    pub fn note(&mut self, key: &str, origin: Origin) {
        self.forget(key);
        self.origins.insert(key.into(), origin);
    }

    fn forget(&mut self, key: &str) {
        forget(&mut self.origins, key);
    }

    /// Removes the value at the dotted `key`, and the origins of the value and of everything below it.
    pub fn remove(&mut self, key: &str) {
        let mut table = Some(&mut self.table);
        let names: Vec<&str> = key.split('.').collect();
        for (i, name) in names.iter().enumerate() {
            let Some(here) = table else { break };
            if i + 1 == names.len() {
                here.remove(*name);
                break;
            }
            table = here.get_mut(*name).and_then(Value::as_table_mut);
        }
        self.forget(key);
    }

    /// Replaces the value at `key` by the table of `layer`, with its origins. `key` is one name or two (`materials.steel`).
    pub fn mount(&mut self, key: &str, layer: Layer) {
        self.remove(key);
        for (inner, origin) in layer.origins {
            self.origins.insert(join(key, &inner), origin);
        }
        match key.split_once('.') {
            None => {
                self.table.insert(key.into(), Value::Table(layer.table));
            }
            Some((outer, name)) => {
                let slot = self.table.entry(outer).or_insert_with(|| Value::Table(Table::new()));
                if let Value::Table(table) = slot {
                    table.insert(name.into(), Value::Table(layer.table));
                }
            }
        }
    }

    /// Lays `upper` over this layer: tables are merged, every other value of `upper` replaces the one here and removes its rivals
    /// ([`RIVALS`]). The source of a changed value becomes "replaced " and `by` (`in coke.toml`), unless `upper` gives the value a
    /// source.
    pub fn merge(&mut self, upper: Layer, by: &str) {
        let mut lower = std::mem::take(self);
        merge_tables(
            &mut lower.table,
            &upper.table,
            "",
            &mut |key| {
                forget(&mut lower.origins, key);
                for (k, origin) in within(&upper.origins, key) {
                    lower.origins.insert(k.clone(), origin.clone());
                }
                lower.origins.insert(key.into(), upper.origin(key));
            },
            by,
        );
        if let Some(top) = upper.origins.get("") {
            lower.origins.insert(String::new(), top.clone());
        }
        *self = lower;
    }
}

/// Calls `visit` with the dotted key of every value of a table and of the tables in it. Entries of lists are not visited.
fn each_key(table: &Table, at: &str, visit: &mut impl FnMut(&str)) {
    for (name, value) in table {
        let key = join(at, name);
        visit(&key);
        if let Value::Table(inner) = value {
            each_key(inner, &key, visit);
        }
    }
}

/// Whether the dotted `key` is that of `table` or of something in it.
fn below_or_at(key: &str, table: &str) -> bool {
    key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

/// The origins of the value at `key` and of everything below it. Keys that begin with `key` follow each other in the map, so that
/// the others are not looked at.
fn within<'a>(origins: &'a BTreeMap<String, Origin>, key: &'a str) -> impl Iterator<Item = (&'a String, &'a Origin)> {
    let from = origins.range::<str, _>((Bound::Included(key), Bound::Unbounded));
    from.take_while(move |(k, _)| k.starts_with(key)).filter(move |(k, _)| below_or_at(k, key))
}

/// Removes the origins of the value at `key` and of everything below it.
fn forget(origins: &mut BTreeMap<String, Origin>, key: &str) {
    let gone: Vec<String> = within(origins, key).map(|(k, _)| k.clone()).collect();
    for key in gone {
        origins.remove(&key);
    }
}

/// Lays `upper`, the table at the dotted key `at`, over `lower` ([`Layer::merge`]), and calls `written` with the key of every value
/// that was replaced or added.
fn merge_tables(lower: &mut Table, upper: &Table, at: &str, written: &mut impl FnMut(&str), by: &str) {
    for (name, value) in upper {
        let key = join(at, name);
        for (a, b) in RIVALS {
            for (mine, other) in [(a, b), (b, a)] {
                if name == mine && !upper.contains_key(*other) {
                    lower.remove(*other);
                    if let Some(Value::Table(by_key)) = lower.get_mut("source") {
                        by_key.remove(*other);
                    }
                }
            }
        }
        match (lower.get_mut(name), value) {
            (Some(Value::Table(below)), Value::Table(above)) if name != "source" => {
                merge_tables(below, above, &key, written, by);
            }
            (old, _) => {
                let changed = old.is_some_and(|v| v != value);
                written(&key);
                if name == "source" {
                    merge_sources(lower, value);
                } else {
                    let sourced = upper.get("source").and_then(|s| s.get(name)).is_some();
                    if changed && !sourced {
                        outdate(lower, name, by);
                    }
                    lower.insert(name.clone(), value.clone());
                }
            }
        }
    }
}

/// The dotted key `table.name`; where one of the two is empty, the other.
pub fn join(table: &str, name: &str) -> String {
    match (table, name) {
        ("", name) => name.into(),
        (table, "") => table.into(),
        (table, name) => format!("{table}.{name}"),
    }
}

/// A value as error messages show it: on one line, at most 60 characters; `{…}` for a table.
pub fn shown(value: &Value) -> String {
    let text = match value {
        Value::Float(x) if x.is_finite() => format!("{x:?}").trim_end_matches(".0").to_string(),
        Value::Table(_) => "{…}".into(),
        Value::String(s) => format!("\"{}\"", s.escape_debug()),
        other => other.to_string(),
    };
    match text.char_indices().nth(60) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::scene::sources::spread_sources;

    fn layer(place: &str, text: &str) -> Layer {
        Layer::of(toml::from_str(text).expect("TOML"), place, "")
    }

    #[test]
    fn the_upper_layer_wins_and_is_remembered() {
        let mut below = layer("below", "a = 1\n[t]\nx = 1\ny = 2");
        below.merge(layer("above", "[t]\ny = 3"), "above");
        assert_eq!(below.table["t"]["x"], Value::Integer(1));
        assert_eq!(below.table["t"]["y"], Value::Integer(3));
        assert_eq!(below.origin("t.x").place, "below");
        assert_eq!(below.origin("t.y").place, "above");
        assert_eq!(below.origin("t.z").key, "t.z");
    }

    #[test]
    fn rivals_replace_each_other_between_layers_only() {
        let mut below = layer("below", "G_GPa = 1");
        below.merge(layer("above", "E_GPa = 2"), "above");
        assert!(!below.table.contains_key("G_GPa"));
        below.merge(layer("both", "E_GPa = 2\nG_GPa = 1"), "both");
        assert_eq!(below.table.len(), 2);
    }

    #[test]
    fn a_replaced_value_loses_its_source() {
        let mut table: Table = toml::from_str("source = \"a book\"\nm = 1\nn = 2").expect("TOML");
        spread_sources(&mut table, None);
        let mut below = Layer::of(table, "below", "");
        below.merge(layer("above", "m = 3"), "in above");
        assert_eq!(below.table["source"]["m"].as_str(), Some("replaced in above"));
        assert_eq!(below.table["source"]["n"].as_str(), Some("a book"));
    }
}
