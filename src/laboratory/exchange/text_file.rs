//! Lines of numbers of other programs' files, with errors that name file and line.

use crate::error::{Error, Result};
use std::path::Path;

/// Longest file, bytes.
pub const LONGEST: u64 = 1 << 30;

/// A line of a file.
pub struct Line<'a> {
    path: &'a Path,
    number: usize,
    /// What stands there before any comment.
    pub text: &'a str,
}

impl<'a> Line<'a> {
    /// All lines of a text without what stands behind a `#`, but for the empty ones.
    pub fn all(path: &'a Path, text: &'a str) -> impl Iterator<Item = Line<'a>> {
        let line = |(k, text): (usize, &'a str)| Line { path, number: k + 1, text: text.split('#').next().unwrap_or("").trim() };
        text.lines().enumerate().map(line).filter(|line| !line.text.is_empty())
    }

    /// The error of this line.
    pub fn wrong(&self, message: impl Into<String>) -> Error {
        let shown: String = self.text.chars().take(60).collect();
        let place = format!("{} line {} (`{shown}`)", self.path.display(), self.number);
        Error::input(place, "", None, message)
    }

    /// The finite numbers of this line, of which there must be as many as one of `counts`; `allowed` says which.
    pub fn numbers(&self, counts: &[usize], allowed: &str) -> Result<Vec<f64>> {
        let read = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
        let numbers: Option<Vec<f64>> = self.text.split_whitespace().map(read).collect();
        numbers.filter(|n| counts.contains(&n.len())).ok_or_else(|| self.wrong(format!("must be {allowed}")))
    }

    /// A number of this line as a whole one from 1 on.
    pub fn whole(&self, x: f64, what: &str) -> Result<usize> {
        let whole = (1.0..=9e15).contains(&x) && x.fract() == 0.0;
        if whole { Ok(x as usize) } else { Err(self.wrong(format!("{what} must be a whole number from 1 on"))) }
    }
}
