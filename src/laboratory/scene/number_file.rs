//! Tables of numbers from CSV files: columns are found by their names, which say the unit. Lines that begin with `#` are comments.

use super::files::{bounded_columns, read_text};
use crate::columns::mapped;
use crate::error::{Error, Result};
use std::path::Path;

/// What a table of N quantities looks like.
pub struct Format<'a, const N: usize> {
    /// Columns that a file may have: name, number of the quantity, and what takes it into the unit wanted.
    pub columns: &'a [(&'a str, usize, f64)],
    /// So many quantities, the first ones, must be there.
    pub needed: usize,
    /// Quantities from this number on must be positive; N: none must.
    pub positive: usize,
    /// Name of a column of texts that must be there; empty: there is none.
    pub label: &'a str,
    /// What a row is, in the plural.
    pub rows: &'a str,
    /// Which columns there must be and may be, in words.
    pub words: &'a str,
    /// Most rows.
    pub most: usize,
}

/// A table.
pub struct Table<const N: usize> {
    /// Whether the file has a column of each quantity.
    pub has: [bool; N],
    /// The rows.
    pub rows: Vec<Row<N>>,
}

/// A row of a table.
pub struct Row<const N: usize> {
    /// Line of the file.
    pub line: u64,
    /// Its text, empty where there is none.
    pub label: String,
    /// Its numbers, finite; 0 where the file has no column of them.
    pub numbers: [f64; N],
}

impl<const N: usize> Format<'_, N> {
    /// The table of the file `path`.
    ///
    /// # Errors
    /// A file that cannot be read; unknown, missing and repeated columns; what is no finite number; no rows, and too many.
    pub fn read(&self, path: &Path) -> Result<Table<N>> {
        self.of_text(path, &mapped(path, &read_text(path)?)?)
    }

    /// The table of the text of the file `path`.
    ///
    /// # Errors
    /// Those of [`Format::read`], but for a file that cannot be read.
    pub fn of_text(&self, path: &Path, text: &str) -> Result<Table<N>> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let wrong = |key: &str, message: String| Error::input(path.display(), key, None, message);
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
        let broken = |e: csv::Error| wrong("", e.to_string());
        let header = reader.headers().map_err(broken)?.clone();
        bounded_columns(path, header.len())?;
        let (mut places, mut label): ([Option<(usize, f64)>; N], Option<usize>) = ([None; N], None);
        for (column, name) in header.iter().enumerate() {
            let taken = if !self.label.is_empty() && name == self.label {
                label.replace(column).is_some()
            } else {
                let Some((_, what, times)) = self.columns.iter().find(|c| c.0 == name) else {
                    return Err(wrong(name, format!("unknown column; there must be {}", self.words)));
                };
                places[*what].replace((column, *times)).is_some()
            };
            if taken {
                return Err(wrong(name, "this quantity has two columns".into()));
            }
        }
        let first = |what: usize| self.columns.iter().find(|c| c.1 == what).map_or("", |c| c.0);
        let missing = if label.is_none() { self.label } else { "" };
        let missing = (0..self.needed).find(|&k| places[k].is_none()).map_or(missing, first);
        if !missing.is_empty() {
            return Err(wrong("", format!("has no column {missing}; there must be {}", self.words)));
        }
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(broken)?;
            if rows.len() == self.most {
                return Err(wrong("", format!("must hold at most {} {}", self.most, self.rows)));
            }
            let line = record.position().map_or(0, csv::Position::line);
            let cell = |column: usize| record.get(column).unwrap_or("");
            let mut numbers = [0.0; N];
            for (what, (number, place)) in numbers.iter_mut().zip(places).enumerate() {
                let Some((column, times)) = place else { continue };
                let positive = what >= self.positive;
                let value = cell(column).parse::<f64>().ok().filter(|x| x.is_finite() && (!positive || *x > 0.0));
                let Some(value) = value else {
                    let allowed = if positive { "must be a number > 0" } else { "must be a finite number" };
                    return Err(at(path, line, &header[column], cell(column), allowed));
                };
                *number = value * times;
            }
            rows.push(Row { line, label: label.map_or(String::new(), |column| cell(column).into()), numbers });
        }
        if rows.is_empty() {
            return Err(wrong("", format!("holds no {} below its header", self.rows)));
        }
        Ok(Table { has: places.map(|place| place.is_some()), rows })
    }
}

/// The error of a value at a line of a file.
pub fn at(path: &Path, line: u64, key: &str, value: &str, message: &str) -> Error {
    Error::input(format!("{} line {line}", path.display()), key, Some(value.into()), message)
}
