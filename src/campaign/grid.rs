//! Tables of parameters: full factorials of `key=a,b,c` and files with a column for each key.

use laboratory::error::{Error, Result};
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Largest number of points of one table.
const MOST: usize = 100_000;
/// Most keys of a table, and the length of the longest one, bytes.
const MOST_KEYS: usize = 100;
const LONGEST_KEY: usize = 200;
/// Longest name of a point, which is a folder and part of a scene's name.
const LONGEST: usize = 60;

/// One row of a table of parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Keys with their values, as written.
    pub values: Vec<(String, String)>,
    /// Readable and different from every other point's: `m-2_rate-0.01`.
    pub name: String,
}

impl Point {
    /// The text `key=value` for each key.
    pub fn sets(&self) -> Vec<String> {
        self.values.iter().map(|(key, value)| format!("{key}={value}")).collect()
    }
}

/// All combinations of the rows of `tables` (each table is one factor) and the values of `grids`
/// (each grid is one factor). The last factor varies fastest.
///
/// # Errors
/// A grid without key or values, a key that stands in two of them, or too many points.
pub fn points(grids: &[String], tables: Vec<Vec<Vec<(String, String)>>>) -> Result<Vec<Point>> {
    let mut factors = tables;
    for grid in grids {
        factors.push(factor(grid)?);
    }
    let mut keys: Vec<&str> = Vec::new();
    for factor in &factors {
        for (key, _) in factor.first().into_iter().flatten() {
            if keys.contains(&key.as_str()) {
                return Err(Error::input(
                    format!("grid {key}"),
                    "",
                    None,
                    "is varied twice: name each key in one grid or table only",
                ));
            }
            keys.push(key);
        }
    }
    let mut rows: Vec<Vec<(String, String)>> = vec![Vec::new()];
    for factor in &factors {
        if rows.len().saturating_mul(factor.len()) > MOST {
            return Err(Error::input("grid", "", None, format!("gives more than {MOST} runs")));
        }
        rows = rows.iter().flat_map(|row| factor.iter().map(move |more| [row.as_slice(), more].concat())).collect();
    }
    Ok(named(rows))
}

/// A grid `key=a,b,c` as one row for each value.
fn factor(text: &str) -> Result<Vec<Vec<(String, String)>>> {
    let fail = |message: &str| Error::input(format!("grid {text}"), "", None, message);
    let (key, list) = text.split_once('=').ok_or_else(|| fail("must be KEY=VALUE,VALUE,…"))?;
    let key = key.trim();
    if key.is_empty() {
        return Err(fail("must be KEY=VALUE,VALUE,…"));
    }
    let values = split(list);
    if values.iter().any(|v| v.is_empty()) {
        return Err(fail("has an empty value"));
    }
    let mut seen = HashSet::with_capacity(values.len());
    if let Some(value) = values.iter().find(|value| !seen.insert(value.as_str())) {
        return Err(fail(&format!("has the value {value} twice")));
    }
    Ok(values.into_iter().map(|value| vec![(key.to_string(), value)]).collect())
}

/// Splits a list at the commas outside brackets and quotes.
fn split(list: &str) -> Vec<String> {
    let (mut parts, mut depth, mut quoted) = (vec![String::new()], 0_i32, false);
    for c in list.chars() {
        match c {
            '"' => quoted = !quoted,
            '[' | '{' if !quoted => depth += 1,
            ']' | '}' if !quoted => depth -= 1,
            ',' if !quoted && depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    parts.iter().map(|part| part.trim().to_string()).collect()
}

/// The rows of a CSV file whose header holds keys; an empty cell leaves the scene's own value.
///
/// # Errors
/// A file that cannot be read, has no rows, or a row of another length than the header.
pub fn table(path: &Path) -> Result<Vec<Vec<(String, String)>>> {
    let text = laboratory::scene::read_text(path)?;
    let text = text.trim_start_matches('\u{feff}');
    let wrong = |line: String, message: String| Error::input(format!("{}{line}", path.display()), "", None, message);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| wrong(String::new(), e.to_string()))?;
    laboratory::scene::bounded_columns(path, header.len())?;
    let keys: Vec<String> = header.iter().map(str::to_string).collect();
    if keys.iter().any(String::is_empty) {
        return Err(wrong(String::new(), "the header must hold a key in each column, as in loading.rate,seed.strength".into()));
    }
    if keys.len() > MOST_KEYS || keys.iter().any(|key| key.len() > LONGEST_KEY) {
        return Err(wrong(String::new(), format!("the header must hold at most {MOST_KEYS} keys, of {LONGEST_KEY} bytes at most")));
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| wrong(String::new(), e.to_string()))?;
        if rows.len() == MOST {
            return Err(wrong(String::new(), format!("must hold at most {MOST} rows")));
        }
        let line = record.position().map_or(0, csv::Position::line);
        if record.len() != keys.len() {
            let message = format!("has {} values; the header has {} keys", record.len(), keys.len());
            return Err(wrong(format!(" line {line}"), message));
        }
        let row: Vec<(String, String)> = keys.iter().cloned().zip(record.iter().map(str::to_string)).collect();
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(wrong(String::new(), "holds no rows of values".into()));
    }
    Ok(rows)
}

