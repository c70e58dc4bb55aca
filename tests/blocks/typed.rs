//! Rigid bodies as a user types them.

use crate::common::typed::{comminute, number, summary};
use predicates::str::contains;
use std::path::{Path, PathBuf};

/// Three rocks and a box that fall on each other; the box is the lid.
pub const ROCKS: &str = r#"
kind = "mixture"
duration_s = 0.3
gravity_m_s2 = [0.0, 0.0, -9.81]
[[wall]]
kind = "box"
min_m = [0.0, 0.0, 0.0]
max_m = [0.1, 0.1, 0.4]
[[grain]]
position_m = [0.08, 0.02, 0.02]
radius_m = 0.015
[[block]]
shape = "polyhedron"
points_mm = [-18.0, -12.0, -10.0, 16.0, -14.0, -12.0, 20.0, 10.0, -8.0, -14.0, 15.0, -11.0, -12.0, -10.0, 12.0, 13.0, -11.0, 9.0, 11.0, 9.0, 14.0]
rounding_mm = 2.0
position_mm = [35.0, 35.0, 30.0]
[[block]]
shape = "polyhedron"
points_mm = [-18.0, -12.0, -10.0, 16.0, -14.0, -12.0, 20.0, 10.0, -8.0, -14.0, 15.0, -11.0, -12.0, -10.0, 12.0, 13.0, -11.0, 9.0, 11.0, 9.0, 14.0]
rounding_mm = 2.0
position_mm = [55.0, 55.0, 75.0]
axis = [1.0, 1.0, 0.0]
angle_deg = 35.0
velocity_m_s = [0.0, 0.0, -1.0]
[[block]]
shape = "box"
size_mm = [80.0, 60.0, 20.0]
position_mm = [50.0, 50.0, 115.0]
axis = [0.0, 1.0, 0.2]
angle_deg = 12.0
velocity_m_s = [0.0, 0.0, -1.0]
[material]
name = "rock"
grain.density_kg_m3 = 2600.0
elastic.E_GPa = 0.5
elastic.nu = 0.2
contact.friction = 0.6
contact.restitution = 0.4
[contact]
law = "hertz_viscous"
[records]
rows = 200
figures = false
"#;

/// Writes a scene into a folder; its path.
pub fn scene(folder: &Path, text: &str) -> String {
    let path = folder.join("rocks.toml");
    std::fs::write(&path, text).expect("written");
    path.to_string_lossy().into_owned()
}

/// Runs a scene as a user types it; its folder.
pub fn run(folder: &Path, text: &str, name: &str, more: &[&str]) -> PathBuf {
    let (file, out) = (scene(folder, text), folder.join(name));
    comminute("run").arg(file).args(["--quiet", "--out"]).arg(&out).args(more).assert().success();
    out
}

/// A run of the scene in `file` that is stopped after any of so many steps, and goes on on two threads, leaves the bytes of the whole run in these files.
pub fn resumes(whole: &Path, file: &str, stops: &[u64], files: &[&str]) {
    for stop in stops.iter().map(u64::to_string) {
        let parts = whole.with_file_name(format!("stopped_after_{stop}"));
        let mut command = comminute("run");
        command.arg(file).args(["--quiet", "--threads", "1", "--stop-after", &stop, "--out"]).arg(&parts).assert().code(130);
        comminute("resume").arg(&parts).args(["--threads", "2", "--quiet"]).assert().success();
        for name in files {
            let [a, b] = [whole, &parts].map(|out| std::fs::read(out.join(name)).expect(name));
            assert!(a == b, "{name} after {stop} steps");
        }
    }
}

