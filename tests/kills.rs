//! Processes killed at random moments (SIGKILL) and called again until they are done: every file ends with the same bytes as without a kill, figures
//! included. A few kills of every kind of run stand here; `COMMINUTE_KILLS=1000 cargo test --release --test kills -- --ignored` makes that many and writes the
//! table of the book, `docs/validation/hard_to_break/kills.csv`.

#![cfg(unix)]

#[path = "common/left.rs"]
mod left;

use assert_cmd::cargo::cargo_bin;
use left::files;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const ROOT: &str = env!("CARGO_MANIFEST_DIR");

/// A command that a user would call again after a crash: `--out` is added, and checkpoints often enough that a run of a second has several.
struct Kind {
    name: &'static str,
    /// Whether it takes a second or two, so that it stands in CI.
    quick: bool,
    call: &'static str,
    /// What is set in its scene.
    sets: &'static [&'static str],
}

const fn kind(quick: bool, name: &'static str, call: &'static str, sets: &'static [&'static str]) -> Kind {
    Kind { name, quick, call, sets }
}

const KINDS: [Kind; 13] = [
    kind(
        true,
        "preparation by path",
        "run experiments/hard/oedometer.toml --continue",
        &["specimen.grains=250", "specimen.diameter_mm=3.3", "loading.max_stress_kPa=20", OFTEN],
    ),
    kind(
        false,
        "oedometer with figures",
        "run experiments/hard/oedometer.toml --continue",
        &["records.figures=true", "records.snapshots=true", "records.contacts=true", OFTEN],
    ),
    kind(
        false,
        "oedometer, lost mass as points",
        "run tests/golden/sand_oedometer.toml --continue",
        &["loading.max_stress_kPa=3000", OFTEN],
    ),
    kind(
        false,
        "triaxial",
        "run experiments/fontainebleau/triaxial-h.toml --continue",
        &[
            "specimen.grains=300",
            "specimen.diameter_mm=10.3",
            "crushing.enabled=true",
            "loading.axial_strain=0.02",
            "specimen.isotropic_stress_kPa=2000",
            "loading.inertial_number=0.001",
            OFTEN,
        ],
    ),
    kind(true, "free scene", "run experiments/free/box_settling.toml --continue", &["duration_s=0.1", OFTEN]),
    kind(true, "breakages in a corner", "run experiments/hard/corner.toml --continue", &["steps=20000", OFTEN]),
    kind(
        true,
        "platen tests",
        "run experiments/platen/silica.toml --continue",
        &["batch.grains=4", "batch.diameters_mm=[1.0, 2.0]"],
    ),
    kind(
        true,
        "continuum with figures",
        "run experiments/hard/cube_frictional.toml --continue",
        &["grid.transfer=apic", "records.snapshots=true", "records.figures=true", OFTEN],
    ),
    kind(
        false,
        "mixture that grows and breaks",
        "run experiments/mixture/coke_in_fines.toml --continue",
        &["test.axial_strain=0.01", OFTEN],
    ),
    kind(
        true,
        "sweep",
        "sweep experiments/hard/oedometer.toml --grid material.contact.friction=0.3,0.5 --seeds 1,2",
        &["specimen.void_ratio=0.8", "loading.max_stress_kPa=300", OFTEN],
    ),
    kind(
        false,
        "ensemble",
        "ensemble experiments/hard/oedometer.toml --seeds 1,2,3",
        &["specimen.void_ratio=0.8", "loading.max_stress_kPa=300", OFTEN],
    ),
    // a plan has its settings itself
    kind(true, "reproduce", "reproduce tests/kills/plan.toml", &[]),
    kind(
        false,
        "calibrate curve",
        "calibrate curve tests/kills/curve.csv --scene experiments/hard/oedometer.toml --parameter material.contact.friction=0.2..0.6 \
         --design 6 --budget 14 --batch 2 --check 1",
        &["specimen.void_ratio=0.8", OFTEN],
    ),
];

#[cfg(feature = "gpu")]
const ON_DEVICE: Kind = kind(
    true,
    "continuum on a graphics device",
    "run experiments/hard/cube_frictional.toml --continue --backend gpu",
    &["test.axial_strain=0.005", OFTEN],
);

/// Checkpoints every tenth of a second.
const OFTEN: &str = "records.checkpoint_seconds=0.1";

fn start(kind: &Kind, out: &Path) -> std::process::Child {
    let mut command = Command::new(cargo_bin("comminute"));
    command
        .current_dir(ROOT)
        .args(kind.call.split(' '))
        .args(kind.sets.iter().flat_map(|set| ["--set", set]))
        .arg("--out")
        .arg(out)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // a group of its own, so that the runs of a sweep are killed with it
    command.process_group(0).spawn().expect("start")
}

/// Runs without a kill: what is left, and how long it took.
fn whole(kind: &Kind, folder: &Path) -> (BTreeMap<String, Vec<u8>>, Duration) {
    let (out, began) = (folder.join("whole"), Instant::now());
    assert!(start(kind, &out).wait().expect("ended").success(), "{}", kind.name);
    let took = began.elapsed();
    // of a sweep the folder stands in its tables
    (files(&out), took)
}

