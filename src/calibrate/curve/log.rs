//! Log of a calibration, `evaluations.csv`: a row for each run, written before the run begins and
//! again after it has ended. A later call continues from this log.

use super::parameter::Parameter;
use crate::columns::Columns;
use laboratory::error::{Error, Result};
use std::path::{Path, PathBuf};

/// Purpose of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Part of the design that fills the space between the bounds.
    Design,
    /// In the middle of the bounds, with several seeds, for the scatter between seeds.
    Centre,
    /// At parameters that agree with the curve, where a run makes the emulator's predictions most
    /// certain.
    Search,
    /// At the parameters found; the emulator is not fitted to this run.
    Check,
}

const STAGES: [(Stage, &str); 4] =
    [(Stage::Design, "design"), (Stage::Centre, "centre"), (Stage::Search, "search"), (Stage::Check, "check")];

#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    Planned,
    Done,
    Failed(String),
}

/// A run, planned or ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Evaluation {
    /// Number from 1; check runs are counted by themselves.
    pub number: usize,
    pub stage: Stage,
    /// Values of the parameters, in the units of their keys.
    pub values: Vec<f64>,
    /// Seed of specimen and strengths.
    pub seed: u64,
    pub status: Status,
}

impl Evaluation {
    /// Folder of the run, below the folder of the calibration.
    pub fn folder(&self) -> PathBuf {
        let kind = if self.stage == Stage::Check { "check" } else { "run" };
        Path::new("runs").join(format!("{kind}-{:03}", self.number))
    }
}

/// Name of the file.
pub const FILE: &str = "evaluations.csv";

/// Writes the log. `misfit`: root mean square difference between the curve of the run with this
/// index and the measured curve, each difference over the scale of its point.
pub fn write(dir: &Path, parameters: &[Parameter], all: &[Evaluation], misfit: impl Fn(usize) -> Option<f64>) -> Result<()> {
    let path = dir.join(FILE);
    let mut file = csv::Writer::from_writer(Vec::new());
    let failed = |e: csv::Error| Error::Write { path: path.clone(), source: e.into() };
    let keys = parameters.iter().map(|p| p.key.as_str());
    let header = ["number", "stage", "folder", "status"].into_iter().chain(keys);
    file.write_record(header.chain(["seed", "misfit", "reason"])).map_err(failed)?;
    for (i, e) in all.iter().enumerate() {
        let stage = STAGES.iter().find(|s| s.0 == e.stage).map_or("", |s| s.1);
        let (status, reason) = match &e.status {
            Status::Planned => ("planned", ""),
            Status::Done => ("done", ""),
            Status::Failed(reason) => ("failed", reason.as_str()),
        };
        let optional = |x: Option<f64>| x.map_or(String::new(), table::number);
        let mut row: Vec<String> =
            vec![e.number.to_string(), stage.into(), e.folder().display().to_string().replace('\\', "/"), status.into()];
        row.extend(e.values.iter().map(|v| format!("{v:?}")));
        row.extend([e.seed.to_string(), optional(misfit(i)), reason.replace('\n', "; ")]);
        file.write_record(row).map_err(failed)?;
    }
    let bytes = file.into_inner().map_err(|e| Error::Write { path: path.clone(), source: e.into_error() })?;
    replace(&path, &bytes)
}

/// Where a file is written before it takes the place of the one at `path`.
pub fn aside(path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(".tmp");
    path.with_file_name(name)
}

/// Writes a file whole or not at all, so that an interrupt leaves the old content.
pub fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    let temporary = aside(path);
    std::fs::write(&temporary, bytes).map_err(Error::write(&temporary))?;
    std::fs::rename(&temporary, path).map_err(Error::write(path))
}

/// Reads the log of the folder `dir`; no runs if there is none.
///
/// # Errors
/// A log that lacks a parameter or another column, or has an invalid value.
pub fn read(dir: &Path, parameters: &[Parameter]) -> Result<Vec<Evaluation>> {
    let path = dir.join(FILE);
    if !path.exists() {
        return Ok(Vec::new());
    }
    // `Columns::read` refuses a table without rows, but a log that has just begun has none
    if std::fs::read_to_string(&path).map_err(Error::read(&path))?.lines().count() < 2 {
        return Ok(Vec::new());
    }
    let file = Columns::read(&path)?;
    for name in parameters.iter().map(|p| p.key.as_str()).chain(["number", "stage", "status", "seed", "reason"]) {
        if !file.has(name) {
            return Err(file.wrong(format!("is not the log of this calibration: it has no column {name}")));
        }
    }
    let number = |name: &str, row: usize| -> Result<f64> {
        file.numbers(name, 1.0)?[row].ok_or_else(|| file.wrong_value(row, name, "must be a number"))
    };
    let (stages, statuses, reasons) = (file.texts("stage"), file.texts("status"), file.texts("reason"));
    (0..file.rows.len())
        .map(|row| {
            let stage = STAGES.iter().find(|s| s.1 == stages[row]).map(|s| s.0);
            let status = match statuses[row] {
                "done" => Status::Done,
                "failed" => Status::Failed(reasons[row].into()),
                _ => Status::Planned,
            };
            Ok(Evaluation {
                number: number("number", row)? as usize,
                stage: stage.ok_or_else(|| file.wrong_value(row, "stage", "is none of design, centre, search, check"))?,
                values: parameters.iter().map(|p| number(&p.key, row)).collect::<Result<_>>()?,
                seed: number("seed", row)? as u64,
                status,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::stand_in;

    #[test]
    fn a_log_is_read_as_it_was_written() {
        let dir = tempfile::tempdir().expect("folder");
        let parameters = stand_in::parameters();
        assert!(read(dir.path(), &parameters).expect("none").is_empty());
        let evaluation = |number, stage, status| Evaluation { number, stage, values: vec![0.1 + 0.2, 3e-7], seed: 10_001, status };
        let all = vec![
            evaluation(1, Stage::Design, Status::Done),
            evaluation(2, Stage::Centre, Status::Failed("step 3: it, \"broke\"\nreally".into())),
            evaluation(1, Stage::Check, Status::Planned),
        ];
        write(dir.path(), &parameters, &all, |i| (i == 0).then_some(1.5)).expect("written");
        let again = read(dir.path(), &parameters).expect("read");
        assert_eq!((&again[0], &again[2]), (&all[0], &all[2]));
        assert_eq!(again[1].status, Status::Failed("step 3: it, \"broke\"; really".into()));
        assert_eq!(all[2].folder(), Path::new("runs/check-001"));
        let other = vec![Parameter { key: "other".into(), ..parameters[0].clone() }];
        assert!(read(dir.path(), &other).expect_err("another").to_string().contains("no column other"));
    }
}
