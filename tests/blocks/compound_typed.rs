//! Compounds as a user types them.

use crate::common::typed::{comminute, number, summary};
use crate::typed::{refused, resumes, run, scene};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;
use std::path::Path;

/// A tripod of a box and two rounded bars, an L of boxes and a grain fall onto a floor.
const SCENE: &str = r#"
kind = "mixture"
duration_s = 0.15
gravity_m_s2 = [0.0, 0.0, -9.81]
[[wall]]
kind = "plane"
point_m = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
friction = 0.5
[[grain]]
position_m = [0.004, 0.002, 0.145]
radius_m = 0.012
[[block]]
shape = "compound"
position_mm = [0.0, 0.0, 40.0]
axis = [1.0, 0.4, 0.0]
angle_deg = 25.0
[[block.part]]
shape = "box"
size_mm = [60.0, 14.0, 14.0]
[[block.part]]
shape = "polyhedron"
points_mm = [-4.0, -4.0, 0.0, 4.0, -4.0, 0.0, 0.0, 5.0, 0.0, -3.0, -3.0, 40.0, 3.0, -3.0, 40.0, 0.0, 4.0, 40.0]
rounding_mm = 2.0
[[block.part]]
shape = "polyhedron"
points_mm = [-4.0, -4.0, 0.0, 4.0, -4.0, 0.0, 0.0, 5.0, 0.0, -3.0, -3.0, 40.0, 3.0, -3.0, 40.0, 0.0, 4.0, 40.0]
rounding_mm = 2.0
axis = [1.0, 0.0, 0.0]
angle_deg = 115.0
[[block]]
shape = "compound"
position_mm = [5.0, 3.0, 110.0]
velocity_m_s = [0.0, 0.0, -1.0]
part = [{ shape = "box", size_mm = [50.0, 16.0, 12.0] }, { shape = "box", size_mm = [12.0, 16.0, 40.0], position_mm = [19.0, 0.0, -14.0] }]
[contact]
law = "hertz_viscous"
[material]
name = "rock"
grain.density_kg_m3 = 2600.0
elastic.E_GPa = 0.5
elastic.nu = 0.2
contact.friction = 0.5
contact.restitution = 0.4
[records]
rows = 100
"#;

/// A run is the same on one and two threads and after a stop; `check` and the records tell of the compounds.
#[test]
fn compounds_fall_and_resume_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let [whole, two] =
        [("whole", "1"), ("two", "2")].map(|(name, threads)| run(folder.path(), SCENE, name, &["--threads", threads]));
    let bytes = |out: &Path, name: &str| std::fs::read(out.join(name)).expect("a file");
    let files = ["blocks.csv", "history.csv", "grains_final.csv", "block_surfaces.csv"];
    for name in files {
        assert!(bytes(&whole, name) == bytes(&two, name), "{name} on two threads");
    }
    let file = scene(folder.path(), SCENE);
    resumes(&whole, &file, &[number(&summary(&whole), "steps") as u64 / 2], &files);
    // what the run has resolved runs to the same bytes again
    let again = folder.path().join("again");
    let mut command = comminute("run");
    command.arg(whole.join("scene.resolved.toml")).args(["--quiet", "--threads", "1", "--out"]).arg(&again).assert().success();
    assert!(bytes(&whole, "blocks.csv") == bytes(&again, "blocks.csv"));
    // surfaces of all parts: 12 triangles of each box
    let surfaces = String::from_utf8(bytes(&whole, "block_surfaces.csv")).expect("text");
    assert_eq!(surfaces.lines().filter(|line| line.starts_with("1,")).count(), 3 * 24);
    assert!(whole.join("figures").read_dir().expect("figures").count() > 0);
    let says = "compound of rock of 3 parts";
    comminute("check").arg(&file).assert().success().stderr(contains(says).and(contains("compound of rock of 2 parts")));
}

