//! Checks that every key of a scene is known, of the right type and in its range, and fills in defaults. Whether values agree with
//! each other is checked later, in [`super::view`].

use super::keys::{KEYS, LIST_TABLES, find, is_optional, is_table, keys_in, names_in};
use super::layers::{Layer, join, shown};
use super::schema::{Default, Of};
use super::suggest::nearest;
use crate::error::{Error, Result};
use toml::{Table, Value};

/// Mistakes that are told; of the others it is only said that there are some.
pub const TOLD: usize = 50;
/// Most entries of each list of tables.
const ENTRIES: [(&str, usize); 8] = [
    ("block_set", 20),
    ("joint", 3000),
    ("grain", 150_000),
    ("wall", 1000),
    ("body", 1000),
    ("block", 1000),
    ("block.part", engine::shape::MOST_PARTS),
    ("calibrate", 100),
];

/// Checks the merged table of a scene and fills in its defaults.
///
/// # Errors
/// All mistakes together, each with file, key, value and what is allowed.
pub fn validate(layer: &mut Layer) -> Result<()> {
    let of = Of::kind(layer.table.get("kind").and_then(Value::as_str));
    let mut table = std::mem::take(&mut layer.table);
    let mut walk = Walk { layer, of, errors: Vec::new(), untold: false };
    walk.table(&mut table, "", "");
    let errors = walk.into_errors();
    layer.table = table;
    Error::all(errors)
}

/// Checks the table `material` of a layer, and nothing else of the layer, and fills in its defaults.
///
/// # Errors
/// All mistakes together, each with file, key, value and what is allowed.
pub fn validate_material(layer: &mut Layer) -> Result<()> {
    let mut table = std::mem::take(&mut layer.table);
    // a material has the same keys in every kind of scene, so any kind will do
    let mut walk = Walk { layer, of: Of::Assembly, errors: Vec::new(), untold: false };
    if let Some(Value::Table(material)) = table.get_mut("material") {
        walk.table(material, "material", "material");
    }
    let errors = walk.into_errors();
    layer.table = table;
    Error::all(errors)
}

/// A walk through all tables of a scene of the kind `of`, which collects errors.
struct Walk<'a> {
    layer: &'a Layer,
    of: Of,
    errors: Vec<Error>,
    /// Whether there are mistakes that are not told.
    untold: bool,
}

