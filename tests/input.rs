//! What a user with a sand of their own types: strengths as laboratories give them, templates, the dictionary of columns, specimens for
//! many runs, and a run that failed before it began.

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use predicates::prelude::*;
use predicates::str::contains;
use std::fs;

const COKE: &str = "experiments/petroleum_coke/h-c-2.toml";

fn comminute(args: &[&str]) -> Assert {
    Command::cargo_bin("comminute").expect("the binary").current_dir(env!("CARGO_MANIFEST_DIR")).args(args).assert()
}

/// The coke scene with a strength law of its own, checked as JSON.
fn coke_with(area: &str, strength: &str) -> Assert {
    let folder = tempfile::tempdir().expect("a folder");
    let root = env!("CARGO_MANIFEST_DIR");
    let scene = fs::read_to_string(format!("{root}/{COKE}")).expect("scene");
    fs::write(folder.path().join("scene.toml"), scene.replace("../../materials/petroleum_coke.toml", "material.toml"))
        .expect("written");
    let material = format!(
        "name = \"own\"\ngrain.density_kg_m3 = 2650\nelastic = {{ E_GPa = 70, nu = 0.17 }}\ncontact.friction = 0.4\n\
         gradation.points = [[0.25, 0], [0.75, 1]]\ncomminution.d_limit_over_d50 = 0.4\nfines.d_min_mm = 0.005\n[strength]\nd0_mm = 0.5\n\
         [strength.{}]\nm = 3\nvar = 0.4\n{strength}\n",
        if area == "hertz" { "hertz_area" } else { "fixed_angle" }
    );
    fs::write(folder.path().join("material.toml"), material).expect("written");
    let path = folder.path().join("scene.toml").display().to_string();
    comminute(&["check", &path, "--json", "--set", &format!("crushing.area={area}"), "--set", "specimen.diameter_mm=12"])
}

fn mean_mpa(assert: Assert) -> f64 {
    let out = assert.success().get_output().stdout.clone();
    let value: serde_json::Value = serde_json::from_slice(&out).expect("json");
    value["estimate"]["crushing_stress"]["mean_MPa"].as_f64().expect("a crushing stress")
}

#[test]
fn a_strength_from_single_grain_tests_is_their_mean_crushing_stress() {
    for (area, theta0) in [("fixed_angle", "theta0_rad = 0.35"), ("hertz", "")] {
        let given = format!("{theta0}\ncrushing_stress_MPa = 100\ncrushing_stress_is = \"mean\"");
        assert!((mean_mpa(coke_with(area, &given)) - 100.0).abs() < 1e-9, "{area}");
        // the 37 % strength lies above the mean of a nearly normal distribution, not far
        let survived = mean_mpa(coke_with(area, &given.replace("mean", "survival_37")));
        assert!((50.0..95.0).contains(&survived), "{area}: {survived}");
    }
    let as_limit = mean_mpa(coke_with("fixed_angle", "theta0_rad = 0.35\nsigma_lim0_MPa = 100"));
    assert!((as_limit - 9.3).abs() < 0.2, "eq. 16: {as_limit}");
}

#[test]
fn half_a_crushing_stress_is_refused() {
    let alone = coke_with("fixed_angle", "theta0_rad = 0.35\ncrushing_stress_MPa = 100");
    alone.code(2).stderr(contains("crushing_stress_is").and(contains("survival_37")));
    let orphan = coke_with("fixed_angle", "theta0_rad = 0.35\nsigma_lim0_MPa = 100\ncrushing_stress_is = \"mean\"");
    orphan.code(2).stderr(contains("belongs to crushing_stress_MPa"));
    let two = coke_with("hertz", "crushing_stress_MPa = 100\ncrushing_stress_is = \"mean\"\nsigma_lim0_MPa = 100");
    two.code(2).stderr(contains("one of them"));
}

#[test]
fn pascals_in_a_key_of_megapascals_are_pointed_out() {
    let strength = ["check", COKE, "--set", "material.strength.fixed_angle.sigma_lim0_MPa=100e6"];
    comminute(&strength).success().stderr(contains("warning: a single grain").and(contains("0.5 to 5000 MPa")));
    comminute(&["check", COKE]).success().stderr(contains("mean F/d²").and(contains("warning: a single").not()));
    comminute(&["check", "--keys"]).success().stdout(contains("crushing_stress_MPa").and(contains("11 times at theta0 = 0.35")));
}
