//! Meshes as a user types them.

use crate::common::typed::{comminute, number, summary};
use predicates::str::contains;
use std::path::Path;

/// A trough of two sloping sides as OBJ, in cm.
const TROUGH: &str =
    "# a trough\nv -10 -10 10\nv 10 -10 10\nv -10 0 0\nv 10 0 0\nv -10 10 10\nv 10 10 10\nf 1 2 4 3\nf 3 4 6\nf 3 6 5\n";

/// A grain, a rock and some points fall into a trough.
const SCENE: &str = r#"
kind = "mixture"
duration_s = 0.12
gravity_m_s2 = [0.0, 0.0, -9.81]
[[block]]
shape = "mesh"
mesh_file = "trough.obj"
mesh_unit_mm = 10.0
position_mm = [0.0, 0.0, 0.0]
driven = true
rounding_mm = 1.0
[[block]]
shape = "box"
size_mm = [20.0, 24.0, 18.0]
position_mm = [-40.0, 5.0, 50.0]
axis = [1.0, 0.3, 0.2]
angle_deg = 20.0
[[grain]]
position_m = [0.04, 0.02, 0.045]
radius_m = 0.012
[[body]]
shape = "box"
min_mm = [-10.0, -10.0, 20.0]
max_mm = [10.0, 10.0, 40.0]
[grid]
cell_mm = 10.0
min_mm = [-100.0, -100.0, -50.0]
max_mm = [100.0, 100.0, 150.0]
[material]
name = "rock"
grain.density_kg_m3 = 2600.0
elastic.E_GPa = 0.02
elastic.nu = 0.2
contact.friction = 0.5
contact.restitution = 0.4
[material.continuum]
law = "elastic"
E_MPa = 0.5
nu = 0.2
[contact]
law = "hertz_viscous"
[records]
rows = 100
figures = false
"#;

/// Writes the scene and its mesh into a folder, with `text` and `mesh`.
fn scene(folder: &Path, text: &str, mesh: &[u8]) -> String {
    for name in ["trough.obj", "trough.stl", "trough.txt"] {
        std::fs::write(folder.join(name), mesh).expect("written");
    }
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).expect("written");
    path.to_string_lossy().into_owned()
}

/// A run is the same on one and two threads, and stopped and gone on with after its file is gone; `blocks.csv` has what presses on the mesh, and all records are numbers.
#[test]
fn a_run_on_a_mesh_resumes_to_the_byte_without_its_file() {
    let folder = tempfile::tempdir().expect("folder");
    let file = scene(folder.path(), SCENE, TROUGH.as_bytes());
    let [whole, two, parts] = ["whole", "two", "parts"].map(|name| folder.path().join(name));
    let run = |out: &Path, threads: &str, more: &[&str]| {
        let mut command = comminute("run");
        command.arg(&file).args(["--quiet", "--threads", threads, "--out"]).arg(out).args(more);
        command.assert()
    };
    run(&whole, "1", &[]).success();
    run(&two, "2", &[]).success();
    let s = summary(&whole);
    run(&parts, "2", &["--stop-after", &(number(&s, "steps") as u64 * 3 / 4).to_string()]).code(130);
    std::fs::remove_file(folder.path().join("trough.obj")).expect("removed");
    comminute("resume").arg(&parts).args(["--threads", "1", "--quiet"]).assert().success();
    let bytes = |out: &Path, name: &str| std::fs::read(out.join(name)).expect("a file");
    for name in ["blocks.csv", "history.csv", "grains_final.csv", "points_final.csv", "block_surfaces.csv"] {
        assert!(bytes(&whole, name) == bytes(&two, name), "{name} on two threads");
        assert!(bytes(&whole, name) == bytes(&parts, name), "{name} in two parts");
    }
    let mut reader = csv::Reader::from_path(whole.join("blocks.csv")).expect("blocks");
    let header = reader.headers().expect("header").clone();
    let rows: Vec<csv::StringRecord> = reader.records().map(|r| r.expect("row")).filter(|r| &r[2] == "0").collect();
    let most = |name: &str| {
        let column = header.iter().position(|h| h == name).expect("column");
        rows.iter().map(|r| r[column].parse::<f64>().expect("number").abs()).fold(0.0, f64::max)
    };
    for name in ["points_z_N", "grains_z_N", "blocks_z_N"] {
        assert!(most(name) > 0.1, "nothing in {name}");
    }
    assert!(most("walls_z_N") == 0.0 && most("kinetic_J") == 0.0 && most("mass_kg") == 0.0);
    assert!(rows.iter().flatten().all(|x| x.parse::<f64>().is_ok_and(f64::is_finite)));
    // the resolved scene is the same scene
    let again = folder.path().join("again");
    let resolved = whole.join("scene.resolved.toml");
    comminute("run").arg(resolved).args(["--quiet", "--out"]).arg(&again).assert().success();
    assert!(bytes(&whole, "blocks.csv") == bytes(&again, "blocks.csv"));
}

