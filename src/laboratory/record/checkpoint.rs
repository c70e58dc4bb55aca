//! Checkpoints: the whole progress of a run in one file, so that a run that is killed at any moment goes on from the last one with
//! the same bits.
//!
//! A file is a line that names the format, a head and the content (postcard, compressed with LZ4). The head ties the content to
//! the scene of the run and to itself by SHA-256, and everything is verified before anything is decoded. The decoded progress is
//! checked against the model of the scene before anything of it is used, so that a file with right hashes and a content that no
//! run has written is refused too. A new file is written beside the old one, brought to the disk and renamed; the old one is kept as
//! the previous checkpoint, from which a run goes on if the newest cannot be used.
//!
//! Reading asks for no more memory than a multiple of the file: the content is at most 255 times as long, and a list in it
//! grows with the entries that are really there, whatever length it states (serde makes room for a megabyte at most beforehand).

use crate::error::{Error, Result};
use crate::scene::RESOLVED;
use engine::check::Checked;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::Write;
use std::path::Path;

/// Name of the newest checkpoint in a run's folder.
pub const FILE: &str = "checkpoint.bin";
/// Name of the checkpoint before it.
pub const PREVIOUS: &str = "checkpoint.previous.bin";
/// Name of a checkpoint that is being written.
pub const TEMPORARY: &str = "checkpoint.tmp";
/// First line of every checkpoint; its number rises with every change of the format.
const FORMAT: &[u8] = b"comminute checkpoint 21\n";
/// What the first line of a checkpoint of any format begins with.
const ANY_FORMAT: &[u8] = b"comminute checkpoint ";
/// Largest factor by which LZ4 can shrink anything: a longer content is a lie.
const LZ4_MOST: u64 = 255;

/// What stands before the content; written as it is here, little endian.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Head {
    /// SHA-256 of the rest of the head and of the compressed content.
    own: [u8; 32],
    /// SHA-256 of the run's scene file.
    scene: [u8; 32],
    /// Length of the content before it was compressed, bytes.
    length: [u8; 8],
    /// Length of the compressed content, bytes.
    compressed: [u8; 8],
}

/// Length of a [`Head`] in a file, bytes.
const HEAD: usize = 32 + 32 + 8 + 8;

impl Head {
    fn of(scene: [u8; 32], length: usize, compressed: &[u8]) -> Head {
        let mut head = Head {
            own: [0; 32],
            scene,
            length: (length as u64).to_le_bytes(),
            compressed: (compressed.len() as u64).to_le_bytes(),
        };
        head.own = head.hash(compressed);
        head
    }

    fn hash(&self, compressed: &[u8]) -> [u8; 32] {
        let parts: [&[u8]; 4] = [&self.scene, &self.length, &self.compressed, compressed];
        parts.into_iter().fold(Sha256::new(), Sha256::chain_update).finalize().into()
    }
}

/// SHA-256 of the scene file of the run in `dir`.
fn scene_hash(dir: &Path) -> Result<[u8; 32]> {
    let path = dir.join(RESOLVED);
    Ok(Sha256::digest(std::fs::read(&path).map_err(Error::read(&path))?).into())
}

/// Writes `progress` as the newest checkpoint of the folder `dir`; the newest so far becomes the previous one.
///
/// # Errors
/// A file that cannot be written; the checkpoints so far are kept.
pub fn save<T: Serialize>(dir: &Path, progress: &T) -> Result<()> {
    let (path, temporary) = (dir.join(FILE), dir.join(TEMPORARY));
    let wrong = |what: String| Error::Checkpoint { path: path.clone(), what };
    let content = postcard::to_stdvec(progress).map_err(|e| wrong(e.to_string()))?;
    let compressed = lz4_flex::block::compress(&content);
    let scene = scene_hash(dir).map_err(|e| match e {
        // the folder is gone
        Error::Read { source, .. } => Error::Write { path: path.clone(), source },
        other => other,
    })?;
    let head = postcard::to_stdvec(&Head::of(scene, content.len(), &compressed)).map_err(|e| wrong(e.to_string()))?;
    // what a killed process has left is not written into: it might be a link to another file
    remove_file(&temporary)?;
    let write = || {
        let mut file = File::create_new(&temporary)?;
        [FORMAT, &head[..], &compressed[..]].into_iter().try_for_each(|part| file.write_all(part))?;
        file.sync_all()
    };
    write().map_err(Error::write(&temporary))?;
    match std::fs::rename(&path, dir.join(PREVIOUS)) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::write(&path)(e)),
        _ => {}
    }
    std::fs::rename(&temporary, &path).map_err(Error::write(&path))?;
    // names reach the disk with their folder; not every system can open one
    let _ = File::open(dir).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Whether the folder `dir` has a checkpoint.
