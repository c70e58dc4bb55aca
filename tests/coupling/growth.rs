//! Specimens that grow before their test, and how large a point is.

use crate::common::typed::{columns, comminute, number, run, same_files, summary};
use predicates::prelude::{PredicateBooleanExt, predicate::str::contains};
use std::path::Path;

/// A fifth of the fines of the small twin, in cells that hold seven of them.
const SMALL: [&str; 7] = [
    "growth.fines_diameter_mm=[3.4, 3.6]",
    "grid.cell_mm=6.25",
    "growth.friction=0.1",
    "test.axial_strain=0.002",
    "records.rows=20",
    "records.figures=false",
    "records.snapshots=false",
];

fn rows_of(path: &Path) -> usize {
    let text = std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.lines().filter(|l| !l.starts_with('#')).count() - 1
}

/// A column of the first row, before anything has settled.
fn first(out: &Path, column: &str) -> f64 {
    let mut history = csv::Reader::from_path(out.join("history.csv")).expect("history");
    let k = history.headers().expect("header").iter().position(|h| h == column).expect("column");
    history.records().next().expect("a row").expect("row")[k].parse().expect("number")
}

/// The same grown grains with points for fines and with grains alone: as many, in balance at the cell pressure from the first instant; the same bytes for
/// any number of threads and when stopped and resumed.
#[test]
fn a_grown_specimen_is_in_balance_with_points_or_grains() {
    let folder = tempfile::tempdir().expect("folder");
    let out = |name: &str| folder.path().join(name);
    run("mixture/twin_points", &out("points"), &SMALL, &[]).assert().success();
    // without a point there is none to draw
    let drawn: Vec<&str> = SMALL.into_iter().filter(|s| *s != "records.figures=false").collect();
    run("mixture/twin_grains", &out("grains"), &drawn, &[]).assert().success();
    let [points, grains] = ["points", "grains"].map(|name| {
        let rows = columns(&out(name), ["sigma_1_kPa", "sigma_3_kPa", "grains"]);
        // as they have grown
        assert!((rows[0][0] / 50.0 - 1.0).abs() < 0.02 && (rows[0][1] / 50.0 - 1.0).abs() < 0.02, "{name}: {:?}", rows[0]);
        let last = rows[rows.len() - 1];
        assert!((last[1] / 50.0 - 1.0).abs() < 0.02 && last[0] > 51.0, "{name}: {last:?}");
        rows[0]
    });
    let [a, b] = ["points", "grains"].map(|name| first(&out(name), "void_ratio"));
    assert!((a / b - 1.0).abs() < 1e-9, "as they have grown: {a} {b}");
    let fines = rows_of(&out("points").join("points_start.csv"));
    assert!(fines > 1000 && points[2] + fines as f64 == grains[2], "{fines}, {points:?}, {grains:?}");
    let s = summary(&out("points"));
    assert!((number(&s, "coarse_mass_fraction") - 0.2).abs() < 0.02, "{s}");

    // stopped while it grows, while its walls press and while it is loaded
    let [grown, steps] = ["growth_steps", "steps"].map(|key| number(&s, key) as u64);
    assert!(grown > 4200, "{s}");
    run("mixture/twin_points", &out("parts"), &SMALL, &["--stop-after", "1500"]).assert().code(130);
    for at in [4100, grown + steps / 2] {
        comminute("resume")
            .arg(out("parts"))
            .args(["--threads", "2", "--quiet", "--stop-after", &at.to_string()])
            .assert()
            .code(130);
    }
    comminute("resume").arg(out("parts")).args(["--threads", "2", "--quiet"]).assert().success();
    same_files(&out("points"), &out("parts"));
}

