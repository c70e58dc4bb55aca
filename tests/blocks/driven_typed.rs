//! Bodies on paths, pushed, held and joined bodies as a user types them.

use crate::common::typed::{columns, comminute, number, summary};
use crate::typed::{refused, resumes, run, scene};
use predicates::str::contains;
use std::path::Path;

/// A table that moves along a path, a brick that is glued to it, a lid that is pressed on the brick, and a bar on a hinge that falls on both.
const SCENE: &str = r#"
kind = "mixture"
duration_s = 0.2
gravity_m_s2 = [0.0, 0.0, -9.81]
[[block]]
shape = "box"
size_mm = [300.0, 300.0, 40.0]
position_mm = [0.0, 0.0, -20.0]
path_s = [0.0, 0.05, 0.15]
path_mm = [0.0, 0.0, -20.0, 3.0, 0.0, -20.0, -3.0, 0.0, -20.0]
path_deg = [0.0, 0.0, 1.0]
[[block]]
shape = "box"
size_mm = [80.0, 80.0, 60.0]
position_mm = [0.0, 0.0, 30.0]
[[block]]
shape = "box"
size_mm = [100.0, 100.0, 20.0]
position_mm = [0.0, 0.0, 70.0]
stress_kPa = [0.0, 0.0, -2.0]
ramp_s = 0.05
held = ["x", "y", "rotation"]
[[block]]
shape = "box"
size_mm = [200.0, 30.0, 30.0]
position_mm = [220.0, 0.0, 60.0]
[[joint]]
kind = "glue"
blocks = [0, 1]
position_mm = [0.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
radius_mm = 20.0
thickness_mm = 10.0
E_MPa = 20.0
damping = 0.1
shear_MPa = 0.005
[[joint]]
kind = "hinge"
blocks = [3]
position_mm = [320.0, 0.0, 60.0]
axis = [0.0, 1.0, 0.0]
radius_mm = 10.0
thickness_mm = 10.0
E_MPa = 20.0
[material]
name = "brick"
grain.density_kg_m3 = 2000.0
elastic.E_GPa = 0.2
elastic.nu = 0.2
contact.friction = 0.6
contact.restitution = 0.4
[contact]
law = "hertz_viscous"
[records]
rows = 100
figures = false
"#;

/// A run that was stopped before and after glue broke goes on to the same bytes on two threads; its tables say what was done, and when the glue broke.
#[test]
fn driven_and_joined_blocks_resume_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = run(folder.path(), SCENE, "whole", &["--threads", "1"]);
    let s = summary(&whole);
    assert_eq!((s["joints"].as_u64(), s["joints_broken"].as_u64()), (Some(2), Some(1)), "{s}");
    let stops = [0.1, 0.7].map(|share| (number(&s, "steps") * share) as u64);
    resumes(&whole, &scene(folder.path(), SCENE), &stops, &["blocks.csv", "joints.csv", "history.csv"]);
    let bytes = |out: &Path, name: &str| std::fs::read(out.join(name)).expect("a file");
    // the resolved scene gives the same run
    let again = folder.path().join("again");
    comminute("run").arg(whole.join("scene.resolved.toml")).args(["--quiet", "--out"]).arg(&again).assert().success();
    assert!(bytes(&whole, "joints.csv") == bytes(&again, "joints.csv"));
    let read = |name: &str, wanted: [&str; 8]| -> Vec<[f64; 8]> {
        let mut reader = csv::Reader::from_path(whole.join(name)).expect("a table");
        let header = reader.headers().expect("header").clone();
        let at = wanted.map(|w| header.iter().position(|h| h == w).unwrap_or_else(|| panic!("{w} in {header:?}")));
        reader.records().map(|r| r.expect("row")).map(|row| at.map(|k| row[k].parse().expect("number"))).collect()
    };
    // the table is where its path says, to the digits that a table keeps; the lid bears 2 kPa on 100 cm²
    let rows = read("blocks.csv", ["block", "time_s", "x_m", "joints_x_N", "outer_z_N", "outer_work_J", "blocks_z_N", "kinetic_J"]);
    for row in rows.iter().filter(|row| row[0] == 0.0) {
        let t = row[1];
        let x = if t < 0.05 { 0.06 * t } else { (0.003 - 0.06 * (t - 0.05)).max(-0.003) };
        assert!((row[2] - x).abs() < 1e-9, "{row:?}");
    }
    let lid = rows.iter().rfind(|row| row[0] == 2.0).expect("a row");
    assert!((lid[4] + 20.0).abs() < 1e-9, "{lid:?}");
    // joints on a joint's two bodies add up to nothing, and the energy that went is told
    for at in rows.chunks(4) {
        assert!((at[0][3] + at[1][3]).abs() < 1e-9 * (1.0 + at[0][3].abs()), "{at:?}");
    }
    let joints =
        read("joints.csv", ["joint", "second", "time_s", "utilisation", "broken_at_s", "elastic_J", "viscous_J", "released_J"]);
    let glue: Vec<_> = joints.iter().filter(|row| row[0] == 0.0).collect();
    let broken = glue.last().expect("a row")[4];
    assert!(broken > 0.0 && glue.iter().all(|row| (row[4] == -1.0) == (row[2] < broken) && row[3] < 1.0), "{glue:?}");
    assert!(glue.last().expect("a row")[7] > 0.0 && joints[1][1] == -1.0);
    let history = columns(&whole, ["driven_work_J", "dissipated_J"]);
    assert!((history.last().expect("a row")[0] / number(&s, "driven_work_J") - 1.0).abs() < 1e-6, "{history:?}");
}

