//! Files of the user's cache: what is measured once, and holds until the program, the machine or the grains change. Each says on what it
//! depends, as a text, and is not read for another text.

use crate::record::specimen::checksum;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The content of a file.
#[derive(Serialize, Deserialize)]
struct Kept<T> {
    /// Everything that the value depends on: tells two apart whose file names are equal by chance.
    of: String,
    value: T,
}

/// The value of a kind, as in `range`, that was kept for the text `of`; `None` where there is none.
pub(crate) fn read<T: DeserializeOwned>(kind: &str, of: &str) -> Option<T> {
    let text = std::fs::read_to_string(file(kind, of)?).ok()?;
    let kept: Kept<T> = serde_json::from_str(&text).ok()?;
    (kept.of == of).then_some(kept.value)
}

/// Keeps a value. Without a cache that can be written nothing is kept, and it has to be measured again.
pub(crate) fn keep<T: Serialize>(kind: &str, of: &str, value: T) {
    if let Some(path) = file(kind, of) {
        let _ = write(&path, &Kept { of: of.into(), value });
    }
}

/// File of a value: in the folder of the environment variable `COMMINUTE_CACHE`, or in `comminute` below the user's folder for
/// caches; `None` where there is no such folder.
fn file(kind: &str, of: &str) -> Option<PathBuf> {
    let of_system = || {
        let own = |key: &str| std::env::var_os(key).filter(|v| !v.is_empty()).map(PathBuf::from);
        let base = own("XDG_CACHE_HOME").or_else(|| own("LOCALAPPDATA")).or_else(|| own("HOME").map(|home| home.join(".cache")));
        base.map(|base| base.join("comminute"))
    };
    let folder = std::env::var_os("COMMINUTE_CACHE").map(PathBuf::from).or_else(of_system)?;
    Some(folder.join(format!("{kind}-{:016x}.json", checksum(of))))
}

/// Writes a file. It gets its name when it is complete, so a process that is killed leaves no broken file.
fn write<T: Serialize>(path: &Path, kept: &Kept<T>) -> std::io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let unfinished = path.with_extension(format!("{}.tmp", std::process::id()));
    std::fs::write(&unfinished, serde_json::to_string_pretty(kept)?)?;
    std::fs::rename(&unfinished, path)
}
