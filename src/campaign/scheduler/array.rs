//! What a campaign's folder remembers of each array that was submitted to a scheduler: a folder with the runs of its elements.

use super::super::job::shell_word;
use laboratory::error::{Error, Result};
use laboratory::record::specimen::checksum;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// An array of runs. Its elements are numbered from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Array {
    /// Its folder.
    pub folder: PathBuf,
    /// What is in its file.
    pub told: Told,
}

/// Content of an array's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Told {
    /// Name by which the scheduler knows it: no other array of the cluster has it.
    pub name: String,
    /// Number that the scheduler has given to it; `None` until it has.
    pub job: Option<String>,
    /// Folder of the run of each element, absolute.
    pub runs: Vec<PathBuf>,
}

/// File that tells what an array is.
const FILE: &str = "array.json";
/// Script that each element runs, and the script with the command of each run.
const SCRIPT: (&str, &str) = ("array.sh", include_str!("array.sh"));
const RUNS: &str = "runs.sh";

/// The arrays of the folder `dir`, in the order in which they were made.
///
/// # Errors
/// A file that cannot be read.
pub fn all(dir: &Path) -> Result<Vec<Array>> {
    let mut arrays = Vec::new();
    for number in numbers(dir)? {
        let folder = dir.join(number.to_string());
        let path = folder.join(FILE);
        let text = match std::fs::read_to_string(&path) {
            Ok(text) => text,
            // a call was killed before it submitted the array
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => continue,
            Err(source) => return Err(Error::Read { path, source }),
        };
        let told = serde_json::from_str(&text).map_err(|e| Error::input(path.display(), "", None, e.to_string()))?;
        arrays.push(Array { folder, told });
    }
    Ok(arrays)
}

/// Numbers of the folders of arrays, in order.
fn numbers(dir: &Path) -> Result<Vec<u64>> {
    let entries = dir.read_dir().map_err(Error::read(dir))?;
    let mut numbers: Vec<u64> = entries.flatten().filter_map(|e| e.file_name().to_str()?.parse().ok()).collect();
    numbers.sort_unstable();
    Ok(numbers)
}

/// A run of an array that is to be made.
pub struct Element {
    /// Its command line for a shell, in the working directory.
    pub line: String,
    /// Its folder, absolute.
    pub out: PathBuf,
    /// File for what it says, in the working directory.
    pub log: PathBuf,
}

impl Array {
    /// Writes the folder of an array that is to be submitted, the next of `dir`; `cwd` is the working directory of its command lines.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(dir: &Path, elements: &[Element], cwd: &Path) -> Result<Array> {
        let number = numbers(dir)?.last().map_or(1, |last| last + 1);
        let folder = dir.join(number.to_string());
        std::fs::create_dir(&folder).map_err(Error::write(&folder))?;
        let name = format!("comminute-{:08x}-{number}", checksum(&dir.to_string_lossy()) >> 32);
        let array = Array { folder, told: Told { name, job: None, runs: elements.iter().map(|e| e.out.clone()).collect() } };
        let word = |path: &Path| shell_word(&path.to_string_lossy());
        let mut runs = format!(
            "# Makes the run whose number is the first word, or what is left of it.\ncd {} || exit 1\ncase \"$1\" in\n",
            word(cwd)
        );
        for (i, element) in elements.iter().enumerate() {
            // writing to a String does not fail
            let _ = writeln!(runs, "{})\n    exec {} 2>{}\n    ;;", i + 1, element.line, word(&element.log));
        }
        runs += "esac\n";
        for (file, text) in [(RUNS, runs.as_str()), SCRIPT] {
            let path = array.folder.join(file);
            std::fs::write(&path, text).map_err(Error::write(&path))?;
        }
        array.save()?;
        Ok(array)
    }

    /// Writes its file, whole or not at all.
    fn save(&self) -> Result<()> {
        let (path, new) = (self.folder.join(FILE), self.folder.join("array.new"));
        let text = serde_json::to_string_pretty(&self.told).unwrap_or_default();
        std::fs::write(&new, text + "\n").and_then(|()| std::fs::rename(&new, &path)).map_err(Error::write(&path))
    }

    /// Remembers the number that the scheduler has given to it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn submitted(&mut self, job: String) -> Result<()> {
        self.told.job = Some(job);
        self.save()
    }

    /// Forgets an array that was not submitted.
    pub fn remove(self) {
        let _ = std::fs::remove_dir_all(self.folder);
    }

    /// Number of the element that makes the run in the folder `out`.
    pub fn element(&self, out: &Path) -> Option<usize> {
        self.told.runs.iter().position(|run| run == out).map(|at| at + 1)
    }

    /// Exit code of an element that has ended by itself; `None` where it has not, or was killed.
    pub fn code(&self, element: usize) -> Option<i32> {
        std::fs::read_to_string(self.folder.join(format!("{element}.code"))).ok()?.trim().parse().ok()
    }

    /// The script that each element runs.
    pub fn script(&self) -> PathBuf {
        self.folder.join(SCRIPT.0)
    }

    /// File of what the scheduler says about an element.
    pub fn said(&self, element: usize) -> PathBuf {
        self.folder.join(format!("{element}.out"))
    }

    /// When it was submitted, by the clock of its file.
    pub fn since(&self) -> Option<std::time::SystemTime> {
        self.folder.join(FILE).metadata().and_then(|m| m.modified()).ok()
    }
}

#[cfg(test)]
impl Array {
    /// An array of this name that was never written.
    pub fn example(name: &str) -> Array {
        Array { folder: "/arrays/1".into(), told: Told { name: name.into(), job: None, runs: Vec::new() } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn an_array_is_remembered_and_its_script_makes_the_run_of_each_element() {
        let dir = tempfile::tempdir().expect("folder");
        let slurm = dir.path().join("it's here/slurm");
        std::fs::create_dir_all(&slurm).expect("folder");
        let element = |n: &str, line: &str| Element { line: line.into(), out: dir.path().join(n), log: format!("{n}.log").into() };
        let elements = [element("a", "sh -c 'echo \"b\nc\" >&2'"), element("d e", "sh -c 'pwd >&2; exit 3'")];
        let mut array = Array::write(&slurm, &elements, dir.path()).expect("written");
        array.submitted("17".into()).expect("written");
        let again = Array::write(&slurm, &elements[..1], dir.path()).expect("written");
        assert_eq!(all(&slurm).expect("read"), [array.clone(), again.clone()]);
        assert!(array.told.name != again.told.name && array.folder.ends_with("1") && again.folder.ends_with("2"));
        again.remove();
        assert_eq!((array.element(&dir.path().join("d e")), array.element(dir.path())), (Some(2), None));
        for (number, code, variable) in [(1, 0, "SLURM_ARRAY_TASK_ID"), (2, 3, "HQ_TASK_ID")] {
            assert_eq!(array.code(number), None);
            let mut script = std::process::Command::new("sh");
            script.arg(array.script()).arg(&array.folder).env_remove("HQ_TASK_ID").env(variable, number.to_string());
            assert_eq!(script.status().expect("a shell").code(), Some(code));
            assert_eq!(array.code(number), Some(code));
        }
        let log = |name: &str| std::fs::read_to_string(dir.path().join(name)).expect("a log");
        assert_eq!(log("a.log"), "b\nc\n");
        assert_eq!(Path::new(log("d e.log").trim()), dir.path().canonicalize().expect("folder"));
    }
}
