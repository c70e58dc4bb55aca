//! The one error type of the laboratory. Every variant carries the values that it names: file, key, grain, step.
//!
//! Messages say what is wrong and what is allowed. They never name options of the command line: what a person types next is
//! added by the program from the variant.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

/// The result of everything in this crate that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// What the place of a value begins with that a caller has laid over the files ([`crate::scene::load`]); `key=value` follows.
pub(crate) const OVERRIDE: &str = "override ";

/// Words of every message about a file that could not be written: what failed for them says nothing about a scene.
pub const CANNOT_WRITE: &str = "cannot write";

/// Why nothing was started, or why a run ended.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scene, material, data file or override says something that is not allowed.
    #[error("{}", input_line(.place, .key, .value.as_deref(), .message))]
    Input {
        /// File (with a line where there is one), or `override key=value`.
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
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A file could not be written.
    #[error("{}: {CANNOT_WRITE}: {}", .path.display(), reason(.source))]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// The output folder holds results already, and the caller has not asked to overwrite them.
    #[error("{}: holds a run already", .path.display())]
    Exists {
        /// The folder.
        path: PathBuf,
    },
    /// The output folder holds a run of another scene, and the caller has not asked to overwrite it.
    #[error("{}: holds a run of another scene ({what})", .path.display())]
    Other {
        /// The folder.
        path: PathBuf,
        /// The first difference of the two scenes.
        what: String,
    },
    /// Another process is running in the folder, or a campaign.
    #[error("{}: another process is running there", .path.display())]
    Busy {
        /// The folder.
        path: PathBuf,
    },
    /// Some runs of a campaign failed; the others are done.
    #[error("{}{} of {of} runs failed", failures(.failed), .failed.len())]
    Campaign {
        /// Folder and reason of each.
        failed: Vec<(PathBuf, String)>,
        /// Runs of the campaign.
        of: usize,
    },
    /// Work that keeps nothing until it is done was stopped from outside (Ctrl-C, SIGTERM).
    #[error("stopped while {doing}; nothing of it is kept")]
    Cut {
        /// What was being done.
        doing: &'static str,
    },
    /// A campaign was stopped from outside (Ctrl-C, SIGTERM). Finished runs and the checkpoints of the others are kept, and
    /// the same call made again does what is left.
    #[error("{}stopped with {done} of {of} runs done{}; what is done is kept", failures(.failed), and_failed(.failed.len()))]
    Stopped {
        /// Folder and reason of each run that had failed before.
        failed: Vec<(PathBuf, String)>,
        /// Runs that are finished.
        done: usize,
        /// Runs of the campaign.
        of: usize,
    },
    /// A number of the state is not finite, or out of the range in which the method is valid.
    #[error("step {step}: {what}{}", of_grain(.grain))]
    Unstable {
        /// The step that found it.
        step: u64,
        /// What is wrong and what to change.
        what: String,
        /// Persistent id of the grain, where one is to blame.
        grain: Option<u64>,
    },
    /// A test shows something that is physically impossible: energy from nothing, opposite platens out of balance, or solids
    /// that fill more than the whole volume. The records so far are kept.
    #[error("step {step}: {what}")]
    Impossible {
        /// The step that found it.
        step: u64,
        /// What is wrong and what to change.
        what: String,
    },
    /// A test does not come to what the scene asks for: a stress, or rest. The records so far are kept.
    #[error("step {step}: {what}")]
    Stalled {
        /// The step at which it was given up.
        step: u64,
        /// What was not reached, the likely cause, and what to change.
        what: String,
    },
    /// The run could not be prepared, such as a specimen that does not come to rest.
    #[error("step {step}: {what}")]
    Failed {
        /// The step at which it was given up; 0 where there was none yet.
        step: u64,
        /// What was not reached.
        what: String,
    },
    /// What a graphics device could not do; the CPU can do the same work ([`crate::run::Backend::Cpu`]).
    #[error("{0}")]
    Device(Box<Error>),
    /// A checkpoint that cannot be continued.
    #[error("{}: cannot be resumed: {what}", .path.display())]
    Checkpoint {
        /// The checkpoint, or the folder of the run.
        path: PathBuf,
        /// Why not.
        what: String,
    },
    /// Figures could not be drawn from the records.
    #[error("{what}")]
    Figure {
        /// What is wrong, with the file.
        what: String,
        /// True: the records or data asked for are wrong. False: a file could not be written.
        input: bool,
    },
    /// The run was stopped from outside (Ctrl-C, SIGTERM) or at the step that the caller asked for. Its checkpoint is kept (a
    /// batch of single grains has none and begins again), and [`crate::run::resume`] continues it.
    #[error("{}: interrupted at step {step}", .out.display())]
    Interrupted {
        /// Steps done.
        step: u64,
        /// The folder of the run.
        out: PathBuf,
    },
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
            Engine::Device(error) => Error::from(*error).on_device(),
        }
    }
}

impl Error {
    /// A wrong value at `key` of `place`.
    pub fn input(place: impl fmt::Display, key: impl Into<String>, value: Option<String>, message: impl Into<String>) -> Self {
        Error::Input { place: place.to_string(), key: key.into(), value, message: message.into() }
    }

    /// This error as one that only a graphics device has ([`Error::Device`]).
    pub(crate) fn on_device(self) -> Self {
        Error::Device(Box::new(self))
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

    /// All errors of a list as one; `Ok` when the list is empty.
    ///
    /// # Errors
    /// The only error of the list, or [`Error::Several`].
    pub fn all(mut errors: Vec<Error>) -> Result<()> {
        match errors.len() {
            0 => Ok(()),
            1 => Err(errors.remove(0)),
            _ => Err(Error::Several(errors)),
        }
    }

    /// Exit code for a program that ends with this error: 1 the run failed; 2 the call, scene or data is wrong and nothing was
    /// started; 3 the run became unstable, physically impossible, or
    /// came to a standstill (its records are kept); 130 stopped from outside.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Device(error) => error.exit_code(),
            Error::Input { .. } | Error::Several(_) | Error::Read { .. } | Error::Exists { .. } | Error::Checkpoint { .. } => 2,
            Error::Other { .. } | Error::Busy { .. } => 2,
            Error::Figure { input, .. } => 1 + u8::from(*input),
            Error::Write { .. } | Error::Failed { .. } | Error::Campaign { .. } => 1,
            Error::Unstable { .. } | Error::Impossible { .. } | Error::Stalled { .. } => 3,
            Error::Interrupted { .. } | Error::Stopped { .. } | Error::Cut { .. } => 130,
        }
    }
}

fn input_line(place: &str, key: &str, value: Option<&str>, message: &str) -> String {
    // the place of an override states its key and value already
    if key.is_empty() || place.starts_with(OVERRIDE) {
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

fn and_failed(count: usize) -> String {
    if count == 0 { String::new() } else { format!(" and {count} failed") }
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
        let e = Error::input("override a.b=3", "a.b", Some("3".into()), "must be at most 1");
        assert_eq!(e.to_string(), "override a.b=3: must be at most 1");
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
