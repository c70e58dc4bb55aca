//! Reproduction of a paper: its runs are made again, and the results stand beside the published
//! numbers in tables, in figures with the axes of the paper, and in a report.

mod comparison;
mod figures;
mod graph;
mod plan;
mod reading;
mod report;
mod results;

pub use comparison::{Compare, Comparison, Row};
pub use plan::{Plan, PublishedTest, Run, Statement};
pub(crate) use report::cell;
pub(crate) use results::rows;
pub use results::{Done, gather};

use laboratory::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Writes tables, figures and the report for the finished runs of a plan into `dir`, and returns
/// the files.
///
/// # Errors
/// Files that cannot be read or written.
pub fn write(plan: &Plan, done: &[Done], dir: &Path) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(dir).map_err(Error::write(dir))?;
    let (mut files, compared) = plan.compare.comparison().compare(plan, done, dir)?;
    let mut drawn = Vec::new();
    for figure in &plan.figures {
        drawn.push(figures::draw(figure, plan, done, &dir.join(&figure.name))?);
    }
    files.push(report::write(plan, &compared, &drawn, dir)?);
    files.extend(drawn.into_iter().flatten());
    Ok(files)
}