/// A scene without points needs no grid; its records tell what bodies press on each other, and a run that was stopped goes on to the same bytes on two threads.
#[test]
fn rocks_fall_on_each_other_and_resume_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = run(folder.path(), ROCKS, "whole", &["--threads", "1"]);
    let s = summary(&whole);
    assert_eq!((s["blocks"].as_u64(), s["points"].as_u64(), s["grains"].as_u64()), (Some(3), Some(0), Some(1)), "{s}");
    assert!(["bytes_per_point", "point_steps_per_second"].iter().all(|key| s.get(key).is_none()), "{s}");
    let half = number(&s, "steps") as u64 / 2;
    resumes(&whole, &scene(folder.path(), ROCKS), &[half], &["blocks.csv", "history.csv", "grains_final.csv"]);
    let mut reader = csv::Reader::from_path(whole.join("blocks.csv")).expect("blocks");
    let header = reader.headers().expect("header").clone();
    let column = |name: &str| header.iter().position(|h| h == name).expect("column");
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("row")).collect();
    let of = |row: &csv::StringRecord, name: &str| row[column(name)].parse::<f64>().expect("number");
    // forces between bodies add up to nothing at any time
    let mut pressed = 0;
    for at in rows.chunks(3) {
        for name in ["blocks_x_N", "blocks_y_N", "blocks_z_N"] {
            let forces: Vec<f64> = at.iter().map(|row| of(row, name)).collect();
            assert!(forces.iter().sum::<f64>().abs() < 1e-8 * (1.0 + forces[0].abs()), "{name}: {forces:?}");
            pressed += usize::from(forces.iter().any(|f| *f != 0.0));
        }
    }
    assert!(pressed > 3 && rows.iter().all(|row| of(row, "z_m") > 0.009), "{pressed}");
}

/// Checks that `text` with `to` for the first `from` is refused with a message that has `says` in it.
pub fn refused(folder: &Path, text: &str, from: &str, to: &str, says: &str) {
    let changed = text.replacen(from, to, 1);
    assert_ne!(changed, text, "{from}");
    comminute("check").arg(scene(folder, &changed)).assert().code(2).stderr(contains(says));
}

#[test]
fn bodies_that_cannot_stand_together_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    for (from, to, says) in [
        (
            "position_mm = [55.0, 55.0, 75.0]",
            "position_mm = [40.0, 40.0, 35.0]",
            "must be further from block 0: they overlap more than 0.5 of the radii of their edges",
        ),
        ("position_mm = [50.0, 50.0, 115.0]", "position_mm = [55.0, 55.0, 75.0]", "must be further from block 1"),
        ("[[wall]]", "grid.cell_mm = 8.0\n[[wall]]", "grid.cell_mm = 8: has no meaning without a [[body]] of points"),
        ("[[wall]]", "grid.z_low = \"stick\"\n[[wall]]", "grid.z_low = \"stick\": has no meaning without a [[body]] of points"),
    ] {
        refused(folder.path(), ROCKS, from, to, says);
    }
    // one of two may be sharp
    let one = ROCKS.replacen("rounding_mm = 2.0", "", 1);
    comminute("check").arg(scene(folder.path(), &one)).assert().success();
    // without any round edge the direction of the force is not known
    let sharp =
        ROCKS.replace("rounding_mm = 2.0", "").replace("position_mm = [55.0, 55.0, 75.0]", "position_mm = [45.0, 45.0, 60.0]");
    comminute("check").arg(scene(folder.path(), &sharp)).assert().code(2).stderr(contains("one of the two needs rounding_mm"));
}

/// A floor that is held, on a wall and in it, has forces that are numbers.
#[test]
fn a_held_body_on_a_wall_has_numbers() {
    let folder = tempfile::tempdir().expect("folder");
    let text = [
        ("[35.0, 35.0, 30.0]", "[35.0, 35.0, 60.0]"),
        ("[55.0, 55.0, 75.0]", "[55.0, 55.0, 120.0]"),
        ("[0.08, 0.02, 0.02]", "[0.08, 0.02, 0.2]"),
        (
            "[50.0, 50.0, 115.0]\naxis = [0.0, 1.0, 0.2]\nangle_deg = 12.0\nvelocity_m_s = [0.0, 0.0, -1.0]",
            "[50.0, 50.0, 9.99]\ndriven = true",
        ),
        ("duration_s = 0.3", "duration_s = 0.01"),
    ]
    .into_iter()
    .fold(ROCKS.to_string(), |text, (from, to)| text.replace(from, to));
    let out = run(folder.path(), &text, "out", &[]);
    let mut reader = csv::Reader::from_path(out.join("blocks.csv")).expect("blocks");
    let walls = reader.headers().expect("header").iter().position(|h| h == "walls_z_N").expect("column");
    let last = reader.records().map(|r| r.expect("row")).filter(|r| &r[2] == "2").last().expect("a row");
    assert!(
        last.iter().all(|x| x.parse::<f64>().is_ok_and(f64::is_finite)) && last[walls].parse::<f64>().expect("number") > 0.0,
        "{last:?}"
    );
}

