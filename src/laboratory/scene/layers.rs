//! Layers of a scene (a base, a file, an override), merged into one table that remembers where each value was written.

use super::keys::RIVALS;
use super::sources::{merge_sources, outdate};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Where a value was written: a file or an override, and its key there.
#[derive(Clone, Debug, PartialEq)]
pub struct Origin {
    pub place: String,
    pub key: String,
}

/// A table with the origin of each of its values.
#[derive(Clone, Debug, Default)]
pub struct Layer {
    pub table: Table,
    origins: BTreeMap<String, Origin>,
}

impl Layer {
    /// Everything in `table`, written at the key `at` of `place`.
    pub fn of(table: Table, place: &str, at: &str) -> Layer {
        let mut origins = BTreeMap::new();
        let mut note = |key: &str| {
            let origin = Origin { place: place.into(), key: join(at, key) };
            origins.insert(key.to_string(), origin);
        };
        note("");
        each_key(&table, "", &mut note);
        Layer { table, origins }
    }

    /// Where `key` was written, or would have to be: the nearest table above it that was.
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

    /// Say that everything at and below `key` was written at `origin`.
    pub fn note(&mut self, key: &str, origin: Origin) {
        self.forget(key);
        self.origins.insert(key.into(), origin);
    }

    fn forget(&mut self, key: &str) {
        forget(&mut self.origins, key);
    }

    /// Take out what is at `key`.
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

    /// Put `layer` at `key`, one or two names deep.
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

    /// Lay `upper` over this one. `by` names it in the sources of values it replaces.
    pub fn merge(&mut self, upper: Layer, by: &str) {
        let mut lower = std::mem::take(self);
        merge_tables(
            &mut lower.table,
            &upper.table,
            "",
            &mut |key| {
                forget(&mut lower.origins, key);
                for (k, origin) in upper.origins.iter().filter(|(k, _)| below_or_at(k, key)) {
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

/// Every key of a table and of the tables in it, by its path.
fn each_key(table: &Table, at: &str, visit: &mut impl FnMut(&str)) {
    for (name, value) in table {
        let key = join(at, name);
        visit(&key);
        if let Value::Table(inner) = value {
            each_key(inner, &key, visit);
        }
    }
}

fn below_or_at(key: &str, table: &str) -> bool {
    key.strip_prefix(table).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

fn forget(origins: &mut BTreeMap<String, Origin>, key: &str) {
    origins.retain(|k, _| !below_or_at(k, key));
}

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

/// `a.b`, or the one that is not empty.
pub fn join(table: &str, name: &str) -> String {
    match (table, name) {
        ("", name) => name.into(),
        (table, "") => table.into(),
        (table, name) => format!("{table}.{name}"),
    }
}

/// A value as an error line shows it: short, on one line.
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
