//! The command line as a user types it, from the repository root.

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;
use std::fs;
use tempfile::TempDir;

const COKE: &str = "experiments/petroleum_coke/h-c-2.toml";

fn comminute(args: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("comminute").expect("the binary").current_dir(env!("CARGO_MANIFEST_DIR")).args(args).assert()
}

/// Refused before any work: exit code 2, and this on standard error.
fn refused(args: &[&str], says: &str) {
    comminute(args).code(2).stdout("").stderr(contains(says));
}

fn folder() -> TempDir {
    tempfile::tempdir().expect("a folder")
}

/// A copy of the coke material with `from` replaced, and a scene that uses it.
fn scene_with(folder: &TempDir, from: &str, to: &str) -> String {
    let root = env!("CARGO_MANIFEST_DIR");
    let coke = fs::read_to_string(format!("{root}/materials/petroleum_coke.toml")).expect("coke");
    assert!(coke.contains(from));
    fs::write(folder.path().join("coke.toml"), coke.replacen(from, to, 1)).expect("written");
    let scene = fs::read_to_string(format!("{root}/{COKE}")).expect("scene");
    let scene = scene.replace("../../materials/petroleum_coke.toml", "coke.toml");
    let path = folder.path().join("scene.toml");
    fs::write(&path, scene).expect("written");
    path.display().to_string()
}

/// The machine is measured where somebody asks for it, and stays known; a run's summary has what was expected beside what came out.
#[test]
fn what_is_expected_follows_the_machine_and_stands_in_the_summary() {
    let folder = folder();
    let call = |args: &[&str]| {
        let mut command = Command::cargo_bin("comminute").expect("the binary");
        command.current_dir(env!("CARGO_MANIFEST_DIR")).env("COMMINUTE_CACHE", folder.path().join("cache")).args(args);
        command.assert().success().get_output().clone()
    };
    let pace = |args: &[&str]| {
        let output = call(&[&["check", COKE, "--json"], args].concat());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("json");
        json["estimate"]["pace"].clone()
    };
    let summary = || -> serde_json::Value {
        let out = folder.path().join("run");
        call(&["run", "experiments/free/hertz_impact.toml", "--quiet", "--force", "--out", &out.display().to_string()]);
        serde_json::from_str(&fs::read_to_string(out.join("summary.json")).expect("summary")).expect("json")
    };
    assert!(pace(&[]).is_null(), "nobody asked for it");
    assert!(summary()["predicted_seconds"].is_null(), "no time that another machine would take");
    let measured = pace(&["--measure"]);
    assert!(["grain_step_s", "point_step_s"].iter().all(|key| measured[key].as_f64().is_some_and(|t| t > 0.0)), "{measured}");
    assert_eq!(pace(&[]), measured);
    let told = String::from_utf8(call(&["check", COKE]).stderr).expect("text");
    assert!(told.contains("on one thread of this machine"), "{told}");
    let summary = summary();
    // the step in which the time is over counts in the run
    let [expected, made] = ["predicted_steps", "steps"].map(|key| summary[key].as_f64().expect(key));
    assert!((expected - made).abs() <= 1.0, "{expected} {made}");
    for key in ["predicted_seconds", "predicted_memory_MB"] {
        assert!(summary[key].as_f64().is_some_and(|x| x > 0.0), "{key}: {summary}");
    }
    assert!(cfg!(not(unix)) || summary["peak_memory_MB"].as_f64().is_some_and(|mb| mb > 1.0), "{summary}");
}

#[test]
fn check_says_what_the_run_would_be() {
    comminute(&["check", COKE])
        .success()
        .stdout("")
        .stderr(contains("grains          680"))
        .stderr(contains("H = 51.8"))
        .stderr(contains("eq. 18"))
        .stderr(contains("assumed"))
        .stderr(contains("walls.friction.cylinder = 0"));
}

