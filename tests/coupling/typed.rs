//! Mixtures as a user types them.

use crate::common::typed::{array, columns, comminute, final_grains, keeps_its_solids, number, numbers, run, same_files, summary};
use predicates::prelude::{PredicateBooleanExt, predicate::str::contains};
use std::path::Path;

const QUIET: [&str; 2] = ["records.figures=false", "records.snapshots=false"];

/// A small binary mixture: placed in balance at the cell pressure, borne by matrix and grains together, the same bytes for any number of threads and when
/// stopped and resumed.
#[test]
fn a_small_mixture_is_in_balance_and_resumes_to_the_byte() {
    let folder = tempfile::tempdir().expect("folder");
    let whole = folder.path().join("whole");
    let sets: Vec<&str> = ["test.axial_strain=0.002", "records.rows=20"].into_iter().chain(QUIET).collect();
    run("mixture/triaxial_small", &whole, &sets, &[]).assert().success();
    let s = summary(&whole);
    assert!((number(&s, "coarse_mass_fraction") - 0.2).abs() < 0.01, "{s}");
    let doubts = s["outside_of_the_method"].as_array().expect("doubts");
    assert!(doubts.len() == 1 && doubts[0].as_str().expect("text").contains("no points are between them"), "{doubts:?}");
    let rows = columns(&whole, ["sigma_1_kPa", "sigma_zz_of_contacts_kPa", "q_kPa", "q_interface_kPa"]);
    let [axial, contacts, q, interface] = rows[rows.len() - 1];
    // as filled, and in the end by who bears it
    let mut history = csv::Reader::from_path(whole.join("history.csv")).expect("history");
    let k = history.headers().expect("header").iter().position(|h| h == "sigma_1_kPa").expect("column");
    let first: f64 = history.records().next().expect("a row").expect("row")[k].parse().expect("number");
    assert!((first / 50.0 - 1.0).abs() < 0.01, "{first} kPa");
    assert!((contacts / axial - 1.0).abs() < 0.02, "{contacts} of {axial}");
    assert!(q > 10.0 && interface > 0.1 * q, "{interface} of {q}");

    let parts = folder.path().join("parts");
    let half = (number(&s, "steps") as u64 / 2).to_string();
    run("mixture/triaxial_small", &parts, &sets, &["--stop-after", &half]).assert().code(130);
    // on other threads, and with one number in a register
    comminute("resume").arg(&parts).args(["--threads", "2", "--quiet", "--simd", "scalar"]).assert().success();
    same_files(&whole, &parts);
}

/// Matrix and contacts bear what the platens feel, where no damping holds a part of it: measured 0.04 kPa apart. Stresses are means since the row before, and so is what
/// bears them: as an instant it would be half a row ahead, here 0.35 kPa.
#[test]
fn who_bears_the_stress_adds_up() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let own = ["damping.local=0.0", "test.axial_strain=0.002", "records.rows=20"];
    run("mixture/triaxial_small", &out, &[&own[..], &QUIET].concat(), &[]).assert().success();
    let borne = columns(&out, ["q_kPa", "q_matrix_kPa", "q_skeleton_kPa", "q_interface_kPa"]);
    let apart = borne.iter().skip(2).map(|[q, parts @ ..]| (parts.iter().sum::<f64>() - q).abs()).fold(0.0, f64::max);
    assert!(apart < 0.1 && borne[borne.len() - 1][0] > 10.0, "{apart} kPa");
}

/// A shell keeps the volume of a cylinder as platens that of a box. Measured: 4e-5.
#[test]
fn a_cylinder_is_sheared_at_constant_volume() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let own = ["test.drainage=constant_volume", "grid.grains_per_point=64", "test.axial_strain=0.002", "records.rows=20"];
    run("mixture/triaxial_cylinder", &out, &[&own[..], &QUIET].concat(), &[]).assert().success();
    let rows = columns(&out, ["volumetric_strain", "sigma_3_kPa", "pore_pressure_kPa"]);
    assert!(rows[2..].iter().all(|r| r[0].abs() < 1e-4), "{rows:?}");
    let [_, lateral, pore] = rows[rows.len() - 1];
    assert!(pore > 3.0 && (lateral + pore - 50.0).abs() < 1e-6, "{lateral} kPa and {pore} kPa");
}

