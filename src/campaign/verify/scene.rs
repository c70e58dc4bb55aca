//! Cases that are scenes: run as a user would run them, and read back from the files of the run.

use super::Task;
use laboratory::error::{Error, Result};
use laboratory::run::{self, Found, Outcome, ResumeOptions, RunRequest};
use laboratory::scene;
use serde_json::Value;
use std::path::PathBuf;

/// A finished run.
pub struct Run {
    out: PathBuf,
    summary: Value,
}

/// Runs `scenes/name.toml` with these overrides in the task's folder, without figures and
/// snapshots, on the threads of the caller's pool. If the task keeps runs, a finished run in the
/// folder is taken as it is, and an unfinished one is continued.
///
/// # Errors
/// As [`run::run`].
pub fn run(task: &Task, name: &str, sets: &[String]) -> Result<Run> {
    let mut all = vec!["records.figures=false".into(), "records.snapshots=false".into()];
    all.extend_from_slice(sets);
    let scene = scene::load(task.scenes.join(name).with_extension("toml"), &all)?;
    let model = scene::model(&scene)?;
    let threads = Some(rayon::current_num_threads());
    let outcome = match if task.keep { run::look(&task.out, &scene, &model)? } else { Found::Nothing } {
        Found::Finished(summary) | Found::Undrawn(summary) => {
            Outcome { summary, out: task.out.clone(), draw: false, report: false }
        }
        Found::Unfinished => run::resume(&task.out, ResumeOptions { threads, quiet: true, ..ResumeOptions::default() })?,
        _ => run::run(RunRequest {
            backend: run::choose(task.backend, &model)?,
            model,
            scene_resolved: scene::resolved(&scene),
            out: task.out.clone(),
            force: true,
            threads,
            specimen: None,
            quiet: true,
            json: false,
            stop_after: None,
        })?,
    };
    // on one thread: processor time, which does not depend on other work of the machine
    let seconds = |key: &str| outcome.summary[key].as_f64();
    let alone = task.alone && threads == Some(1) && outcome.summary["backend"] == "cpu";
    let spent = if alone { seconds("user_seconds") } else { None };
    task.seconds.set(spent.or(seconds("wall_seconds")));
    Ok(Run { out: outcome.out, summary: outcome.summary })
}

impl Run {
    /// A number of the summary.
    ///
    /// # Errors
    /// A summary that lacks the number.
    pub fn number(&self, key: &str) -> Result<f64> {
        self.summary[key].as_f64().ok_or_else(|| Error::input(self.out.join("summary.json").display(), key, None, "is missing"))
    }

    /// A column of one of the run's tables.
    ///
    /// # Errors
    /// A table that lacks the column.
    pub fn column(&self, file: &str, name: &str) -> Result<Vec<f64>> {
        Ok(plot::read_column(&self.out.join(file), name)?)
    }

    /// First and last entry of a column of the history.
    ///
    /// # Errors
    /// As [`Run::column`], and a table without rows.
    pub fn ends(&self, name: &str) -> Result<[f64; 2]> {
        let values = self.column("history.csv", name)?;
        match values[..] {
            [first, .., last] => Ok([first, last]),
            [one] => Ok([one; 2]),
            [] => Err(Error::input(self.out.join("history.csv").display(), name, None, "has no rows")),
        }
    }

    /// Number of points and number of steps.
    ///
    /// # Errors
    /// A summary that lacks one of the numbers.
    pub fn size(&self) -> Result<(usize, u64)> {
        Ok((self.number("points")? as usize, self.number("steps")? as u64))
    }
}