pub fn exists(dir: &Path) -> bool {
    [FILE, PREVIOUS].iter().any(|name| dir.join(name).exists())
}

/// Reads the newest checkpoint of the folder `dir` that is whole and stands the `check`, which says what is wrong with a progress. The
/// second value says what is wrong with the newest, if something is. Nothing is where it is not there: a process that is killed while
/// [`save`] gives the names leaves the previous one alone.
///
/// # Errors
/// A missing file; [`Error::Checkpoint`] for one of another version or another scene, or if all are damaged.
pub fn load<T: DeserializeOwned>(dir: &Path, check: impl Fn(&T) -> Checked) -> Result<(T, Option<Error>)> {
    match read(&dir.join(FILE), dir, &check) {
        Ok(progress) => Ok((progress, None)),
        Err(newest) => match read(&dir.join(PREVIOUS), dir, &check) {
            Ok(progress) => Ok((progress, Some(newest).filter(|why| !missing(why)))),
            Err(_) => Err(newest),
        },
    }
}

/// Whether a file could not be read because it is not there.
fn missing(why: &Error) -> bool {
    matches!(why, Error::Read { source, .. } if source.kind() == std::io::ErrorKind::NotFound)
}

/// The content of one checkpoint, if it is whole and stands the check.
fn read<T: DeserializeOwned>(path: &Path, dir: &Path, check: &impl Fn(&T) -> Checked) -> Result<T> {
    let bytes = std::fs::read(path).map_err(Error::read(path))?;
    let wrong = |what: String| Error::Checkpoint { path: path.into(), what };
    let damaged = |what: &str| wrong(format!("damaged ({what})"));
    let Some(body) = bytes.strip_prefix(FORMAT) else {
        return Err(if bytes.starts_with(ANY_FORMAT) {
            wrong("of another version of comminute".into())
        } else {
            damaged("it does not begin as a checkpoint")
        });
    };
    let (head, compressed) = body.split_at_checked(HEAD).ok_or_else(|| damaged("it is cut short"))?;
    let head: Head = postcard::from_bytes(head).map_err(|e| damaged(&e.to_string()))?;
    let [length, compressed_length] = [head.length, head.compressed].map(u64::from_le_bytes);
    if compressed_length != compressed.len() as u64 {
        return Err(damaged(&format!("its content has {} bytes instead of {compressed_length}", compressed.len())));
    }
    if head.own != head.hash(compressed) {
        return Err(damaged("its bytes are not those that were written"));
    }
    if head.scene != scene_hash(dir)? {
        return Err(wrong(format!("{RESOLVED} is not the scene that it was written for")));
    }
    if length > LZ4_MOST * compressed_length {
        return Err(damaged("its content is longer than possible"));
    }
    let content = lz4_flex::block::decompress(compressed, length as usize).map_err(|e| damaged(&e.to_string()))?;
    let (progress, rest): (T, &[u8]) = postcard::take_from_bytes(&content).map_err(|e| damaged(&e.to_string()))?;
    if !rest.is_empty() {
        return Err(damaged(&format!("{} bytes too many", rest.len())));
    }
    check(&progress).map_err(|what| damaged(&what))?;
    Ok(progress)
}

/// Removes the checkpoints of the folder `dir`, if there are any.
///
/// # Errors
/// A file that cannot be removed.
pub fn remove(dir: &Path) -> Result<()> {
    // the newest goes last: a process killed on the way leaves it
    [TEMPORARY, PREVIOUS, FILE].iter().try_for_each(|name| remove_file(&dir.join(name)))
}

