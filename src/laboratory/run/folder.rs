//! The state of a run's folder, and the lock that keeps a second process out of it.

use super::files::{lacks_figures, summary};
use crate::error::{Error, Result};
use crate::model::Model;
use crate::record::{checkpoint, specimen};
use crate::scene::{self, RESOLVED, SPECIMEN, Scene};
use serde_json::Value;
use std::fs::{File, TryLockError};
use std::io::Write;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// What a folder holds of the run of a given scene ([`look`]).
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// No run.
    Nothing,
    /// A run of this scene, neither finished nor with a checkpoint: it has to begin again.
    Broken,
    /// A run of this scene with a checkpoint, from which it can be resumed.
    Unfinished,
    /// A run of this scene that lacks its figures only, with the content of its `summary.json`.
    Undrawn(Value),
    /// A finished run of this scene, with the content of its `summary.json`.
    Finished(Value),
    /// A run of this scene on which another process is at work.
    Busy,
    /// A run of another scene, with the first difference of the two.
    Other(String),
}

/// Whether the folder `out` holds a checkpoint, from which its run can be resumed.
pub fn resumable(out: &Path) -> bool {
    checkpoint::exists(out)
}

/// When the run in the folder `out` wrote its newest checkpoint; `None` where it has none.
pub fn last_checkpoint(out: &Path) -> Option<SystemTime> {
    out.join(checkpoint::FILE).metadata().and_then(|m| m.modified()).ok()
}

/// Finds out what the folder `out` holds of the run of `scene`.
///
/// # Errors
/// Files that exist and cannot be read.
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
    // shared: whoever looks at the same moment is no run
    let Ok(_free) = attempt(out, File::try_lock_shared) else { return Ok(Found::Busy) };
    if checkpoint::exists(out) {
        return Ok(Found::Unfinished);
    }
    Ok(match summary(out) {
        None => Found::Broken,
        Some(summary) if lacks_figures(&summary) => Found::Undrawn(summary),
        Some(summary) => Found::Finished(summary),
    })
}

/// The first line in which the resolved scene of the folder (`there`) differs from the `wanted` one, in words; `None` where they
/// are equal.
fn difference(there: &str, wanted: &str) -> Option<String> {
    // a scene whose writing was interrupted counts as equal: no run has begun from it
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

/// Whether a run began with the specimen of `file`: compares it with the run's `own` file. True as well where the run has not
/// written its specimen yet.
fn same_specimen(file: &Path, own: &Path, model: &Model) -> Result<bool> {
    if !own.exists() {
        return Ok(true);
    }
    let materials = &model.physics.materials;
    let places = |path: &Path| {
        Ok::<_, Error>(match model.rig.growth() {
            Some(growth) => specimen::read_grown(path, growth, materials)?.grains,
            None => specimen::read(path, materials)?.0.pos,
        })
    };
    Ok(places(file)? == places(own)?)
}

/// The lock on a run's folder. It ends when it is dropped or when the process ends, in whatever way.
#[derive(Debug)]
pub struct Lock {
    _file: Option<File>,
}

/// Locks the folder of a run, if it holds one. The lock is on `scene.resolved.toml` and makes no file of its own. On file systems
/// without locks nothing is locked. Waits for who only looks.
///
/// # Errors
/// [`Error::Busy`] when another process runs there, or has removed the file to begin a run.
pub fn lock(out: &Path) -> Result<Lock> {
    for _ in 0..LOOKS {
        if let Ok(lock) = attempt(out, File::try_lock) {
            return Ok(lock);
        }
        std::thread::sleep(LOOK);
    }
    attempt(out, File::try_lock)
}

/// Time in which a process has looked at a folder, and how often it is waited for.
const LOOK: Duration = Duration::from_millis(10);
const LOOKS: usize = 50;

/// Takes the lock that `kind` is, alone or shared.
fn attempt(out: &Path, kind: fn(&File) -> std::result::Result<(), TryLockError>) -> Result<Lock> {
    let path = out.join(RESOLVED);
    let Ok(file) = File::options().read(true).write(true).open(&path) else {
        return Ok(Lock { _file: None });
    };
    match kind(&file) {
        Err(TryLockError::WouldBlock) => Err(Error::Busy { path: out.into() }),
        Err(TryLockError::Error(_)) => Ok(Lock { _file: None }),
        Ok(()) if is_at(&file, &path) => Ok(Lock { _file: Some(file) }),
        Ok(()) => Err(Error::Busy { path: out.into() }),
    }
}

/// Whether an open file is the one at `path`: not where that was removed, or made anew, since the file was opened.
#[cfg(unix)]
pub fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), path.metadata()) {
        (Ok(ours), Ok(there)) => (ours.dev(), ours.ino()) == (there.dev(), there.ino()),
        _ => false,
    }
}

/// Nothing is known here; files that are open cannot be removed on this system.
#[cfg(not(unix))]
pub fn is_at(_: &File, _: &Path) -> bool {
    true
}

/// Makes the scene file of a new run in the folder `out`, with the text `resolved`, and locks it: of two processes that begin a run in one
/// folder at the same time one is refused.
///
/// # Errors
/// [`Error::Busy`] when another process has just begun a run there; a file that cannot be written.
pub fn begin(out: &Path, resolved: &str) -> Result<Lock> {
    let path = out.join(RESOLVED);
    match File::create_new(&path) {
        Err(e) if e.kind() == std::io::ErrorKind::AlreadyExists => Err(Error::Busy { path: out.into() }),
        Err(e) => Err(Error::write(&path)(e)),
        Ok(mut file) => {
            // taken before the first byte is there: who finds the file finds it locked
            let lock = lock(out)?;
            file.write_all(resolved.as_bytes()).and_then(|()| file.sync_all()).map_err(Error::write(&path))?;
            Ok(lock)
        }
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

    /// Of campaigns that look at one folder none takes another for the run, and the run waits for them.
    #[test]
    fn who_looks_is_no_run() {
        let dir = tempfile::tempdir().expect("folder");
        std::fs::write(dir.path().join(RESOLVED), "").expect("scene");
        let looks = attempt(dir.path(), File::try_lock_shared).expect("free");
        assert!(attempt(dir.path(), File::try_lock_shared).is_ok());
        assert!(attempt(dir.path(), File::try_lock).is_err());
        std::thread::scope(|scope| {
            let run = scope.spawn(|| lock(dir.path()));
            std::thread::sleep(3 * LOOK);
            drop(looks);
            assert!(run.join().expect("no panic").is_ok());
        });
        let _run = lock(dir.path()).expect("free");
        assert!(attempt(dir.path(), File::try_lock_shared).is_err(), "a run is seen by who looks");
    }

    /// What was opened before another process removed it says nothing about the run that this process then began.
    #[cfg(unix)]
    #[test]
    fn a_lock_on_a_file_that_is_gone_is_none() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join(RESOLVED);
        std::fs::write(&path, "").expect("scene");
        let old = File::open(&path).expect("opened");
        assert!(is_at(&old, &path));
        std::fs::remove_file(&path).expect("removed");
        assert!(!is_at(&old, &path));
        let _other = begin(dir.path(), "kind = 1").expect("free");
        assert!(!is_at(&old, &path));
    }
}
