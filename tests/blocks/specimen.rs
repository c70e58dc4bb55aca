//! Random bodies that fill a box, and mass that passes a plane.

use crate::common::typed::{columns, comminute, number, summary};
use crate::scene::Scene;
use crate::typed::{refused, scene};
use predicates::str::contains;

/// Pentagons with points between them in plane strain, in a box of rods.
const PENTAGONS: &str = r#"
kind = "mixture"
duration_s = 0.05
gravity_m_s2 = [0.0, -9.81, 0.0]
[[body]]
shape = "box"
min_mm = [0.0, 0.0, 0.0]
max_mm = [200.0, 140.0, 0.0]
[[block_set]]
shape = "polygon"
count = 14
diameter_mm = [30.0, 45.0]
corners = [5, 5]
elongation = [1.0, 1.5]
min_mm = [0.0, 0.0, 0.0]
max_mm = [200.0, 140.0, 0.0]
[[block]]
shape = "polygon"
points_mm = [-120.0, 0.0, 120.0, 0.0]
rounding_mm = 5.0
position_mm = [100.0, -5.0, 0.0]
driven = true
[grid]
plane_strain = true
cell_mm = 10.0
min_mm = [-30.0, -30.0, 0.0]
max_mm = [230.0, 200.0, 1.0]
[contact]
law = "spring"
point_radius_mm = 2.5
[material]
name = "stone"
grain.density_kg_m3 = 2500.0
elastic.E_GPa = 1.0
elastic.nu = 0.2
contact.friction = 0.5
contact.restitution = 0.3
spring.k_n_N_m = 3e6
spring.k_t_N_m = 1e6
[material.continuum]
law = "drucker_prager"
cone = "plane_strain"
E_MPa = 5.0
nu = 0.3
friction_angle_deg = 30.0
dilation_angle_deg = 0.0
cohesion_kPa = 0.0
[records]
rows = 20
gate_mm = [0.0, 70.0, 0.0]
gate_direction = [0.0, -1.0, 0.0]
figures = false
"#;

/// Polyhedra in a box between walls.
const RUBBLE: &str = r#"
kind = "mixture"
duration_s = 9.0
gravity_m_s2 = [0.0, 0.0, -9.81]
[[block_set]]
shape = "polyhedron"
count = 12
diameter_mm = [18.0, 26.0]
corners = [8, 14]
elongation = [1.0, 1.6]
flatness = [1.0, 1.4]
min_mm = [0.0, 0.0, 0.0]
max_mm = [80.0, 80.0, 55.0]
[[wall]]
kind = "box"
min_m = [0.0, 0.0, 0.0]
max_m = [0.08, 0.08, 0.4]
[contact]
law = "hertz_viscous"
[material]
name = "stone"
grain.density_kg_m3 = 2600.0
elastic.E_GPa = 0.5
elastic.nu = 0.2
contact.friction = 0.5
contact.restitution = 0.3
"#;

/// Bodies begin apart, within their box, and points leave room for them: nothing flies apart when the run begins.
#[test]
fn a_set_of_polygons_begins_at_rest_among_points() {
    let mut scene = Scene::of(PENTAGONS);
    let points = scene.state.continuum.points();
    let start: Vec<[f64; 4]> = points.position.clone();
    let set = &scene.all().blocks[1..];
    assert_eq!(set.len(), 14);
    for block in set {
        let pose = block.pose(0.0);
        let nearest =
            start.iter().map(|p| block.solid().nearest(pose.within([p[0], p[1], 0.0])).distance).fold(f64::INFINITY, f64::min);
        assert!(nearest >= 2.5e-3, "a point is {nearest} m from a body");
        assert!((0.0..0.2).contains(&block.centre[0]) && (0.0..0.14).contains(&block.centre[1]) && block.centre[2] == 0.0);
    }
    // about as much room as bodies and the shells around them take
    let solid: f64 = set.iter().map(|b| b.mass / 2500.0).sum();
    let taken = 1.0 - start.len() as f64 * 25e-6 / (0.2 * 0.14);
    assert!(taken > solid / 0.028 && taken < solid / 0.028 + 0.3, "{taken} of {}", solid / 0.028);
    scene.run(0.002).expect("a run");
    // what falls freely for 2 ms has 0.02 m/s
    let fastest = scene.all().blocks.iter().map(|b| b.velocity[0].hypot(b.velocity[1])).fold(0.0, f64::max);
    assert!(fastest < 0.03, "{fastest} m/s");
}

/// The seed gives the specimen, the mass beyond the gate is that of all parts below it, and a run on two threads leaves the same bytes.
#[test]
fn a_set_depends_on_its_seed_and_on_nothing_else() {
    let folder = tempfile::tempdir().expect("folder");
    let file = scene(folder.path(), PENTAGONS);
    let run = |name: &str, more: &[&str]| {
        let out = folder.path().join(name);
        comminute("run").arg(&file).args(["--quiet", "--out"]).arg(&out).args(more).assert().success();
        ["history.csv", "blocks.csv", "points_final.csv"].map(|file| std::fs::read_to_string(out.join(file)).expect(file))
    };
    let one = run("one", &["--threads", "1"]);
    assert!(one == run("two", &["--threads", "2"]), "bytes depend on threads");
    assert_ne!(one[1], run("other", &["--seed", "2"])[1]);
    let s = summary(&folder.path().join("one"));
    assert_eq!(number(&s, "blocks"), 15.0);
    // of all that falls nothing comes back; in the beginning the floor and what lies below the gate are beyond it
    let passed: Vec<f64> = columns(&folder.path().join("one"), ["passed_kg"]).into_iter().map(|[x]| x).collect();
    let start = Scene::of(PENTAGONS);
    let below = start.all().blocks.iter().filter(|b| b.centre[1] < 0.07).map(|b| b.mass).sum::<f64>();
    let points = &start.state.continuum.points();
    let below = below + points.position.iter().zip(&points.velocity).filter(|(p, _)| p[1] < 0.07).map(|(_, v)| v[3]).sum::<f64>();
    assert!((passed[0] / below - 1.0).abs() < 1e-6 && passed.windows(2).all(|w| w[1] >= w[0]), "{below} {passed:?}");
    assert!(passed.last() > passed.first(), "{passed:?}");
}