/// A run keeps its grown specimen, and another one that begins with it makes the same test to the byte; friction between points and grains may be another one, and
/// such a run is continued. A specimen of other grains, under another stress, or of another kind of scene is refused before anything is written.
#[test]
fn a_run_begins_with_the_specimen_of_another() {
    let folder = tempfile::tempdir().expect("folder");
    let out = |name: &str| folder.path().join(name);
    run("mixture/twin_points", &out("grows"), &SMALL, &[]).assert().success();
    let file = out("grows").join("specimen.csv");
    let given = ["--specimen", file.to_str().expect("a path")];
    run("mixture/twin_points", &out("given"), &SMALL, &given).assert().success();
    for name in ["history.csv", "points_start.csv", "points_final.csv", "grains_final.csv", "specimen.csv"] {
        let [a, b] = ["grows", "given"].map(|run| std::fs::read(out(run).join(name)).expect(name));
        assert!(a == b, "{name}");
    }
    assert!(number(&summary(&out("grows")), "growth_steps") > 4200.0 && number(&summary(&out("given")), "growth_steps") == 0.0);
    let smooth = [&SMALL[..], &["materials.fines.continuum.interface_friction=0.05"]].concat();
    run("mixture/twin_points", &out("smooth"), &smooth, &[&given[..], &["--stop-after", "40"]].concat()).assert().code(130);
    run("mixture/twin_points", &out("smooth"), &smooth, &[&given[..], &["--continue"]].concat()).assert().success();
    // more coarse grains, larger fines, a higher stress, an edited file, the specimen of a mixture in an oedometer of grains, and a scene that places its grains
    let refused = |scene: &str, sets: &[&str], file: &Path, says: &str| {
        let given = ["--specimen", file.to_str().expect("a path")];
        run(scene, &out("refused"), sets, &given).assert().code(2).stderr(contains(says));
        assert!(!out("refused").exists());
    };
    let with = |set| [&SMALL[..], &[set]].concat();
    refused("mixture/twin_points", &with("coarse.mass_fraction=0.4"), &file, "the coarse grains have a volume of");
    refused(
        "mixture/twin_points",
        &with("growth.fines_diameter_mm=[4.0, 4.2]"),
        &file,
        "the fine grains of the scene have radii of",
    );
    refused("mixture/twin_points", &with("test.cell_pressure_kPa=100"), &file, "the specimen of the scene bears 100");
    let edited = out("edited.csv");
    std::fs::write(&edited, std::fs::read_to_string(&file).expect("file").replacen("# coarse_grains = ", "# coarse_grains = 1", 1))
        .expect("written");
    refused("mixture/twin_points", &SMALL, &edited, "does not fit the file");
    refused("petroleum_coke/h-c-2", &[], &file, "cylinder_radius_m: missing");
    refused("mixture/triaxial_small", &[], &file, "has no meaning without growth.fines_diameter_mm");
}

/// Grains alone at constant volume: the lateral stress falls, and their contacts bear all of p.
#[test]
fn grains_alone_are_sheared_at_constant_volume() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    run("mixture/twin_grains", &out, &[&SMALL[..], &["test.drainage=constant_volume"]].concat(), &[]).assert().success();
    let rows = columns(&out, ["volumetric_strain", "sigma_3_kPa", "pore_pressure_kPa", "p_kPa", "p_skeleton_kPa"]);
    assert!(rows[1..].iter().all(|r| r[0].abs() < 1e-7), "{rows:?}");
    let [_, lateral, pore, p, skeleton] = rows[rows.len() - 1];
    assert!(pore > 1.0 && (lateral + pore - 50.0).abs() < 1e-6, "{lateral} kPa and {pore} kPa");
    assert!((skeleton / p - 1.0).abs() < 0.01, "{skeleton} of {p} kPa");
}

/// Coke that has grown with its fines breaks, and what it loses becomes points.
#[test]
fn fines_from_crushing_enter_a_grown_specimen() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let own = ["growth.fines_diameter_mm=[2.9, 3.1]", "grid.cell_mm=6.0", "test.axial_strain=0.06", "records.rows=20"];
    let sets = [&own[..], &["records.figures=false", "records.snapshots=false"]].concat();
    run("mixture/coke_in_fines", &out, &sets, &[]).assert().success();
    let rows = columns(&out, ["crush_events", "fines_points", "reserve_mass_kg", "total_mass_kg"]);
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    assert!(last[0] > 1.0 && last[1] + last[2] > 0.0, "{last:?}");
    assert!(rows.iter().all(|r| (r[3] / first[3] - 1.0).abs() < 1e-12), "{rows:?}");
}