fn remove_file(path: &Path) -> Result<()> {
    match std::fs::remove_file(path) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::write(path)(e)),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    type Progress = (u64, Vec<f64>, String);

    /// A folder with two checkpoints, of step 1 and of step 2.
    fn folder() -> tempfile::TempDir {
        let dir = tempfile::tempdir().expect("folder");
        std::fs::write(dir.path().join(RESOLVED), "kind = \"oedometer\"\n").expect("scene");
        for step in [1, 2] {
            save(dir.path(), &progress(step)).expect("saved");
        }
        dir
    }

    fn progress(step: u64) -> Progress {
        (step, (0..500).map(|k| (k as f64).sqrt()).collect(), "loading".into())
    }

    fn loaded(dir: &Path) -> Result<(Progress, Option<Error>)> {
        load(dir, |_| Ok(()))
    }

    #[test]
    fn what_was_saved_last_is_loaded() {
        let dir = folder();
        let (there, why) = loaded(dir.path()).expect("whole");
        assert_eq!(there, progress(2));
        assert!(why.is_none());
        remove(dir.path()).expect("removed");
        assert!(!exists(dir.path()) && loaded(dir.path()).is_err());
    }

    /// Any byte changed, any cut and any byte more is noticed, and the run goes on from the previous checkpoint; if that is damaged too, the run is refused.
    #[test]
    fn a_damaged_checkpoint_is_never_taken() {
        let dir = folder();
        let path = dir.path().join(FILE);
        let whole = std::fs::read(&path).expect("bytes");
        let mut damages: Vec<Vec<u8>> = (0..whole.len()).step_by(7).map(|n| whole[..n].to_vec()).collect();
        damages.extend((0..whole.len()).map(|k| {
            let mut bytes = whole.clone();
            bytes[k] ^= 1 << (k % 8);
            bytes
        }));
        damages.push([&whole[..], &[0]].concat());
        for bytes in damages {
            std::fs::write(&path, &bytes).expect("damaged");
            let (there, why) = loaded(dir.path()).expect("the previous one");
            assert_eq!(there, progress(1));
            assert!(matches!(why, Some(Error::Checkpoint { .. })));
        }
        std::fs::write(dir.path().join(PREVIOUS), "nothing").expect("damaged");
        let told = loaded(dir.path()).expect_err("both damaged").to_string();
        assert!(told.contains(FILE) && told.contains("damaged"), "{told}");
    }

    #[test]
    fn a_checkpoint_of_another_scene_is_refused() {
        let dir = folder();
        std::fs::write(dir.path().join(RESOLVED), "kind = \"triaxial\"\n").expect("scene");
        let told = loaded(dir.path()).expect_err("another scene").to_string();
        assert!(told.contains("is not the scene that it was written for"), "{told}");
    }

    /// A content of the wrong type, or a length that would need more memory than any content can fill, has right hashes and is refused all the same.
    #[test]
    fn a_forged_checkpoint_is_refused() {
        let dir = folder();
        remove(dir.path()).expect("removed");
        save(dir.path(), &"only a text").expect("saved");
        assert!(loaded(dir.path()).is_err());
        let compressed = lz4_flex::block::compress(&[0; 100]);
        let head = Head::of(scene_hash(dir.path()).expect("scene"), usize::MAX / 2, &compressed);
        let bytes = [FORMAT, &postcard::to_stdvec(&head).expect("head")[..], &compressed[..]].concat();
        std::fs::write(dir.path().join(FILE), bytes).expect("forged");
        let told = loaded(dir.path()).expect_err("forged").to_string();
        assert!(told.contains("longer than possible"), "{told}");
    }

    /// A whole checkpoint whose content no run has written is passed over like a damaged one, and the error names what is wrong.
    #[test]
    fn a_checkpoint_that_does_not_stand_the_check_is_passed_over() {
        let dir = folder();
        let check = |past: u64| move |p: &Progress| engine::check::ensure(p.0 < past, || format!("step {}", p.0));
        let (there, why) = load(dir.path(), check(2)).expect("the previous one");
        assert_eq!(there, progress(1));
        assert!(why.expect("a reason").to_string().ends_with("damaged (step 2)"));
        assert!(load(dir.path(), check(1)).is_err());
    }

    #[test]
    fn a_process_killed_between_two_names_leaves_the_previous_checkpoint() {
        let dir = folder();
        std::fs::rename(dir.path().join(FILE), dir.path().join(TEMPORARY)).expect("killed");
        assert!(exists(dir.path()));
        let (there, why) = loaded(dir.path()).expect("the previous one");
        assert!(there == progress(1) && why.is_none(), "{why:?}");
        save(dir.path(), &progress(3)).expect("goes on");
        assert_eq!(loaded(dir.path()).expect("whole").0, progress(3));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_the_place_of_a_checkpoint_is_not_followed() {
        let dir = folder();
        let victim = dir.path().join("victim");
        std::fs::write(&victim, "of somebody else").expect("written");
        std::os::unix::fs::symlink(&victim, dir.path().join(TEMPORARY)).expect("link");
        save(dir.path(), &progress(3)).expect("saved");
        assert_eq!(std::fs::read_to_string(&victim).expect("text"), "of somebody else");
        assert_eq!(loaded(dir.path()).expect("whole").0, progress(3));
    }
}
