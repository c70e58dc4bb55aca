//! Tables of numbers as CSV files: the number format, tables that grow row by row, former names of columns, quantiles.

#![deny(missing_docs)]

pub mod old_names;

use serde::{Deserialize, Serialize};
use std::fs::{File, OpenOptions};
use std::io::{BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// A table could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot write: {source}", .path.display())]
pub struct WriteError {
    /// The table's file.
    pub path: PathBuf,
    /// The system's reason.
    pub source: std::io::Error,
}

impl WriteError {
    fn of(path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> WriteError {
        let path = path.as_ref().to_path_buf();
        move |source| WriteError { path, source }
    }
}

/// One value of a row.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number, written in full.
    Count(u64),
    /// A number, written as by [`number`].
    Number(f64),
    /// A text, written as it is: it must hold no comma, quote or line break.
    Text(String),
}

impl From<u64> for Value {
    fn from(x: u64) -> Value {
        Value::Count(x)
    }
}

impl From<usize> for Value {
    fn from(x: usize) -> Value {
        Value::Count(x as u64)
    }
}

impl From<f64> for Value {
    fn from(x: f64) -> Value {
        Value::Number(x)
    }
}

impl From<&str> for Value {
    fn from(x: &str) -> Value {
        Value::Text(x.to_string())
    }
}

impl std::fmt::Display for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Value::Count(n) => write!(f, "{n}"),
            Value::Number(x) => f.write_str(&number(*x)),
            Value::Text(t) => f.write_str(t),
        }
    }
}

/// A number as text with nine significant digits and without trailing zeros; an empty text when it is not finite.
pub fn number(x: f64) -> String {
    if !x.is_finite() {
        return String::new();
    }
    if x == 0.0 {
        return "0".into();
    }
    let size = x.abs().log10().floor() as i32;
    if !(-4..9).contains(&size) {
        return format!("{x:.8e}");
    }
    let text = format!("{x:.*}", (8 - size).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// Quantile `q`, 0 to 1, of values in ascending order, interpolated linearly between neighbours; NaN where there are no values.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let at = q * sorted.len().saturating_sub(1) as f64;
    let i = at as usize;
    match (sorted.get(i), sorted.get(i + 1)) {
        (Some(a), Some(b)) => a + (b - a) * (at - i as f64),
        (Some(a), None) => *a,
        _ => f64::NAN,
    }
}

/// Median of values in any order; NaN where there are no values.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    quantile(&sorted, 0.5)
}

