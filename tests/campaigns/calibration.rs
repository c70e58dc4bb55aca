//! `comminute calibrate grains` as a user types it, from the repository root.

use crate::ROOT;
use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

const DATA: &str = "figures/calibration/grains/simulated.csv";
const MATERIAL: &str = "materials/petroleum_coke.toml";
const COKE: &str = "experiments/petroleum_coke/h-c-2.toml";

fn comminute(args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("comminute").expect("the binary").current_dir(ROOT).args(args).assert()
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

fn text(path: &Path) -> String {
    path.to_str().expect("UTF-8").to_string()
}

/// Calibrates into a new folder and returns it with calibration.json.
fn calibrated(args: &[&str]) -> (TempDir, Value) {
    let folder = folder();
    let out = text(&folder.path().join("out"));
    let all = [&["calibrate", "grains"], args, &["--out", &out, "--quiet", "--samples", "0"]].concat();
    comminute(&all).success().stdout("").stderr("");
    let json = fs::read_to_string(folder.path().join("out/calibration.json")).expect("json");
    (folder, serde_json::from_str(&json).expect("an object"))
}

fn holds(estimate: &Value, truth: f64) {
    let number = |key: &str| estimate[key].as_f64().unwrap_or(f64::NAN);
    assert!(number("lower") < truth && truth < number("upper"), "{estimate} without {truth}");
    assert!(number("lower") < number("estimate") && number("estimate") < number("upper"));
}

#[test]
fn the_example_of_the_help_gives_back_what_it_was_made_with() {
    for verb in [&["calibrate"][..], &["calibrate", "grains"]] {
        comminute(&[verb, &["--help"]].concat()).success().stdout(contains(DATA));
    }
    let (folder, json) = calibrated(&[DATA, "--theta0", "0.1308996938995747"]);
    let best = &json["best"];
    assert_eq!(best["area_model"], "fixed-angle");
    assert_eq!(best["spread"], "truncated-normal");
    holds(&best["sigma_lim0_MPa"], 5000.0);
    holds(&best["m"], 3.0);
    holds(&best["var"], 0.48);
    assert_eq!(json["models"].as_array().map(Vec::len), Some(4));
    assert!(json["models"].as_array().expect("models").iter().all(|m| m["aic"].is_f64() && m["bic"].is_f64()));
    assert_eq!(json["per_size"].as_array().map(Vec::len), Some(4));
    for name in ["report.md", "material.toml", "force_vs_diameter.svg", "survival.csv", "quantiles.png"] {
        assert!(folder.path().join("out").join(name).is_file(), "{name}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    let run = || {
        let (folder, _) = calibrated(&[DATA, "--theta0", "0.13", "--intervals", "bootstrap", "--bootstrap", "100"]);
        fs::read(folder.path().join("out/calibration.json")).expect("json")
    };
    assert_eq!(run(), run());
}

#[test]
fn what_is_said_stands_on_the_right_stream() {
    let folder = folder();
    let out = text(&folder.path().join("out"));
    let args = ["calibrate", "grains", DATA, "--theta0", "0.13", "--out", &out, "--samples", "0"];
    comminute(&args).success().stdout("").stderr(contains("sigma_lim0 (MPa)").and(contains("out/report.md")));
    comminute(&args).code(2).stderr(contains("--force"));
    let forced = [&args[..], &["--force", "--json"]].concat();
    let assert = comminute(&forced).success();
    let json: Value = serde_json::from_slice(&assert.get_output().stdout).expect("one object");
    assert!(json["best"]["why"].is_string());
}

#[test]
fn a_scene_runs_with_the_material_that_was_written() {
    // both tables, as the material gives angle and moduli
    let (folder, json) = calibrated(&[DATA, "--material", MATERIAL]);
    assert_eq!(json["models"].as_array().map(Vec::len), Some(8));
    let material = format!("material={}", text(&folder.path().join("out/material.toml")));
    for area in ["fixed_angle", "hertz"] {
        let area = format!("crushing.area={area}");
        comminute(&["check", COKE, "--set", &material, "--set", &area])
            .success()
            .stderr(contains("material        petroleum coke"));
    }
    // and as the material of a scene file
    let scene = fs::read_to_string(COKE).expect("scene").replace("../../materials/petroleum_coke.toml", "out/material.toml");
    let path = folder.path().join("scene.toml");
    fs::write(&path, scene).expect("written");
    let out = text(&folder.path().join("run"));
    let small = [
        "--set",
        "specimen.grains=60",
        "--set",
        "specimen.diameter_mm=60",
        "--set",
        "specimen.porosity=0.5",
        "--set",
        "preparation.growth_friction=0.4",
    ];
    let load = ["--set", "loading.max_stress_kPa=10", "--quiet", "--out", &out];
    comminute(&[&["run", &text(&path)], &small[..], &load].concat()).success();
    let resolved: toml::Table =
        toml::from_str(&fs::read_to_string(folder.path().join("run/scene.resolved.toml")).expect("scene")).expect("TOML");
    let strength = &resolved["material"]["strength"]["fixed_angle"];
    let fitted = json["best"]["sigma_lim0_MPa"]["estimate"].as_f64().expect("fitted");
    assert!((strength["sigma_lim0_MPa"].as_float().expect("number") / fitted - 1.0).abs() < 1e-5);
}

#[test]
fn without_angle_the_product_is_given_and_no_material() {
    let (folder, json) = calibrated(&[DATA]);
    let best = &json["best"];
    assert!(best["sigma_lim0_MPa"]["estimate"].is_null());
    holds(&best["m"], 3.0);
    holds(&best["identified"]["value"], 5000.0 * 0.1308996938995747_f64.sin().powi(2));
    assert!(json["notes"].to_string().contains("forces alone identify"));
    assert!(!folder.path().join("out/material.toml").exists());
}

#[test]
fn wrong_data_and_options_are_refused_before_any_work() {
    let folder = folder();
    let file = |name: &str, body: &str| {
        let path = folder.path().join(name);
        fs::write(&path, body).expect("written");
        text(&path)
    };
    let out = text(&folder.path().join("out"));
    let negative = file("negative.csv", "diameter_mm,force_N\n1,10\n2,-3\n");
    let unit = file("unit.csv", "diameter_mm,force\n1,10\n");
    let few = file("few.csv", "diameter_mm,force_N\n1,10\n2,20\n");
    let constant = file("constant.csv", &format!("diameter_mm,force_N\n{}", "2,7\n".repeat(9)));
    for (args, says) in [
        (vec![negative.as_str()], "negative.csv: line 3: force_N = \"-3\": must be a number > 0"),
        (vec![&unit], "force: has no unit"),
        (vec![&few], "2 broken grains, too few"),
        (vec![&constant], "constant values"),
        (vec!["no.csv"], "no.csv: no such file"),
        (vec![DATA, "--theta0", "20"], "--theta0 20: must be > 0 and < 1.57 rad"),
        (vec![DATA, "--grain-E-GPa", "5"], "--grain-nu: is needed"),
        (vec![DATA, "--material", "no.toml"], "no such file"),
        (vec![DATA, "--area-model", "cone"], "fixed-angle"),
    ] {
        let all = [&["calibrate", "grains"], &args[..], &["--out", &out]].concat();
        comminute(&all).code(2).stdout("").stderr(contains(says));
        assert!(!Path::new(&out).exists(), "nothing was started");
    }
}

#[test]
fn a_single_size_says_what_it_gives() {
    let folder = folder();
    let rows: String = (1..60).map(|i| format!("3,{}\n", 40.0 + 1.3 * f64::from(i))).collect();
    let path = folder.path().join("one.csv");
    fs::write(&path, format!("diameter_mm,force_N\n{rows}")).expect("written");
    let out = text(&folder.path().join("out"));
    comminute(&["calibrate", "grains", &text(&path), "--theta0", "0.35", "--out", &out, "--samples", "0"])
        .success()
        .stderr(contains("m (the effect of size) cannot be estimated").and(contains("strength at this size")));
}

#[test]
fn the_study_writes_its_tables() {
    let folder = folder();
    let out = text(folder.path());
    let args = ["calibrate", "grains-study", "--repeats", "3", "--grains", "100", "--out", &out];
    comminute(&args).success().stdout("").stderr(contains("width / Fisher"));
    let table = fs::read_to_string(folder.path().join("recovery.csv")).expect("table");
    assert_eq!(table.lines().count(), 13);
    assert_eq!(fs::read_to_string(folder.path().join("repeats.csv")).expect("table").lines().count(), 13);
    comminute(&args).code(2).stderr(contains("--force"));
}

/// `calibrate fines --interface`: the friction of contacts along a coarse grain goes into a material that a scene takes; a run without tables of contacts is
/// refused with the key that writes them.
#[test]
fn friction_along_coarse_grains_goes_into_the_law_of_the_fines() {
    let folder = folder();
    let run = folder.path().join("run");
    fs::create_dir_all(run.join("snapshots")).expect("folder");
    let rows = (0..=200).map(|k| {
        let strain = 6e-4 * f64::from(k);
        // hardens to 2 % of strain, then softens, and dilates
        let ratio = if strain < 0.02 {
            1.0 + 1.4 * (1.0 - (1.0 - strain / 0.02).powi(3))
        } else {
            2.0 + 0.4 * (-40.0 * (strain - 0.02)).exp()
        };
        format!("load,{strain},{},{},50,0.6\n", -0.25 * (strain - 0.005).max(0.0), 50.0 * ratio)
    });
    let history: String = rows.collect();
    let write = |name: &str, text: &str| fs::write(run.join(name), text).expect("written");
    write("history.csv", &format!("stage,axial_strain,volumetric_strain,sigma_1_kPa,sigma_3_kPa,void_ratio\n{history}"));
    write("grains_start.csv", "x_m,y_m,z_m,r_m,generation,material\n0,0,0,0.01,0,coarse\n0.01,0,0.01,0.001,0,fine\n");
    let (out, run) = (text(&folder.path().join("out")), text(&run));
    let base = text(&Path::new(ROOT).join("materials/li2023_fines.toml"));
    let args = ["calibrate", "fines", &run, "--interface", &run, "--base", &base, "--out", &out];
    comminute(&args).code(2).stderr(contains("records.contacts=true"));

    // at 45 degrees from the axis, where sin 2θ is 1: 0.3 of a normal force of √2
    let contacts = "# axial_strain = 0.05\na,kind_b,b,normal_x_N,normal_y_N,normal_z_N,tangential_x_N,tangential_y_N,tangential_z_N\n0,grain,1,-1,0,-1,0.3,0,-0.3\n";
    fs::write(Path::new(&run).join("snapshots/contacts_1.csv"), contacts).expect("written");
    comminute(&args).success().stderr(contains("friction along coarse"));
    let material = text(&folder.path().join("out/material.toml"));
    assert!(fs::read_to_string(&material).expect("a material").contains("interface_friction = 0.3\n"));
    let fines = format!("materials.fines={material}");
    comminute(&["check", "experiments/mixture/twin_points.toml", "--set", &fines])
        .success()
        .stderr(contains("fine grains roll").not());
}