/// A level of accuracy sets numerical keys that the scene does not have, and says so; a wrong word, and a kind of scene that has no levels, are refused.
#[test]
fn check_says_what_a_level_of_accuracy_sets() {
    let draft = ["check", COKE, "--accuracy", "draft"];
    comminute(&draft).success().stderr(contains("accuracy = \"draft\": within").and(contains("loading.pace = 0.01  (five times")));
    let own = [&draft[..], &["--set", "loading.pace=0.004"]].concat();
    comminute(&own).success().stderr(contains("loading.pace = 0.01").not().and(contains("loading.max_lag = 0.05")));
    comminute(&["check", COKE]).success().stderr(contains("accuracy").not());
    let own = ["check", "experiments/mpm/oedometer.toml", "--accuracy", "draft"];
    comminute(&own).success().stderr(contains("test.strain_per_wave stays 0.0002, as the scene has it, not 0.0005"));
    refused(&["check", COKE, "--accuracy", "fast"], "accuracy=fast: must be \"draft\"");
    refused(&["check", "experiments/free/box_settling.toml", "--accuracy", "draft"], "accuracy");
}

#[test]
fn check_warns_of_unloading_with_a_kept_tangential_force() {
    let stages = ["check", COKE, "--set", "loading.stages_kPa=[100.0, 4000.0]"];
    comminute(&stages).success().stderr(contains("creates energy").and(contains("rescale")));
    let rescaled = [&stages[..], &["--set", "contact.unloading=rescale"]].concat();
    comminute(&rescaled).success().stderr(contains("creates energy").not());
    comminute(&["check", COKE]).success().stderr(contains("creates energy").not());
}

/// With var. = 1 and the Hertzian area 2 % of the coke is drawn too weak for the prepared specimen; with a smallest ratio none is.
#[test]
fn check_warns_of_strengths_near_zero() {
    let scene = "experiments/petroleum_coke/h-v-2.toml";
    let told = "drawn weaker than the prepared specimen's own stress";
    comminute(&["check", scene]).success().stderr(contains(told));
    comminute(&["check", scene, "--set", "material.strength.min_ratio=0.08"]).success().stderr(contains(told).not());
}

#[test]
fn check_as_json_is_one_object() {
    let assert = comminute(&["check", COKE, "--json", "--seed", "7"]).success().stderr("");
    let out = String::from_utf8(assert.get_output().stdout.clone()).expect("text");
    let value: serde_json::Value = serde_json::from_str(&out).expect("json");
    assert_eq!(value["scene"], "H-C-2");
    assert_eq!(value["estimate"]["grains"], 680);
    assert_eq!(value["seed"]["packing"], 7);
    assert_eq!(value["seed"]["strength"], 7);
    assert!(value["assumed"].as_array().is_some_and(|a| a.len() > 3));
    assert!(value["decisions"].as_array().is_some_and(|a| a.len() > 10));
}

#[test]
fn the_key_reference_is_printed() {
    comminute(&["check", "--keys"]).success().stdout(contains("[loading]").and(contains("max_stress_kPa")));
}

#[test]
fn shells_can_complete_and_man_has_pages() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let told = contains("comminute").and(contains("point-test")).and(contains("stop-after"));
        comminute(&["completions", shell]).success().stderr("").stdout(told);
    }
    refused(&["completions", "sh"], "possible values: bash");
    comminute(&["man"]).success().stderr("").stdout(contains(".TH comminute 1").and(contains("calibrate")));
    let page = contains(".TH comminute-calibrate-curve 1").and(contains("\\fBcomminute calibrate curve\\fR"));
    comminute(&["man", "calibrate", "curve"]).success().stderr("").stdout(page);
    refused(&["man", "crush"], "man crush: must be one of new, run, check");
    refused(&["man", "run", "crush"], "man crush: run has no verbs of its own");
}

#[test]
fn help_shows_an_example_that_works_as_typed() {
    for verb in ["run", "check"] {
        comminute(&[verb, "--help"]).success().stdout(contains(COKE));
    }
    comminute(&["--help"]).success().stdout(contains(COKE));
    comminute(&["check", COKE]).success();
}

