//! Hard cases: scenes on which such programs fail, each with what must come of it. A case is right (compared with a closed form or a balance), refused before
//! any work, or stopped with a diagnosis. Reduced forms run here; `cargo test --release --test hard -- --ignored` makes the long ones and writes the table
//! of the book, `docs/validation/hard_to_break/hard_cases.csv`.

mod common;

use common::{ROOT, typed};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// What a run has left.
struct Run {
    dir: tempfile::TempDir,
    code: i32,
    message: String,
}

type Row = HashMap<String, f64>;

impl Run {
    fn new(scene: &str, sets: &[String]) -> Run {
        let dir = tempfile::tempdir().expect("folder");
        let sets: Vec<&str> = sets.iter().map(String::as_str).collect();
        let output = typed::run(&format!("hard/{scene}"), &dir.path().join("run"), &sets, &["--set", "records.figures=false"])
            .output()
            .expect("start");
        let code = output.status.code().unwrap_or_else(|| panic!("{scene}: ended by a signal"));
        Run { dir, code, message: String::from_utf8_lossy(&output.stderr).trim().to_string() }
    }

    fn path(&self) -> PathBuf {
        self.dir.path().join("run")
    }

    /// The rows of a table, numbers only.
    fn table(&self, name: &str) -> Vec<Row> {
        let (header, rows) = typed::table(&self.path().join(name));
        let row = |row: &csv::StringRecord| {
            header.iter().map(str::to_string).zip(row.iter().map(|x| x.parse().unwrap_or(f64::NAN))).collect()
        };
        rows.iter().map(row).collect()
    }

    fn ends(&self, name: &str, column: &str) -> [f64; 2] {
        let rows = self.table(name);
        [rows.first(), rows.last()].map(|row| row.expect("rows")[column])
    }

    fn last(&self, column: &str) -> f64 {
        self.ends("history.csv", column)[1]
    }

    fn summary(&self, key: &str) -> f64 {
        typed::number(&typed::summary(&self.path()), key)
    }

    /// Of the last instant of a free scene the rows of all tracked grains.
    fn grains(&self) -> Vec<Row> {
        let rows = self.table("tracks.csv");
        let last = rows.last().expect("rows")["step"];
        rows.into_iter().filter(|row| row["step"] == last).collect()
    }

    #[track_caller]
    fn finished(&self) {
        assert_eq!(self.code, 0, "{}", self.message);
    }
}

/// Compares a value with what it should be and says so.
#[track_caller]
fn near(what: &str, value: f64, wanted: f64, within: f64) -> String {
    let off = value / wanted - 1.0;
    assert!(off.abs() < within, "{what} {value} instead of {wanted}");
    format!("{what} {value:.6} for {wanted:.6} ({:+.1e})", off)
}

/// Asserts that a number which should vanish is below a bound, and says so.
#[track_caller]
fn small(what: &str, value: f64, bound: f64) -> String {
    assert!(value.abs() < bound, "{what} {value:e} is not below {bound:e}");
    format!("{what} {value:.1e}")
}

/// A hard case: name, scene, what is set in it for CI, and for the long form instead; and the check of what came of it, which says what it has found.
struct Case {
    name: &'static str,
    scene: &'static str,
    reduced: &'static [&'static str],
    long: Option<&'static [&'static str]>,
    check: fn(&Run) -> String,
}

/// Asserts that no table of a run, finished or broken, holds a number that is not finite. Cells that have no value are empty. (Snapshots check themselves as they are
/// written, and JSON has no such numbers.)
#[track_caller]
fn finite(run: &Path) {
    let folders = [run.to_path_buf(), run.join("snapshots")];
    let files = folders.iter().flat_map(|folder| folder.read_dir().into_iter().flatten().flatten()).map(|entry| entry.path());
    for path in files.filter(|path| path.extension().is_some_and(|ending| ending == "csv")) {
        let text = std::fs::read_to_string(&path).expect("a table");
        for (k, line) in text.lines().enumerate().filter(|(_, line)| !line.starts_with('#')) {
            let wrong = line.split(',').find(|cell| cell.parse::<f64>().is_ok_and(|x| !x.is_finite()));
            assert_eq!(wrong, None, "{}, line {}", path.display(), k + 1);
        }
    }
}

