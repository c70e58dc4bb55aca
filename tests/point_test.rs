//! `comminute point-test` as a user types it, from the repository root.

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;
use std::fs;
use std::path::Path;

const FINES: &str = "materials/li2023_fines.toml";

fn comminute(args: &[&str]) -> assert_cmd::assert::Assert {
    let mut command = Command::cargo_bin("comminute").expect("the binary");
    command.current_dir(env!("CARGO_MANIFEST_DIR")).arg("point-test").args(args).assert()
}

fn names(dir: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(dir).expect("folder").map(|e| e.expect("entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_test_leaves_records_and_figures() {
    let dir = tempfile::tempdir().expect("folder");
    let out = dir.path().join("out");
    let at = out.display().to_string();
    let args = [FINES, "--confining-kPa", "50,100", "--steps", "300", "--out", &at, "--json"];
    let assert = comminute(&args).success().stderr(contains("closed form 2.8365").and(contains("stress_path.svg")));
    let printed: Value = serde_json::from_slice(&assert.get_output().stdout).expect("JSON");
    let kept: Value = serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("summary")).expect("JSON");
    assert_eq!(printed, kept);
    assert_eq!(kept["tests"].as_array().map(Vec::len), Some(2));
    let peak = kept["peak_stress_ratio"].as_f64().expect("a ratio");
    assert!((peak / 2.8365 - 1.0).abs() < 0.02, "{peak}");
    assert_eq!(names(&out), ["figures", "history.csv", "material.resolved.toml", "summary.json"]);
    assert_eq!(names(&out.join("figures")).len(), 9);
    let history = fs::read_to_string(out.join("history.csv")).expect("history");
    assert_eq!(history.lines().count(), 1 + 2 * 301);
    assert!(history.starts_with("confining_kPa,step,axial_strain,"));

    // the folder is not overwritten unasked, and the resolved material repeats the test
    comminute(&args).code(2).stderr(contains("--force"));
    let again = dir.path().join("again").display().to_string();
    let resolved = out.join("material.resolved.toml").display().to_string();
    comminute(&[&resolved, "--confining-kPa", "50,100", "--steps", "300", "--out", &again, "--quiet"])
        .success()
        .stderr("")
        .stdout("");
    for name in ["history.csv", "summary.json", "material.resolved.toml"] {
        assert_eq!(fs::read(out.join(name)).expect("file"), fs::read(Path::new(&again).join(name)).expect("file"), "{name}");
    }
    // another path in the same folder leaves nothing of the old one
    let other = [FINES, "--path", "oedometer", "--strain", "0.01", "--steps", "20", "--out", &at, "--force", "--quiet"];
    comminute(&other).success();
    assert_eq!(names(&out.join("figures")).iter().filter(|n| n.ends_with("svg")).count(), 2);
}

#[test]
fn every_path_and_an_elastic_law_are_drawn() {
    let dir = tempfile::tempdir().expect("folder");
    let material = dir.path().join("rubber.toml");
    let text = "name = \"rubber\"\n[grain]\ndensity_kg_m3 = 1100.0\n[continuum]\nlaw = \"elastic\"\nE_MPa = 2.0\nnu = 0.49\nsource.nu = \"assumed: nearly incompressible\"\n";
    fs::write(&material, text).expect("written");
    let material = material.display().to_string();
    for (path, key, value) in [("triaxial", "peak_q_kPa", 100.0), ("simple_shear", "largest_tau_kPa", 2000.0 / 2.98 * 0.05)] {
        let out = dir.path().join(path);
        let args = [&material, "--path", path, "--strain", "0.05", "--steps", "20", "--out", &out.display().to_string()];
        comminute(&args).success().stderr(contains("assumed: continuum.nu = 0.49"));
        let summary: Value = serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("summary")).expect("JSON");
        let found = summary["tests"][0][key].as_f64().expect("a number");
        assert!((found / value - 1.0).abs() < 1e-2, "{path}: {found} for {value}");
        assert!(out.join("figures/stress_path.png").is_file());
    }
}

#[test]
fn mistakes_are_refused_before_any_file() {
    let dir = tempfile::tempdir().expect("folder");
    let out = dir.path().join("out").display().to_string();
    for (args, says) in [
        (vec!["materials/steel.toml"], "materials/steel.toml: continuum: is missing"),
        (vec!["materials/li2023_fine.toml"], "did you mean materials/li2023_fines.toml?"),
        (vec!["experiments/petroleum_coke/h-c-2.toml"], "a material file is needed"),
        (vec![FINES, "--confining-kPa=-5"], "confining_kPa = -5: must be >= 0"),
        (vec![FINES, "--strain", "2"], "strain = 2: must be between -1 and 1, and not 0"),
        (vec![FINES, "--steps", "0"], "steps"),
        (vec![FINES, "--path", "ring"], "triaxial, oedometer, simple_shear"),
        (vec![FINES, "--set", "continuum.nu=0.5"], "must be > -1 and < 0.5"),
        (vec![FINES, "--set", "continuum.dilation_angle_deg=19"], "smallest friction angle, 18.3346"),
        (vec![FINES, "--set", "continuum.cone=round"], "\"plane_strain\""),
    ] {
        let args = [&args[..], &["--out", &out]].concat();
        comminute(&args).code(2).stdout("").stderr(contains(says));
        assert!(!Path::new(&out).exists(), "{says}");
    }
    comminute(&["--help"]).success().stdout(contains("comminute point-test materials/li2023_fines.toml"));
}