#[test]
fn unknown_verbs_and_missing_arguments_are_refused() {
    refused(&["crush"], "unrecognized subcommand");
    refused(&["run"], "required");
    refused(&["check"], "required");
    refused(&["run", COKE, "--threads", "0"], "0");
    refused(&["check", COKE, "--seed", "-1"], "-1");
}

#[test]
fn a_misspelt_key_gets_a_suggestion() {
    refused(
        &["check", COKE, "--set", "loading.max_stres_kPa=2000"],
        "override loading.max_stres_kPa=2000: unknown key; did you mean loading.max_stress_kPa?",
    );
    let folder = folder();
    let scene = scene_with(&folder, "theta0_rad", "theta_rad");
    refused(
        &["check", &scene],
        "coke.toml: strength.fixed_angle.theta_rad: unknown key; did you mean strength.fixed_angle.theta0_rad?",
    );
}

#[test]
fn values_out_of_range_name_file_key_value_and_limit() {
    let folder = folder();
    for (to, says) in [
        ("m = -2.0", "coke.toml: strength.fixed_angle.m = -2: must be > 0 (Weibull modulus, eq. 7)"),
        ("m = nan", "coke.toml: strength.fixed_angle.m = nan: must be a finite number"),
        ("m = inf", "strength.fixed_angle.m = inf: must be a finite number"),
        ("m = \"2\"", "strength.fixed_angle.m = \"2\": must be a number > 0"),
        ("m = 1e-9", "strength.fixed_angle.m = 1e-9: gives strengths without limit"),
        ("", "coke.toml: strength.fixed_angle.m: is missing"),
        ("m = 2.0\nm = 2.0", "duplicate key"),
        ("m 2.0", "coke.toml: line 42 (`m 2.0`): not TOML"),
    ] {
        let scene = scene_with(&folder, "\nm = 2.0", &format!("\n{to}"));
        refused(&["check", &scene], says);
    }
    let scene = scene_with(&folder, "[[5.0, 0.0], [10.0, 1.0]]", "[]");
    refused(&["check", &scene], "coke.toml: gradation.points = []: must have at least two points");
    let scene = scene_with(&folder, "d_min_mm = 0.1", "d_min_mm = 0.5");
    refused(&["check", &scene], "coke.toml: fines.d_min_mm = 0.5: must be < 0.4200");
}

#[test]
fn all_mistakes_are_said_at_once() {
    let sets = ["--set", "loading.rate=-1", "--set", "contact.law=hert"];
    let args: Vec<&str> = ["check", COKE].into_iter().chain(sets).collect();
    comminute(&args).code(2).stderr(contains("loading.rate=-1: must be > 0")).stderr(contains("did you mean \"hertz\"?"));
}

#[test]
fn overrides_are_refused_by_their_own_text() {
    for (set, says) in [
        ("loading.rate", "must be KEY=VALUE"),
        ("loading.rate=", "has no value"),
        (".rate=1", "is not a key"),
        ("loading.rate=nan", "must be a finite number"),
        ("specimen.grains=1.5", "must be a whole number"),
        ("specimen=3", "must be a table with scale"),
        ("loading.stages_kPa=[100, -1]", "entry 2 must be > 0"),
        ("loading.max_stress_kPa=1", "must be > 5, the isotropic stress"),
        ("loading.stages_kPa=[5000]", "must each differ"),
        ("contact.law=hertz_viscous", "rate-dependent"),
        ("crushing.pattern=57", "2, 5, 14, 26, 38, 50, 68"),
        ("specimen.diameter_mm=15", "the largest grain"),
        ("records.at_kPa=[0]", "entry 1 must be > 0"),
        ("material=materials/petroleum_cok.toml", "did you mean materials/petroleum_coke.toml?"),
        ("new.table=1", "unknown key"),
    ] {
        let place = format!("override {set}");
        comminute(&["check", COKE, "--set", set]).code(2).stderr(contains(says).and(contains(place).or(contains("materials/"))));
    }
}

#[test]
fn inherited_stiffness_is_refused_where_an_area_is_hertzian() {
    comminute(&["check", "experiments/petroleum_coke/h-v-2.toml", "--set", "contact.law=linear_inherited"])
        .code(2)
        .stderr(contains("contact.law=linear_inherited: must be another law").and(contains("crushing.criterion = \"hertz_area\"")));
}

