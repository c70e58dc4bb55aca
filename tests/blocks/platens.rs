//! Oedometer and triaxial tests of rigid bodies between platens, without points and with them.

use crate::common::typed::{columns, comminute, number, numbers, summary};
use crate::typed::{refused, resumes, run, scene};
use predicates::str::contains;
use std::path::Path;

/// Twenty rubber rocks under a cell pressure.
const TRIAXIAL: &str = r#"
kind = "mixture"
crushing.enabled = false
damping.local = 0.2
[test]
rig = "triaxial"
cell_pressure_kPa = 50.0
axial_strain = 0.05
strain_per_wave = 0.002
[[block_set]]
shape = "polyhedron"
count = 20
diameter_mm = [20.0, 26.0]
corners = [8, 14]
min_mm = [0.0, 0.0, 0.0]
max_mm = [70.0, 70.0, 90.0]
[material]
name = "rubber"
grain.density_kg_m3 = 1500.0
elastic.E_GPa = 0.05
elastic.nu = 0.3
contact.friction = 0.5
[records]
rows = 40
figures = false
"#;

/// Forty pentagons in plane strain.
const BIAXIAL: &str = r#"
kind = "mixture"
crushing.enabled = false
damping.local = 0.2
grid.plane_strain = true
contact.law = "spring"
[test]
rig = "triaxial"
cell_pressure_kPa = 50.0
axial_strain = 0.03
strain_per_wave = 0.002
[[block_set]]
shape = "polygon"
count = 40
diameter_mm = [8.0, 12.0]
corners = [5, 5]
min_mm = [0.0, 0.0, 0.0]
max_mm = [60.0, 75.0, 0.0]
[material]
name = "rubber"
grain.density_kg_m3 = 1500.0
contact.friction = 0.5
spring.k_n_N_m = 5e6
spring.k_t_N_m = 5e6
[records]
rows = 40
figures = false
"#;

/// Stones of chalk that break under the top platen of an oedometer.
const OEDOMETER: &str = r#"
kind = "mixture"
crushing.enabled = true
damping.local = 0.2
[test]
rig = "oedometer"
seating_kPa = 20.0
axial_strain = 0.08
strain_per_wave = 0.002
[[block_set]]
shape = "polyhedron"
count = 12
diameter_mm = [20.0, 26.0]
corners = [8, 14]
min_mm = [0.0, 0.0, 0.0]
max_mm = [60.0, 60.0, 70.0]
[material]
name = "chalk"
grain.density_kg_m3 = 2000.0
elastic.E_GPa = 0.2
elastic.nu = 0.2
contact.friction = 0.5
strength.d0_mm = 23.0
strength.fixed_angle = { sigma_lim0_MPa = 5.0, theta0_rad = 0.2, m = 3.0, var = 0.3 }
comminution = { d50_mm = 23.0, d_limit_over_d50 = 0.5 }
[records]
rows = 40
figures = false
"#;

/// What holds at every row of a test between platens: the stress of the contacts in the specimen (Love–Weber) is that on its sides, and the void ratio follows from the volume.
fn holds(out: &Path, [axial, of_contacts]: [&str; 2], within: f64) {
    let rows = columns(out, [axial, of_contacts, "void_ratio", "volumetric_strain", "coordination_number"]);
    let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / rows.len() as f64;
    assert!((mean(0) / mean(1) - 1.0).abs() < within, "{axial} {} of contacts {}", mean(0), mean(1));
    // means of the strain since the row before, so half a row behind
    let start = rows[0][2];
    for row in &rows {
        let expected = (1.0 + start) * (1.0 - row[3]) - 1.0;
        assert!((row[2] - expected).abs() < 2e-3 * (1.0 + start), "void ratio {} for {expected}", row[2]);
        assert!(row[4] > 1.5, "coordination number {}", row[4]);
    }
}

#[test]
fn rocks_in_a_triaxial_test_bear_what_their_contacts_do() {
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), TRIAXIAL, "out", &["--threads", "1"]);
    holds(&out, ["sigma_1_kPa", "sigma_zz_of_contacts_kPa"], 0.02);
    let rows = columns(&out, ["sigma_1_kPa", "sigma_3_kPa", "q_kPa"]);
    // at rest the cell pressure is on all sides, and the lateral platens hold it
    assert!((rows[0][0] / 50.0 - 1.0).abs() < 0.03 && rows.iter().all(|row| (row[1] / 50.0 - 1.0).abs() < 0.2), "{rows:?}");
    let last = rows.last().expect("rows");
    assert!(last[2] > 25.0, "{last:?}");
    let s = summary(&out);
    assert!(s["quasi_static"]["largest_inertial_number"].as_f64().is_some_and(|i| i > 0.0 && i < 0.05), "{s}");
    // the volume of the bodies over that of the box in which they were packed
    let start = numbers(&out.join("history.csv"), ["void_ratio", "coarse_mass_kg"])[0];
    let volume = start[1] / 1500.0;
    assert!((start[0] / (0.07 * 0.07 * 0.09 / volume - 1.0) - 1.0).abs() < 0.02, "{start:?}");
    // prepared without friction they are denser
    let smooth = run(
        folder.path(),
        &TRIAXIAL.replace("axial_strain = 0.05", "axial_strain = 0.002"),
        "smooth",
        &["--set", "growth.friction=0"],
    );
    let [dense, loose] = [&smooth, &out].map(|out| columns(out, ["void_ratio"])[0][0]);
    assert!(dense < loose - 0.02, "{dense} {loose}");
}