/// `check` counts what will grow, and sees beforehand that coarse grains are too small for their points.
#[test]
fn check_counts_grains_that_have_yet_to_grow() {
    let folder = tempfile::tempdir().expect("folder");
    let check = |sets: &[&str]| {
        let mut command = comminute("check");
        command.args(["experiments/mixture/twin_points.toml", "--json"]);
        for set in sets {
            command.args(["--set", set]);
        }
        let output = command.output().expect("run");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).expect("json")["estimate"].clone()
    };
    let (small, out) = (check(&SMALL[..3]), folder.path().join("out"));
    run("mixture/twin_points", &out, &[&SMALL[..], &["test.axial_strain=1e-5"]].concat(), &[]).assert().success();
    let points = small["continuum"]["points"].as_f64().expect("points");
    assert!((points / rows_of(&out.join("points_start.csv")) as f64 - 1.0).abs() < 0.02, "{small}");
    assert_eq!(small["grains"].as_f64(), Some(number(&summary(&out), "grains")));
    let doubts = |e: &serde_json::Value| e["warnings"].to_string();
    assert!(doubts(&small).contains("times as large as the ghosts"), "{small}");
    let wide = check(&["coarse.diameter_mm=[12.0, 12.1]"]);
    assert!(!doubts(&wide).contains("times as large as the ghosts"), "{wide}");
}

/// The share of coarse grains that `check` judges is that of the scene, though it makes but a part of half a million points and none of the rest.
#[test]
fn check_weighs_points_that_it_does_not_make() {
    let check = |scene: &str| comminute("check").arg(format!("experiments/mixture/{scene}.toml")).assert().success();
    check("triaxial_20_ratio_10").stderr(contains("of the mass are coarse grains").not());
    check("triaxial_60_ratio_10").stderr(contains("warning: 60 % of the mass are coarse grains"));
}

/// One number says how many grains a point stands for: 1:8 of 1 mm grains at porosity 0.365 are 40 points along 75 mm (Li et al. 2023, Table 4).
#[test]
fn the_particle_reduction_gives_the_cell() {
    let check = |n: &str| {
        let mut command = comminute("check");
        command.args(["experiments/mixture/triaxial_20_50kPa.toml", "--json", "--set", &format!("grid.grains_per_point={n}")]);
        let output = command.output().expect("run");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("json");
        json["estimate"]["continuum"]["points"].as_f64().expect("points")
    };
    let (eight, many) = (check("8"), check("64"));
    assert!((50_000.0..60_000.0).contains(&eight), "{eight}");
    assert!((6.0..10.0).contains(&(eight / many)), "{eight} {many}");
}

#[test]
fn specimens_that_cannot_grow_are_refused() {
    for (scene, set, says) in [
        ("mixture/twin_points", "growth.fines_diameter_mm=[3.0, 2.0]", "smallest, then the largest"),
        ("mixture/twin_points", "growth.fines=dust", "growth.fines"),
        ("mixture/triaxial_small", "growth.friction=0.1", "has no meaning without growth.fines_diameter_mm"),
        ("mixture/ball_impact", "growth.fines_diameter_mm=[1.0, 2.0]", "has no meaning with test.rig = \"free\""),
        ("mixture/ball_impact", "grid.grains_per_point=8", "has no meaning beside grid.cell_mm"),
    ] {
        let mut command = comminute("check");
        command.args([&format!("experiments/{scene}.toml"), "--set", set]);
        // once, however often the key is read
        command.assert().code(2).stderr(predicates::str::contains(says).count(1));
    }
    let folder = tempfile::tempdir().expect("folder");
    let sets = [&SMALL[..], &["growth.max_steps=4100"]].concat();
    run("mixture/twin_points", &folder.path().join("out"), &sets, &[])
        .assert()
        .failure()
        .stderr(predicates::str::contains("growth.max_steps"));
}
