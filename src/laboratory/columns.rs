//! Tables of others: a TOML file beside a CSV file says which of its columns are which quantities of this program, as expressions of its
//! own columns. Everything that reads a user's CSV file reads it through [`mapped`].

use crate::error::{Error, Result};
use crate::expression::Expression;
use crate::scene::read_text;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a file of columns says.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Mapping {
    /// Columns of this program: an expression of the file's columns, or the name of one, whose texts are taken as they are.
    columns: BTreeMap<String, String>,
    /// What stands between the values of a line.
    #[serde(default = "comma")]
    separator: char,
    /// Whether numbers have a comma where others have a point.
    #[serde(default)]
    decimal_comma: bool,
    /// The line that names the columns, from 1; where it is not given, the first that is neither empty nor a comment.
    header_line: Option<usize>,
    /// The first line with values, from 1; where it is not given, the one behind the header.
    first_line: Option<usize>,
}

fn comma() -> char {
    ','
}

/// The file that says what the columns of `path` are: `test.columns.toml` for `test.csv`.
pub fn beside(path: &Path) -> PathBuf {
    path.with_extension("columns.toml")
}

/// The text of the CSV file `path` with the columns of this program: `text` itself, where no file beside it says what they are. Each row
/// keeps its line, so that messages name the right one.
///
/// # Errors
/// A file of columns that is not what it must be; a column that the table has not; a cell that is no number; a row of another length than
/// the header: each by file, line and column.
pub fn mapped<'a>(path: &Path, text: &'a str) -> Result<Cow<'a, str>> {
    let source = beside(path);
    if !source.is_file() {
        return Ok(Cow::Borrowed(text));
    }
    let mapping: Mapping = toml::from_str(&read_text(&source)?).map_err(|e| {
        let message = format!("{}; allowed are columns, separator, decimal_comma, header_line, first_line", e.message().trim());
        Error::input(source.display(), "", None, message.replace('\n', ", "))
    })?;
    mapping.apply(&source, path, text.trim_start_matches('\u{feff}')).map(Cow::Owned)
}

/// A column of the new table.
enum Column {
    /// A column of the file, as it is.
    Copy(usize),
    /// An expression of columns of the file.
    Of(Box<Expression>, Vec<usize>),
}

impl Mapping {
    fn apply(&self, source: &Path, path: &Path, text: &str) -> Result<String> {
        let comment = |line: &str| line.trim().is_empty() || line.starts_with('#');
        let found = text.lines().position(|line| !comment(line)).map(|k| k + 1);
        let Some(header_line) = self.header_line.or(found) else {
            return Err(Error::input(path.display(), "", None, "holds no rows"));
        };
        let first = self.first_line.unwrap_or(header_line + 1);
        if header_line == 0 || first <= header_line {
            let message = "the header must be in line 1 or below, and values below the header";
            return Err(Error::input(source.display(), "header_line", Some(header_line.to_string()), message));
        }
        let mut columns = Vec::new();
        let mut header = Vec::new();
        let mut out = String::new();
        for (number, line) in (1..).zip(text.lines()) {
            if number == header_line {
                header = self.cells(path, number, line)?;
                columns = self.columns(source, path, &header)?;
                out += &self.columns.keys().map(|name| quoted(name)).collect::<Vec<_>>().join(",");
            } else if number >= first && !comment(line) {
                let cells = self.cells(path, number, line)?;
                if cells.len() != header.len() {
                    let message = format!("has {} values; the header has {}", cells.len(), header.len());
                    return Err(Error::input(format!("{} line {number}", path.display()), "", None, message));
                }
                let cell = |column: &Column| self.cell(path, number, &header, &cells, column);
                out += &columns.iter().map(cell).collect::<Result<Vec<_>>>()?.join(",");
            } else if line.starts_with('#') {
                out += line;
            } else {
                // what is left out keeps its place
                out.push('#');
            }
            out.push('\n');
        }
        if columns.is_empty() {
            return Err(Error::input(source.display(), "header_line", Some(header_line.to_string()), "the table is shorter"));
        }
        Ok(out)
    }

    /// The values of a line.
    fn cells(&self, path: &Path, number: usize, line: &str) -> Result<Vec<String>> {
        let wrong = |message: String| Error::input(format!("{} line {number}", path.display()), "", None, message);
        let separator = u8::try_from(self.separator).map_err(|_| wrong("the separator must be one byte long".into()))?;
        let mut reader =
            csv::ReaderBuilder::new().has_headers(false).delimiter(separator).trim(csv::Trim::All).from_reader(line.as_bytes());
        let record = reader.records().next().transpose().map_err(|e| wrong(e.to_string()))?;
        Ok(record.map_or(Vec::new(), |record| record.iter().map(String::from).collect()))
    }

    /// What the new columns are made of.
    fn columns(&self, source: &Path, path: &Path, header: &[String]) -> Result<Vec<Column>> {
        let column = |(name, text): (&String, &String)| {
            if let Some(k) = header.iter().position(|h| h == text) {
                return Ok(Column::Copy(k));
            }
            let wrong =
                |message: String| Error::input(source.display(), format!("columns.{name}"), Some(format!("{text:?}")), message);
            let expression: Expression = named(text, header).try_into().map_err(wrong)?;
            let place = |of: &String| {
                let missing = || {
                    let there = header.join(", ");
                    wrong(format!(
                        "{} has no column {of}; it has {there} (names with blanks or signs stand in {{…}})",
                        path.display()
                    ))
                };
                header.iter().position(|h| h == of).ok_or_else(missing)
            };
            let places = expression.names().iter().map(place).collect::<Result<Vec<_>>>()?;
            Ok(Column::Of(Box::new(expression), places))
        };
        self.columns.iter().map(column).collect()
    }