#[test]
fn an_override_reaches_the_run() {
    comminute(&["check", COKE, "--set", "loading.max_stress_kPa=500", "--json"])
        .success()
        .stdout(contains("\"steps\": 8123").and(contains("4000 will not be reached")));
    comminute(&["check", COKE, "--set", "walls.friction.cylinder=0.1"]).success().stderr(contains("walls.friction.cylinder = 0.1"));
}

#[test]
fn files_that_are_none_are_refused() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    refused(&["check", "experiments/petroleum_coke/h-c-3.toml"], "no such file; did you mean");
    refused(&["check", &path("none/at/all.toml")], "no such file");
    refused(&["check", "experiments"], "is a folder");
    fs::write(folder.path().join("binary.toml"), [0x6b, 0x69, 0xff, 0xfe]).expect("written");
    refused(&["check", &path("binary.toml")], "is not UTF-8 text (byte 2)");
    fs::write(folder.path().join("empty.toml"), "").expect("written");
    refused(&["check", &path("empty.toml")], "kind: is missing");
    refused(&["run", COKE, "--specimen", &path("none.csv"), "--out", &path("out")], "no such file");
    refused(&["plot", &path("none")], "is no folder");
}

#[test]
fn an_existing_run_is_not_overwritten() {
    let out = folder();
    fs::write(out.path().join("history.csv"), "step\n").expect("written");
    let dir = out.path().display().to_string();
    refused(&["run", COKE, "--out", &dir], "--force");
    assert_eq!(fs::read_to_string(out.path().join("history.csv")).expect("kept"), "step\n");
    refused(&["run", COKE, "--out", &format!("{dir}/history.csv")], "is a file");
}

/// A time step far too large: the run stops itself with exit code 3 and a diagnosis, and what it had recorded is there.
#[test]
fn an_unstable_run_stops_itself_and_keeps_its_data() {
    for more in [&["--set", "duration_s=5.0"][..], &[]] {
        let out = folder();
        let dir = out.path().join("run").display().to_string();
        let args =
            ["run", "experiments/free/box_settling.toml", "--out", &dir, "--set", "stepping.dt_s=0.01", "--set", "records.every=1"];
        let (forced, again) = (&["--set", "stepping.above_bound=true"][..], &["--force"][..]);
        comminute(&[&args[..], more].concat()).code(3).stderr(contains("above").and(contains("the largest stable step")));
        comminute(&[&args[..], forced, more, again].concat())
            .code(3)
            .stderr(contains("larger than all energy that they were ever given"));
        let history = fs::read_to_string(out.path().join("run/history.csv")).expect("history");
        assert!(history.lines().count() > 5, "{history}");
        assert!(!out.path().join("run/summary.json").exists(), "an unstable run is not a finished one");
    }
}

/// Soft grains dropped on each other overlap by less than the scene allows: the run stops itself where it allows less, and names grain, depth and key.
#[test]
fn a_run_stops_at_the_overlap_that_the_scene_states() {
    let out = folder();
    let dir = |name: &str| out.path().join(name).display().to_string();
    let settle = |name: &str, more: &[&str]| {
        let dir = dir(name);
        comminute(
            &[&["run", "experiments/free/box_settling.toml", "--quiet", "--out", &dir, "--set", "duration_s=0.1"][..], more]
                .concat(),
        )
    };
    settle("allowed", &[]).success();
    let said = contains("of its radius with a grain of").and(contains("records.stop_at_overlap"));
    settle("less", &["--set", "records.stop_at_overlap=1e-6"]).code(3).stderr(said);
}

