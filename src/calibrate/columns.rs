//! Columns of a CSV file by name, with errors that say file, line and column.

use laboratory::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Most values of a file.
const MOST_CELLS: usize = 4_000_000;

pub struct Columns {
    pub path: PathBuf,
    pub headers: Vec<String>,
    /// Number of the line in the file, and cells, of each row.
    pub rows: Vec<(u64, Vec<String>)>,
    /// Numbers of the comments `# name = number` before the header.
    notes: Vec<(String, f64)>,
}

impl Columns {
    /// Reads a file with a header line and `#` comments.
    ///
    /// # Errors
    /// A file that cannot be read, without rows, or with rows of another length than the header.
    pub fn read(path: &Path) -> Result<Columns> {
        let bytes = laboratory::scene::read_bytes(path)?;
        let wrong = |place: String, message: String| Error::input(format!("{}{place}", path.display()), "", None, message);
        let text = String::from_utf8(bytes).map_err(|_| wrong(String::new(), "is not UTF-8 text".into()))?;
        let text = laboratory::columns::mapped(path, text.trim_start_matches('\u{feff}'))?;
        let text = text.as_ref();
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
        let header = reader.headers().map_err(|e| wrong(String::new(), e.to_string()))?;
        laboratory::scene::bounded_columns(path, header.len())?;
        let mut headers: Vec<String> = header.iter().map(str::to_string).collect();
        table::old_names::renew(&mut headers);
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| wrong(String::new(), e.to_string()))?;
            let line = record.position().map_or(0, csv::Position::line);
            if record.len() != headers.len() {
                let message = format!("has {} values; the header has {}", record.len(), headers.len());
                return Err(wrong(format!(" line {line}"), message));
            }
            if (rows.len() + 1) * headers.len() > MOST_CELLS {
                return Err(wrong(String::new(), format!("must hold at most {MOST_CELLS} values")));
            }
            rows.push((line, record.iter().map(str::to_string).collect()));
        }
        if headers.len() == 1 && headers[0].contains([';', '\t']) {
            return Err(wrong(String::new(), "values must be separated by commas".into()));
        }
        if rows.is_empty() {
            return Err(wrong(String::new(), "holds no rows".into()));
        }
        let note = |line: &str| {
            line.strip_prefix('#')?.split_once('=').and_then(|(name, n)| Some((name.trim().into(), n.trim().parse().ok()?)))
        };
        let notes = text.lines().take_while(|line| line.starts_with('#')).filter_map(note).collect();
        Ok(Columns { path: path.to_path_buf(), headers, rows, notes })
    }

    /// The number of a comment `# name = number` before the header.
    pub fn note(&self, name: &str) -> Option<f64> {
        self.notes.iter().find(|(n, _)| n == name).map(|n| n.1)
    }

    pub fn has(&self, name: &str) -> bool {
        self.headers.iter().any(|h| h == name)
    }

    /// Refuses a file without a column that `whose` has.
    ///
    /// # Errors
    /// The column is missing.
    pub fn require(&self, name: &str, whose: &str) -> Result<()> {
        let missing = || Error::input(self.path.display(), name, None, format!("is missing: {whose} has it"));
        self.has(name).then_some(()).ok_or_else(missing)
    }

    /// A column that `whose` has, as a finite number in every row.
    ///
    /// # Errors
    /// A column that is missing; a cell that is empty or no finite number.
    pub fn complete(&self, name: &str, whose: &str) -> Result<Vec<f64>> {
        self.require(name, whose)?;
        let value = |(row, value): (usize, Option<f64>)| value.ok_or_else(|| self.wrong_value(row, name, "must be a number"));
        self.numbers(name, 1.0)?.into_iter().enumerate().map(value).collect()
    }

    /// An error about this file.
    pub fn wrong(&self, message: impl Into<String>) -> Error {
        Error::input(self.path.display(), "", None, message)
    }

    /// An error about a value in a row.
    pub fn wrong_value(&self, row: usize, column: &str, message: impl Into<String>) -> Error {
        let at = self.headers.iter().position(|h| h == column);
        let value = at.and_then(|i| self.rows[row].1.get(i)).cloned();
        Error::input(format!("{} line {}", self.path.display(), self.rows[row].0), column, value, message)
    }

    /// A column as text; empty texts if the file has no such column.
    pub fn texts(&self, name: &str) -> Vec<&str> {
        let at = self.headers.iter().position(|h| h == name);
        self.rows.iter().map(|(_, cells)| at.and_then(|i| cells.get(i)).map_or("", String::as_str)).collect()
    }

    /// A column as finite numbers times `factor`; empty cells are `None`.
    ///
    /// # Errors
    /// A cell that is no finite number.
    pub fn numbers(&self, name: &str, factor: f64) -> Result<Vec<Option<f64>>> {
        self.texts(name)
            .iter()
            .enumerate()
            .map(|(row, cell)| match cell.parse::<f64>() {
                _ if cell.is_empty() => Ok(None),
                Ok(x) if x.is_finite() => Ok(Some(x * factor)),
                _ => Err(self.wrong_value(row, name, "must be a finite number")),
            })
            .collect()
    }
}