/// A row: the name and the value of each column, in order.
pub type Row = Vec<(&'static str, Value)>;

/// A CSV file that is written row by row. A checkpoint keeps the length of the file, not its name: a table from a checkpoint is given
/// its name by [`Table::reopen`], which cuts the file back to this length.
#[derive(Debug, Serialize, Deserialize)]
pub struct Table {
    #[serde(skip)]
    name: &'static str,
    /// Length of the file with all rows pushed so far, bytes.
    length: u64,
    #[serde(skip)]
    open: Option<(PathBuf, BufWriter<File>)>,
}

impl Table {
    /// A new, empty table in the file `name`. The file is made with the first row.
    pub fn new(name: &'static str) -> Table {
        Table { name, length: 0, open: None }
    }

    /// Goes on with a table from a checkpoint, whose file is `name` in `dir`. Rows written after the checkpoint are cut off.
    ///
    /// # Errors
    /// A file that lacks rows which the checkpoint knows, or that cannot be written.
    pub fn reopen(&mut self, dir: &Path, name: &'static str) -> Result<(), WriteError> {
        self.name = name;
        if self.length > 0 {
            let path = dir.join(name);
            let found = std::fs::symlink_metadata(&path).map_err(WriteError::of(&path))?.len();
            if found < self.length {
                let lost = format!("the file has {found} bytes where the checkpoint knows of {}: rows were lost", self.length);
                return Err(WriteError::of(&path)(std::io::Error::other(lost)));
            }
            self.writer(dir)?;
        }
        Ok(())
    }

    /// Checks the length of a table from a checkpoint, whose file is `name` in `dir`: the file is cut back to it, so that a row must end there. A
    /// file that is too short or cannot be read is left to [`Table::reopen`].
    ///
    /// # Errors
    /// A length that falls into a row, in words.
    pub fn check(&self, dir: &Path, name: &str) -> Result<(), String> {
        let before = || {
            let mut file = File::open(dir.join(name)).ok()?;
            file.seek(SeekFrom::Start(self.length.checked_sub(1)?)).ok()?;
            let mut byte = [0];
            file.read_exact(&mut byte).ok().map(|()| byte)
        };
        match before() {
            Some(byte) if byte != *b"\n" => Err(format!("{name} would be cut inside of a row, after {} bytes", self.length)),
            _ => Ok(()),
        }
    }

    /// Opens the file in `dir`, and cuts it back to the known length.
    fn writer(&mut self, dir: &Path) -> Result<&mut (PathBuf, BufWriter<File>), WriteError> {
        if self.open.is_none() {
            let path = dir.join(self.name);
            no_link(&path).map_err(WriteError::of(&path))?;
            let mut options = OpenOptions::new();
            options.write(true).create(true).truncate(false);
            let file = options.open(&path).map_err(WriteError::of(&path))?;
            file.set_len(self.length).map_err(WriteError::of(&path))?;
            let mut writer = BufWriter::new(file);
            writer.seek(SeekFrom::End(0)).map_err(WriteError::of(&path))?;
            self.open = Some((path, writer));
        }
        Ok(self.open.as_mut().expect("just opened"))
    }

    /// Appends a row to the file in `dir`; the first row writes the header as well.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn push(&mut self, dir: &Path, row: &Row) -> Result<(), WriteError> {
        let mut text = String::new();
        if self.length == 0 {
            text += &row.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text += &row.iter().map(|(_, v)| v.to_string()).collect::<Vec<_>>().join(",");
        text.push('\n');
        let (path, writer) = self.writer(dir)?;
        writer.write_all(text.as_bytes()).map_err(WriteError::of(&path))?;
        self.length += text.len() as u64;
        Ok(())
    }

    /// Brings all rows to the disk, so that a checkpoint written afterwards knows of no row that a power failure can take.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn sync(&mut self, dir: &Path) -> Result<(), WriteError> {
        self.flush(dir)?;
        match &self.open {
            Some((path, writer)) => writer.get_ref().sync_data().map_err(WriteError::of(path)),
            None => Ok(()),
        }
    }

    /// Hands all rows to the operating system. A file that exists though the table has no rows yet is emptied.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn flush(&mut self, dir: &Path) -> Result<(), WriteError> {
        if self.length == 0 && !dir.join(self.name).exists() {
            return Ok(());
        }
        let (path, writer) = self.writer(dir)?;
        writer.flush().map_err(WriteError::of(path))
    }
}

/// Fails where `path` is a symbolic link: a file of a run is never written through one.
///
/// # Errors
/// A link.
pub fn no_link(path: &Path) -> std::io::Result<()> {
    match std::fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => Err(std::io::Error::other("is a symbolic link, which is not followed")),
        _ => Ok(()),
    }
}

/// Reads the file `path`; `None` where it is longer than `longest` bytes: a device or a pipe does not say how long it is, and would be read until memory is full.
///
/// # Errors
/// A file that cannot be read.
pub fn read_up_to(path: &Path, longest: u64) -> std::io::Result<Option<Vec<u8>>> {
    let mut bytes = Vec::new();
    File::open(path)?.take(longest + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= longest).then_some(bytes))
}

/// Makes the empty file `path`, or empties it. Every file of a run that is not a [`Table`] is made here.
///
/// # Errors
/// A symbolic link, which is not followed; a file that cannot be written.
pub fn create(path: &Path) -> std::io::Result<File> {
    no_link(path)?;
    File::create(path)
}

