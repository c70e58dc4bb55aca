//! Why a step could not be made, or was not begun.

use std::fmt;

/// The result of everything in the engine that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a step could not be made, or was not begun.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting or value is not allowed.
    #[error("{of}: {}{message}", setting(.key, .value.as_deref()))]
    Refused {
        /// What the setting is of: the continuum, the graphics device.
        of: &'static str,
        /// Its name; empty when the whole is meant.
        key: String,
        /// The value that it has.
        value: Option<String>,
        /// What is allowed.
        message: String,
    },
    /// Several settings are not allowed.
    #[error("{}", .0.iter().map(Error::to_string).collect::<Vec<_>>().join("\n"))]
    Several(Vec<Error>),
    /// The state left the range in which it means anything.
    #[error("step {step}: {what}{}", .grain.map_or(String::new(), |id| format!(" (grain {id})")))]
    Unstable {
        /// The step that could not be made.
        step: u64,
        /// What is wrong with the state.
        what: String,
        /// Persistent id of the grain, where one is to blame.
        grain: Option<u64>,
    },
    /// The step needs what there is not.
    #[error("step {step}: {what}")]
    Failed {
        /// The step that could not be made.
        step: u64,
        /// What is missing.
        what: String,
    },
}

impl Error {
    /// The value of setting `key` of `of` is not allowed.
    pub fn refused(of: &'static str, key: impl Into<String>, value: Option<String>, message: impl Into<String>) -> Self {
        Error::Refused { of, key: key.into(), value, message: message.into() }
    }

    /// All errors of a list as one; `Ok` when the list is empty.
    ///
    /// # Errors
    /// Those of the list.
    pub fn all(mut errors: Vec<Error>) -> Result<()> {
        match errors.len() {
            0 => Ok(()),
            1 => Err(errors.remove(0)),
            _ => Err(Error::Several(errors)),
        }
    }
}

fn setting(key: &str, value: Option<&str>) -> impl fmt::Display {
    match value {
        _ if key.is_empty() => String::new(),
        Some(value) => format!("{key} = {value}: "),
        None => format!("{key}: "),
    }
}