#[test]
fn the_bench_measures_what_features_cost() {
    let folder = tempfile::tempdir().expect("folder");
    let few = ["bench", "features", "--grains", "500", "--steps", "2", "--repeats", "2", "--warm-up", "1", "--json", "--cache"];
    let cache = folder.path().display().to_string();
    let output = comminute(&[&few[..], &[cache.as_str()]].concat()).success().get_output().stdout.clone();
    let json: serde_json::Value = serde_json::from_slice(&output).expect("json");
    let rows = json["rows"].as_array().expect("rows");
    let bytes = |name: &str| {
        let of_it = rows.iter().find(|row| row["feature"].as_str().is_some_and(|f| f.contains(name)));
        of_it.and_then(|row| row["bytes_per_grain"].as_f64()).unwrap_or_else(|| panic!("no {name} in {json:#}"))
    };
    // what a scene does not use takes no memory
    let plain = bytes("nothing more");
    assert!(["local damping", "gravity", "fixed_angle"].iter().all(|name| (bytes(name) / plain - 1.0).abs() < 0.01), "{json:#}");
    assert!(["rolling", "account", "hertz_viscous"].iter().all(|name| bytes(name) > 1.05 * plain), "{json:#}");
    refused(&["bench", "features", "--grains", "7"], "7 is not in 500..=2000000");
}

#[test]
fn the_bench_measures_material_points() {
    let few = ["bench", "mpm", "--points", "64", "--threads", "1,2", "--steps", "2", "--repeats", "1", "--warm-up", "0", "--json"];
    comminute(&few).success().stdout(contains("\"point_steps_per_second\"")).stderr(contains("M point-steps/s"));
    refused(&["bench", "mpm", "--points", "7"], "7 is not in 8..=50000000");
    comminute(&["bench", "mpm", "--help"]).success().stdout(contains("comminute bench mpm --points 64000"));
}

/// A run is shown by a page, when it ends and later; what is no run or no report is refused before anything is written.
#[test]
fn runs_are_shown_by_a_page() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    comminute(&["run", "experiments/free/hertz_impact.toml", "--report", "--out", &at("run")])
        .success()
        .stderr(contains("report in").and(contains("report.html")));
    assert!(fs::read_to_string(at("run/report.html")).expect("page").contains("hertz_impact"));
    let json = comminute(&["report", &at("run"), "--out", &at("pages/two.html"), "--json", "--quiet"]).success().stderr("");
    let json: serde_json::Value = serde_json::from_slice(&json.get_output().stdout).expect("json");
    assert_eq!(json["bytes"].as_u64(), fs::metadata(at("pages/two.html")).ok().map(|m| m.len()));
    refused(&["report", &at("pages")], "holds no run");
    fs::write(at("notes.html"), "mine").expect("written");
    refused(&["report", &at("run"), "--out", &at("notes.html")], "is no report");
    refused(&["report", &at("run"), "--snapshots", "0"], "--snapshots");
    // the report is the run's, and goes with it
    comminute(&["run", "experiments/free/hertz_impact.toml", "--force", "--quiet", "--out", &at("run")]).success();
    assert!(!folder.path().join("run/report.html").exists());
}

/// A scene may ask for the page, and a run that is taken up again writes it; a finished run lacks it only where it is not there.
#[test]
fn a_scene_or_a_resumed_run_writes_the_page() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let page = |run: &str| folder.path().join(run).join("report.html");
    let run = |out: &str, more: &[&str]| {
        let out = at(out);
        comminute(&[&["run", "experiments/free/hertz_impact.toml", "--quiet", "--out", &out], more].concat())
    };
    run("asked", &["--set", "records.report=true"]).success().stderr("");
    assert!(page("asked").is_file());
    fs::remove_file(page("asked")).expect("removed");
    run("asked", &["--set", "records.report=true", "--continue"]).success();
    assert!(page("asked").is_file());
    for (name, key, option) in [("key", "records.report=true", &[][..]), ("option", "records.report=false", &["--report"])] {
        run(name, &["--set", key, "--stop-after", "100"]).code(130);
        assert!(!page(name).exists());
        comminute(&[&["resume", &at(name), "--quiet"], option].concat()).success();
        assert!(page(name).is_file(), "{name}");
    }
}