/// At constant volume the space between the platens stays, who bears p adds up, and the equivalent pore pressure is what the lateral stress has lost.
#[test]
fn a_mixture_is_sheared_at_constant_volume() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let own = ["test.drainage=constant_volume", "test.axial_strain=0.003", "records.rows=20"];
    run("../tests/gpu/mixture", &out, &[&own[..], &QUIET].concat(), &[]).assert().success();
    let rows = columns(&out, ["axial_strain", "volumetric_strain", "sigma_3_kPa", "pore_pressure_kPa"]);
    let borne = columns(&out, ["p_kPa", "p_matrix_kPa", "p_skeleton_kPa", "p_interface_kPa"]);
    // the first row is a mean over steps before the test as well
    assert!(rows[1..].iter().all(|r| r[1].abs() < 2e-5), "{rows:?}");
    let [strain, _, lateral, pore] = rows[rows.len() - 1];
    // a row is a mean since the last one, half a row behind
    assert!((strain / 0.003 - 1.0).abs() < 0.6 / 20.0, "{strain}");
    // an undrained specimen: the mean stress stays near the cell pressure while the lateral one falls
    assert!(pore > 1.0 && (lateral + pore - 50.0).abs() < 1e-6, "{lateral} kPa and {pore} kPa");
    let [p, matrix, skeleton, interface] = borne[borne.len() - 1];
    assert!(
        ((matrix + skeleton + interface) / p - 1.0).abs() < 0.05 && interface > 1.0,
        "{matrix} {skeleton} {interface} of {p} kPa"
    );
}

/// A chain of crushable grains in a soil: one breaks, its daughters go on in smaller steps, mass is that of the grains less what the pattern loses.
#[test]
fn a_grain_breaks_inside_a_continuum() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let sets = ["test.axial_strain=0.012", "records.rows=60", "records.frames=2", "records.contacts=true"];
    run("mixture/oedometer_crushing", &out, &sets, &[]).assert().success();
    let rows =
        columns(&out, ["crush_events", "grains", "coarse_mass_kg", "sigma_v_kPa", "q_skeleton_kPa", "q_kPa", "axial_strain"]);
    keeps_its_solids(&out);
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    let [events, grains, mass, ..] = last;
    assert_eq!((events, grains), (1.0, 16.0), "{last:?}");
    // the one that broke touched the platen; its daughters stay below
    let (whole, daughters): (Vec<[f64; 2]>, Vec<[f64; 2]>) = final_grains(&out, ["z_m", "r_m", "generation"])
        .into_iter()
        .map(|[z, radius, generation]| [z + radius, generation])
        .partition(|[_, generation]| *generation == 0.0);
    assert!(whole.iter().all(|[top, _]| *top < 0.0101), "{whole:?}");
    let (platen, top) = (0.015 * (1.0 - last[6]), daughters.iter().map(|d| d[0]).fold(0.0, f64::max));
    assert!((top - platen).abs() < 5e-5, "{top} under {platen}");
    // 46.6 % of one of three equal grains (NOTES: sum of r³ of the pattern is 0.53378)
    assert!((mass / first[2] - (1.0 - (1.0 - 0.53378) / 3.0)).abs() < 1e-4, "{mass} of {}", first[2]);
    // the chain bears most of the deviatoric stress until it breaks
    let before = rows.iter().rev().find(|r| r[0] == 0.0).expect("a row before");
    assert!(before[4] > 0.5 * before[5], "{before:?}");
    let after = rows.iter().find(|r| r[0] > 0.0).expect("a row after");
    assert!(last[3] < 0.5 * before[3] && after[3] < before[3], "{before:?} {last:?}");
    leaves_what_grains_alone_do(&out, before[3]);
}