/// Contacts of Hertz's law know no length: a test of bodies of twice the size takes twice the time and gives the same stresses and strains.
#[test]
fn a_test_of_twice_the_size_gives_the_same_stresses() {
    let folder = tempfile::tempdir().expect("folder");
    let short = TRIAXIAL.replace("axial_strain = 0.05", "axial_strain = 0.02");
    let large = short.replace("[20.0, 26.0]", "[40.0, 52.0]").replace("[70.0, 70.0, 90.0]", "[140.0, 140.0, 180.0]");
    let names = ["axial_strain", "sigma_1_kPa", "sigma_3_kPa", "void_ratio", "coordination_number"];
    let [small, large] =
        [("small", &short), ("large", &large)].map(|(name, text)| run(folder.path(), text, name, &["--threads", "1"]));
    let [a, b] = [&small, &large].map(|out| columns(out, names));
    assert_eq!(a.len(), b.len());
    let off = a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (x - y).abs() / (1.0 + x.abs())).fold(0.0, f64::max);
    assert!(off < 1e-6, "{off}");
    let [t, twice] = [&small, &large].map(|out| number(&summary(out), "time_s"));
    assert!((twice / t - 2.0).abs() < 1e-9, "{t} {twice}");
}

#[test]
fn pentagons_in_a_biaxial_test_bear_what_their_contacts_do() {
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), BIAXIAL, "out", &["--threads", "1"]);
    holds(&out, ["sigma_1_kPa", "sigma_yy_of_contacts_kPa"], 0.03);
    let rows = columns(&out, ["sigma_1_kPa", "sigma_3_kPa", "p_kPa", "p_skeleton_kPa"]);
    for row in &rows {
        assert!((row[2] / (0.5 * (row[0] + row[1])) - 1.0).abs() < 1e-6, "{row:?}");
    }
    assert!(rows.last().is_some_and(|row| row[0] > 1.5 * row[1]), "{rows:?}");
}

/// Bodies and points bear the stress together.
#[test]
fn rocks_among_points_bear_a_share_of_the_stress() {
    let points = r#"damping.local = 0.1
grid = { cell_mm = 10.0, pic = 0.05 }
[[body]]
material = "rubber"
shape = "box"
min_mm = [0.0, 0.0, 0.0]
max_mm = [60.0, 60.0, 80.0]
stress_kPa = 50.0
porosity = 0.4
[material.continuum]
law = "drucker_prager"
cone = "outer"
E_MPa = 10.0
nu = 0.3
friction_angle_deg = 30.0
dilation_angle_deg = 0.0
cohesion_kPa = 0.0
"#;
    let text = TRIAXIAL
        .replace("damping.local = 0.2\n", points)
        .replace("count = 20", "count = 6")
        .replace("max_mm = [70.0, 70.0, 90.0]", "max_mm = [60.0, 60.0, 80.0]")
        .replace("axial_strain = 0.05", "axial_strain = 0.01");
    // tables of the file come after its keys
    let (head, tables) = text.split_once("[test]").expect("tables");
    let (keys, bodies) = head.split_once("[[body]]").expect("a body");
    let folder = tempfile::tempdir().expect("folder");
    let out = run(folder.path(), &format!("{keys}[test]{tables}[[body]]{bodies}"), "out", &["--threads", "2"]);
    let rows = columns(&out, ["sigma_1_kPa", "sigma_zz_of_contacts_kPa", "q_matrix_kPa", "q_interface_kPa", "void_ratio"]);
    let mean = |k: usize| rows.iter().map(|row| row[k]).sum::<f64>() / rows.len() as f64;
    assert!((mean(0) / mean(1) - 1.0).abs() < 0.02, "{} {}", mean(0), mean(1));
    assert!(mean(2) > 0.0 && mean(3) > 0.0, "{} {}", mean(2), mean(3));
    assert!(rows.iter().all(|row| row[4] > 0.3 && row[4] < 0.8), "{rows:?}");
}

