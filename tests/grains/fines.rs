//! Fines from crushing as material points in an oedometer, from the scene that `comminute new` writes with one line changed.

use assert_cmd::cargo::cargo_bin;
use std::path::Path;
use std::process::{Command, Stdio};

fn comminute() -> Command {
    let mut command = Command::new(cargo_bin("comminute"));
    command.stdout(Stdio::null());
    command
}

/// A run of a small sand with lost mass as points, in `dir/name`.
fn run(dir: &Path, name: &str, more: &[&str]) -> std::process::Output {
    let scene = dir.join("sand/scene.toml");
    if !scene.exists() {
        assert!(comminute().args(["new", "oedometer", "--quiet"]).arg(dir.join("sand")).status().expect("starts").success());
    }
    let mut command = comminute();
    command.arg("run").arg(scene).arg("--out").arg(dir.join(name)).args(["--quiet", "--set", "crushing.lost_mass=points"]);
    for set in [
        "specimen.grains=250",
        "specimen.void_ratio=0.75",
        "specimen.diameter_mm=3.0",
        "loading.max_stress_kPa=7000",
        "loading.stages_kPa=[5800.0]",
        "records.at_kPa=[5000.0]",
        "records.figures=false",
        "records.snapshots=false",
        "material.strength.fixed_angle.crushing_stress_MPa=28",
        "material.elastic.G_GPa=3",
    ] {
        command.args(["--set", set]);
    }
    command.args(more).output().expect("starts")
}

/// The columns asked for of `history.csv`, a row each.
fn history<const N: usize>(dir: &Path, columns: [&str; N]) -> Vec<[f64; N]> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(dir.join("history.csv")).expect("table");
    let head = reader.headers().expect("head").clone();
    let at = columns.map(|c| head.iter().position(|h| h == c).unwrap_or_else(|| panic!("no column {c}")));
    reader.records().map(|row| at.map(|k| row.as_ref().expect("row")[k].parse().expect("number"))).collect()
}

/// What breakages lose is in points and reserve, points bear a part of the stress, the energy ledger closes with the work on them, and threads and interruptions change nothing.
#[test]
fn fines_of_an_oedometer_bear_their_share() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let done = run(dir, "whole", &["--threads", "1"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let rows = history(
        &dir.join("whole"),
        [
            "sigma_v_kPa",
            "sigma_v_points_kPa",
            "fines_points",
            "fines_mass_kg",
            "reserve_mass_kg",
            "mass_lost_kg",
            "energy_error",
            "energy_points_J",
            "released_J",
            "energy_kinetic_J",
            "energy_wall_J",
        ],
    );
    let mut bearing = 0;
    // nothing has been done yet at the first row
    for [sigma, borne, points, entered, reserve, lost, error, work, released, kinetic, by_walls] in &rows[1..] {
        assert!((entered + reserve - lost).abs() <= 1e-8 * lost, "{entered} + {reserve} of {lost} kg");
        assert!((0.0..=*sigma).contains(borne), "{borne} of {sigma} kPa");
        // between two half steps the kinetic energy of a burst is known to one per cent
        assert!(error.abs() < (3e-7 + 0.01 * kinetic / by_walls).min(3e-5), "the ledger is open by {error}");
        assert!(*points > 0.0 || (*borne == 0.0 && *work == 0.0), "nothing where nothing has broken");
        assert!(work + released >= -1e-9, "points give back no more than they were given: {work} and {released} J");
        bearing += usize::from(*borne > 0.01 * sigma);
    }
    // what points bear is part of a grain's balance
    let [unbalanced, error] = history(&dir.join("whole"), ["unbalanced_ratio", "energy_error"]).pop().expect("a row");
    assert!(unbalanced < 0.01 && error.abs() < 3e-7, "unbalanced by {unbalanced}, the ledger is open by {error}");
    assert!(bearing > 3, "points bear a part in {bearing} of {} rows", rows.len());

    let end = rows.len();
    let steps = history(&dir.join("whole"), ["step"]);
    let cut = steps[end / 2][0] + 30_000.0; // preparation comes first; whatever it is, this is on the way
    let stopped = run(dir, "cut", &["--threads", "2", "--stop-after", &format!("{cut}")]);
    assert_eq!(stopped.status.code(), Some(130), "{}", String::from_utf8_lossy(&stopped.stderr));
    assert!(comminute().arg("resume").arg(dir.join("cut")).args(["--threads", "1", "--quiet"]).status().expect("starts").success());
    for table in ["history.csv", "breakage.csv", "gsd.csv", "grains_final.csv"] {
        let of = |run: &str| std::fs::read(dir.join(run).join(table)).expect("table");
        assert!(of("whole") == of("cut"), "{table} of a run with two threads, stopped on the way, differs");
    }
}

/// A material that says nothing of its fines as soil is refused by name before anything is written.
#[test]
fn points_need_a_law() {
    let folder = tempfile::tempdir().expect("folder");
    let dir = folder.path();
    let material = dir.join("sand/material.toml");
    assert!(comminute().args(["new", "oedometer", "--quiet"]).arg(dir.join("sand")).status().expect("starts").success());
    let text = std::fs::read_to_string(&material).expect("material");
    let (text, _) = text.split_once("[continuum]").expect("has one");
    std::fs::write(&material, text).expect("written");
    let refused = run(dir, "refused", &[]);
    let message = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(2), "{message}");
    assert!(message.contains("continuum") && message.contains("lost_mass = \"points\""), "{message}");
    assert!(!dir.join("refused").exists());
}