/// Replaces the words for `n` cycles of unloading and reloading, and for the points of a spinning bar, `4 n` across, by the lists that they stand for.
fn set(text: &str) -> Vec<String> {
    let number = |n: &str| n.parse::<usize>().expect("number");
    if let Some(n) = text.strip_prefix("cycles=") {
        return vec![format!("loading.stages_kPa=[{}]", vec!["100.0,200.0"; number(n)].join(","))];
    }
    let Some(n) = text.strip_prefix("bar=").map(number) else { return vec![text.into()] };
    let spacing = 0.05 / n as f64;
    let at = |i: usize, count: usize| spacing * (i as f64 + 0.5 - count as f64 / 2.0);
    let point = |k: usize| {
        let [x, y] = [at(k / (4 * n), 20 * n), at(k % (4 * n), 4 * n)];
        format!(
            "{{shape='points',points_m=[{x:?},{y:?},0.0],volumes_m3=[{:?}],velocity_m_s=[{:?},{x:?},0.0]}}",
            spacing * spacing,
            -y
        )
    };
    let points: Vec<String> = (0..80 * n * n).map(point).collect();
    vec![format!("body=[{}]", points.join(",")), format!("grid.cell_mm={:?}", 100.0 / n as f64)]
}

fn check(case: &Case, long: bool) -> [String; 4] {
    let sets: Vec<String> =
        if long { case.long.unwrap_or(case.reduced) } else { case.reduced }.iter().flat_map(|s| set(s)).collect();
    let run = Run::new(case.scene, &sets);
    println!("{}: exit {}, {}", case.name, run.code, run.message);
    let found = (case.check)(&run);
    let outcome = match run.code {
        0 => "right",
        2 => "refused",
        3 => "stopped",
        code => panic!("{}: exit {code}", case.name),
    };
    // nothing that a run leaves may be nonsense
    finite(&run.path());
    [case.name.replace('_', " "), format!("{}.toml", case.scene), outcome.into(), found]
}

/// An error of a code whose message holds all these words.
#[track_caller]
fn told(run: &Run, code: i32, words: &[&str]) -> String {
    assert_eq!(run.code, code, "{}", run.message);
    for word in words {
        assert!(run.message.contains(word), "`{word}` is not in: {}", run.message);
    }
    let first = run.message.lines().next().unwrap_or_default();
    first.trim_start_matches("error: ").into()
}

/// A specimen that has come to its stress, with a ledger that closes and no mass lost but by breakages.
#[track_caller]
fn held(run: &Run) -> String {
    run.finished();
    let [_, mass] = run.ends("history.csv", "mass_error");
    let (error, events) = (run.last("energy_error"), run.last("crush_events"));
    near("σ_v", run.last("sigma_v_kPa"), run.last("target_kPa"), 0.02);
    format!("{events} breakages, {}, {}", small("ledger", error, 1e-4), small("mass", mass, 1e-12))
}

/// σ1/σ3 of a continuum at its peak and at the end against the closed form of its law.
#[track_caller]
fn strength(run: &Run) -> String {
    run.finished();
    let of = |which: &str| {
        near(which, run.summary(&format!("{which}_stress_ratio")), run.summary(&format!("{which}_stress_ratio_of_the_law")), 2e-3)
    };
    format!("{}, {}", of("peak"), of("residual"))
}

#[track_caller]
fn modulus(run: &Run) -> String {
    run.finished();
    near("oedometric modulus", run.summary("oedometric_modulus_MPa"), run.summary("oedometric_modulus_of_the_law_MPa"), 6e-3)
}

/// A grain that has broken, with a ledger that closes.
#[track_caller]
fn broken(run: &Run) -> String {
    run.finished();
    assert!(run.last("crush_events") >= 1.0, "nothing broke");
    format!("{} breakages, {}", run.last("crush_events"), small("ledger", run.last("energy_error"), 1e-3))
}

/// Angular momentum and kinetic energy that a spinning bar has lost in a turn, which must lie below bounds; and the energy of its stresses.
#[track_caller]
fn spun(run: &Run, bounds: [f64; 2]) -> String {
    run.finished();
    let moment = |name: &str| -> f64 {
        let of = |r: &Row| r["volume_m3"] * (r["x_m"] * r["vy_m_s"] - r["y_m"] * r["vx_m_s"]);
        run.table(name).iter().map(of).sum()
    };
    let [before, after] = run.ends("history.csv", "kinetic_J");
    let lost = [1.0 - moment("points_final.csv") / moment("points_start.csv"), 1.0 - after / before];
    assert!(
        lost.iter().zip(bounds).all(|(lost, bound)| *lost < bound),
        "{lost:?} of the angular momentum and the kinetic energy are lost"
    );
    let [moment, kinetic, stress] = [lost[0], lost[1], run.last("stress_work_J") / before].map(|x| 100.0 * x);
    format!(
        "in a turn {moment:.1} % of the angular momentum and {kinetic:.1} % of the kinetic energy are lost, {stress:.1} % of it went into stresses"
    )
}

