//! `runs.csv`: a line for every run.

use crate::reproduce::results::Done;
use laboratory::error::{Error, Result};
use std::path::{Path, PathBuf};
use table::number;

/// Writes a line for every run. `columns`: names, and where their values stand in a summary.
///
/// # Errors
/// A file that cannot be written.
pub fn write(done: &[Done], columns: &[(&str, &str)], path: &Path) -> Result<PathBuf> {
    let failed = |e: csv::Error| Error::Write { path: path.into(), source: e.into() };
    let mut file = csv::Writer::from_path(path).map_err(failed)?;
    file.write_record(std::iter::once("run").chain(columns.iter().map(|c| c.0))).map_err(failed)?;
    for d in done {
        for seed in &d.seeds {
            let cell = |at: &str| seed.summary.pointer(at).and_then(serde_json::Value::as_f64).map_or(String::new(), number);
            let cells = columns.iter().map(|(_, at)| cell(at));
            file.write_record(std::iter::once(d.id.clone()).chain(cells)).map_err(failed)?;
        }
    }
    file.flush().map_err(Error::write(path))?;
    Ok(path.into())
}