/// A run that takes the folder of another one removes the tables that it does not write: of joints, walls and breakages.
#[test]
fn a_folder_that_is_used_again_keeps_no_table_of_the_run_before() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let first = SCENE.replace("duration_s = 0.2", "duration_s = 0.002");
    run(folder.path(), &first, "out", &[]);
    let stale = ["joints.csv", "walls.csv", "block_breakage.csv"].map(|name| out.join(name));
    assert!(stale[0].exists());
    // as runs with a moving wall and with breakages leave them
    stale[1..].iter().for_each(|path| std::fs::write(path, "step\n").expect("written"));
    let [joints, rest] = ["[[joint]]", "[material]"].map(|word| first.find(word).expect("a table"));
    let without = format!("{}{}", &first[..joints], &first[rest..])
        .replace("position_mm = [0.0, 0.0, 30.0]", "position_mm = [0.0, 0.0, 30.5]");
    let higher = without.replace("position_mm = [0.0, 0.0, 70.0]", "position_mm = [0.0, 0.0, 71.0]");
    run(folder.path(), &higher, "out", &["--force"]);
    for path in stale {
        assert!(!path.exists(), "{}", path.display());
    }
}

/// A path from a file is the path in the scene, to the byte.
#[test]
fn a_path_may_stand_in_a_file() {
    let folder = tempfile::tempdir().expect("folder");
    let written = SCENE.replace("duration_s = 0.2", "duration_s = 0.02");
    let (from, to) = (written.find("path_s").expect("path"), written.find("path_deg").expect("path"));
    let end = to + written[to..].find('\n').expect("a line");
    let named = format!("{}path_csv = \"table.csv\"{}", &written[..from], &written[end..]);
    let table = folder.path().join("table.csv");
    std::fs::write(&table, "# a table\ntime_s,z_mm,x_mm,y_m,angle_deg\n0,-20,0,0,0\n0.05,-20,3,0,0\n0.15,-20,-3,0,1\n")
        .expect("file");
    let outs = [(&written, "one"), (&named, "two")]
        .map(|(text, name)| std::fs::read(run(folder.path(), text, name, &[]).join("blocks.csv")).expect("a table"));
    assert!(outs[0] == outs[1]);
    for (text, says) in [
        ("time_s,x_mm,y_mm\n0,0,0\n", "has no column z_mm"),
        ("time_s,x_mm,y_mm,z_mm,v\n0,0,0,0,0\n", "unknown column"),
        ("time_s,x_mm,y_mm,z_mm\n", "holds no rows"),
        ("time_s,x_mm,y_mm,z_mm\n0,0,a,0\n", "must be a finite number"),
        ("time_s,x_mm,x_m,y_mm,z_mm\n0,0,0,0,0\n", "this quantity has two columns"),
        ("time_s,x_mm,y_mm,z_mm\n0,0,0,-20\n0,0,0,-20\n", "must rise from row to row: row 1"),
    ] {
        std::fs::write(&table, text).expect("file");
        comminute("check").arg(scene(folder.path(), &named)).assert().code(2).stderr(contains(says));
    }
    std::fs::remove_file(&table).expect("removed");
    comminute("check").arg(scene(folder.path(), &named)).assert().code(2).stderr(contains("no such file"));
    let both = written.replacen("path_s =", "path_csv = \"table.csv\"\npath_s =", 1);
    comminute("check").arg(scene(folder.path(), &both)).assert().code(2).stderr(contains("must not stand beside path_s"));
}

