//! The folders of the runs that a report shows.

use laboratory::error::{Error, Result};
use laboratory::run::FAILED;
use laboratory::scene::RESOLVED;
use std::path::{Path, PathBuf};

/// The folders of runs that `dirs` stand for: those that hold a run, and of others the folders in them that do, in the order of their
/// names (numbers in them by value).
///
/// # Errors
/// A folder without a run; none at all.
pub fn runs(dirs: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut found: Vec<PathBuf> = Vec::new();
    for dir in dirs {
        let refused = |message: String| Err(Error::input(dir.display(), "", None, message));
        if !dir.is_dir() {
            return refused("is no folder".into());
        }
        let inner = if is_run(dir) { vec![dir.clone()] } else { below(dir)? };
        if inner.is_empty() && dir.join(FAILED).is_file() {
            return refused(format!("holds a run that failed before its test began; {FAILED} there says why"));
        }
        if inner.is_empty() {
            return refused(format!("holds no run: no {RESOLVED} in it or in its folders"));
        }
        found.extend(inner.into_iter().filter(|run| !found.contains(run)).collect::<Vec<PathBuf>>());
    }
    match found.is_empty() {
        true => Err(Error::input("report", "", None, "needs the folder of a run")),
        false => Ok(found),
    }
}

fn is_run(dir: &Path) -> bool {
    dir.join(RESOLVED).is_file()
}

/// The runs in the folders of `dir`.
fn below(dir: &Path) -> Result<Vec<PathBuf>> {
    let entries = dir.read_dir().map_err(Error::read(dir))?;
    let mut inner: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(|path| is_run(path)).collect();
    inner.sort_by_key(|path| natural(&path.file_name().unwrap_or_default().to_string_lossy()));
    Ok(inner)
}

/// A key that sorts `seed-2` before `seed-10`: the text with every number padded.
fn natural(name: &str) -> String {
    let mut key = String::new();
    for (i, part) in name.split_inclusive(|c: char| !c.is_ascii_digit()).enumerate() {
        let digits = part.trim_end_matches(|c: char| !c.is_ascii_digit());
        let rest = &part[digits.len()..];
        if i > 0 || !digits.is_empty() {
            key += &format!("{digits:0>20}");
        }
        key += rest;
    }
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(path: &Path) {
        std::fs::create_dir_all(path).expect("folder");
        std::fs::write(path.join(RESOLVED), "").expect("scene");
    }

    #[test]
    fn an_ensemble_stands_for_its_runs_in_the_order_of_their_numbers() {
        let dir = tempfile::tempdir().expect("folder");
        for name in ["seed-10", "seed-2", "seed-1"] {
            run(&dir.path().join(name));
        }
        std::fs::create_dir(dir.path().join("figures")).expect("folder");
        let found = runs(&[dir.path().to_path_buf(), dir.path().join("seed-2")]).expect("runs");
        let names: Vec<_> = found.iter().map(|p| p.file_name().expect("name").to_string_lossy().into_owned()).collect();
        assert_eq!(names, ["seed-1", "seed-2", "seed-10"]);
    }

    #[test]
    fn folders_without_runs_are_named() {
        let dir = tempfile::tempdir().expect("folder");
        let says = |dirs: &[PathBuf]| runs(dirs).expect_err("refused").to_string();
        assert!(says(&[dir.path().to_path_buf()]).contains("holds no run"));
        assert!(says(&[dir.path().join("absent")]).contains("absent: is no folder"));
        std::fs::write(dir.path().join(FAILED), "").expect("written");
        assert!(says(&[dir.path().to_path_buf()]).contains("failed before its test began"));
        assert!(says(&[]).contains("needs the folder of a run"));
    }
}
