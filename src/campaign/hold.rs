//! Locks that keep campaigns in one folder out of each other's way.

use laboratory::error::{Error, Result};
#[cfg(unix)]
use laboratory::run::is_at;
use std::fs::{File, TryLockError};
use std::path::Path;

/// A lock on a folder or file. It ends when it is dropped, or when the process ends in whatever way.
#[derive(Debug)]
#[must_use = "the folder is free again when this is dropped"]
pub struct Hold {
    _file: Option<File>,
}

impl Hold {
    /// Takes the folder for a campaign that shares it with no other. The lock is on the folder itself and makes no file in it; where
    /// folders cannot be locked (some network file systems, Windows) nothing is locked.
    ///
    /// # Errors
    /// [`Error::Busy`] while another campaign has the folder; a folder that cannot be made.
    pub fn take(folder: &Path) -> Result<Hold> {
        let Some(file) = opened(folder)? else { return Ok(Hold { _file: None }) };
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(Error::Busy { path: folder.into() }),
            Err(TryLockError::Error(_)) => Ok(Hold { _file: None }),
            Ok(()) => Ok(Hold { _file: Some(file) }),
        }
    }

    /// Waits until no other campaign writes tables and figures into the folder, and takes it as [`Hold::take`] does.
    ///
    /// # Errors
    /// A folder that cannot be made.
    pub fn wait_for(folder: &Path) -> Result<Hold> {
        let file = opened(folder)?;
        Ok(Hold { _file: file.filter(|file| file.lock().is_ok()) })
    }

    /// Waits until no other process holds the file at `path`, which is made where there is none, and holds it. Network file systems that
    /// lock files but no folders lock this.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn wait_for_file(path: &Path) -> Result<Hold> {
        let file = File::options().create(true).append(true).open(path).map_err(Error::write(path))?;
        Ok(Hold { _file: file.lock().is_ok().then_some(file) })
    }
}

/// Makes the folder and opens it; `None` where folders cannot be opened.
fn opened(folder: &Path) -> Result<Option<File>> {
    std::fs::create_dir_all(folder).map_err(Error::write(folder))?;
    Ok(File::open(folder).ok())
}

/// Opens the log of a run, made where there is none, for the one process that is to make the run. `None` while another campaign has
/// it. The process of the run gets the open file, so that its lock lasts as long as the longer-lived of the two.
///
/// # Errors
/// A file that cannot be opened or made.
pub fn log(path: &Path) -> Result<Option<File>> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(Error::write(folder))?;
    let file = File::options().create(true).append(true).open(path).map_err(Error::write(path))?;
    Ok(alone(&file, path).then_some(file))
}

/// Locks a file, unless another process has; false as well where the file at `path` is a new one, as after the other process has
/// removed its own. Where files cannot be locked nothing is.
#[cfg(unix)]
fn alone(file: &File, path: &Path) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock)) && is_at(file, path)
}

/// Locks nothing: a lock of this system keeps the process of the run from writing as well.
#[cfg(not(unix))]
fn alone(_: &File, _: &Path) -> bool {
    true
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_taken_by_one_campaign_at_a_time_and_stays_empty() {
        let dir = tempfile::tempdir().expect("folder");
        let folder = dir.path().join("new/folder");
        let first = Hold::take(&folder).expect("free");
        assert!(matches!(Hold::take(&folder), Err(Error::Busy { path }) if path == folder));
        drop(first);
        drop(Hold::wait_for(&folder).expect("free again"));
        assert_eq!(folder.read_dir().expect("folder").count(), 0);
    }

    #[test]
    fn a_log_belongs_to_whoever_has_it_open_even_if_that_is_the_run_alone() {
        let dir = tempfile::tempdir().expect("folder");
        let path = dir.path().join("m-2.log");
        let ours = log(&path).expect("opened").expect("free");
        // what a process of the run has as its standard error
        let of_the_run = ours.try_clone().expect("the same open file");
        drop(ours);
        assert!(log(&path).expect("opened").is_none());
        drop(of_the_run);
        let stale = File::options().append(true).open(&path).expect("opened");
        std::fs::remove_file(&path).expect("removed");
        assert!(!alone(&stale, &path), "removed by the one who had it");
        assert!(log(&path).expect("opened").is_some());
    }
}