/// What is pressed deeper than its edges are round ends the run with the reason, and keeps its records.
#[test]
fn bodies_deep_in_each_other_end_the_run() {
    let folder = tempfile::tempdir().expect("folder");
    let text = ROCKS.replace("E_GPa = 0.5", "E_GPa = 0.0005").replace("rounding_mm = 2.0", "rounding_mm = 0.5");
    let out = folder.path().join("out");
    let mut command = comminute("run");
    command.arg(scene(folder.path(), &text)).args(["--quiet", "--out"]).arg(&out);
    let failed = command.assert().failure();
    let told = String::from_utf8_lossy(&failed.get_output().stderr).to_string();
    assert!(told.contains("of the radii of their edges"), "{told}");
    assert!(out.join("blocks.csv").exists());
}

/// A pentagon falls on a rod that is held.
const PLANE: &str = r#"
kind = "mixture"
duration_s = 0.1
gravity_m_s2 = [0.0, -9.81, 0.0]
grid.plane_strain = true
[[block]]
shape = "polygon"
points_mm = [-100.0, 0.0, 100.0, 0.0]
rounding_mm = 10.0
position_mm = [0.0, 0.0, 0.0]
driven = true
[[block]]
shape = "polygon"
points_mm = [0.0, 0.0, 40.0, 0.0, 50.0, 30.0, 20.0, 50.0, -10.0, 30.0]
rounding_mm = 4.0
position_mm = [0.0, 50.0, 0.0]
[contact]
law = "spring"
[material]
name = "stone"
grain.density_kg_m3 = 2500.0
elastic.E_GPa = 1.0
elastic.nu = 0.2
contact.friction = 0.5
spring.k_n_N_m = 1e8
spring.k_t_N_m = 5e7
[records]
figures = false
"#;

#[test]
fn what_cannot_be_in_the_plane_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    comminute("check").arg(scene(folder.path(), PLANE)).assert().success();
    for (from, to, says) in [
        ("law = \"spring\"", "law = \"hertz\"", "must be \"spring\" in plane strain"),
        ("grid.plane_strain = true", "", "\"polygon\" needs grid.plane_strain = true"),
        ("20.0, 50.0, -10.0, 30.0]", "20.0, 20.0, -10.0, 30.0]", "must be the corners of a convex outline: 4 of 5 are"),
        ("-10.0, 30.0]", "-10.0]", "must be x, y of each corner, one after the other; there are 9 numbers"),
        ("rounding_mm = 10.0", "", "have no area: give rounding_mm"),
        ("[0.0, 50.0, 0.0]", "[0.0, 50.0, 5.0]", "must have 0 along z in plane strain"),
        ("[0.0, 50.0, 0.0]", "[0.0, 25.0, 0.0]", "must be further from block 0"),
        (
            "[contact]",
            "[[grain]]\nposition_m = [0.0, 0.5, 0.0]\nradius_m = 0.01\n[contact]",
            "a disc is a [[block]] with shape = \"polygon\" and one corner",
        ),
        ("law = \"spring\"", "law = \"spring\"\npoint_radius_mm = 2.0", "has no meaning without both points and a [[block]]"),
        ("spring.k_n_N_m = 1e8", "", "spring.k_n_N_m: is missing"),
    ] {
        refused(folder.path(), PLANE, from, to, says);
    }
}
