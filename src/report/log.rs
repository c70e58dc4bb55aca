//! Tables of a run for its page: which there are, and logs of breakages in full.

use super::links::link;
use laboratory::error::{Error, Result};
use laboratory::record::dictionary::{Column, SHEETS};
use plot::Table;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// The tables with a row for each breakage.
const LOGS: [(&str, &str); 2] = [("breakage.csv", "Breakages of grains"), ("block_breakage.csv", "Breakages of bodies")];

/// The column `name` of the table `file` of a run of kind `kind`, as the dictionary has it.
fn column(file: &str, kind: &str, name: &str) -> Option<&'static Column> {
    SHEETS.iter().filter(|sheet| sheet.describes(file, kind)).flat_map(|sheet| sheet.columns).find(|column| column.name == name)
}

/// The logs of breakages of the run in `dir`: title, columns with unit and meaning, and rows, numbers as they stand in the file.
///
/// # Errors
/// A table that cannot be read.
pub fn logs(dir: &Path, kind: &str) -> Result<Vec<Value>> {
    let mut logs = Vec::new();
    for (file, title) in LOGS {
        let Some(table) = Table::read_if_there(&dir.join(file))? else { continue };
        let columns: Vec<Value> = table
            .headers()
            .iter()
            .map(|name| match column(file, kind, name) {
                Some(known) => json!({ "name": name, "unit": known.unit, "what": known.what }),
                None => json!({ "name": name, "unit": "", "what": "" }),
            })
            .collect();
        let cells = table.headers().iter().map(|name| cells(&table, name)).collect::<Result<Vec<Vec<Value>>>>()?;
        let rows: Vec<Vec<Value>> = (0..table.len()).map(|i| cells.iter().map(|column| column[i].clone()).collect()).collect();
        logs.push(json!({ "file": file, "title": title, "columns": columns, "rows": rows }));
    }
    Ok(logs)
}

/// Columns of text whose cells may look like numbers.
const TEXTS: [&str; 1] = ["lineage"];

/// The cells of a column: numbers where every cell is one or empty, else texts.
fn cells(table: &Table, column: &str) -> Result<Vec<Value>> {
    let texts = table.texts(column)?;
    let numbers: Option<Vec<Value>> =
        texts.iter().map(|text| if text.is_empty() { Some(Value::Null) } else { Some(json!(text.parse::<f64>().ok()?)) }).collect();
    let texts = || texts.iter().map(|text| json!(text)).collect();
    Ok(numbers.filter(|_| !TEXTS.contains(&column)).unwrap_or_else(texts))
}

/// The CSV files in the folder of a run and in its figures: name, and address from `page`.
///
/// # Errors
/// A folder that cannot be read.
pub fn tables(dir: &Path, page: &Path) -> Result<Vec<Value>> {
    let mut found: Vec<PathBuf> = csvs(dir)?;
    let figures = dir.join(laboratory::run::FIGURES);
    if figures.is_dir() {
        found.extend(csvs(&figures)?);
    }
    let name = |path: &Path| path.strip_prefix(dir).unwrap_or(path).display().to_string();
    Ok(found.iter().map(|path| json!({ "file": name(path), "link": link(page, path) })).collect())
}

fn csvs(dir: &Path) -> Result<Vec<PathBuf>> {
    let entries = dir.read_dir().map_err(Error::read(dir))?.flatten();
    let mut found: Vec<PathBuf> =
        entries.map(|entry| entry.path()).filter(|path| path.is_file() && path.extension().is_some_and(|e| e == "csv")).collect();
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_has_the_numbers_of_its_file_and_the_words_of_the_dictionary() {
        let dir = tempfile::tempdir().expect("folder");
        let text = "event,sigma_v_kPa,lineage,force_N,new\n1,4.99999998,571a6ddaab90b8c8,2.398565e-3,\n2,12,1234567890123456,,x\n";
        std::fs::write(dir.path().join("breakage.csv"), text).expect("written");
        let log = &logs(dir.path(), "oedometer").expect("read")[0];
        assert_eq!(
            log["rows"],
            json!([[1.0, 4.99999998, "571a6ddaab90b8c8", 2.398565e-3, ""], [2.0, 12.0, "1234567890123456", null, "x"]])
        );
        assert_eq!(log["columns"][1]["unit"], "kPa");
        assert_eq!(log["columns"][4], json!({ "name": "new", "unit": "", "what": "" }));
        assert!(logs(&dir.path().join("absent"), "oedometer").expect("none").is_empty());
    }
}