/// Writes the file `path` as [`create`] makes it.
///
/// # Errors
/// Those of [`create`].
pub fn write(path: impl AsRef<Path>, text: impl AsRef<[u8]>) -> std::io::Result<()> {
    create(path.as_ref())?.write_all(text.as_ref())
}

/// Makes the folder `path` where it is missing.
///
/// # Errors
/// A symbolic link, which is not followed; a folder that cannot be made.
pub fn folder(path: &Path) -> std::io::Result<()> {
    no_link(path)?;
    std::fs::create_dir_all(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_nine_digits_and_no_more() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(1.0 / 3.0), "0.333333333");
        assert_eq!(number(5000.0), "5000");
        assert_eq!(number(-1234567.891234), "-1234567.89");
        assert_eq!(number(1e-7), "1.00000000e-7");
        assert_eq!(number(f64::NAN), "");
    }

    #[test]
    fn quantiles_are_linear_between_two_values() {
        let sorted = [1.0, 2.0, 4.0, 8.0];
        assert_eq!([0.0, 0.5, 1.0].map(|q| quantile(&sorted, q)), [1.0, 3.0, 8.0]);
        assert_eq!(median(&[8.0, 1.0, 4.0]), 4.0);
        assert!(quantile(&[], 0.5).is_nan() && quantile(&[7.0], 0.9) == 7.0);
    }

    #[test]
    fn a_table_is_cut_back_to_what_the_checkpoint_knows() {
        let dir = tempfile::tempdir().expect("folder");
        let row = |k: u64| -> Row { vec![("step", k.into()), ("x_m", (k as f64 * 0.5).into())] };
        let mut table = Table::new("t.csv");
        table.push(dir.path(), &row(1)).expect("row");
        table.flush(dir.path()).expect("flush");
        let saved = postcard::to_stdvec(&table).expect("save");
        table.push(dir.path(), &row(2)).expect("row");
        table.flush(dir.path()).expect("flush");
        drop(table);
        let mut again: Table = postcard::from_bytes(&saved).expect("load");
        again.check(dir.path(), "t.csv").expect("the end of a row");
        again.length -= 1;
        let told = again.check(dir.path(), "t.csv").expect_err("inside of a row");
        assert!(told.contains("t.csv would be cut inside of a row"), "{told}");
        again.length += 1;
        again.reopen(dir.path(), "t.csv").expect("whole");
        again.push(dir.path(), &row(3)).expect("row");
        again.flush(dir.path()).expect("flush");
        assert_eq!(std::fs::read_to_string(dir.path().join("t.csv")).expect("text"), "step,x_m\n1,0.5\n3,1.5\n");
    }

    /// A file that lost rows is not filled up with zeros, and a link is not written through.
    #[test]
    fn a_file_that_lost_rows_or_is_a_link_is_refused() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("t.csv");
        let mut table = Table::new("t.csv");
        table.push(dir.path(), &vec![("step", 1_u64.into())]).expect("row");
        table.sync(dir.path()).expect("on the disk");
        let saved = postcard::to_stdvec(&table).expect("save");
        let again = || postcard::from_bytes::<Table>(&saved).expect("load");
        std::fs::write(&path, "step\n").expect("cut");
        let told = again().reopen(dir.path(), "t.csv").expect_err("rows were lost").to_string();
        assert!(told.contains("has 5 bytes where the checkpoint knows of 7"), "{told}");
        assert_eq!(std::fs::read_to_string(&path).expect("text"), "step\n");
        #[cfg(unix)]
        {
            let victim = dir.path().join("victim");
            std::fs::write(&victim, "a text of somebody else").expect("written");
            std::fs::remove_file(&path).expect("removed");
            std::os::unix::fs::symlink(&victim, &path).expect("link");
            let told = again().reopen(dir.path(), "t.csv").expect_err("a link").to_string();
            assert!(told.contains("symbolic link"), "{told}");
            assert_eq!(std::fs::read_to_string(&victim).expect("text"), "a text of somebody else");
        }
    }
}