/// The breakage with its stress, gradations, B_r in rows and summary, and their figures.
fn leaves_what_grains_alone_do(out: &Path, before: f64) {
    let broken = numbers(&out.join("breakage.csv"), ["event", "step", "sigma_v_kPa", "utilisation", "lost_mass_g"]);
    let [[event, step, sigma, utilisation, lost]] = broken[..] else { panic!("{broken:?}") };
    assert!(event == 1.0 && (1.0..1.01).contains(&utilisation), "{broken:?}");
    // the stress of that instant is near the last row's, a mean, before the chain broke
    assert!((sigma / before - 1.0).abs() < 0.2, "{sigma} kPa after a row of {before} kPa");
    let rows = columns(out, ["step", "crush_events", "hardin_br", "einav_br", "mass_lost_kg", "d50_mm"]);
    assert!(rows.iter().all(|r| (r[1] > 0.0) == (r[0] > step) && (r[2] > 0.0) == (r[1] > 0.0)), "{rows:?}");
    let [.., hardin, einav, mass, d50] = rows[rows.len() - 1];
    assert!(einav > hardin && hardin > 0.05 && (1e3 * mass / lost - 1.0).abs() < 1e-6 && (d50 - 5.0).abs() < 1e-6);
    // one of three equal grains has broken: a third passes their size, and all of them at the start
    let just_below = |at: &dyn Fn(f64) -> bool| {
        let sieves = numbers(&out.join("gsd.csv"), ["axial_strain", "diameter_mm", "passing_percent"]);
        sieves.iter().filter(|r| at(r[0]) && r[1] < 4.9).map(|r| r[2]).fold(0.0, f64::max)
    };
    let [start, end] = [just_below(&|e| e == 0.0), just_below(&|e| e > 0.0115)];
    assert!(start == 0.0 && (end - 100.0 / 3.0).abs() < 1e-6, "{start} % {end} %");
    let s = summary(out);
    assert_eq!(s["breakages"]["by_generation"][0]["breakages"], 1, "{s}");
    assert!((number(&s, "hardin_br") - hardin).abs() < 1e-8 && s["warnings"].as_array().is_some_and(Vec::is_empty), "{s}");
    assert!(number(&s, "max_measured_stress_kPa") > 0.999 * before, "{s}");
    let snapshots = std::fs::read_dir(out.join("snapshots")).expect("snapshots").map(|f| f.expect("file").path());
    let mut files: Vec<_> = snapshots.map(|p| (p.file_name().map(|n| n.to_string_lossy().into_owned()), p)).collect();
    files.sort();
    let of = |kind: &str| -> Vec<&Path> {
        let own = files.iter().filter(|f| f.0.as_ref().is_some_and(|name| name.starts_with(kind)));
        own.map(|f| f.1.as_path()).collect()
    };
    // halfway the chain bears what it hands from grain to grain and to the platen; points bear little of it
    let [start, halfway, end] = of("contacts_")[..] else { panic!("{files:?}") };
    let text = std::fs::read_to_string(halfway).expect("contacts");
    let rows: Vec<Vec<&str>> = text.lines().filter(|l| !l.starts_with('#')).skip(1).map(|l| l.split(',').collect()).collect();
    let down = |row: &Vec<&str>| row[14].parse::<f64>().expect("N").abs();
    let chain: Vec<f64> = rows.iter().filter(|r| r[1] != "point").map(down).collect();
    let top = rows.iter().find(|r| r[2] == "top").map(down).expect("the platen");
    assert!(chain.len() == 4 && chain.iter().all(|f| (f / top - 1.0).abs() < 0.3) && (50.0..186.0).contains(&top), "{chain:?} N");
    assert!(rows.iter().filter(|r| r[1] == "point").count() > 50 && start < end);
    // the daughters of the one that broke, and the two others
    let grains = std::fs::read(of("grains_")[2]).expect("a snapshot");
    let numbers = |name: &str| -> Vec<f64> { array(&grains, name).into_iter().map(f64::from_le_bytes).collect() };
    let mother = numbers("mother_id")[15];
    assert_eq!(numbers("mother_id"), [&[-1.0; 2][..], &[mother; 14]].concat());
    let whose = numbers("ancestor_id");
    assert!(whose[2..].iter().all(|a| *a == mother) && whose[0] != mother && whose[1] != mother && mother < 3.0, "{whose:?}");
    assert!(numbers("mean_stress_Pa")[0] > 1e4 && of("walls_").len() == 3 && out.join("walls.pvd").exists());
    for figure in ["gradation", "breakage_mixture", "section", "force_chains"] {
        assert!(out.join("figures").join(figure).with_extension("svg").exists(), "{figure}");
    }
}

/// Points that bear all: no grain comes to touch another one, so none can break, which is said before and after the run. Neither can one that is too small.
#[test]
fn grains_that_cannot_break_are_told() {
    let none = "contacts with points break no grain";
    check("oedometer_crushing", "seed.packing=1").success().stderr(contains(none).not());
    check("oedometer_crushing", "grain[1].radius_m=0.0002").success().stderr(contains(none).not());
    let apart = (0..3).map(|k| format!("grain[{k}].radius_m=0.0018"));
    let sets: Vec<String> = apart.chain(["test.axial_strain=0.001".into(), "grid.cell_mm=3.0".into()]).collect();
    let sets: Vec<&str> = sets.iter().map(String::as_str).chain(QUIET).collect();
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    comminute("run")
        .args(["experiments/mixture/oedometer_crushing.toml", "--threads", "1", "--out"])
        .arg(&out)
        .args(sets.iter().flat_map(|set| ["--set", set]))
        .assert()
        .success()
        .stderr(contains("points keep all grains apart").and(contains("touched neither each other nor a wall")));
    assert!(summary(&out)["warnings"][0].as_str().is_some_and(|w| w.contains("touched neither")));
    let small: Vec<String> = (0..3).map(|k| format!("grain[{k}].radius_m=0.0001")).collect();
    let mut command = comminute("check");
    command.arg("experiments/mixture/oedometer_crushing.toml");
    command.args(small.iter().flat_map(|set| ["--set", set])).assert().success().stderr(contains("the comminution limit is"));
}

