//! What the folder of a run holds, and the lock that keeps a second process out of it.

use super::files::SUMMARY;
use crate::error::{Error, Result};
use crate::model::Model;
use crate::record::{checkpoint, specimen};
use crate::scene::{self, RESOLVED, SPECIMEN, Scene};
use serde_json::Value;
use std::fs::{File, TryLockError};
use std::path::Path;

/// A folder, seen by somebody who wants to run a scene there.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// No run.
    Nothing,
    /// This scene, neither finished nor with a checkpoint: it has to begin again.
    Broken,
    /// This scene, with a checkpoint to go on from.
    Unfinished,
    /// This scene, finished, with its `summary.json`.
    Finished(Value),
    /// This scene, and another process is running it.
    Busy,
    /// A run of another scene; says what differs.
    Other(String),
}

/// Looks what `out` holds of the run of `scene`.
///
/// # Errors
/// Files that are there and cannot be read.
pub fn look(out: &Path, scene: &Scene, model: &Model) -> Result<Found> {
    let path = out.join(RESOLVED);
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Found::Nothing),
        Err(source) => return Err(Error::Read { path, source }),
    };
    if let Some(what) = difference(&text, &scene::resolved(scene)) {
        return Ok(Found::Other(what));
    }
    if let Some(file) = scene.specimen()
        && !same_specimen(&file, &out.join(SPECIMEN), model)?
    {
        return Ok(Found::Other(format!("it began with another specimen than {}", file.display())));
    }
    if lock(out).is_err() {
        return Ok(Found::Busy);
    }
    if out.join(checkpoint::FILE).exists() {
        return Ok(Found::Unfinished);
    }
    let summary = std::fs::read_to_string(out.join(SUMMARY)).ok();
    // a summary that was cut short while it was written is none
    let summary = summary.and_then(|text| serde_json::from_str(&text).ok());
    Ok(summary.map_or(Found::Broken, Found::Finished))
}

/// The first line in which two resolved scenes differ.
fn difference(there: &str, wanted: &str) -> Option<String> {
    // a scene that was cut short while it was written is the beginning of one: nothing was run from it
    if there == wanted || (wanted.starts_with(there) && !there.ends_with('\n')) {
        return None;
    }
    let mut table = "";
    let mut lines = (there.lines(), wanted.lines());
    loop {
        match (lines.0.next(), lines.1.next()) {
            (Some(a), Some(b)) if a == b => {
                if a.starts_with('[') {
                    table = a;
                }
            }
            (None, None) => return None,
            (a, b) => {
                let shown = |line: Option<&str>| line.filter(|l| !l.is_empty()).unwrap_or("nothing").to_string();
                let table = if table.is_empty() { String::new() } else { format!("{table} ") };
                return Some(format!("{table}{} there, {} here", shown(a), shown(b)));
            }
        }
    }
}

/// Whether a run began with the specimen of `file`; a run that has not yet written its specimen is taken to.
fn same_specimen(file: &Path, own: &Path, model: &Model) -> Result<bool> {
    if !own.exists() {
        return Ok(true);
    }
    let (a, b) = (specimen::read(file, &model.physics.materials)?.0, specimen::read(own, &model.physics.materials)?.0);
    Ok(a.pos == b.pos)
}

/// Held while a process runs in a folder; let go when it is dropped or the process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    _file: Option<File>,
}

/// Takes the folder of a run, if it holds one. The lock is on `scene.resolved.toml`, so that it leaves no file of its own. File
/// systems without locks let everybody in.
///
/// # Errors
/// [`Error::Busy`] when another process runs there.
pub fn lock(out: &Path) -> Result<Lock> {
    let Ok(file) = File::options().read(true).write(true).open(out.join(RESOLVED)) else {
        return Ok(Lock { _file: None });
    };
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Error::Busy { path: out.into() }),
        Err(TryLockError::Error(_)) => Ok(Lock { _file: None }),
        Ok(()) => Ok(Lock { _file: Some(file) }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_difference_names_its_table_and_both_values() {
        let (a, b) = ("kind = 1\n[loading]\nrate = 1\n", "kind = 1\n[loading]\nrate = 2\n");
        assert_eq!(difference(a, a), None);
        assert_eq!(difference(a, b).as_deref(), Some("[loading] rate = 1 there, rate = 2 here"));
        assert_eq!(difference("", a), None, "cut short before the first byte");
        assert_eq!(difference("kind = 1\n[load", a), None);
        assert_eq!(difference("kind = 1\n", a).as_deref(), Some("nothing there, [loading] here"));
    }

    #[test]
    fn a_folder_is_taken_once_at_a_time() {
        let dir = tempfile::tempdir().expect("folder");
        assert!(lock(dir.path()).is_ok(), "there is nothing to take");
        std::fs::write(dir.path().join(RESOLVED), "").expect("scene");
        let first = lock(dir.path()).expect("free");
        assert!(matches!(lock(dir.path()), Err(Error::Busy { .. })));
        drop(first);
        assert!(lock(dir.path()).is_ok());
    }
}