#[test]
fn what_a_block_cannot_do_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
    comminute("check").arg(scene(folder.path(), SCENE)).assert().success();
    for (from, to, says) in [
        (
            "path_s = [0.0, 0.05, 0.15]",
            "path_s = [0.0, 0.15, 0.05]",
            "block[0].path_s = [0.0, 0.15, 0.05]: must rise from row to row: row 2",
        ),
        ("path_s = [0.0, 0.05, 0.15]", "path_s = [0.0, 0.05]", "6 numbers; there are 9"),
        ("path_s = [0.0, 0.05, 0.15]", "", "block[0].path_s: is missing: a path needs the times"),
        ("path_deg = [0.0, 0.0, 1.0]", "path_deg = [0.0, 1.0]", "must have an angle for each time of path_s, 3; there are 2"),
        ("path_deg = [0.0, 0.0, 1.0]", "path_deg = [1.0, 0.0, 1.0]", "must begin with 0"),
        ("path_mm = [0.0, 0.0, -20.0,", "path_mm = [0.0, 0.0, -19.0,", "must begin at position_mm"),
        ("path_s =", "path_axis = [0.0, 0.0, 0.0]\npath_s =", "block[0].path_axis = [0.0, 0.0, 0.0]: must not be zero"),
        ("path_s =", "velocity_m_s = [1.0, 0.0, 0.0]\npath_s =", "must be [0, 0, 0] for a block on a path"),
        ("path_s =", "force_N = [1.0, 0.0, 0.0]\npath_s =", "has no meaning for a block on a path"),
        ("stress_kPa", "driven = true\nstress_kPa", "block[2].stress_kPa = [0.0, 0.0, -2.0]: has no meaning with driven = true"),
        ("stress_kPa", "angle_deg = 3.0\nstress_kPa", "needs angle_deg = 0"),
        ("stress_kPa = [0.0, 0.0, -2.0]", "", "block[2].ramp_s = 0.05: has no meaning without force_N"),
        (
            "ramp_s = 0.05",
            "push_s = [0.0, 1.0]",
            "block[2].push_s = [0.0, 1.0]: must be times and as many shares: push_s has 2, push_share has 0",
        ),
        ("ramp_s = 0.05", "push_s = [0.0, 1.0, 1.0]\npush_share = [0.0, 1.0, 0.0]", "must rise from row to row: row 2"),
        ("ramp_s = 0.05", "ramp_s = 0.05\npush_share = [0.0]", "block[2].push_share = [0.0]: must not stand beside ramp_s"),
        ("[\"x\", \"y\", \"rotation\"]", "[\"x\", \"tilt\"]", "must be a list of some of \"x\", \"y\", \"z\", \"rotation\""),
        (
            "size_mm = [100.0, 100.0, 20.0]",
            "size_mm = [100.0, 100.0, 20.0]\nblockiness = [4.0, 4.0]",
            "has no meaning with shape = \"box\"",
        ),
        ("[contact]", "[contact]\nrotation = \"fixed\"", "block[0].path_deg = [0.0, 0.0, 1.0]: must be 0 where contact.rotation"),
        ("blocks = [0, 1]", "blocks = [0, 9]", "joint[0].blocks = [0, 9]: there is no [[block]] 9; there are 4, from 0"),
        ("blocks = [0, 1]", "blocks = [1, 1]", "must be two blocks, or one that is joined to the world"),
        ("blocks = [0, 1]", "blocks = [0, 1, 2]", "there are 3"),
        ("blocks = [0, 1]", "blocks = []", "there are 0"),
        ("blocks = [3]", "blocks = [0]", "joint[1].blocks = [0]: block 0 is driven, so nothing joins it to the world"),
        ("blocks = [3]\n", "blocks = [3]\ntension_MPa = 1.0\n", "has no meaning but for glue"),
        ("axis = [0.0, 0.0, 1.0]\nradius", "radius", "joint[0].axis: is missing: glue needs the direction"),
        ("axis = [0.0, 1.0, 0.0]\nradius", "radius", "joint[1].axis: is missing: a hinge needs the axis"),
        ("axis = [0.0, 1.0, 0.0]\nradius", "axis = [0.0, 0.0, 0.0]\nradius", "must not be zero"),
        ("kind = \"hinge\"", "kind = \"ball\"", "has no meaning for a ball joint"),
        ("E_MPa = 20.0\ndamping", "damping", "joint[0].E_MPa: is missing"),
        ("kind = \"glue\"", "kind = \"glu\"", "did you mean \"glue\"?"),
        ("[contact]", "[crushing]\nenabled = true\n[contact]", "bodies that break are not"),
        (
            "shape = \"box\"\nsize_mm = [80.0, 80.0, 60.0]",
            "shape = \"polyhedron\"\nforce_N = [1.0, 0.0, 0.0]\nstress_kPa = [0.0, 0.0, 1.0]\npoints_mm = [0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 30.0, 0.0, 0.0, 0.0, 30.0]\nrounding_mm = 2.0",
            "needs shape = \"box\": of other shapes write force_N",
        ),
    ] {
        refused(folder.path(), SCENE, from, to, says);
    }
    // two driven bodies are not joined
    let both = SCENE.replacen("size_mm = [80.0, 80.0, 60.0]", "size_mm = [80.0, 80.0, 60.0]\ndriven = true", 1);
    comminute("check").arg(scene(folder.path(), &both)).assert().code(2).stderr(contains("both are driven"));
    // without the joint they stand too deep in each other
    let deep = SCENE.replacen("position_mm = [0.0, 0.0, 70.0]", "position_mm = [0.0, 0.0, 65.0]", 1);
    comminute("check").arg(scene(folder.path(), &deep)).assert().code(2).stderr(contains("must be further from block 1"));
}

