//! Checkpoints: the whole progress of a run in one file. A new checkpoint replaces the old one in a single operation of the file
//! system, so a run that is killed at any moment can go on from the last one, with the same bits.

use crate::error::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;

/// Name of the file in a run's folder.
pub const FILE: &str = "checkpoint.bin";
/// Beginning of every checkpoint; its number rises with every change of the format.
const MAGIC: &[u8] = b"comminute checkpoint 9\n";

/// Writes `progress` as the checkpoint of the folder `dir`.
///
/// # Errors
/// A file that cannot be written.
pub fn save<T: Serialize>(dir: &Path, progress: &T) -> Result<()> {
    let path = dir.join(FILE);
    let body =
        postcard::to_extend(progress, MAGIC.to_vec()).map_err(|e| Error::Checkpoint { path: path.clone(), what: e.to_string() })?;
    let temporary = dir.join("checkpoint.tmp");
    std::fs::write(&temporary, body).map_err(Error::write(&temporary))?;
    std::fs::rename(&temporary, &path).map_err(Error::write(&path))
}

/// Reads the checkpoint of the folder `dir`.
///
/// # Errors
/// A missing file; [`Error::Checkpoint`] for one of another version, or a damaged one.
pub fn load<T: DeserializeOwned>(dir: &Path) -> Result<T> {
    let path = dir.join(FILE);
    let bytes = std::fs::read(&path).map_err(Error::read(&path))?;
    let wrong = |what: String| Error::Checkpoint { path: path.clone(), what };
    let body = bytes.strip_prefix(MAGIC).ok_or_else(|| wrong("not a checkpoint of this version of comminute".into()))?;
    postcard::from_bytes(body).map_err(|e| wrong(format!("damaged ({e})")))
}

/// Removes the checkpoint of the folder `dir`, if there is one.
///
/// # Errors
/// A file that cannot be removed.
pub fn remove(dir: &Path) -> Result<()> {
    let path = dir.join(FILE);
    match std::fs::remove_file(&path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::write(&path)(e)),
        _ => Ok(()),
    }
}
