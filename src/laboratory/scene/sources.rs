//! The `source` of values, kept true while layers are merged.

use toml::{Table, Value};

/// Sources by key are laid over each other; a text replaces all.
pub fn merge_sources(lower: &mut Table, above: &Value) {
    match (lower.get_mut("source"), above) {
        (Some(Value::Table(old)), Value::Table(new)) => old.extend(new.clone()),
        _ => {
            lower.insert("source".into(), above.clone());
        }
    }
}

/// A replaced value no longer comes from where its file says.
pub fn outdate(table: &mut Table, name: &str, by: &str) {
    if let Some(Value::Table(by_key)) = table.get_mut("source")
        && by_key.contains_key(name)
    {
        by_key.insert(name.into(), Value::String(format!("replaced {by}")));
    }
}

/// Give each value written in a table the text `source` of the table, or of the table above it.
pub fn spread_sources(table: &mut Table, above: Option<&str>) {
    const UNSOURCED: [&str; 8] = ["source", "name", "description", "kind", "base", "material", "materials", "grains_csv"];
    let (text, mut by_key) = match table.get("source") {
        None => (above.map(str::to_string), Table::new()),
        Some(Value::String(text)) => (Some(text.clone()), Table::new()),
        Some(Value::Table(by_key)) => (above.map(str::to_string), by_key.clone()),
        Some(_) => return,
    };
    for (name, value) in table.iter_mut().filter(|(k, _)| *k != "source") {
        let list = value.as_array().is_some_and(|a| a.iter().any(Value::is_table));
        match (value, &text) {
            (Value::Table(inner), _) if name == "materials" => {
                for (_, material) in inner.iter_mut() {
                    if let Value::Table(material) = material {
                        spread_sources(material, None);
                    }
                }
            }
            (Value::Table(inner), _) => spread_sources(inner, text.as_deref()),
            (_, Some(text)) if !list && !UNSOURCED.contains(&name.as_str()) => {
                let text = || Value::String(text.clone());
                by_key.entry(name.clone()).or_insert_with(text);
            }
            _ => {}
        }
    }
    table.remove("source");
    if !by_key.is_empty() {
        table.insert("source".into(), Value::Table(by_key));
    }
}
