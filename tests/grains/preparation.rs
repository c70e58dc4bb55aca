//! Preparation of specimens that are hard to make.

use crate::common::*;
use assert_cmd::Command;
use assert_cmd::assert::Assert;
use comminute::dem::Workspace;
use comminute::model::Model;
use comminute::record::specimen;
use comminute::rig::cylinder::space;
use comminute::rig::preparation::{Preparation, porosity};
use predicates::prelude::*;
use predicates::str::contains;

/// 160 grains, as dense as asked and as exact.
fn small(porosity: f64, tolerance: f64, seed: u32) -> Model {
    let sets = [
        format!("specimen.porosity={porosity}"),
        format!("preparation.porosity_tolerance={tolerance}"),
        "preparation.growth_friction=0.4".into(),
        format!("seed.packing={seed}"),
    ];
    model(&oedometer_text(160, 8.0, ""), &sets)
}

/// A program that steps a specimen itself starts its test from the same bits as a run, which goes by way of a file.
#[test]
fn a_specimen_at_rest_is_what_its_file_holds() {
    let model = small(0.46, 0.02, 1);
    let (_, mut state) = Preparation::start(&model, model.rig.specimen().expect("a specimen"));
    state.grains.vel[3] = [1.0, 2.0, 3.0, 1e3];
    state.grains.generation[5] = 2;
    state.grains.permute(&(0..160).rev().collect::<Vec<u32>>());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("specimen.csv");
    let materials = &model.physics.materials;
    specimen::write(&path, &state.grains, materials, Some(space(&state))).expect("written");
    let read = specimen::read(&path, materials).expect("read");
    assert_eq!(format!("{read:?}"), format!("{:?}", specimen::at_rest(&state, materials)));
}

/// Without its retry this one ends 0.3 % too dense.
#[test]
fn a_pressing_that_was_too_strong_is_taken_back() {
    let (state, _) = prepare(&small(0.444, 0.003, 5), |_, _| ());
    assert!((porosity(&state) / 0.444 - 1.0).abs() <= 0.003, "{}", porosity(&state));
}

#[test]
fn a_porosity_out_of_reach_is_told_as_such() {
    let model = small(0.42, 0.004, 17);
    let Some(rig) = model.rig.specimen() else { panic!("a specimen") };
    let (mut preparation, mut state) = Preparation::start(&model, rig);
    let mut work = Workspace::new(&model.physics, &mut state);
    let error = loop {
        match preparation.advance(&model, rig, &mut state, &mut work) {
            Ok(ready) => assert!(!ready, "prepared at {}", porosity(&state)),
            Err(e) => break e.to_string(),
        }
    };
    assert!(error.contains("cannot make so few grains as dense as asked") && error.contains("target 0.4200"), "{error}");
}

/// A folder with a scene of 160 grains whose preparation is left to the program, and the cache that it uses.
struct Open {
    folder: tempfile::TempDir,
}

impl Open {
    fn new() -> Open {
        let folder = tempfile::tempdir().expect("a folder");
        let text = oedometer_text(160, 5.5, "crushing.enabled = false")
            .replace("specimen.porosity = 0.46", "specimen.void_ratio = 0.8")
            .replace("preparation.growth_friction = 0.4", "preparation.growth_friction = \"auto\"");
        std::fs::write(folder.path().join("scene.toml"), text).expect("written");
        Open { folder }
    }

    fn call(&self, verb: &str, more: &[&str]) -> Assert {
        let scene = self.folder.path().join("scene.toml").display().to_string();
        let mut command = Command::cargo_bin("comminute").expect("the binary");
        command.env("COMMINUTE_CACHE", self.folder.path().join("cache")).current_dir(self.folder.path());
        command.args([verb, &scene]).args(more).assert()
    }

    /// Densest and loosest void ratio, and whether they are measured.
    fn range(&self, more: &[&str]) -> (f64, f64, bool) {
        let out = self.call("check", &[&["--json"], more].concat()).success().get_output().stdout.clone();
        let value: serde_json::Value = serde_json::from_slice(&out).expect("json");
        let range = &value["estimate"]["void_ratio_range"];
        let number = |key: &str| range[key].as_f64().expect("a number");
        (number("void_ratio_densest"), number("void_ratio_loosest"), range["measured"] == true)
    }

    /// Void ratio of the specimen that a run makes.
    fn made(&self, set: &str, more: &[&str]) -> f64 {
        self.call("run", &[&["--quiet", "--force", "--out", "run", "--set", set], more].concat()).success();
        let text = std::fs::read_to_string(self.folder.path().join("run/history.csv")).expect("history");
        let mut rows = text.lines().filter(|line| !line.starts_with('#')).map(|line| line.split(',').collect::<Vec<_>>());
        let column = rows.next().and_then(|names| names.iter().position(|name| *name == "void_ratio")).expect("a column");
        rows.next().expect("a row")[column].parse().expect("a number")
    }
}

