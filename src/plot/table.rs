//! Reading of CSV files: one header line, commas, comments of the form `# key = value`.

use super::error::{FigureError, Result};
use std::path::{Path, PathBuf};

/// A CSV file with its cells as text; numbers are read by column name.
#[derive(Clone, Debug)]
pub struct Table {
    /// The file.
    pub path: PathBuf,
    headers: Vec<String>,
    rows: Vec<(u64, Vec<String>)>,
    comments: Vec<(String, String)>,
}

/// Longest file, bytes.
const LONGEST: u64 = 1 << 30;

impl Table {
    /// Reads a file of at most 1 GiB. An incomplete last line is left out: a run may have been stopped while writing
    /// it.
    pub fn read(path: &Path) -> Result<Self> {
        let too_long = || FigureError::io(path, format!("must be at most {} MiB long", LONGEST >> 20));
        let bytes = ::table::read_up_to(path, LONGEST).map_err(|e| FigureError::io(path, e))?.ok_or_else(too_long)?;
        let text = String::from_utf8_lossy(&bytes);
        Self::of_text(path, text.trim_start_matches('\u{feff}'))
    }

    /// Reads a file of a user, whose columns a file beside it may name ([`laboratory::columns`]).
    pub fn of_user(path: &Path) -> Result<Self> {
        let text = laboratory::scene::read_text(path)?;
        Self::of_text(path, &laboratory::columns::mapped(path, text.trim_start_matches('\u{feff}'))?)
    }

    fn of_text(path: &Path, text: &str) -> Result<Self> {
        let comments = text
            .lines()
            .filter_map(|l| l.trim().strip_prefix('#')?.split_once('='))
            .map(|(k, v)| (k.trim().to_string(), v.trim().to_string()))
            .collect();
        let mut reader =
            csv::ReaderBuilder::new().comment(Some(b'#')).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
        let mut headers: Vec<String> = reader.headers().map_err(|e| FigureError::io(path, e))?.iter().map(str::to_string).collect();
        ::table::old_names::renew(&mut headers);
        let mut rows = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|e| FigureError::io(path, e))?;
            let line = record.position().map_or(0, csv::Position::line);
            rows.push((line, record.iter().map(str::to_string).collect()));
        }
        let cut = |row: &Vec<String>| row.len() < headers.len();
        if rows.last().is_some_and(|(_, r)| cut(r)) && !text.ends_with('\n') {
            rows.pop();
        }
        Ok(Self { path: path.to_path_buf(), headers, rows, comments })
    }

    /// Reads a file if it exists.
    pub fn read_if_there(path: &Path) -> Result<Option<Self>> {
        if path.is_file() { Self::read(path).map(Some) } else { Ok(None) }
    }

    /// Number of rows.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Names of the columns.
    pub fn headers(&self) -> &[String] {
        &self.headers
    }

    /// Whether there is a column of this name.
    pub fn has(&self, column: &str) -> bool {
        self.headers.iter().any(|h| h == column)
    }

    fn index(&self, column: &str) -> Result<usize> {
        let found = self.headers.iter().position(|h| h == column);
        found.ok_or_else(|| FigureError::Column {
            path: self.path.clone(),
            column: column.to_string(),
            have: self.headers.join(", "),
        })
    }

    /// A column as text; missing cells are empty.
    pub fn texts(&self, column: &str) -> Result<Vec<&str>> {
        let i = self.index(column)?;
        Ok(self.rows.iter().map(|(_, row)| row.get(i).map_or("", String::as_str)).collect())
    }

    /// A column as numbers; empty cells are NaN.
    pub fn numbers(&self, column: &str) -> Result<Vec<f64>> {
        let i = self.index(column)?;
        let number = |line: u64, cell: &str| -> Result<f64> {
            if cell.is_empty() {
                return Ok(f64::NAN);
            }
            cell.parse().map_err(|_| FigureError::Number {
                path: self.path.clone(),
                line,
                column: column.to_string(),
                value: cell.to_string(),
            })
        };
        self.rows.iter().map(|(line, row)| number(*line, row.get(i).map_or("", String::as_str))).collect()
    }

    /// The number after `# key =`.
    pub fn note(&self, key: &str) -> Option<f64> {
        self.note_text(key)?.split_whitespace().next()?.parse().ok()
    }

    /// The text after `# key =`.
    pub fn note_text(&self, key: &str) -> Option<&str> {
        let note = self.comments.iter().find(|(k, _)| k == key)?;
        Some(note.1.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<Table> {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("t.csv");
        std::fs::write(&path, text).expect("written");
        Table::read(&path)
    }

    #[test]
    fn columns_are_found_by_name_and_comments_kept() {
        let t = table("# height_m = 0.05\n# label = after Ciantia\na, b_kPa\n1, 2.5\n# between\n,nan\n3\n").expect("read");
        assert_eq!(t.note("height_m"), Some(0.05));
        assert_eq!(t.note_text("label"), Some("after Ciantia"));
        assert_eq!(t.note("absent"), None);
        let a = t.numbers("a").expect("a");
        assert!(a[0] == 1.0 && a[1].is_nan() && a[2] == 3.0);
        let b = t.numbers("b_kPa").expect("b");
        assert!(b[0] == 2.5 && b[1].is_nan() && b[2].is_nan());
    }

    #[test]
    fn errors_name_file_column_and_line() {
        let t = table("a,b\n1,2\n1,x2\n").expect("read");
        let error = t.numbers("c").expect_err("absent").to_string();
        assert!(error.contains("t.csv: no column `c`; the file has a, b"), "{error}");
        let error = t.numbers("b").expect_err("text").to_string();
        assert!(error.ends_with("line 3, column `b`: `x2` is not a number"), "{error}");
        let error = Table::read(Path::new("/nowhere/at.csv")).expect_err("absent");
        assert!(error.to_string().starts_with("/nowhere/at.csv: "));
    }

    #[test]
    fn a_line_cut_short_is_left_out_but_only_at_the_end() {
        assert_eq!(table("a,b\n1,2\n3").expect("read").len(), 1);
        assert_eq!(table("a,b\n1,2\n3\n").expect("read").len(), 2);
        assert_eq!(table("").expect("read").len(), 0);
        assert_eq!(table("a,b\n").expect("read").len(), 0);
    }
}
