//! What can go wrong when records are read or figures are written.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Result of a figure.
pub type Result<T> = std::result::Result<T, FigureError>;

/// Each message names the file and, where there is one, the column or line.
#[derive(Debug, Error)]
pub enum FigureError {
    #[error("{path}: {message}")]
    Io { path: PathBuf, message: String },
    #[error("{path}: no column `{column}`; the file has {have}")]
    Column { path: PathBuf, column: String, have: String },
    #[error("{path}: line {line}, column `{column}`: `{value}` is not a number")]
    Number { path: PathBuf, line: u64, column: String, value: String },
    #[error("{path}: {why}")]
    Nothing { path: PathBuf, why: String },
    #[error("{path}: could not draw: {message}")]
    Draw { path: PathBuf, message: String },
}

impl FigureError {
    pub(super) fn io(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::Io { path: path.to_path_buf(), message: error.to_string() }
    }

    pub(super) fn draw(path: &Path, error: impl std::fmt::Display) -> Self {
        Self::Draw { path: path.to_path_buf(), message: error.to_string() }
    }

    pub(super) fn nothing(path: &Path, why: impl Into<String>) -> Self {
        Self::Nothing { path: path.to_path_buf(), why: why.into() }
    }
}

impl From<FigureError> for laboratory::error::Error {
    fn from(error: FigureError) -> Self {
        let input = !matches!(error, FigureError::Io { .. } | FigureError::Draw { .. });
        laboratory::error::Error::Figure { what: error.to_string(), input }
    }
}