macro_rules! cases {
    ($($name:ident: $scene:literal, $reduced:expr $(=> $long:expr)?, $check:expr;)*) => {
        const CASES: &[Case] = &[$(Case {
            name: stringify!($name),
            scene: $scene,
            reduced: &$reduced,
            long: { #[allow(unused_mut, unused_assignments)] let mut long: Option<&'static [&'static str]> = None; $(long = Some(&$long);)? long },
            check: $check,
        }),*];
        $(#[test]
        fn $name() {
            let case = CASES.iter().find(|c| c.name == stringify!($name)).expect("listed");
            println!("{:?}", check(case, false));
        })*
    };
}

cases! {
    diameters_100_to_1: "size_ratio", [], |run| {
        run.finished();
        let [before, after] = run.ends("history.csv", "kinetic_energy_J");
        let (radius, density) = ([0.01, 1e-4], 2500.0);
        let mass = |k: usize| density * 4.0 / 3.0 * std::f64::consts::PI * f64::powi(radius[usize::from(k > 0)], 3);
        let momentum: f64 = run.grains().iter().enumerate().map(|(k, g)| mass(k) * g["vx_m_s"]).sum();
        let fastest = run.grains().iter().skip(1).map(|g| g["vx_m_s"]).fold(0.0, f64::max);
        assert!(fastest > 3.5, "no small sphere was thrown ahead at nearly twice the speed: {fastest}");
        format!("{}, {}", near("momentum", momentum, mass(0) * 2.0, 1e-8), near("energy", after, before, 1e-6))
    };
    moduli_10_000_to_1: "stiffness_ratio", [], |run| {
        run.finished();
        let v: Vec<f64> = run.grains().iter().map(|g| g["vx_m_s"]).collect();
        format!("velocities exchanged: {}, {}", near("v1", v[0], -1.0, 1e-6), near("v2", v[1], 1.0, 1e-6))
    };
    strengths_without_spread: "oedometer", ["material.strength.fixed_angle.var=0", "loading.max_stress_kPa=15000"], |run| {
        let found = held(run);
        assert!(run.last("crush_events") >= 1.0, "grains break");
        found
    };
    strengths_with_spread_1: "oedometer", ["material.strength.fixed_angle.var=1", "loading.max_stress_kPa=2000"] => ["material.strength.fixed_angle.var=1"], held;
    strengths_with_spread_2: "oedometer", ["material.strength.fixed_angle.var=2"], held;
    no_size_effect: "oedometer", ["material.strength.fixed_angle.m=1e9"], held;
    no_friction: "oedometer", ["material.contact.friction=0"], held;
    limit_above_all_grains: "oedometer", ["material.comminution.d_limit_over_d50=3"], |run| {
        let found = held(run);
        assert_eq!(run.last("crush_events"), 0.0, "nothing is above the limit");
        found
    };
    limit_below_all_daughters: "oedometer", ["material.comminution.d_limit_over_d50=0.001"], |run| told(run, 2, &["fines.d_min_mm", "must be <"]);
    one_grain_in_an_oedometer: "oedometer", ["specimen.grains=1"], |run| told(run, 2, &["specimen.grains=1", "largest grain"]);
    specimen_narrower_than_a_grain: "oedometer", ["specimen.diameter_mm=0.7"], |run| told(run, 2, &["specimen.diameter_mm", "must be > 0.8"]);
    density_that_no_packing_has: "oedometer", ["specimen.void_ratio=0.2"], |run| told(run, 2, &["specimen.void_ratio", "the nearest that works"]);
    unloading_to_5_kpa: "unload_to_5kpa", ["loading.max_stress_kPa=1000"] => [], held;
    one_gpa_with_deep_overlaps: "one_gpa", ["loading.max_stress_kPa=20000"] => [], |run| match run.code {
        0 => held(run),
        _ => told(run, 3, &["void ratio", "more than the whole volume", "stop at a lower stress"]),
    };
    cycles_without_drift: "cycles", ["cycles=10"] => ["cycles=1000"], |run| {
        let found = held(run);
        let rows = run.table("history.csv");
        let peaks: Vec<f64> = rows.iter().filter(|r| (r["target_kPa"] - 200.0).abs() < 1e-9).map(|r| r["void_ratio"]).collect();
        let (early, end) = (peaks[peaks.len() / 10], peaks[peaks.len() - 1]);
        format!("void ratio {early:.5} after a tenth, {end:.5} at the end of {} cycles, {found}", peaks.len() - 1)
    };
    generations_at_once: "generations", [], |run| {
        run.finished();
        let deepest = run.table("breakage.csv").iter().map(|b| b["generation"]).fold(0.0, f64::max);
        assert!(deepest >= 3.0, "{deepest} generations");
        format!("{} breakages, generation {deepest}, {}", run.last("crush_events"), small("ledger", run.last("energy_error"), 1e-2))
    };
    breakage_in_a_corner: "corner", [], broken;
    breakage_against_a_platen: "platen", ["steps=10000"] => [], broken;
    breakage_against_a_wall: "thrown", [], |run| {
        let found = broken(run);
        assert_eq!(typed::summary(&run.path())["warnings"], serde_json::json!([]), "walls that do no work are no measure");
        found
    };
    no_room_between_walls: "empty_box", ["wall=[{kind='plane',point_m=[0.0,0.0,0.0],normal=[0.0,0.0,1.0]},{kind='plane',point_m=[0.0,0.0,0.0007],normal=[0.0,0.0,-1.0]}]"], |run| told(run, 2, &["overlaps a wall by 0.600", "records.largest_overlap_at_start"]);
    a_box_without_grains: "empty_box", ["grain=[]"], |run| told(run, 2, &["is missing", "[[grain]]"]);
    servo_that_touches_nothing: "empty_box", ["grain=[{position_m=[0.0,0.0,0.5],radius_m=0.0005}]", "wall=[{kind='plane',point_m=[0.0,0.0,0.0],normal=[0.0,0.0,1.0],stress_kPa=100.0,area_m2=1e-6}]"], |run| {
        run.finished();
        let way = run.grains()[0]["z_m"] - 0.5;
        format!("{} steps, {}, {}", run.last("step"), small("way of the grain, m", way, 1e-300), small("work of the platen, J", run.last("wall_work_J"), 1e-300))
    };
    servo_at_no_pressure: "empty_box", ["steps=20000", "wall=[{kind='plane',point_m=[0.0,0.0,0.0],normal=[0.0,0.0,1.0]},{kind='plane',point_m=[0.0,0.0,0.002],normal=[0.0,0.0,-1.0],stress_kPa=0.0,area_m2=1e-6}]"], |run| {
        run.finished();
        format!("{}, {}", small("stored energy, J", run.last("stored_energy_J"), 1e-30), small("kinetic energy, J", run.last("kinetic_energy_J"), 1e-30))
    };
    oedometer_at_no_stress: "oedometer", ["loading.stages_kPa=[0.0]"], |run| told(run, 2, &["loading.stages_kPa", "must be > 0"]);
    servo_on_a_single_grain: "empty_box", [], |run| {
        run.finished();
        // two equal Hertz contacts under F store 2 · 2/5 F δ
        let overlap = 0.0005 - run.grains()[0]["z_m"];
        near("stored energy over 4/5 F δ", run.last("stored_energy_J") / (0.8 * 0.1 * overlap), 1.0, 1e-4)
    };
    two_grains_at_one_place: "empty_box", ["grain=[{position_m=[0.0,0.0,0.0005],radius_m=0.0005},{position_m=[-0.0,0.0,0.0005],radius_m=0.0005}]"], |run| told(run, 2, &["overlap by 2.000 of the smaller radius", "records.largest_overlap_at_start"]);
    step_ten_times_too_large: "large_step", [], |run| told(run, 3, &["stepping.dt_s", "largest stable step", "stepping.above_bound"]);
    the_same_forced: "large_step", ["stepping.above_bound=true"], |run| told(run, 3, &["kinetic energy", "ever given", "stepping.dt_s"]);
    packing_at_rest: "idle", ["steps=600000", "records.every=300000"] => [], |run| {
        run.finished();
        let rows = run.table("tracks.csv");
        let n = run.grains().len();
        // the file of the grains has no tangential forces: they settle anew in the first half. From there one grain rolls freely, for nothing resists rolling
        let middle = rows.len() / n / 2 * n;
        let way = |(a, b): (&Row, &Row)| ["x_m", "y_m", "z_m"].iter().map(|k| (b[*k] - a[*k]).abs()).fold(0.0, f64::max);
        let mut ways: Vec<f64> = rows[middle..middle + n].iter().zip(&rows[rows.len() - n..]).map(way).collect();
        ways.sort_by(f64::total_cmp);
        let (rests, rolls) = (small("way of the others, m", ways[n - 2], 1e-9), small("kinetic energy, J", run.last("kinetic_energy_J"), 1e-12));
        format!("{} steps, in the second half a grain rolls by {:.1e} m, {rests}, {rolls}", run.last("step"), ways[n - 1])
    };
    elastic_cube_flip: "cube", [], modulus;
    elastic_cube_apic: "cube", ["grid.transfer=apic"], modulus;
    elastic_cube_gimp: "cube", ["grid.shape_functions=gimp"], modulus;
    elastic_cube_pic: "cube", ["grid.pic=1"], modulus;
    nearly_incompressible: "incompressible", [], modulus;
    frictional_cube_flip: "cube_frictional", [], strength;
    frictional_cube_apic: "cube_frictional", ["grid.transfer=apic"], strength;
    frictional_cube_gimp: "cube_frictional", ["grid.shape_functions=gimp"], strength;
    cohesive_cube_flip: "cube_cohesive", [], strength;
    cohesive_cube_apic: "cube_cohesive", ["grid.transfer=apic"], strength;
    cohesive_cube_gimp: "cube_cohesive", ["grid.shape_functions=gimp"], strength;
    pulled_apart_at_the_apex: "pulled_apart", [], |run| {
        run.finished();
        let [before, after] = run.ends("history.csv", "kinetic_J");
        let [front, void_ratio] = ["front_mm", "void_ratio"].map(|column| run.ends("history.csv", column));
        assert!(front[1] - front[0] > 10.0, "it was not pulled apart");
        near("void ratio without the gap", void_ratio[1], void_ratio[0], 1e-9);
        format!("{}, {}", near("kinetic energy", after, before, 1e-12), small("work of stresses, J", run.last("stress_work_J"), 1e-15))
    };
    fifty_steps_in_one: "kappa", ["duration_s=0.0004"] => [], |run| {
        run.finished();
        assert_eq!(run.last("grain_steps"), 50.0);
        let grain = &run.table("grains_final.csv")[0];
        let mass = run.last("coarse_mass_kg");
        let momentum = run.last("momentum_z_kg_m_s") + mass * grain["vz_m_s"];
        let made = -100.0 * run.last("dissipated_share");
        assert!(made < 3.0, "{made} % of the energy was made");
        format!("{}, {made:.1} % of the energy made", near("momentum", momentum, -5.0 * mass, 1e-7))
    };
    spinning_bar_flip: "spinning_bar", ["bar=1"], |run| spun(run, [0.6, 0.6]);
    spinning_bar_apic: "spinning_bar", ["bar=1", "grid.transfer=apic"], |run| spun(run, [0.1, 0.15]);
    spinning_bar_pic: "spinning_bar", ["bar=1", "grid.pic=1"], |run| spun(run, [1.01, 1.01]);
    finer_spinning_bar_flip: "spinning_bar", ["bar=2"], |run| spun(run, [0.4, 0.4]);
    finer_spinning_bar_apic: "spinning_bar", ["bar=2", "grid.transfer=apic"], |run| spun(run, [0.03, 0.04]);
    mixture_at_rest: "idle_mixture", ["duration_s=2"] => [], |run| {
        run.finished();
        let rows = run.table("history.csv");
        let [middle, end] = [&rows[rows.len() / 2], &rows[rows.len() - 1]];
        let way = 1e-3 * (end["lowest_grain_mm"] - middle["lowest_grain_mm"]);
        let kinetic = end["kinetic_J"] + end["coarse_kinetic_J"];
        // the grain presses the points by 2.5 mm, and FLIP keeps the last of their vibration
        format!("{} steps, {}, {}", end["step"], small("way of the grain in the second half, m", way, 1e-5), small("kinetic energy, J", kinetic, 1e-3))
    };
    compression_to_90_percent: "cube", ["test.axial_strain=0.9"], |run| told(run, 3, &["void ratio", "test.axial_strain"]);
    cells_crossed: "cell_crossing", [], |run| {
        run.finished();
        let [before, after] = run.ends("history.csv", "momentum_x_kg_m_s");
        format!("{}, {}", near("momentum", after, before, 1e-12), small("work of stresses, J", run.last("stress_work_J"), 1e-15))
    };
    single_point_falls: "single_point", [], |run| {
        run.finished();
        let (time, dt) = (run.last("time_s"), run.last("dt_s"));
        let mass = 2650.0 * 0.6 * 1e-6;
        let wanted = -mass * 9.81 * time;
        // the first kick is a whole step at half a step of way
        near("momentum", run.last("momentum_z_kg_m_s"), wanted, 2.0 * dt / time)
    };
}

/// All cases in their long form, as the table of the book. Cases that the table holds already are not made again: remove it to begin anew.
#[test]
#[ignore = "minutes: writes docs/validation/hard_to_break/hard_cases.csv"]
fn long_forms() {
    let path = Path::new(ROOT).join("docs/validation/hard_to_break/hard_cases.csv");
    std::fs::create_dir_all(path.parent().expect("a folder")).expect("folder");
    let done: Vec<[String; 4]> =
        csv::Reader::from_path(&path).map_or(Vec::new(), |r| r.into_deserialize().map(|row| row.expect("a row")).collect());
    let mut table = csv::Writer::from_path(path).expect("a table");
    table.write_record(["case", "scene", "outcome", "found"]).expect("row");
    for case in CASES {
        let known = done.iter().find(|row| row[0] == case.name.replace('_', " "));
        table.write_record(known.cloned().unwrap_or_else(|| check(case, true))).expect("row");
        table.flush().expect("written");
    }
}

/// The skin of the neighbour lists, and so the order of grains in memory, changes no byte of a free scene with breakages and walls under servo.
#[test]
fn a_free_scene_does_not_depend_on_its_lists() {
    let history = |skin: &str| {
        let run = Run::new("corner", &["steps=6000".into(), format!("stepping.skin={skin}"), "records.every=20".into()]);
        run.finished();
        assert!(run.last("crush_events") >= 3.0);
        std::fs::read(run.path().join("history.csv")).expect("a table")
    };
    assert!(history("0.2") == history("0.5"), "history.csv differs");
}

/// A step ten times as long as the largest stable one, forced upon points, and upon points and a grain: what comes of it is noticed.
#[test]
fn a_forced_step_of_points_ends_the_run() {
    for (scene, dt) in [("../mpm/column_collapse_2d", "1e-3"), ("../mixture/ball_impact", "4.6e-5")] {
        let dt = format!("stepping.dt_s={dt}");
        let sets = |more: &[&str]| -> Vec<String> { more.iter().map(|s| s.to_string()).chain([dt.clone()]).collect() };
        told(&Run::new(scene, &sets(&["records.snapshots=false"])), 2, &["stepping.dt_s", "compression wave"]);
        let run = Run::new(scene, &sets(&["records.snapshots=false", "stepping.above_bound=true"]));
        assert_eq!(run.code, 3, "{scene}: {}", run.message);
        finite(&run.path());
    }
    // some two times too long: nothing flies away, but there is energy that nobody gave
    let run = Run::new("../mixture/ball_impact", &["stepping.dt_s=1.2e-5", "stepping.above_bound=true"].map(String::from));
    told(&run, 3, &["kinetic energy of points and grains", "ever given", "fastest point"]);
}

/// Steps so short that a run would never end stop it at once, with who causes them.
#[test]
fn a_run_does_not_creep() {
    for (scene, more) in [
        ("../free/box_settling", "steps=100000"),
        ("../mpm/column_collapse_2d", "records.snapshots=false"),
        ("../mixture/rocks_drop", "records.snapshots=false"),
    ] {
        let run = Run::new(scene, &["stepping.safety=1e-15", more].map(String::from));
        told(&run, 3, &["records.stop_at_step", "the run would never end", "stepping.safety"]);
    }
}

/// Many steps of the points in a cycle let the transfer damp them: `check` says so, and only then.
#[test]
fn many_steps_in_a_cycle_are_doubted() {
    let said = |steps: &str| {
        let scene = Path::new(ROOT).join("experiments/mixture/triaxial_small.toml");
        let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("comminute"));
        let output = command.arg("check").arg(scene).args(["--set", "grid.pic=0.05", "--set", steps]).output().expect("starts");
        String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()
    };
    assert!(!said("stepping.continuum_steps=1").contains("viscous"));
    assert!(said("stepping.continuum_steps=10").contains("makes the points viscous"));
}