/// Numbers of the columns of a table of grains.
fn numbers(path: &str, columns: &[&str]) -> Vec<f64> {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).expect("a table");
    let header = reader.headers().expect("a header").clone();
    let at = |name: &&str| header.iter().position(|h| h == *name).unwrap_or_else(|| panic!("{path} has no {name}"));
    let at: Vec<usize> = columns.iter().map(at).collect();
    let row = |record: csv::StringRecord| at.iter().map(|k| record[*k].parse().expect("a number")).collect::<Vec<f64>>();
    reader.records().flat_map(|record| row(record.expect("a row"))).collect()
}

#[test]
fn grains_go_to_other_programs_and_come_back() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name).display().to_string();
    comminute(&["run", "experiments/free/hertz_impact.toml", "--quiet", "--out", &at("run")]).success();
    for (format, name) in [("lammps", "a.data"), ("yade", "a.txt"), ("stl", "a.stl"), ("ply", "a.ply")] {
        comminute(&["export", &at("run"), "--to", format, "--out", &at(name)]).success().stderr(contains("grains in"));
    }
    refused(&["export", &at("run"), "--to", "yade", "--out", &at("a.txt")], "is there already");
    refused(&["export", &at("run"), "--to", "stl", "--triangles", "7", "--out", &at("b.stl")], "must be one of 20, 80");
    refused(&["export", &at("run"), "--to", "stl", "--snapshot", "9999", "--out", &at("b.stl")], "snapshot = 9999: must be 0 to");
    let places = ["x_m", "y_m", "z_m", "r_m"];
    let moving = ["vx_m_s", "vy_m_s", "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s"];
    comminute(&["import", &at("a.data"), "--out", &at("lammps.csv")]).success();
    comminute(&["import", &at("a.txt"), "--out", &at("yade.csv")]).success();
    let [last, lammps, yade] = ["run/grains_final.csv", "lammps.csv", "yade.csv"].map(&at);
    assert_eq!(numbers(&lammps, &places), numbers(&last, &places));
    assert_eq!(numbers(&lammps, &moving), numbers(&last, &moving));
    assert_eq!(numbers(&yade, &places), numbers(&last, &places));
    let grains = numbers(&last, &["r_m"]).len() as u64;
    assert_eq!(fs::metadata(at("a.stl")).expect("a file").len(), 84 + 50 * 80 * grains);

    comminute(&["export", &at("run"), "--to", "paraview", "--out", &at("small")]).success().stderr(contains("snapshots.pvd"));
    refused(&["export", &at("run"), "--to", "paraview", "--force", "--out", &at("run")], "is the folder of a run");
    refused(&["export", &at("run"), "--to", "paraview", "--fields", "colour", "--out", &at("other")], "colour: no snapshot has it");
    for entry in fs::read_dir(at("small/snapshots")).expect("snapshots").map(|e| e.expect("an entry")) {
        let read = |path: std::path::PathBuf| comminute::record::snapshot::Snapshot::read(&path).expect("a snapshot");
        let (small, whole) = (read(entry.path()), read(folder.path().join("run/snapshots").join(entry.file_name())));
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-4;
        assert!(small.position.as_flattened().iter().zip(whole.position.as_flattened()).all(near));
        assert_eq!(small.position.len(), whole.position.len());
    }

    // a table of others, whose columns a file beside it names
    fs::write(at("packing.csv"), "X (um);Y;Z;D\n1000;0;2000,5;3000\n").expect("written");
    let columns = "separator = \";\"\ndecimal_comma = true\n[columns]\nx_mm = \"{X (um)}/1000\"\ny_mm = \"Y/1000\"\nz_mm = \"Z/1000\"\nd_mm = \"D/1000\"\n";
    fs::write(at("packing.columns.toml"), columns).expect("written");
    let set = format!("grains_csv={:?}", at("packing.csv"));
    comminute(&["check", "experiments/free/imported_packing.toml", "--set", &set]).success();
    fs::write(at("packing.csv"), "X (um);Y;Z;D\n1000;0;2000,5;-3000\n").expect("written");
    refused(&["check", "experiments/free/imported_packing.toml", "--set", &set], "packing.csv line 2: d_mm = -3.0: must be > 0");
}
