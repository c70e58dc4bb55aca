//! Reports: one page in a file of its own, which needs no network, that shows one run or several: what was run, what was found, every figure as a
//! chart, the specimen in three dimensions, breakages, tables. It is made of record files only.

#![deny(missing_docs)]

mod blob;
mod contacts;
mod folders;
mod frames;
mod links;
mod log;
mod page;
mod pictures;
mod run;

use laboratory::error::{Error, Result};
use std::io::Read;
use std::path::{Path, PathBuf};

/// How a report is made.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Largest number of snapshots of a run that the page holds, at least 1: first and last, and others at equal distances in the list.
    pub snapshots: usize,
    /// Overwrite a file that is no report.
    pub force: bool,
}

impl Default for Options {
    fn default() -> Self {
        Options { snapshots: 12, force: false }
    }
}

/// A report that was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// The file.
    pub path: PathBuf,
    /// Its length, bytes.
    pub bytes: usize,
    /// The runs that it shows.
    pub runs: Vec<PathBuf>,
    /// What a reader must know of the runs that are not finished, a line each.
    pub notes: Vec<String>,
}

/// Writes the report of the runs in `dirs` to the file `out`. A folder that holds no run itself but runs in its folders, as an ensemble leaves
/// them, stands for these.
///
/// # Errors
/// A folder without a run; records that are damaged, by file, column and line; `out` where it is a folder, or a file that is no report
/// (unless [`Options::force`]), or cannot be written. Nothing is written then.
pub fn write(dirs: &[PathBuf], out: &Path, options: &Options) -> Result<Written> {
    guard(out, options.force)?;
    let runs = folders::runs(dirs)?;
    let (text, notes) = page::page(&runs, out, options)?;
    if let Some(folder) = out.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        table::folder(folder).map_err(Error::write(folder))?;
    }
    table::write(out, &text).map_err(Error::write(out))?;
    Ok(Written { path: out.into(), bytes: text.len(), runs, notes })
}

/// Writes the report of one run into its folder, as `report.html`.
///
/// # Errors
/// Those of [`write()`].
pub fn write_run(dir: &Path) -> Result<Written> {
    write(&[dir.to_path_buf()], &dir.join(laboratory::run::REPORT), &Options::default())
}

/// Refuses to overwrite what is no report.
fn guard(out: &Path, force: bool) -> Result<()> {
    let refused = |message: &str| Err(Error::input(out.display(), "", None, message));
    if out.is_dir() {
        return refused("is a folder; --out names the file of the report");
    }
    if force || !out.exists() {
        return Ok(());
    }
    let mut head = Vec::new();
    let file = std::fs::File::open(out).map_err(Error::read(out))?;
    file.take(page::HEAD.len() as u64).read_to_end(&mut head).map_err(Error::read(out))?;
    if head == page::HEAD.as_bytes() {
        return Ok(());
    }
    refused("is no report, so that it is not overwritten; choose another file with --out, or overwrite it with --force")
}

#[cfg(test)]
mod tests;