impl Walk<'_> {
    /// The errors, with one for those that are not told.
    fn into_errors(mut self) -> Vec<Error> {
        if self.untold {
            let place = self.layer.origin("").place;
            self.errors.push(Error::input(place, "", None, "and more mistakes"));
        }
        self.errors
    }

    /// Whether as many mistakes are told as may be; notes that there are more.
    fn is_full(&mut self) -> bool {
        self.untold = self.untold || self.errors.len() >= TOLD;
        self.untold
    }

    fn refuse(&mut self, key: &str, value: Option<&Value>, message: String) {
        if self.is_full() {
            return;
        }
        let origin = self.layer.origin(key);
        self.errors.push(Error::input(origin.place, origin.key, value.map(shown), message));
    }

    /// Checks a table and fills in its defaults, with sub-tables that are missing and not optional. `at`: its dotted key in the
    /// scene (`wall[0]`, `materials.steel.grain`); `path`: the same in the key table, without list indices and names of materials
    /// (`wall`, `material.grain`).
    fn table(&mut self, table: &mut Table, at: &str, path: &str) {
        let names: Vec<String> = table.keys().cloned().collect();
        for name in names {
            let Some(value) = table.remove(&name) else {
                continue;
            };
            if let Some(value) = self.entry(table, at, path, &name, value) {
                table.insert(name, value);
            }
        }
        // where the kind of scene is unknown, only `kind` itself is reported as missing
        self.fill(table, at, path);
        // what tables of lists hold are lists
        if LIST_TABLES.contains(&path) {
            return;
        }
        for name in names_in(path, self.of) {
            let inner = join(path, name);
            let wanted = is_table(&inner) && !is_optional(&inner) && !LIST_TABLES.contains(&inner.as_str());
            if wanted && self.of != Of::Every && !table.contains_key(name) {
                let mut new = Table::new();
                self.table(&mut new, &join(at, name), &inner);
                table.insert(name.into(), Value::Table(new));
            }
        }
    }

    /// Checks the value of the key `name` of the table at `at`. Returns the value to keep, in its canonical form; `None` where the
    /// key is unknown or has no meaning in this kind of scene. `table`: the other keys of the table.
    fn entry(&mut self, table: &Table, at: &str, path: &str, name: &str, value: Value) -> Option<Value> {
        let (key, inner) = (join(at, name), join(path, name));
        if name == "source" && !LIST_TABLES.contains(&path) {
            self.source(&value, table, at, path);
            return Some(value);
        }
        if path.is_empty() && name == "materials" && (self.of == Of::Every || !Of::Cylinder.fits(self.of)) {
            return Some(self.materials(value));
        }
        if let Some(schema) = find(&inner) {
            if !schema.of.fits(self.of) {
                self.refuse(&key, Some(&value), self.foreign());
                return None;
            }
            match schema.shape.accept(value.clone()) {
                Ok(value) => return Some(value),
                Err(message) => {
                    let message = format!("{message} ({})", schema.what);
                    self.refuse(&key, Some(&value), message);
                    return Some(value);
                }
            }
        }
        if !is_table(&inner) && self.is_full() {
            return None;
        }
        if !is_table(&inner) {
            let message = self.unknown(at, path, name);
            self.refuse(&key, None, message);
            return None;
        }
        let own = |k: &super::schema::Key| k.path.starts_with(&format!("{inner}.")) && k.of.fits(self.of);
        if !KEYS.iter().any(own) {
            self.refuse(&key, None, self.foreign());
            return None;
        }
        if LIST_TABLES.contains(&inner.as_str()) {
            return Some(self.list(value, &key, &inner));
        }
        match value {
            Value::Table(mut below) => {
                self.table(&mut below, &key, &inner);
                Some(Value::Table(below))
            }
            other => {
                let message = format!("must be a table with {}", list(&names_in(&inner, self.of)));
                self.refuse(&key, Some(&other), message);
                Some(other)
            }
        }
    }

    /// Checks the list of tables at `key`.
    fn list(&mut self, value: Value, key: &str, path: &str) -> Value {
        let Value::Array(mut entries) = value else {
            let message = format!("must be a list of tables, written [[{path}]]");
            self.refuse(key, Some(&value), message);
            return value;
        };
        if let Some((_, most)) = ENTRIES.iter().find(|(name, most)| *name == path && entries.len() > *most) {
            let message = format!("must have at most {most} entries; there are {}", entries.len());
            self.refuse(key, None, message);
            return Value::Array(Vec::new());
        }
        for (i, entry) in entries.iter_mut().enumerate() {
            if self.is_full() {
                break;
            }
            let at = format!("{key}[{i}]");
            match entry {
                Value::Table(table) => self.table(table, &at, path),
                other => {
                    let other = other.clone();
                    let message = format!("must be a table with {}", list(&names_in(path, self.of)));
                    self.refuse(&at, Some(&other), message);
                }
            }
        }
        Value::Array(entries)
    }

    /// Checks the table `materials`, which holds materials by name.
    fn materials(&mut self, value: Value) -> Value {
        let Value::Table(mut named) = value else {
            let message = "must be a table of materials by name, [materials.NAME]".to_string();
            self.refuse("materials", Some(&value), message);
            return value;
        };
        for (name, value) in named.iter_mut() {
            let at = format!("materials.{name}");
            if !name.chars().all(|c| c.is_alphanumeric() || "-_".contains(c)) {
                let message = "a name must be of letters, digits, '-' and '_'".to_string();
                self.refuse(&at, None, message);
                continue;
            }
            match value {
                Value::Table(material) => self.table(material, &at, "material"),
                other => {
                    let other = other.clone();
                    let message = "must be the path of a material file or a table".to_string();
                    self.refuse(&at, Some(&other), message);
                }
            }
        }
        Value::Table(named)
    }

    /// Checks the key `source` of the table at `at`: one text for the whole table, or a table of texts by key (`source.nu = "…"`).
    fn source(&mut self, value: &Value, table: &Table, at: &str, path: &str) {
        let key = join(at, "source");
        match value {
            Value::String(_) => {}
            Value::Table(by_key) => {
                for (name, text) in by_key {
                    let inner = join(&key, name);
                    let known = names_in(path, Of::Every).contains(&name.as_str());
                    if !known && !table.contains_key(name) {
                        let message = self.unknown(&key, path, name);
                        self.refuse(&inner, None, message);
                    } else if !text.is_str() {
                        self.refuse(&inner, Some(text), "must be text in quotes".into());
                    }
                }
            }
            other => {
                let message = "must be text, or a table of texts by key".to_string();
                self.refuse(&key, Some(other), message);
            }
        }
    }

    /// Fills in the defaults of a table, and refuses the scene where required keys are missing. Sub-tables are left as they are.
    fn fill(&mut self, table: &mut Table, at: &str, path: &str) {
        for key in keys_in(path) {
            let (_, name) = key.split();
            let kind_unknown = self.of == Of::Every && key.path != "kind";
            let foreign = !key.of.fits(self.of);
            if table.contains_key(name) || kind_unknown || foreign {
                continue;
            }
            if key.default == Default::Required {
                let message = format!("is missing: {} ({})", key.what, key.shape.text());
                self.refuse(&join(at, name), None, message);
            } else if let Some(value) = key.default_for(self.of)
                && let Ok(value) = key.shape.accept(value)
            {
                table.insert(name.into(), value);
            }
        }
    }

    /// Message for a key of other kinds of scenes.
    fn foreign(&self) -> String {
        format!("has no meaning in {}", self.of.called())
    }

    /// Message for an unknown key: a key here with a similar name, the same name in another table, or all keys that may stand here.
    fn unknown(&self, at: &str, path: &str, name: &str) -> String {
        let here = names_in(path, self.of);
        if let Some(near) = nearest(name, here.iter().copied()) {
            let written = self.layer.origin(&join(at, name)).key;
            let table = written.rsplit_once('.').map_or("", |(table, _)| table);
            return format!("unknown key; did you mean {}?", join(table, near));
        }
        let elsewhere =
            KEYS.iter().filter(|k| k.of.fits(self.of)).filter(|k| k.split().1.eq_ignore_ascii_case(name)).map(|k| k.path).next();
        match elsewhere {
            Some(path) => format!("unknown key here; did you mean {path}?"),
            None => format!("unknown key; there are {}", list(&here)),
        }
    }
}

/// The names with commas between.
fn list(names: &[&str]) -> String {
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is said about a table of so many unknown keys.
    fn told(count: usize) -> Vec<String> {
        let text: String = (0..count).map(|k| format!("k{k} = 1\n")).collect();
        let mut layer = Layer::of(toml::from_str(&format!("kind = \"isotropic\"\n{text}")).expect("TOML"), "a.toml", "");
        let error = validate(&mut layer).expect_err("unknown keys").to_string();
        error.lines().filter(|line| !line.contains("is missing")).map(str::to_string).collect()
    }

    #[test]
    fn of_many_mistakes_the_first_are_told() {
        assert_eq!(told(1).len(), 1, "{:?}", told(1));
        let many = told(5000);
        assert_eq!(many.len(), TOLD + 1);
        assert_eq!(many.last().map(String::as_str), Some("a.toml: and more mistakes"));
    }
}