    /// A value of the new table; empty where one that it is made of is empty.
    fn cell(&self, path: &Path, number: usize, header: &[String], cells: &[String], column: &Column) -> Result<String> {
        let place = format!("{} line {number}", path.display());
        let pointed = |text: &str| if self.decimal_comma { text.replace(',', ".") } else { text.to_string() };
        match column {
            Column::Copy(k) => {
                let text = pointed(&cells[*k]);
                Ok(if text.parse::<f64>().is_ok() { text } else { quoted(&cells[*k]) })
            }
            Column::Of(_, places) if places.iter().any(|k| cells[*k].is_empty()) => Ok(String::new()),
            Column::Of(expression, places) => {
                let number = |k: &usize| {
                    let read = pointed(&cells[*k]).parse::<f64>().ok().filter(|x| x.is_finite());
                    read.ok_or_else(|| Error::input(&place, header[*k].clone(), Some(cells[*k].clone()), "must be a finite number"))
                };
                let numbers = places.iter().map(number).collect::<Result<Vec<_>>>()?;
                let value = expression.value(&numbers).map_err(|message| Error::input(&place, "", None, message))?;
                Ok(format!("{value:?}"))
            }
        }
    }
}

/// The expression with each word that is a column in `{…}`: a column `e` is no constant.
fn named(text: &str, header: &[String]) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let word = first.is_alphabetic() || first == '_';
        let end = match first {
            '{' => rest.find('}').map_or(rest.len(), |at| at + 1),
            // a number with its exponent
            '0'..='9' => rest.find(|c: char| !c.is_alphanumeric() && c != '.').unwrap_or(rest.len()),
            _ if word => rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len()),
            _ => first.len_utf8(),
        };
        let (part, after) = rest.split_at(end);
        match word && header.iter().any(|name| name == part) {
            true => out += &format!("{{{part}}}"),
            false => out += part,
        }
        rest = after;
    }
    out
}

/// A text as a value of a CSV file.
fn quoted(text: &str) -> String {
    crate::record::specimen::quoted(text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The table with the columns of this program, or what is wrong.
    fn table(columns: &str, text: &str) -> std::result::Result<String, String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("test.csv");
        std::fs::write(folder.path().join("test.columns.toml"), columns).expect("written");
        mapped(&path, text).map(Cow::into_owned).map_err(|e| e.to_string())
    }

    #[test]
    fn a_table_of_a_laboratory_is_read_where_its_lines_are() {
        let columns = "separator = \";\"\ndecimal_comma = true\nheader_line = 3\nfirst_line = 5\n\
                       [columns]\nsigma_v_kPa = \"{Sig_v [MPa]} * 1000\"\nvoid_ratio = \"e\"\nseries = \"Versuch\"\n";
        let text = "Oedometer;;\n# label = Sand 7\nSig_v [MPa];e;Versuch\nMPa;-;-\n0,5;0,81;A, dicht\n\n1;;B\n";
        let made = table(columns, text).expect("a table");
        assert_eq!(made, "#\n# label = Sand 7\nseries,sigma_v_kPa,void_ratio\n#\n\"A, dicht\",500.0,0.81\n#\nB,1000.0,\n");
    }

    #[test]
    fn a_column_is_a_column_also_where_it_is_named_like_a_constant() {
        let of = |expression: &str| table(&format!("[columns]\nn = \"{expression}\"\n"), "e,E,x 2\n0.5,4,3\n").expect("a table");
        assert_eq!(of("e/(1+e)").lines().nth(1), Some("0.3333333333333333"));
        assert_eq!(of("1e1*E + {x 2} - 2.5").lines().nth(1), Some("40.5"));
        assert_eq!(of("sqrt(E)").lines().nth(1), Some("2.0"));
    }

    #[test]
    fn mistakes_are_named() {
        let text = "a,b\n1,x\n";
        for (columns, needed) in [
            ("[columns]\nq = \"2*b\"\n", "test.csv line 2: b = x: must be a finite number"),
            ("[columns]\nq = \"2*c\"\n", "columns.q = \"2*c\": "),
            ("[columns]\nq = \"2*c\"\n", "has no column c; it has a, b"),
            ("[columns]\nq = \"2*\"\n", "is no expression"),
            ("[columns]\nq = \"a\"\n[rows]\n", "unknown field `rows`"),
            ("header_line = 9\n[columns]\nq = \"a\"\n", "the table is shorter"),
            ("first_line = 1\n[columns]\nq = \"a\"\n", "values below the header"),
            ("separator = \";\"\n[columns]\nq = \"a\"\n", "has no column a; it has a,b"),
        ] {
            let error = table(columns, text).expect_err(needed);
            assert!(error.contains(needed), "{error}");
        }
        assert!(table("[columns]\nq = \"a\"\n", "a,b\n1,2\n3\n").expect_err("short").contains("line 3: has 1 values"));
    }

    #[test]
    fn without_such_a_file_the_text_is_as_it_was() {
        let text = "a,b\n1,2\n";
        assert!(matches!(mapped(Path::new("/nowhere/a.csv"), text), Ok(Cow::Borrowed(same)) if same == text));
    }
}
