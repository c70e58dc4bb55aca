//! Whole runs whose bytes do not change: each file of a run has its hash in `hashes.csv`, with one thread and scalar instructions as with three threads and the widest
//! instructions (on a device the latter alone). A change that is meant to change results says so in its message and writes the table anew: `COMMINUTE_GOLDEN=write cargo test --release --test golden`.

#[cfg(feature = "gpu")]
#[path = "../../src/engine/gpu/tests/adapter.rs"]
mod adapter;
#[path = "../common/left.rs"]
mod left;
mod runs;

#[cfg(feature = "gpu")]
use comminute::gpu;

use assert_cmd::cargo::cargo_bin;
use left::OF_THE_MACHINE;
use std::collections::BTreeMap;
use std::fs;
use std::hash::Hasher;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

/// A run: its scene and what is replaced in it, so that it takes a second or two.
struct Run {
    name: &'static str,
    scene: &'static str,
    sets: &'static [&'static str],
    backend: &'static str,
}

const ADAPTER: &str = "llvmpipe (LLVM 15.0.6, 256 bits)";
const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// FNV-1a of bytes.
fn hash(bytes: &[u8]) -> String {
    let mut hasher = fnv::FnvHasher::default();
    hasher.write(bytes);
    format!("{:016x}", hasher.finish())
}

/// What came out: without what depends on the machine, numbers as they are written.
fn summary(text: &str) -> String {
    text.lines()
        .filter(|line| !OF_THE_MACHINE.iter().any(|word| line.split(':').next().is_some_and(|key| key.contains(word))))
        .collect()
}

/// File or folder of snapshots to hash, for everything that a run has left.
fn hashes(run: &Path) -> BTreeMap<String, String> {
    let mut of = BTreeMap::new();
    for entry in fs::read_dir(run).expect("a run's folder").flatten() {
        let (path, name) = (entry.path(), entry.file_name().into_string().expect("a plain name"));
        if name == "figures" {
            continue; // drawn from the tables
        } else if path.is_dir() {
            let mut files: Vec<PathBuf> = fs::read_dir(&path).expect("a folder").flatten().map(|e| e.path()).collect();
            files.sort();
            let bytes: Vec<u8> = files.iter().flat_map(|f| fs::read(f).expect("a file")).collect();
            of.insert(name, hash(&bytes));
        } else if name == "summary.json" {
            of.insert(name, hash(summary(&fs::read_to_string(path).expect("a file")).as_bytes()));
        } else if name.ends_with(".csv") {
            of.insert(name, hash(&fs::read(path).expect("a file")));
        }
    }
    of
}

fn table() -> PathBuf {
    Path::new(ROOT).join("tests/golden/hashes.csv")
}

/// The table's rows of all runs but `name`, and those of `name`.
fn known(name: &str) -> (Vec<[String; 3]>, BTreeMap<String, String>) {
    let text = fs::read_to_string(table()).unwrap_or_default();
    let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize::<[String; 3]>().map(|row| row.expect("run, file, hash"));
    let (own, others): (Vec<_>, Vec<_>) = rows.partition(|row| row[0] == name);
    (others, own.into_iter().map(|[_, file, hash]| (file, hash)).collect())
}

fn write(name: &str, found: &BTreeMap<String, String>) {
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _held = ONE_AT_A_TIME.lock().expect("nobody failed while writing");
    let mut rows = known(name).0;
    rows.extend(found.iter().map(|(file, hash)| [name.to_string(), file.clone(), hash.clone()]));
    rows.sort();
    let mut out = csv::Writer::from_path(table()).expect("can be written");
    out.write_record(["run", "file", "fnv1a"]).expect("written");
    rows.iter().for_each(|row| out.write_record(row).expect("written"));
    out.flush().expect("written");
}

/// Whether a run was done by the software adapter whose rounding the table holds: others divide otherwise.
fn the_known_adapter(run: &Path) -> bool {
    let text = fs::read_to_string(run.join("summary.json")).expect("a summary");
    let known = text.contains(ADAPTER);
    if !known {
        eprintln!("SKIPPED: the table's hashes are of {ADAPTER}");
    }
    known
}

fn check(run: &Run) {
    #[cfg(feature = "gpu")]
    if run.backend == "gpu" && !adapter::adapter(run.name) {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let writes = std::env::var("COMMINUTE_GOLDEN").is_ok_and(|v| v == "write");
    // on a device the processor's instructions do little
    let ways: &[_] = if run.backend == "gpu" { &[("3", "best")] } else { &[("1", "scalar"), ("3", "best")] };
    for (k, &(threads, instructions)) in ways.iter().enumerate() {
        let out = folder.path().join(threads);
        let mut command = Command::new(cargo_bin("comminute"));
        command.current_dir(ROOT).env("COMMINUTE_CACHE", folder.path().join("cache")).stdout(Stdio::null());
        command
            .arg("run")
            .arg(run.scene)
            .args([
                "--set",
                "records.figures=false",
                "--quiet",
                "--threads",
                threads,
                "--simd",
                instructions,
                "--backend",
                run.backend,
                "--out",
            ])
            .arg(&out);
        for set in run.sets {
            command.args(["--set", set]);
        }
        let done = command.output().expect("starts");
        assert!(done.status.success(), "{}: {}", run.name, String::from_utf8_lossy(&done.stderr));
        if run.backend == "gpu" && !the_known_adapter(&out) {
            return;
        }
        let found = hashes(&out);
        if writes && k == 0 {
            write(run.name, &found);
        }
        let known = known(run.name).1;
        assert!(!known.is_empty(), "{} is not in {}", run.name, table().display());
        assert_eq!(found, known, "{} with {threads} threads and {instructions} instructions", run.name);
    }
}