/// `check` says what a mesh is, for people and as JSON.
#[test]
fn check_says_what_a_mesh_is() {
    let folder = tempfile::tempdir().expect("folder");
    let file = scene(folder.path(), SCENE, TROUGH.as_bytes());
    let says = "mesh of rock, 4 triangles in 2 facets, open, 200.0000 × 200.0000 × 100.0000 mm";
    comminute("check").arg(&file).assert().success().stderr(contains(says));
    comminute("check").args([&file, "--json"]).assert().success().stdout(contains(says));
}

/// A binary STL file of these triangles.
fn binary(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for t in triangles {
        bytes.extend([0; 12]);
        bytes.extend(t.iter().flatten().flat_map(|x| x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Every file and key that makes no sheet is refused before anything is computed, by the key of its block with the reason.
#[test]
fn what_is_no_sheet_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let refused = |text: &str, mesh: &[u8], says: &[&str]| {
        let mut check = comminute("check").arg(scene(folder.path(), text, mesh)).assert().code(2);
        for part in says {
            check = check.stderr(contains(*part));
        }
    };
    let obj = |from: &str, to: &str| TROUGH.replacen(from, to, 1).into_bytes();
    let file = "scene.toml: block[0].mesh_file";
    // the file
    refused(SCENE, b"", &[file, "has no triangles"]);
    refused(SCENE, &obj("f 1 2 4 3\n", "f 1 2 9\n"), &[file, "line 8 (`f 1 2 9`): must be a face with three or more"]);
    refused(
        SCENE,
        &obj("v 10 0 0\n", "v 10 nan 0\n"),
        &[file, "line 5 (`v 10 nan 0`): must be a vertex with three finite numbers"],
    );
    refused(SCENE, &obj("f 3 4 6\n", "f 3 3 6\n"), &[file, "has a flat triangle, number 2 from 0"]);
    refused(
        SCENE,
        &obj("f 3 6 5\n", "f 3 6 5\nf 3 4 5\n"),
        &[file, "has 3 triangles at one edge, where two may meet at most: numbers 1, 2, 4"],
    );
    refused(SCENE, &obj("v 10 0 0\n", "v 1e9 0 0\n"), &[file, "which is no place"]);
    refused(SCENE, b"hello\n", &[file, "is no line of an OBJ file"]);
    refused(SCENE, &[0xff, 0xfe], &[file, "is not UTF-8 text"]);
    refused(&SCENE.replace("trough.obj", "gone.obj"), b"", &["block[0].mesh_file", "no such file"]);
    refused(&SCENE.replace("trough.obj", "trough.txt"), b"", &[file, "must end in .stl or .obj"]);
    let stl = SCENE.replace("trough.obj", "trough.stl");
    let one = binary(&[[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    refused(
        &stl,
        &one[..one.len() - 7],
        &[file, "is cut off: as a binary file it has 1 triangles, which take 134 bytes, and it has 127"],
    );
    refused(&stl, &one[..40], &[file, "is no STL file: it has 40 bytes"]);
    refused(&stl, &binary(&[]), &[file, "has no triangles"]);
    refused(
        &stl,
        &binary(&[[[0.0; 3], [1.0, f32::NAN, 0.0], [0.0, 1.0, 0.0]]]),
        &[file, "has a vertex of triangle 0 from 0 at NaN"],
    );
    refused(
        &stl,
        b"solid x\nfacet\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendfacet\n",
        &[file, "is cut off: it does not end with endsolid"],
    );
    refused(
        &stl,
        b"solid x\nfacet\nvertex 0 0 0\nvertex 1 0 0\nendfacet\nendsolid\n",
        &[file, "line 5 (`endfacet`): ends a facet of 2 vertices"],
    );
    let many = (0..=100_000).map(|k| [[k as f32, 0.0, 0.0], [k as f32, 1.0, 0.0], [k as f32, 0.0, 1.0]]).collect::<Vec<_>>();
    refused(&stl, &binary(&many), &[file, "has more than 100000 triangles"]);
    // the keys
    let good = TROUGH.as_bytes();
    for (from, to, says) in [
        ("mesh_unit_mm = 10.0\n", "", "block[0].mesh_unit_mm: is missing: the length of the file's unit"),
        ("mesh_unit_mm = 10.0", "mesh_unit_mm = 0.0", "block[0].mesh_unit_mm = 0"),
        ("mesh_unit_mm = 10.0", "mesh_unit_mm = \"cm\"", "block[0].mesh_unit_mm = \"cm\""),
        ("driven = true\n", "", "block[0].driven = false: must be true: a mesh has no mass"),
        ("rounding_mm = 1.0\n", "rounding_mm = -1.0\n", "block[0].rounding_mm = -1"),
        ("rounding_mm = 1.0\n", "rounding_mm = 1.0\nsize_mm = [1.0, 1.0, 1.0]\n", "has no meaning with shape = \"mesh\""),
        ("rounding_mm = 1.0\n", "triangles = [0, 1, 2]\n", "must not stand beside vertices_mm and triangles"),
        ("mesh_file = \"trough.obj\"\nmesh_unit_mm = 10.0\n", "", "is missing: shape = \"mesh\" needs it (or mesh_file)"),
        (
            "mesh_file = \"trough.obj\"\nmesh_unit_mm = 10.0\n",
            "vertices_mm = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]\ntriangles = [0, 1, 3]\n",
            "has triangle 0 with the vertices [0, 1, 3] of 3",
        ),
        (
            "mesh_file = \"trough.obj\"\nmesh_unit_mm = 10.0\n",
            "vertices_mm = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]\ntriangles = [0, 1]\n",
            "must be three numbers of each",
        ),
        ("shape = \"box\"\nsize_mm", "shape = \"box\"\nmesh_unit_mm = 1.0\nsize_mm", "has no meaning with shape = \"box\""),
        // its place
        ("[0.04, 0.02, 0.045]", "[0.04, 0.02, 0.03]", "must not put the mesh through grains: grain 0 overlaps it by 0."),
        ("[-40.0, 5.0, 50.0]", "[-40.0, 5.0, 10.0]", "must be further from block 0: they overlap more than 0.5 of the radii"),
        ("min_mm = [-10.0, -10.0, 20.0]", "min_mm = [-10.0, -10.0, 2.0]", "must not put the mesh through points: it cuts"),
        (
            "shape = \"box\"\nsize_mm = [20.0, 24.0, 18.0]\nposition_mm = [-40.0, 5.0, 50.0]",
            "shape = \"superquadric\"\nblockiness = [4.0, 4.0]\nsize_mm = [20.0, 24.0, 18.0]\nposition_mm = [-40.0, 5.0, 10.0]",
            "must be further from block 0: they overlap more than 0.5 of the radii of their edges",
        ),
        ("[grid]\n", "[grid]\nplane_strain = true\n", "must be \"polygon\" in plane strain"),
    ] {
        let text = SCENE.replacen(from, to, 1);
        assert_ne!(text, SCENE, "{from}");
        refused(&text, good, &[says]);
    }
}
