//! A paper's runs again: what was published of them beside what they give here, in tables, in figures with the paper's axes, and in a
//! report.

mod compare;
mod figures;
mod plan;
mod report;
mod results;

pub use compare::Row;
pub use plan::{Plan, Run};
pub use results::{Done, gather};

use laboratory::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Writes the tables, figures and report of what is done of a plan into `dir`, and returns the files.
///
/// # Errors
/// Files that cannot be read or written.
pub fn write(plan: &Plan, done: &[Done], dir: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(Error::write(dir))?;
    let rows = compare::rows(done);
    let mut files = vec![compare::write(&rows, &dir.join("comparison.csv"))?, compare::write_runs(done, &dir.join("runs.csv"))?];
    let mut drawn = Vec::new();
    for figure in &plan.figures {
        drawn.push(figures::draw(figure, done, &dir.join(&figure.name))?);
    }
    files.push(report::write(plan, done, &rows, &drawn, dir)?);
    files.extend(drawn.into_iter().flatten());
    Ok(files)
}