/// Names the rows: each key, shortened to as many of its last words as tell it from the other keys
/// of the row, with its value. Equal names get a number.
fn named(rows: Vec<Vec<(String, String)>>) -> Vec<Point> {
    let mut taken: HashMap<String, usize> = HashMap::new();
    let mut out = Vec::new();
    for values in rows {
        // an empty cell leaves the scene's value
        let values: Vec<(String, String)> = values.into_iter().filter(|(_, v)| !v.is_empty()).collect();
        let keys: Vec<&str> = values.iter().map(|(k, _)| k.as_str()).collect();
        let parts = values.iter().map(|(key, value)| format!("{}-{}", short(key, &keys), plain(value)));
        let mut name: String = parts.collect::<Vec<_>>().join("_").chars().take(LONGEST).collect();
        if name.is_empty() {
            name = "base".into();
        }
        let times = taken.entry(name.clone()).or_default();
        *times += 1;
        if *times > 1 {
            name += &format!("+{times}");
        }
        out.push(Point { values, name });
    }
    out
}

fn short(key: &str, keys: &[&str]) -> String {
    let words: Vec<&str> = key.split('.').collect();
    let last = |k: &str, n: usize| {
        let w: Vec<&str> = k.split('.').collect();
        w[w.len().saturating_sub(n)..].join(".")
    };
    let count = (1..=words.len()).find(|&n| keys.iter().filter(|k| last(k, n) == last(key, n)).count() == 1);
    plain(&last(key, count.unwrap_or(words.len())))
}

/// Text for the names of folders and scenes: the last part of a path, without quotes, and with
/// hyphens for characters that do not fit.
fn plain(text: &str) -> String {
    let text = text.rsplit('/').next().unwrap_or(text).trim_matches('"');
    let text: String = text.chars().map(|c| if c.is_alphanumeric() || "-_.+".contains(c) { c } else { '-' }).collect();
    text.trim_matches('-').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(grids: &[&str]) -> Vec<String> {
        let grids: Vec<String> = grids.iter().map(|g| g.to_string()).collect();
        points(&grids, Vec::new()).expect("points").into_iter().map(|p| p.name).collect()
    }

    #[test]
    fn a_grid_is_a_full_factorial_with_the_last_key_fastest() {
        let all = names(&["material.strength.m=2,3", "loading.rate=0.01,0.005,1e-3"]);
        assert_eq!(all[..2], ["m-2_rate-0.01", "m-2_rate-0.005"]);
        assert_eq!(all.len(), 6);
        assert_eq!(all[5], "m-3_rate-1e-3");
        assert_eq!(names(&[]), ["base"]);
    }

    #[test]
    fn keys_are_named_by_what_tells_them_apart() {
        assert_eq!(names(&["a.x.m=1", "a.y.m=2"]), ["x.m-1_y.m-2"]);
        assert_eq!(names(&["loading.stages_kPa=[100, 200],[5]"]), ["stages_kPa-100--200", "stages_kPa-5"]);
        assert_eq!(names(&["material=a/coke.toml,b/coke.toml"]), ["material-coke.toml", "material-coke.toml+2"]);
        assert_eq!(names(&["name=\"a,b\",c"]), ["name-a-b", "name-c"]);
    }

    #[test]
    fn grids_that_are_none_are_refused() {
        for (grid, says) in
            [("m", "KEY=VALUE"), ("=1", "KEY=VALUE"), ("m=", "empty value"), ("m=1,,2", "empty"), ("m=1,1", "twice")]
        {
            let error = points(&[grid.to_string()], Vec::new()).expect_err(grid).to_string();
            assert!(error.contains(says) && error.contains("grid"), "{error}");
        }
        let twice = points(&["a.b=1".into(), "a.b=2".into()], Vec::new());
        assert!(twice.expect_err("twice").to_string().contains("twice"));
    }

    #[test]
    fn a_table_has_a_key_in_each_column() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("points.csv");
        let read = |text: &str| {
            std::fs::write(&path, text).expect("written");
            table(&path)
        };
        let rows = read("# note\nloading.rate, seed.strength\n0.01,1\n,2\n").expect("rows");
        let all = points(&["m=1,2".into()], vec![rows]).expect("points");
        assert_eq!(all.len(), 4);
        assert_eq!(all[0].sets(), ["loading.rate=0.01", "seed.strength=1", "m=1"]);
        assert_eq!(all[3].name, "strength-2_m-2");
        assert!(read("a,b\n1\n").expect_err("short").to_string().contains("line 2: has 1 values"));
        assert!(read("a,b\n").expect_err("none").to_string().contains("holds no rows"));
        assert!(read("a,\n1,2\n").expect_err("key").to_string().contains("header"));
    }
}