/// Twelve rocks that fill a quarter of a box come to rest; the floor bears them.
#[test]
fn a_set_of_polyhedra_settles() {
    let mut scene = Scene::of(RUBBLE);
    let weight = 9.81 * scene.all().blocks.iter().map(|b| b.mass).sum::<f64>();
    scene.run(0.7).expect("a run");
    let on_floor: f64 = (0..12).map(|k| scene.all().forces(k)[2][2]).sum();
    assert!((on_floor / weight - 1.0).abs() < 0.02, "{on_floor} N of {weight} N");
    let fastest = scene.all().blocks.iter().map(|b| b.kinetic()).sum::<f64>() / weight;
    assert!(fastest < 1e-6, "{fastest}");
}

/// A library of outlines as image analysis gives them: bodies are their hulls, and a resolved scene needs no other file.
#[test]
fn bodies_have_the_outlines_of_a_file() {
    let folder = tempfile::tempdir().expect("folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("grains.csv", "# in pixels\noutline,x,y\na,10,10\na,90,12\na,50,80\nb,0,0\nb,40,0\nb,40,40\nb,20,20\nb,0,40\n");
    let text = PENTAGONS.replace("corners = [5, 5]\nelongation = [1.0, 1.5]", "outlines_csv = \"grains.csv\"");
    let file = scene(folder.path(), &text);
    let out = folder.path().join("out");
    let run = |file: &std::path::Path, out: &std::path::Path| {
        comminute("run")
            .arg(file)
            .args(["--quiet", "--threads", "1", "--set", "duration_s=0.002", "--out"])
            .arg(out)
            .assert()
            .success();
        std::fs::read_to_string(out.join("blocks.csv")).expect("blocks")
    };
    let first = run(file.as_ref(), &out);
    let again = run(&out.join("scene.resolved.toml"), &folder.path().join("again"));
    assert!(first == again, "the resolved scene is another one");
    for (csv, says) in [
        ("outline,x,y\na,0,0\na,1,0\na,0,nan\n", "grains.csv line 4: y = nan: must be a finite number"),
        ("outline,x\na,0\n", "has no column y"),
        ("outline,x,y,size\na,0,0,1\n", "size: unknown column"),
        ("outline,x,y\na,0,0\nb,1,0\na,0,1\n", "comes again after another one"),
        ("outline,x,y\na,0,0\na,1,0\na,0,1\nb,0,0\nb,1,1\nb,2,2\n", "outline 1 of 2, of 3 points, has no area"),
        ("outline,x,y,z\na,0,0,0\na,1,0,0\na,0,1,1\n", "has corners out of the plane"),
        ("outline,x,y\n", "holds no outlines"),
    ] {
        write("grains.csv", csv);
        comminute("check").arg(&file).assert().code(2).stderr(contains(says));
    }
    write("grains.csv", "outline,x,y\na,0,0\na,1,0\na,0,1\n");
    let refuse = |from: &str, to: &str, says: &str| refused(folder.path(), &text, from, to, says);
    refuse("count = 14", "count = 14\ncorners = [5, 6]", "block_set[0].corners = [5.0, 6.0]: has no meaning beside outlines");
    refuse("outlines_csv = \"grains.csv\"", "", "block_set[0].corners: is missing: give the least and largest number of corners");
    refuse("outlines_csv = \"grains.csv\"", "outlines_csv = \"none.csv\"", "none.csv");
    refuse("grains.csv\"", "grains.csv\"\noutline_corners = [3]", "must not stand beside");
    refuse(
        "outlines_csv = \"grains.csv\"",
        "outline_corners = [3]\noutline_points = [0.0, 0.0, 0.0, 1.0]",
        "in all a third of the 4 numbers",
    );
}

#[test]
fn sets_that_cannot_be_are_refused_by_their_key() {
    let folder = tempfile::tempdir().expect("folder");
    for (from, to, says) in [
        ("count = 14", "count = 40", "block_set[0].count = 40: is too large: the bodies would fill"),
        ("count = 14", "count = 21", "and overlap by up to"),
        ("shape = \"polygon\"\ncount", "shape = \"polyhedron\"\ncount", "must be \"polygon\" in plane strain"),
        ("corners = [5, 5]", "corners = [7, 5]", "must be the least, then the largest"),
        ("corners = [5, 5]", "corners = [4.5, 5]", "must be whole numbers from 3 on"),
        ("diameter_mm = [30.0, 45.0]", "diameter_mm = [30.0, 450.0]", "leaves no room"),
        ("max_mm = [200.0, 140.0, 0.0]\n[[block]]", "max_mm = [200.0, -140.0, 0.0]\n[[block]]", "must be above min_mm"),
        ("gate_direction = [0.0, -1.0, 0.0]", "gate_direction = [0.0, 0.0, 0.0]", "must not be zero"),
        ("gate_direction = [0.0, -1.0, 0.0]\n", "", "records.gate_mm and records.gate_direction go together"),
    ] {
        refused(folder.path(), PENTAGONS, from, to, says);
    }
    comminute("check").arg(scene(folder.path(), PENTAGONS)).assert().success().stderr(contains("3 more of them"));
}