#[test]
fn mixtures_that_cannot_be_are_refused() {
    for (set, says) in [
        ("grid.plane_strain=true", "must be false beside [coarse], which makes spheres"),
        ("coarse.mass_fraction=0.9", "cannot be placed at random"),
        ("coarse.material=gravel", "is no material of the scene"),
        ("stepping.inertia_scaling=true", "a continuum moves in time"),
        ("coarse.diameter_mm=[10.0, 9.0]", "smallest, then the largest"),
        ("coarse.diameter_mm=[34.0, 35.0]", "less than one grain of this size"),
        ("growth.fines=\"grains\"", "must be \"points\" without growth.fines_diameter_mm"),
    ] {
        check("triaxial_small", set).code(2).stderr(contains(says));
    }
    let through = "must not put the grain over points";
    for (scene, set, says) in [
        ("oedometer_crushing", "grain[2].position_m=[0.0075, 0.0075, 0.03]", "grain 2 of radius 0.0025 m reaches"),
        ("oedometer_crushing", "grain[2].position_m=[0.0075, 0.0075, 0.0131]", "out of the specimen"),
        ("ball_impact", "grain[0].position_m=[0.0, 0.0, 0.01]", through),
        ("ball_impact", "grain[0].radius_m=10.0", through),
    ] {
        check(scene, set).code(2).stderr(contains(says).and(contains("grain[")));
    }
}

fn check(scene: &str, set: &str) -> assert_cmd::assert::Assert {
    comminute("check").args([&format!("experiments/mixture/{scene}.toml"), "--set", set]).assert()
}

/// What `check` says of a mixture outside of the range: rigid bodies count, points that are not there do not.
#[test]
fn a_mixture_outside_of_the_range_is_doubted() {
    let coarse = "more than half of the smallest grain";
    check("rocks_drop", "seed.packing=1").success().stderr(contains(coarse).not());
    check("rocks_drop", "block[1].size_mm=[4.0, 3.0, 2.4]").success().stderr(contains(coarse));
    // 1:5, as the paper has it; and grains alone
    check("twin_points", "seed.packing=1").success().stderr(contains("times as large as the ghosts").not());
    check("twin_points", "coarse.mass_fraction=1.0").success().stderr(contains("warning").not());
    // cells that hold too few points, and cells wider than a grain, are refused with what would do
    let few = contains("grid.cell_mm").and(contains("must be at least 2.98")).and(contains("with 2.4 the soil comes apart"));
    check("twin_points", "grid.cell_mm=2.5").code(2).stderr(few);
    let wide = contains("grid.cell_mm").and(contains("must be at most 3.5").and(contains("better 1.75")));
    check("twin_points", "coarse.diameter_mm=[3.5, 3.6]").code(2).stderr(wide);
    // too many of them, and too near each other for points to be between
    let many = "of the mass are coarse grains";
    check("triaxial_60_50kPa", "seed.packing=1").success().stderr(contains(many));
    check("triaxial_40_50kPa", "seed.packing=1").success().stderr(contains(many).not());
    let rolling = "fine grains roll along coarse ones";
    check("triaxial_20_50kPa", "seed.packing=1")
        .success()
        .stderr(contains("no points are between them").and(contains(many).not()).and(contains(rolling).not()));
    check("triaxial_20_50kPa", "materials.fines=materials/li2023_fines.toml").success().stderr(contains(rolling));
}

/// Forces act on faces or centres of points as the kind of scene has it, and as the scene says.
#[test]
fn the_place_of_forces_on_points_can_be_chosen() {
    let folder = tempfile::tempdir().expect("folder");
    let end = |name: &str, set: Option<&str>| {
        let out = folder.path().join(name);
        let sets: Vec<&str> = ["records.rows=2"].into_iter().chain(set).chain(QUIET).collect();
        run("mixture/ball_impact_point", &out, &sets, &[]).assert().success();
        std::fs::read_to_string(out.join("points_final.csv")).expect("points")
    };
    let [usual, centre, face] =
        [end("usual", None), end("centre", Some("contact.on_points=centre")), end("face", Some("contact.on_points=face"))];
    assert!(usual == centre && usual != face);
    check("ball_impact", "contact.on_points=edge").code(2).stderr(contains("\"face\" or \"centre\""));
}

/// A grain that would be through the points before it sees them ends the run.
#[test]
fn a_grain_too_fast_for_its_step_is_told() {
    let folder = tempfile::tempdir().expect("folder");
    let sets = ["grain[0].velocity_m_s=[0.0, 0.0, -5000.0]", QUIET[0], QUIET[1]];
    let told = "further than a cell";
    run("mixture/ball_impact", &folder.path().join("out"), &sets, &[]).assert().code(3).stderr(contains(told));
}
