//! The resolved scene as text, in the order of the key list.

use super::keys::{KEYS, LIST_TABLES, is_table};
use super::layers::join;
use toml::{Table, Value};

const HEAD: &str = "\
# The scene with every default filled in, and its material and grains written out. Running it repeats the run:
#   comminute run scene.resolved.toml --out NEW_FOLDER
";

pub fn write(scene: &Table) -> String {
    let mut text = HEAD.to_string();
    table(&mut text, scene, "", "");
    if let Some(Value::Table(named)) = scene.get("materials") {
        for (name, material) in named {
            if let Value::Table(material) = material {
                table(&mut text, material, &format!("materials.{name}"), "material");
            }
        }
    }
    text
}

/// A material file with every default filled in.
pub fn write_material(material: &Table) -> String {
    let mut text = String::new();
    table(&mut text, material, "", "material");
    text
}

/// One table: its own keys, its lists of tables, then the tables in it.
fn table(text: &mut String, values: &Table, at: &str, path: &str) {
    let own: Vec<&str> =
        KEYS.iter().filter(|k| k.split().0 == path && values.contains_key(k.split().1)).map(|k| k.split().1).collect();
    let source = values.get("source");
    if !at.is_empty() && (!own.is_empty() || source.is_some()) {
        *text += &format!("\n[{at}]\n");
    }
    for name in own {
        *text += &format!("{name} = {}\n", plain(&values[name]));
    }
    match source {
        Some(Value::Table(by_key)) => {
            for (name, value) in by_key {
                *text += &format!("source.{name} = {}\n", plain(value));
            }
        }
        Some(value) => *text += &format!("source = {}\n", plain(value)),
        None => {}
    }
    for name in tables_in(path) {
        let (at, path) = (join(at, name), join(path, name));
        match values.get(name) {
            Some(Value::Array(list)) if LIST_TABLES.contains(&path.as_str()) => {
                *text += &format!("\n{at} = [\n");
                for entry in list {
                    *text += &format!("  {},\n", plain(entry));
                }
                *text += "]\n";
            }
            Some(Value::Table(inner)) => table(text, inner, &at, &path),
            _ => {}
        }
    }
}

/// Names of the tables in the table `path`, in the order of the key list; lists first, for they are written as values.
fn tables_in(path: &str) -> Vec<&'static str> {
    let mut names: Vec<&str> =
        super::keys::names_in(path, super::schema::Of::Every).into_iter().filter(|name| is_table(&join(path, name))).collect();
    names.sort_by_key(|name| !LIST_TABLES.contains(name));
    names
}

/// A value on one line; numbers so that reading gives the same bits.
fn plain(value: &Value) -> String {
    match value {
        Value::Float(x) => format!("{x:?}"),
        Value::String(s) => quoted(s),
        Value::Array(list) => {
            let list: Vec<String> = list.iter().map(plain).collect();
            format!("[{}]", list.join(", "))
        }
        Value::Table(table) => {
            let pairs: Vec<String> = table.iter().map(|(k, v)| format!("{k} = {}", plain(v))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
        other => other.to_string(),
    }
}

fn quoted(s: &str) -> String {
    let mut out = String::from("\"");
    for c in s.chars() {
        match c {
            '"' => out += "\\\"",
            '\\' => out += "\\\\",
            '\n' => out += "\\n",
            '\t' => out += "\\t",
            c if c.is_control() => out += &format!("\\u{:04X}", u32::from(c)),
            c => out.push(c),
        }
    }
    out + "\""
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_texts_survive() {
        for x in [0.1 + 0.2, 5000.0, 1e-12, 1.8e14, -0.0] {
            let back: Table = toml::from_str(&format!("v = {}", plain(&Value::Float(x)))).unwrap();
            assert_eq!(back["v"].as_float().unwrap().to_bits(), f64::to_bits(x));
        }
        let odd = "a \"b\" \\ \n\t\u{1} ü";
        let back: Table = toml::from_str(&format!("v = {}", quoted(odd))).unwrap();
        assert_eq!(back["v"].as_str(), Some(odd));
    }
}