/// What is no compound is refused with file, key, body and value.
#[test]
fn compounds_that_cannot_be_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let last = "{ shape = \"box\", size_mm = [12.0, 16.0, 40.0], position_mm = [19.0, 0.0, -14.0] }";
    for (from, to, says) in [
        ("part = [{", "parts = [{", "block[1].parts: unknown key; did you mean block[1].part?"),
        (&format!(", {last}]"), "]", "must be 2 to 100 parts; there are 1"),
        (
            "position_mm = [19.0, 0.0, -14.0]",
            "position_mm = [91.0, 0.0, -14.0]",
            "must hang together: part 1 neither overlaps nor touches",
        ),
        ("{ shape = \"box\", size_mm = [12.0", "{ shape = \"ball\", size_mm = [12.0", "block[1].part[1].shape = \"ball\""),
        (
            "{ shape = \"box\", size_mm = [12.0",
            "{ shape = \"superquadric\", size_mm = [12.0",
            "superquadrics and meshes cannot be parts",
        ),
        (
            "{ shape = \"box\", size_mm = [12.0",
            "{ shape = \"polygon\", size_mm = [12.0",
            "\"polygon\" needs grid.plane_strain = true",
        ),
        (
            "size_mm = [60.0, 14.0, 14.0]",
            "points_mm = [60.0, 14.0, 14.0]",
            "block[0].part[0].size_mm: is missing: shape = \"box\" needs it",
        ),
        (
            "size_mm = [60.0, 14.0, 14.0]",
            "size_mm = [60.0, 14.0, 14.0]\nrounding_mm = 2.0",
            "block[0].part[0].rounding_mm = 2: has no meaning with shape = \"box\"",
        ),
        ("size_mm = [60.0, 14.0, 14.0]", "size_mm = [60.0, 14.0, 0.0]", "block[0].part[0].size_mm"),
        ("axis = [1.0, 0.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "block[0].part[2].axis = [0.0, 0.0, 0.0]: must not be zero"),
        ("4.0, 40.0]\nrounding_mm = 2.0\n[[", "4.0]\nrounding_mm = 2.0\n[[", "block[0].part[1].points_mm"),
        (
            "angle_deg = 115.0",
            "angle_deg = 115.0\ndriven = true",
            "block[0].part[2].driven: unknown key here; did you mean block.driven?",
        ),
        (
            "position_mm = [0.0, 0.0, 40.0]",
            "position_mm = [0.0, 0.0, 40.0]\nsize_mm = [1.0, 1.0, 1.0]",
            "block[0].size_mm = [1.0, 1.0, 1.0]: has no meaning with shape = \"compound\"",
        ),
        (
            "shape = \"compound\"\nposition_mm = [5",
            "shape = \"box\"\nsize_mm = [9.0, 9.0, 9.0]\nposition_mm = [5",
            "has no meaning with shape = \"box\"",
        ),
        ("[5.0, 3.0, 110.0]", "[5.0, 3.0, 70.0]", "must be further from block 0"),
        ("[0.004, 0.002, 0.145]", "[0.004, 0.002, 0.115]", "must not put the block over grains"),
        ("[0.0, 0.0, 40.0]", "[0.0, 0.0, 20.0]", "must not put the block through a wall"),
    ] {
        refused(folder.path(), SCENE, from, to, says);
    }
    // a list of parts that is none, and a compound without parts
    let [from, to] = ["part = [{ shape", "part = 3\nother = [{ shape"];
    comminute("check")
        .arg(scene(folder.path(), &SCENE.replace(from, to)))
        .assert()
        .code(2)
        .stderr(contains("written [[block.part]]"));
    let none = SCENE.replace("[[block.part]]", "[[wall]]");
    comminute("check").arg(scene(folder.path(), &none)).assert().code(2);
    let lone = "kind = \"mixture\"\nduration_s = 1.0\n[[block]]\nshape = \"compound\"\nposition_mm = [0.0, 0.0, 0.0]\n[material]\nname = \"a\"\ngrain.density_kg_m3 = 1.0\nelastic.E_GPa = 1.0\nelastic.nu = 0.2\ncontact.friction = 0.1\n";
    let says = "block[0].part: is missing: shape = \"compound\" needs it";
    comminute("check").arg(scene(folder.path(), lone)).assert().code(2).stderr(contains(says));
    // a graphics device
    comminute("run").arg(scene(folder.path(), SCENE)).args(["--backend", "gpu"]).assert().failure();
}

/// Non-convex outlines of the plane, by their parts.
const PLANE: &str = r#"
kind = "mixture"
duration_s = 0.05
gravity_m_s2 = [0.0, -9.81, 0.0]
grid.plane_strain = true
[[block]]
shape = "polygon"
points_mm = [-100.0, 0.0, 100.0, 0.0]
rounding_mm = 10.0
position_mm = [0.0, 0.0, 0.0]
driven = true
[[block]]
shape = "compound"
position_mm = [0.0, 40.0, 0.0]
[[block.part]]
shape = "polygon"
points_mm = [0.0, 0.0, 60.0, -30.0, 20.0, 0.0]
rounding_mm = 4.0
[[block.part]]
shape = "polygon"
points_mm = [0.0, 0.0, 20.0, 0.0, 60.0, 30.0]
rounding_mm = 4.0
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
fn outlines_of_the_plane_are_refused_by_name() {
    let folder = tempfile::tempdir().expect("folder");
    comminute("check").arg(scene(folder.path(), PLANE)).assert().success();
    for (from, to, says) in [
        ("grid.plane_strain = true", "", "\"polygon\" needs grid.plane_strain = true"),
        ("[0.0, 0.0, 20.0, 0.0, 60.0, 30.0]", "[0.0, 0.0, 20.0, 0.0, 60.0, 30.0, 20.0, 5.0]", "block[1].part[1].points_mm"),
        (
            "[0.0, 0.0, 20.0, 0.0, 60.0, 30.0]",
            "[0.0, 0.0, 20.0, 0.0, 60.0, 30.0, 20.0, 5.0]",
            "must be the corners of a convex outline: 3 of 4 are",
        ),
        ("[0.0, 0.0, 20.0, 0.0, 60.0, 30.0]", "[0.0, 0.0, 20.0]", "must be x, y of each corner"),
        (
            "rounding_mm = 4.0\n[contact]",
            "rounding_mm = 4.0\nposition_mm = [0.0, 0.0, 1.0]\n[contact]",
            "must have 0 along z in plane strain",
        ),
        (
            "rounding_mm = 4.0\n[contact]",
            "rounding_mm = 4.0\naxis = [1.0, 0.0, 0.0]\n[contact]",
            "block[1].part[1].axis = [1.0, 0.0, 0.0]: must be [0, 0, 1] in plane strain",
        ),
        ("position_mm = [0.0, 40.0, 0.0]", "position_mm = [0.0, 25.0, 0.0]", "must be further from block 0"),
    ] {
        refused(folder.path(), PLANE, from, to, says);
    }
}
