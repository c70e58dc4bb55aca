//! What can go wrong, said with the values: which file, which key, which grain, which step.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// The result of everything in this crate that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// Why nothing was started, or why a run ended.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scene, material, data file or override says something that is not allowed.
    #[error("{}", input_line(.place, .key, .value.as_deref(), .message))]
    Input {
        /// File (with a line where there is one) or `--set key=value`.
        place: String,
        /// Dotted key or column; empty when the whole place is meant.
        key: String,
        /// The value as written.
        value: Option<String>,
        /// What is allowed and what to do.
        message: String,
    },
    /// Several mistakes found in one reading.
    #[error("{}", lines(.0))]
    Several(Vec<Error>),
    /// A file could not be read.
    #[error("{}: {}", .path.display(), reason(.source))]
    Read { path: PathBuf, source: io::Error },
    /// A file could not be written.
    #[error("{}: cannot write: {}", .path.display(), reason(.source))]
    Write { path: PathBuf, source: io::Error },
    /// The output folder holds something already.
    #[error(
        "{}: holds a run already: choose another folder with --out, or --force to overwrite it",
        .path.display()
    )]
    Exists { path: PathBuf },
    /// The output folder holds a run of another scene.
    #[error("{}: holds a run of another scene ({what}): choose another folder with --out, or --force to overwrite it", .path.display())]
    Other { path: PathBuf, what: String },
    /// Somebody else is at work in the folder.
    #[error("{}: another process is running there", .path.display())]
    Busy { path: PathBuf },
    /// Some runs of a campaign failed; the others are done.
    #[error("{}{} of {of} runs failed", failures(.failed), .failed.len())]
    Campaign {
        /// Folder and reason of each.
        failed: Vec<(PathBuf, String)>,
        of: usize,
    },
    /// A campaign was stopped from outside; what is done and the checkpoints of the rest are kept.
    #[error("stopped with {done} of {of} runs done; the same command goes on")]
    Stopped { done: usize, of: usize },
    /// The state left the range in which it means anything.
    #[error("step {step}: {what}{}", of_grain(.grain))]
    Unstable {
        step: u64,
        what: String,
        /// Persistent id of the grain, where one is to blame.
        grain: Option<u64>,
    },
    /// A test has left what is possible: a continuum's energy or platens, or anything's voids; what is recorded so far is kept.
    #[error("step {step}: {what}")]
    Impossible { step: u64, what: String },
    /// The run could not reach what the scene asks for.
    #[error("step {step}: {what}")]
    Failed { step: u64, what: String },
    /// A checkpoint that cannot be continued.
    #[error("{}: cannot be resumed: {what}", .path.display())]
    Checkpoint { path: PathBuf, what: String },
    /// Figures could not be drawn from the records.
    #[error("{what}")]
    Figure {
        what: String,
        /// Whether the records or data asked for are wrong; else a file could not be written.
        input: bool,
    },
    /// Stopped from outside; everything recorded so far is kept.
    #[error("interrupted at step {step}; continue with: comminute resume {}", .out.display())]
    Interrupted { step: u64, out: PathBuf },
}

impl From<table::WriteError> for Error {
    fn from(error: table::WriteError) -> Self {
        Error::Write { path: error.path, source: error.source }
    }
}

impl From<engine::error::Error> for Error {
    fn from(error: engine::error::Error) -> Self {
        use engine::error::Error as Engine;
        match error {
            Engine::Refused { of, key, value, message } => Error::Input { place: of.into(), key, value, message },
            Engine::Several(errors) => Error::Several(errors.into_iter().map(Error::from).collect()),
            Engine::Unstable { step, what, grain } => Error::Unstable { step, what, grain },
            Engine::Failed { step, what } => Error::Failed { step, what },
        }
    }
}

impl Error {
    /// A wrong value at `key` of `place`.
    pub fn input(place: impl fmt::Display, key: impl Into<String>, value: Option<String>, message: impl Into<String>) -> Self {
        Error::Input { place: place.to_string(), key: key.into(), value, message: message.into() }
    }

    /// A failure to read `path`; for `map_err`.
    pub fn read(path: impl AsRef<Path>) -> impl FnOnce(io::Error) -> Error {
        let path = path.as_ref().to_path_buf();
        move |source| Error::Read { path, source }
    }

    /// A failure to write `path`; for `map_err`.
    pub fn write(path: impl AsRef<Path>) -> impl FnOnce(io::Error) -> Error {
        let path = path.as_ref().to_path_buf();
        move |source| Error::Write { path, source }
    }

    /// One error of a list; `Ok` when the list is empty.
    pub fn all(mut errors: Vec<Error>) -> Result<()> {
        match errors.len() {
            0 => Ok(()),
            1 => Err(errors.remove(0)),
            _ => Err(Error::Several(errors)),
        }
    }

    /// 1 the run failed, 2 the command, scene or data is wrong (nothing was started), 3 it has become unstable or left what is possible (its records are
    /// kept), 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Input { .. } | Error::Several(_) | Error::Read { .. } | Error::Exists { .. } | Error::Checkpoint { .. } => 2,
            Error::Other { .. } | Error::Busy { .. } => 2,
            Error::Figure { input, .. } => 1 + u8::from(*input),
            Error::Write { .. } | Error::Failed { .. } | Error::Campaign { .. } => 1,
            Error::Unstable { .. } | Error::Impossible { .. } => 3,
            Error::Interrupted { .. } | Error::Stopped { .. } => 130,
        }
    }
}

fn input_line(place: &str, key: &str, value: Option<&str>, message: &str) -> String {
    // an override states its own key and value
    if key.is_empty() || place.starts_with("--") {
        return format!("{place}: {message}");
    }
    match value {
        Some(value) => format!("{place}: {key} = {value}: {message}"),
        None => format!("{place}: {key}: {message}"),
    }
}

fn failures(failed: &[(PathBuf, String)]) -> String {
    failed.iter().map(|(out, reason)| format!("{}: {reason}\n", out.display())).collect()
}

fn lines(errors: &[Error]) -> String {
    let lines: Vec<String> = errors.iter().map(Error::to_string).collect();
    lines.join("\n")
}

fn reason(source: &io::Error) -> String {
    match source.kind() {
        io::ErrorKind::NotFound => "no such file".into(),
        io::ErrorKind::PermissionDenied => "not permitted".into(),
        io::ErrorKind::IsADirectory => "is a folder, not a file".into(),
        _ => source.to_string(),
    }
}

fn of_grain(grain: &Option<u64>) -> String {
    grain.map_or(String::new(), |id| format!(" (grain {id})"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_value_names_file_key_value_and_limit() {
        let e = Error::input("materials/coke.toml", "strength.m", Some("-2".into()), "must be > 0");
        assert_eq!(e.to_string(), "materials/coke.toml: strength.m = -2: must be > 0");
        assert_eq!(e.exit_code(), 2);
    }

    #[test]
    fn an_override_is_not_repeated() {
        let e = Error::input("--set a.b=3", "a.b", Some("3".into()), "must be at most 1");
        assert_eq!(e.to_string(), "--set a.b=3: must be at most 1");
    }

    #[test]
    fn one_error_of_a_list_stands_alone() {
        assert!(Error::all(vec![]).is_ok());
        let one = Error::all(vec![Error::input("f", "", None, "x")]).unwrap_err();
        assert!(matches!(one, Error::Input { .. }));
        let two = Error::all(vec![Error::input("f", "", None, "x"), Error::input("g", "", None, "y")]);
        assert_eq!(two.unwrap_err().to_string(), "f: x\ng: y");
    }
}