impl Open {
    /// Void ratios of the densest and the loosest specimen as the last run's summary says; NaN where it says none.
    fn summary_range(&self) -> [f64; 2] {
        let text = std::fs::read_to_string(self.folder.path().join("run/summary.json")).expect("summary");
        let summary: serde_json::Value = serde_json::from_str(&text).expect("json");
        ["void_ratio_densest", "void_ratio_loosest"].map(|key| summary[key].as_f64().unwrap_or(f64::NAN))
    }
}

#[test]
fn what_lies_in_the_measured_range_is_made_and_what_does_not_is_refused() {
    let open = Open::new();
    assert!(!open.range(&[]).2, "nothing has been measured");
    let (dense, loose, measured) = open.range(&["--range"]);
    assert!(measured && dense + 0.05 < loose, "{dense} {loose}");
    assert_eq!(open.range(&[]), (dense, loose, true), "kept");
    for share in [0.1, 0.5, 0.9] {
        let asked = loose - share * (loose - dense);
        let made = open.made(&format!("specimen.void_ratio={asked}"), &[]);
        let porosity = |e: f64| e / (1.0 + e);
        assert!((porosity(made) / porosity(asked) - 1.0).abs() < 0.021, "asked {asked}, made {made}");
    }
    assert_eq!(open.summary_range(), [dense, loose], "a void ratio asked for");
    let half = open.made("specimen.relative_density=0.5", &[]);
    assert!((half - 0.5 * (dense + loose)).abs() < 0.04, "{half}");
    assert_eq!(open.summary_range(), [dense, loose], "a relative density");
    // a run that was stopped keeps what was measured for it
    let halves = ["--quiet", "--force", "--out", "run", "--set", "specimen.relative_density=0.5"];
    open.call("run", &[&halves[..], &["--stop-after", "100"]].concat()).code(130);
    open.call("run", &["--quiet", "--continue", "--out", "run", "--set", "specimen.relative_density=0.5"]).success();
    assert_eq!(open.summary_range(), [dense, loose], "resumed");
    // a specimen from a file was made elsewhere
    let file = open.folder.path().join("kept.csv");
    std::fs::copy(open.folder.path().join("run/specimen.csv"), &file).expect("copied");
    open.made("specimen.relative_density=0.5", &["--specimen", &file.display().to_string()]);
    assert!(open.summary_range().iter().all(|e| e.is_nan()));
    for (key, beyond) in [("void_ratio", dense - 0.1), ("void_ratio", loose + 0.1), ("porosity", 0.2)] {
        let set = format!("specimen.{key}={beyond}");
        for verb in ["check", "run"] {
            let nearest = contains("the nearest that works").and(contains(format!("specimen.{key} = ")));
            open.call(verb, &["--set", &set]).code(2).stderr(nearest);
        }
    }
    // a broken file is as good as none
    let cache = open.folder.path().join("cache");
    for entry in std::fs::read_dir(&cache).expect("cache").flatten() {
        std::fs::write(entry.path(), "{").expect("written");
    }
    assert!(!open.range(&[]).2);
    let stated = ["--set", "specimen.relative_density=0.5", "--set", "preparation.growth_friction=0.4"];
    open.call("check", &["--range", stated[2], stated[3]]).code(2).stderr(contains("preparation.growth_friction"));
    open.call("check", &stated).code(2).stderr(contains("specimen.relative_density").and(contains("auto")));
}

/// The loosest specimen of a wide gradation (Cu 5.2): one that is only taken to bear a stress, while it moves, collapses under the small stress of rest for longer than this.
#[test]
fn the_loosest_of_a_wide_gradation_comes_to_rest() {
    let folder = tempfile::tempdir().expect("a folder");
    let sand = folder.path().join("sand");
    Command::cargo_bin("comminute").expect("the binary").args(["new", "oedometer", "--quiet"]).arg(&sand).assert().success();
    let mut check = Command::cargo_bin("comminute").expect("the binary");
    check.env("COMMINUTE_CACHE", folder.path()).arg("check").arg(sand.join("scene.toml")).arg("--range");
    for set in [
        "material.gradation.points=[[0.11399, 0], [0.13411, 0.1], [0.18635, 0.2], [0.25895, 0.3], [0.35982, 0.4], [0.50000, 0.5], [0.69478, 0.6], [0.95379, 1]]",
        "specimen.grains=600",
        "specimen.diameter_mm=2.16",
        "specimen.relative_density=0.5",
        "preparation.max_steps=100000",
    ] {
        check.args(["--set", set]);
    }
    check.assert().success().stderr(contains("can be made (measured)"));
}

#[test]
fn a_preparation_that_is_stopped_goes_on_to_the_same_specimen() {
    let open = Open::new();
    let specimen = |run: &str| std::fs::read(open.folder.path().join(run).join("specimen.csv")).expect("specimen");
    open.call("run", &["--quiet", "--out", "whole", "--threads", "1"]).success();
    let out = ["--quiet", "--out", "halves", "--continue", "--threads", "2"];
    for stop in ["1000", "2500", "4000", "7000"] {
        open.call("run", &[&out[..], &["--stop-after", stop]].concat()).code(130);
    }
    open.call("run", &out).success();
    assert!(specimen("whole") == specimen("halves"));
}
