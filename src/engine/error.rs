//! Errors of the engine: settings that are refused before a step, and steps that cannot be made.

use std::fmt;

/// Result of the engine's functions that can fail.
pub type Result<T> = std::result::Result<T, Error>;

/// A setting that is refused before a step, or a step that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Error {
    /// A setting has a value that is not allowed.
    #[error("{of}: {}{message}", setting(.key, .value.as_deref()))]
    Refused {
        /// Part of the engine that has the setting: `continuum` or `gpu`.
        of: &'static str,
        /// Name of the setting; empty when no single setting is to blame.
        key: String,
        /// Value of the setting, as text.
        value: Option<String>,
        /// Values that are allowed, or what to do instead.
        message: String,
    },
    /// Several errors at once, for instance all settings that are not allowed.
    #[error("{}", .0.iter().map(Error::to_string).collect::<Vec<_>>().join("\n"))]
    Several(Vec<Error>),
    /// The state has become meaningless: a number is not finite, or a grain or point has moved too far in one step.
    #[error("step {step}: {what}{}", .grain.map_or(String::new(), |id| format!(" (grain {id})")))]
    Unstable {
        /// The step that could not be made.
        step: u64,
        /// What is wrong with the state, and what can be changed.
        what: String,
        /// Identity of the grain to blame, if there is one.
        grain: Option<u64>,
    },
    /// The step cannot be made for another reason, such as a graphics device that was lost or bodies that come too close.
    #[error("step {step}: {what}")]
    Failed {
        /// The step that could not be made.
        step: u64,
        /// The reason.
        what: String,
    },
    /// What the graphics device could not do; the CPU can do the same work.
    #[error("{0}")]
    Device(Box<Error>),
}

impl Error {
    /// An [`Error::Refused`] from its parts.
    pub fn refused(of: &'static str, key: impl Into<String>, value: Option<String>, message: impl Into<String>) -> Self {
        Error::Refused { of, key: key.into(), value, message: message.into() }
    }

    /// Turns a list of errors into one result; `Ok` when the list is empty.
    ///
    /// # Errors
    /// The error of the list, or [`Error::Several`] if there are more than one.
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