/// In plane strain nothing may point out of the plane.
#[test]
fn what_points_out_of_the_plane_is_refused() {
    let folder = tempfile::tempdir().expect("folder");
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
path_s = [0.0, 1.0]
path_mm = [0.0, 0.0, 0.0, 5.0, 0.0, 0.0]
[[block]]
shape = "polygon"
points_mm = [0.0, 0.0]
rounding_mm = 10.0
position_mm = [0.0, 50.0, 0.0]
force_N = [1.0, 0.0, 0.0]
torque_N_m = [0.0, 0.0, 1.0]
[[joint]]
kind = "glue"
blocks = [0, 1]
position_mm = [0.0, 25.0, 0.0]
axis = [0.0, 1.0, 0.0]
radius_mm = 10.0
thickness_mm = 10.0
E_MPa = 1.0
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
    comminute("check").arg(scene(folder.path(), PLANE)).assert().success();
    for (from, to, says) in [
        ("5.0, 0.0, 0.0]", "5.0, 0.0, 1.0]", "block[0].path_mm"),
        ("path_s =", "path_axis = [0.0, 1.0, 0.0]\npath_s =", "must be [0, 0, 1] in plane strain"),
        ("force_N = [1.0, 0.0, 0.0]", "force_N = [1.0, 0.0, 1.0]", "block[1].force_N"),
        ("torque_N_m = [0.0, 0.0, 1.0]", "torque_N_m = [1.0, 0.0, 1.0]", "must have 0 along x and y in plane strain"),
        ("[0.0, 25.0, 0.0]", "[0.0, 25.0, 1.0]", "joint[0].position_mm"),
        ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 1.0, 1.0]", "joint[0].axis"),
        ("kind = \"glue\"", "kind = \"hinge\"", "must be [0, 0, 1] in plane strain"),
    ] {
        refused(folder.path(), PLANE, from, to, says);
    }
}
