//! What can go wrong when records are read or figures are written.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Result of a figure.
pub type Result<T> = std::result::Result<T, FigureError>;

/// Why no figure was drawn. Each message names the file and, where there is one, column and line.
#[derive(Debug, Error)]
pub enum FigureError {
    /// A file cannot be read or written.
    #[error("{path}: {message}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        message: String,
    },
    /// A table lacks a column.
    #[error("{path}: no column `{column}`; the file has {have}")]
    Column {
        /// The table.
        path: PathBuf,
        /// The missing column.
        column: String,
        /// The columns that the table has.
        have: String,
    },
    /// A cell of a table holds no number.
    #[error("{path}: line {line}, column `{column}`: `{value}` is not a number")]
    Number {
        /// The table.
        path: PathBuf,
        /// Line in the file, from 1.
        line: u64,
        /// Column of the cell.
        column: String,
        /// Content of the cell.
        value: String,
    },
    /// The records hold nothing that could be drawn, or hold something that is not allowed.
    #[error("{path}: {why}")]
    Nothing {
        /// The folder or file.
        path: PathBuf,
        /// What is missing or wrong.
        why: String,
    },
    /// A file of a user is not what it must be.
    #[error(transparent)]
    User(Box<laboratory::error::Error>),
    /// The drawing library failed.
    #[error("{path}: could not draw: {message}")]
    Draw {
        /// The figure.
        path: PathBuf,
        /// The library's reason.
        message: String,
    },
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

impl From<laboratory::error::Error> for FigureError {
    fn from(error: laboratory::error::Error) -> Self {
        Self::User(Box::new(error))
    }
}

impl From<FigureError> for laboratory::error::Error {
    fn from(error: FigureError) -> Self {
        if let FigureError::User(error) = error {
            return *error;
        }
        let input = !matches!(error, FigureError::Io { .. } | FigureError::Draw { .. });
        laboratory::error::Error::Figure { what: error.to_string(), input }
    }
}