/// Breaking bodies keep their mass and volume of solids, and a run that was stopped while it settles and while it loads goes on to the same bytes.
#[test]
fn an_oedometer_of_breaking_rocks_resumes_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = run(folder.path(), OEDOMETER, "whole", &["--threads", "1"]);
    let s = summary(&whole);
    assert!(number(&s, "crush_events") > 2.0 && number(&s, "seating_kPa") == 20.0, "{s}");
    let rows = columns(&whole, ["sigma_v_kPa", "void_ratio", "axial_strain", "coarse_mass_kg"]);
    assert!((rows[0][0] / 20.0 - 1.0).abs() < 0.05, "{:?}", rows[0]);
    for row in &rows {
        let expected = (1.0 + rows[0][1]) * (1.0 - row[2]) - 1.0;
        // strains are means since the row before: at most the strain of a row behind
        assert!((row[1] - expected).abs() < 0.002 * (1.0 + rows[0][1]), "{row:?} {expected}");
        assert!((row[3] / rows[0][3] - 1.0).abs() < 1e-12, "{row:?}");
    }
    let stops = [0.1, 0.8].map(|share| (number(&s, "steps") * share) as u64);
    let files = ["history.csv", "blocks.csv", "gsd.csv", "block_breakage.csv"];
    resumes(&whole, &scene(folder.path(), OEDOMETER), &stops, &files);

    let drawn = folder.path().join("drawn");
    comminute("plot").arg(&whole).args(["--show", "gradation", "--out"]).arg(&drawn).assert().success();
    let figure = std::fs::read_to_string(drawn.join("gradation.svg")).expect("a figure");
    assert!(figure.contains("grain size") && !figure.contains("not counted"), "there are no points");
}

#[test]
fn tests_of_bodies_that_mean_nothing_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    let head = "damping.local = 0.2";
    for (text, from, to, says) in [
        (OEDOMETER, "seating_kPa = 20.0\n", "", "test.seating_kPa: is missing: an oedometer of rigid bodies needs the stress"),
        (
            TRIAXIAL,
            "axial_strain = 0.05",
            "axial_strain = 0.05\nseating_kPa = 9.0",
            "test.seating_kPa = 9: has no meaning with test.rig = \"triaxial\"",
        ),
        (TRIAXIAL, "cell_pressure_kPa = 50.0\n", "", "test.cell_pressure_kPa: is missing"),
        (TRIAXIAL, "axial_strain = 0.05\n", "", "test.axial_strain: is missing"),
        (TRIAXIAL, head, "grid.cell_mm = 5.0", "grid.cell_mm = 5: has no meaning without a [[body]]"),
        (TRIAXIAL, head, "duration_s = 5.0", "duration_s = 5: has no meaning with test.rig = \"triaxial\""),
        (TRIAXIAL, head, "gravity_m_s2 = [0.0, 0.0, -9.81]", "must be [0, 0, 0] with test.rig = \"triaxial\""),
        (TRIAXIAL, head, "stepping.points_inertia = 100.0", "stepping.points_inertia = 100: has no meaning without a [[body]]"),
        (
            TRIAXIAL,
            "axial_strain = 0.05",
            "axial_strain = 0.05\ncontact_modulus_MPa = 9.0",
            "test.contact_modulus_MPa = 9: has no meaning without",
        ),
        (
            TRIAXIAL,
            head,
            "coarse.mass_fraction = 0.1\ncoarse.diameter_mm = [5.0, 6.0]\ncoarse.material = \"rubber\"",
            "coarse.mass_fraction = 0.1: has no meaning",
        ),
        (TRIAXIAL, head, "growth.fines_diameter_mm = [5.0, 6.0]", "growth.fines_diameter_mm"),
        (
            TRIAXIAL,
            "[[block_set]]",
            "[[block]]\nshape = \"box\"\nsize_mm = [5.0, 5.0, 5.0]\nposition_mm = [-40.0, 10.0, 10.0]\n[[block_set]]",
            "must not put the block through a side: it reaches 42.5",
        ),
        (
            TRIAXIAL,
            "[[block_set]]",
            "[[block]]\nshape = \"box\"\nsize_mm = [2.0, 2.0, 2.0]\nposition_mm = [2.0, 2.0, 2.0]\ndriven = true\n[[block_set]]",
            "must be a free body in a test",
        ),
        (
            TRIAXIAL,
            "[[block_set]]",
            "[[wall]]\nkind = \"plane\"\npoint_m = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n[[block_set]]",
            "has no meaning in a test, which sets its own",
        ),
    ] {
        refused(folder.path(), text, from, to, says);
    }
    // a box of one's own alone is no specimen
    let (head, tail) = TRIAXIAL.split_once("[[block_set]]").expect("a set");
    let (_, tail) = tail.split_once("[material]").expect("a material");
    let text =
        format!("{head}[[block]]\nshape = \"box\"\nsize_mm = [5.0, 5.0, 5.0]\nposition_mm = [9.0, 9.0, 9.0]\n[material]{tail}");
    let message =
        "block_set: is missing: without a [[body]] of points test.rig = \"triaxial\" needs one, whose box is the specimen";
    comminute("check").arg(scene(folder.path(), &text)).assert().code(2).stderr(contains(message));
}