/// Calls a command, killing it after random times up to `longest`, at most `most` times, then until it is done; gives the number of kills.
fn killed(kind: &Kind, out: &Path, longest: Duration, most: usize, random: &mut ChaCha8Rng) -> usize {
    let mut kills = 0;
    while kills < most {
        let mut child = start(kind, out);
        std::thread::sleep(longest.mul_f64(random.random_range(0.0..1.0)));
        if child.try_wait().expect("state").is_some() {
            break;
        }
        let group = nix::unistd::Pid::from_raw(child.id() as i32);
        let _ = nix::sys::signal::killpg(group, nix::sys::signal::Signal::SIGKILL);
        let _ = child.wait();
        kills += 1;
    }
    assert!(start(kind, out).wait().expect("ended").success(), "{} after {kills} kills in {}", kind.name, out.display());
    kills
}

/// Asserts that a killed run has left what the whole one has.
fn same(kind: &Kind, whole: &BTreeMap<String, Vec<u8>>, out: &Path) {
    let now = files(out);
    let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&now), names(whole), "{}", kind.name);
    for (name, bytes) in &now {
        assert!(*bytes == whole[name], "{}: {name} differs after kills", kind.name);
    }
}

fn kinds() -> Vec<&'static Kind> {
    #[allow(unused_mut)]
    let mut kinds: Vec<&Kind> = KINDS.iter().collect();
    #[cfg(feature = "gpu")]
    if adapter::adapter("killed processes go on") {
        kinds.push(&ON_DEVICE);
    }
    kinds
}

#[cfg(feature = "gpu")]
use comminute::gpu;

#[cfg(feature = "gpu")]
#[path = "../src/engine/gpu/tests/adapter.rs"]
mod adapter;

#[test]
fn every_kind_of_run_survives_kills() {
    let folder = tempfile::tempdir().expect("folder");
    let quick: Vec<&Kind> = kinds().into_iter().filter(|kind| kind.quick).collect();
    quick.par_iter().enumerate().for_each(|(k, kind)| {
        let base = folder.path().join(k.to_string());
        fs::create_dir_all(&base).expect("folder");
        let (reference, took) = whole(kind, &base);
        let out = base.join("killed");
        let kills = killed(kind, &out, took.mul_f64(0.7), 2, &mut ChaCha8Rng::seed_from_u64(26 + k as u64));
        println!("{}: {kills} kills", kind.name);
        same(kind, &reference, &out);
    });
}

/// Kinds of run with the numbers of runs, kills, and runs that ended with the same bytes.
type Counts = BTreeMap<String, (usize, usize, usize)>;

/// What the table of the book holds already; empty where there is no table.
fn counted(path: &Path) -> Counts {
    let Ok(mut table) = csv::Reader::from_path(path) else { return Counts::new() };
    table
        .deserialize()
        .map(|row| {
            let (kind, runs, kills, identical) = row.expect("a row of kind, runs, kills, identical");
            (kind, (runs, kills, identical))
        })
        .collect()
}

fn write(path: &Path, kinds: &[&Kind], counts: &Counts) {
    let mut table = csv::Writer::from_path(path).expect("a table");
    table.write_record(["kind", "runs", "kills", "identical"]).expect("row");
    for kind in kinds {
        if let Some((runs, kills, identical)) = counts.get(kind.name) {
            table.serialize((kind.name, runs, kills, identical)).expect("row");
        }
    }
    table.flush().expect("written");
}

#[test]
#[ignore = "an hour: writes docs/validation/hard_to_break/kills.csv; kills that the table holds are not made again: remove it to begin anew"]
fn a_thousand_kills() {
    let wanted: usize = std::env::var("COMMINUTE_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(1000);
    let folder = tempfile::tempdir().expect("folder");
    let kinds = kinds();
    let path = Path::new(ROOT).join("docs/validation/hard_to_break/kills.csv");
    fs::create_dir_all(path.parent().expect("a folder")).expect("folder");
    let mut counts = counted(&path);
    let of_each = wanted.div_ceil(kinds.len());
    for (k, kind) in kinds.iter().enumerate() {
        let (mut runs, mut kills, mut identical) = counts.get(kind.name).copied().unwrap_or_default();
        if kills >= of_each {
            continue;
        }
        // other moments than those of the kills that the table holds
        let mut random = ChaCha8Rng::seed_from_u64(kills as u64);
        let base: PathBuf = folder.path().join(k.to_string());
        fs::create_dir_all(&base).expect("folder");
        let (reference, took) = whole(kind, &base);
        while kills < of_each {
            let out = base.join(runs.to_string());
            kills += killed(kind, &out, took.mul_f64(0.3), 25, &mut random);
            same(kind, &reference, &out);
            fs::remove_dir_all(&out).expect("removed");
            (runs, identical) = (runs + 1, identical + 1);
            counts.insert(kind.name.into(), (runs, kills, identical));
            write(&path, &kinds, &counts);
        }
    }
}
