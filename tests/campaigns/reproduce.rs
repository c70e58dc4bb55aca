//! A plan from the command line: its runs, once, and the report with what was published beside.

use crate::ROOT;
use crate::called::{said, text};
#[cfg(target_os = "linux")]
use crate::{called, left, processes, scenes_small};
use std::fs;
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

/// A plan of two small scenes, one crushable with two seeds and one not.
fn folder() -> TempDir {
    let dir = tempfile::tempdir().expect("folder");
    fs::write(dir.path().join("crushes.toml"), scenes_small::crushes(ROOT)).expect("scene");
    fs::write(dir.path().join("twin.toml"), "base = \"crushes.toml\"\nname = \"twin\"\n[crushing]\nenabled = false\n")
        .expect("scene");
    let plan = "title = \"A paper\"\nsource = \"A journal.\"\npublished_minutes = 120\nnotes = [\"A remark.\"]\n\
        [[run]]\nid = \"crushes\"\nscene = \"crushes.toml\"\nseeds = \"1,2\"\n\
        published = [{ events = 4, grains = 152, excluded = 900, minutes = 7 }, { stress_kPa = 9999, events = 1e6, grains = 1, excluded = 1 }]\n\
        [[run]]\nid = \"twin\"\nscene = \"twin.toml\"\n\
        [[figure]]\nname = \"fig1\"\ntitle = \"Fig. 1: lines\"\npaper = \"Lines | fall.\"\nhere = \"They do.\"\n\
        [figure.draw]\nof = \"curves\"\nshow = [\"compression\"]\nruns = [\"crushes\", \"twin\"]\n\
        [[figure]]\nname = \"fig2\"\ntitle = \"Fig. 2: time\"\npaper = \"Time grows.\"\n[figure.draw]\nof = \"cost\"\n";
    fs::write(dir.path().join("plan.toml"), plan).expect("plan");
    dir
}

fn command(dir: &TempDir, args: &[&str]) -> Command {
    called::command(dir, &[&["reproduce"], args].concat())
}

#[track_caller]
fn call(dir: &TempDir, args: &[&str], code: i32) -> Output {
    called::call(dir, &[&["reproduce"], args].concat(), code)
}

#[test]
fn runs_are_done_once_and_stand_beside_what_was_published() {
    let dir = folder();
    call(&dir, &["plan.toml", "--only", "cr*", "--out", "out"], 0);
    assert!(!dir.path().join("out/twin").exists(), "not asked for");
    let part = text(&dir, "out/report/README.md");
    assert!(part.contains("# A paper\n\nA journal.") && part.contains("- A remark."), "{part}");

    let output = call(&dir, &["plan.toml", "--out", "out", "--report", "paper"], 0);
    assert!(said(&output).contains("3 of 3 runs done, 2 of them before"), "{}", said(&output));
    let table = text(&dir, "paper/comparison.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split(',').collect()).collect();
    let cell = |row: usize, name: &str| rows[row][rows[0].iter().position(|h| *h == name).expect("column")];
    let number = |row: usize, name: &str| cell(row, name).parse::<f64>().expect("number");
    assert_eq!((rows.len(), cell(1, "run"), cell(1, "seeds")), (3, "crushes", "2"));
    let events = number(1, "events_mean");
    assert!(events > 0.0 && (number(1, "grains_mean") - (100.0 + 13.0 * events)).abs() < 1e-6);
    assert!((number(1, "difference_percent") - 100.0 * (events / 4.0 - 1.0)).abs() < 1e-6);
    assert_eq!(cell(2, "events_mean"), "", "no run got to that stress");
    assert_eq!(cell(2, "reached_seeds"), "0");
    assert_eq!(text(&dir, "paper/runs.csv").lines().count(), 4);

    let report = text(&dir, "paper/README.md");
    assert!(report.contains("| Lines \\| fall. | They do. |") && report.contains("<img src=\"fig1/compression.svg\""), "{report}");
    assert!(report.contains("the paper's took 120 min"), "{report}");
    for file in ["fig1/compression.csv", "fig2/run_time_crush_events.svg"] {
        assert!(dir.path().join("paper").join(file).is_file(), "{file}");
    }
    // the same again changes nothing but what it says
    call(&dir, &["plan.toml", "--out", "out", "--report", "again"], 0);
    assert_eq!(report, text(&dir, "again/README.md"));
}

/// One run is killed; then the same is called twice at the same moment, and both share what is left and leave one whole report.
#[cfg(target_os = "linux")]
#[test]
fn a_killed_run_is_all_that_is_left_to_two_that_go_on() {
    let dir = folder();
    let plan = text(&dir, "plan.toml");
    // the second figure holds run times
    fs::write(dir.path().join("plan.toml"), &plan[..plan.rfind("[[figure]]").expect("figures")]).expect("plan");
    call(&dir, &["plan.toml", "--out", "whole"], 0);
    let args = ["plan.toml", "--out", "out", "--jobs", "1"];
    let start = || command(&dir, &args).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("started");
    let mut child = start();
    processes::kill_run(&mut child, dir.path(), "out/crushes/seed-2", || true);
    let output = child.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("error: out/crushes/seed-2: was killed by SIGKILL (from outside"), "{}", said(&output));
    assert!(text(&dir, "out/report/runs.csv").lines().count() == 3, "the report holds what is done");

    let begun = || ["crushes/seed-1", "twin/seed-1"].map(|run| fs::metadata(dir.path().join("out").join(run).join("history.csv")));
    let times = || begun().map(|m| m.and_then(|m| m.modified()).expect("history"));
    let before = times();
    let both = [start(), start()].map(|child| child.wait_with_output().expect("ended"));
    let made = both.iter().filter(|output| said(output).contains("3 of 3 runs done, 2 of them before")).count();
    for output in &both {
        assert!(output.status.success() && said(output).contains("3 of 3 runs done"), "{}", said(output));
    }
    assert_eq!((made, times()), (1, before), "only the killed run is made, by one of them");
    left::assert_same(&left::files(&dir.path().join("whole")), &left::files(&dir.path().join("out")), "killed");
}

#[test]
fn mistakes_are_told_before_anything_runs() {
    let dir = folder();
    let output = call(&dir, &["plan.toml", "--only", "x*"], 2);
    assert!(said(&output).contains("matches no run of the plan: crushes, twin"), "{}", said(&output));
    assert!(said(&call(&dir, &["plan.toml", "--only", "[a"], 2)).contains("is no pattern"));
    assert!(said(&call(&dir, &["nobody1999"], 2)).contains("experiments/nobody1999.toml"));
    fs::write(dir.path().join("twin.toml"), "base = \"crushes.toml\"\n[loading]\nrate = -1\n").expect("scene");
    assert!(said(&call(&dir, &["plan.toml"], 2)).contains("loading.rate = -1"));
    assert!(!dir.path().join("runs").exists());
}

#[test]
fn the_plan_of_the_paper_holds_every_row_of_its_table() {
    let plan = comminute::reproduce::Plan::read(&format!("{ROOT}/experiments/ciantia2015.toml")).expect("plan");
    let rows: Vec<_> = plan.runs.iter().flat_map(|r| &r.published).collect();
    assert_eq!(rows.len(), 18, "Table 4 of Ciantia et al. 2015");
    for run in &plan.runs {
        for job in plan.jobs(run, std::path::Path::new("out")).expect("jobs") {
            let (_, model) = job.load().expect("scene");
            for p in &run.published {
                let comminute::model::Rig::Oedometer(rig) = &model.rig else { panic!("{} is no oedometer", run.id) };
                assert_eq!(rig.specimen.grains as f64 + 13.0 * p.events, p.grains, "{}", run.id);
            }
        }
    }
    // the starred rows of Table 4 are stages of the runs that follow them
    let minutes: f64 = plan.runs.iter().filter_map(|r| r.published.last()?.minutes).sum();
    assert_eq!(Some(minutes), plan.published_minutes);
}

/// A plan of three tiny triaxial tests: fines alone and with coarse grains, and one of another name.
fn triaxial() -> TempDir {
    let dir = tempfile::tempdir().expect("folder");
    let scene = format!(
        "base = \"{ROOT}/tests/gpu/mixture.toml\"\nname = \"mixed\"\n[materials]\nfines = \"{ROOT}/materials/li2023_fines.toml\"\n\
         coarse = \"{ROOT}/materials/li2023_coarse.toml\"\n[test]\naxial_strain = 0.001\nstrain_per_wave = 1e-3\n\
         [records]\nrows = 10\nfigures = false\nsnapshots = false\n"
    );
    fs::write(dir.path().join("mixed.toml"), scene).expect("scene");
    let plan = "title = \"A paper\"\nsource = \"A journal.\"\ncompare = \"triaxial\"\n\
        [[statement]]\npaper = \"More grains | more strength\"\nof = \"peak\"\nexpect = \"rises\"\nruns = [\"1:5-00\", \"1:5-20\"]\n\
        [[statement]]\npaper = \"Table of times\"\nof = \"wall_time\"\nruns = [\"1:5-00\", \"1:5-20\"]\n\
        [[statement]]\npaper = \"Others too\"\nof = \"residual\"\nexpect = \"equal\"\nruns = [\"1:5-20\", \"1:10-20\"]\n\
        [[run]]\nid = \"1:5-00\"\nscene = \"mixed.toml\"\nset = [\"coarse.mass_fraction=0.0\"]\n\
        published_test = { coarse_percent = 0, points = 64000, seconds = 34951, simulated_s = 6.4 }\n\
        [[run]]\nid = \"1:5-20\"\nscene = \"mixed.toml\"\npublished_test = { coarse_percent = 20, points = 53884, grains = 114 }\n\
        [[run]]\nid = \"1:10-20\"\nscene = \"mixed.toml\"\n\
        [[figure]]\nname = \"fig22\"\ntitle = \"Fig. 22\"\npaper = \"Lines.\"\nhere = \"Lines.\"\n\
        [figure.draw]\nof = \"curves\"\nshow = [\"stress_ratio\"]\nruns = [\"1:5-00\", \"1:5-20\"]\n";
    fs::write(dir.path().join("plan.toml"), plan).expect("plan");
    dir
}

/// Triaxial tests have a table of their own; a text without wildcards selects the runs whose names contain it.
#[test]
fn triaxial_tests_stand_beside_what_the_paper_says() {
    let dir = triaxial();
    call(&dir, &["plan.toml", "--only", "1:5", "--out", "out"], 0);
    assert!(!dir.path().join("out/1:10-20").exists(), "not asked for");
    let rows: Vec<Vec<String>> =
        text(&dir, "out/report/comparison.csv").lines().map(|l| l.split(',').map(String::from).collect()).collect();
    let cell = |row: usize, name: &str| rows[row][rows[0].iter().position(|h| h == name).expect("column")].as_str();
    let number = |row: usize, name: &str| cell(row, name).parse::<f64>().expect("number");
    assert_eq!((rows.len(), cell(1, "run"), cell(2, "run"), cell(3, "seeds")), (4, "1:5-00", "1:5-20", "0"));
    assert_eq!((cell(1, "points_mean"), cell(1, "points_paper"), cell(3, "peak_stress_ratio_mean")), ("1000", "64000", ""));
    // as the history has it
    let history = text(&dir, "out/1:5-20/seed-1/history.csv");
    let stages = history.lines().skip(1).map(|l| l.split(',').nth(2) == Some("load"));
    let loaded = |name: &str| -> Vec<f64> {
        column(&history, name).into_iter().zip(stages.clone()).filter(|(_, load)| *load).map(|(x, _)| x).collect()
    };
    let ratios = loaded("principal_ratio");
    let peak = ratios.iter().copied().fold(0.0, f64::max);
    assert!((number(2, "peak_stress_ratio_mean") / peak - 1.0).abs() < 1e-8);
    // the whole test is the last percent of its strain
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!((number(2, "residual_stress_ratio_mean") / mean - 1.0).abs() < 1e-8);
    assert_eq!(number(2, "volumetric_strain_end_mean"), *loaded("volumetric_strain").last().expect("rows"));
    let simulated = number(1, "simulated_s_mean");
    assert!((number(1, "minutes_paper_for_this_time") / (34951.0 / 60.0 * simulated / 6.4) - 1.0).abs() < 1e-8);

    let report = text(&dir, "out/report/README.md");
    assert!(report.contains("| More grains \\| more strength | 1:5-00 ") && report.contains(", 1:5-20 "), "{report}");
    assert!(report.contains("min (paper 583 min, ") && report.contains("min for as much simulated time)"), "{report}");
    assert!(report.contains("not enough runs are done") && report.contains("<img src=\"fig22/stress_ratio.svg\""), "{report}");
    assert_eq!(text(&dir, "out/report/runs.csv").lines().count(), 3);
}

#[test]
fn what_is_said_of_triaxial_tests_needs_its_comparison() {
    let dir = triaxial();
    let plan = text(&dir, "plan.toml");
    let refused = |from: &str, to: &str, says: &[&str]| {
        fs::write(dir.path().join("plan.toml"), plan.replacen(from, to, 1)).expect("plan");
        let told = said(&call(&dir, &["plan.toml"], 2));
        assert!(says.iter().all(|text| told.contains(text)), "{told}");
    };
    refused(
        "compare = \"triaxial\"\n",
        "",
        &["run.published_test = 1:5-00: needs compare = \"triaxial\"", "statement = Table of times"],
    );
    refused("\"1:5-20\"]", "\"1:5-30\"]", &["statement[0].runs = 1:5-30: is no run of the plan"]);
    refused("of = \"peak\"", "of = \"height\"", &["unknown variant `height`, expected one of `peak`"]);
    refused(
        "compare = \"triaxial\"",
        "compare = \"shear\"",
        &["unknown variant `shear`, expected one of `crushing`, `triaxial`, `numbers`"],
    );
}

/// The plan of Li et al. 2023 names valid scenes, and its points are as many as Tables 2 and 4 have where the specimens are lattices.
#[test]
fn the_plan_of_the_mixtures_holds_their_tables() {
    let plan = comminute::reproduce::Plan::read(&format!("{ROOT}/experiments/li2023.toml")).expect("plan");
    assert_eq!(plan.runs.iter().filter(|run| run.id.contains("1:5")).count(), 6);
    assert_eq!(plan.runs.iter().filter(|run| run.id.contains("fan")).count(), 9);
    for run in &plan.runs {
        let [job] = &plan.jobs(run, std::path::Path::new("out")).expect("jobs")[..] else { panic!("one seed") };
        let (_, outline) = job.load().unwrap_or_else(|e| panic!("{}: {e}", run.id));
        let comminute::model::Rig::Continuum(rig) = &outline.rig else { panic!("{} has no points", run.id) };
        let published = run.published_test.expect("published");
        if let (0.0, Some(points)) = (published.coarse_percent, published.points) {
            assert_eq!(rig.counts()[0] as f64, points, "{}", run.id);
        }
    }
}

/// A plan of two impacts of discs of the same mass, whose numbers and graph come from the runs' tables.
fn numbers() -> TempDir {
    let dir = tempfile::tempdir().expect("folder");
    let disc = |x: f64, v: f64| {
        format!(
            "[[block]]\nshape = \"polygon\"\npoints_mm = [0.0, 0.0]\nrounding_mm = 10.0\nposition_mm = [{x:?}, 0.0, 0.0]\nvelocity_m_s = [{v:?}, 0.0, 0.0]\n"
        )
    };
    let scene = format!(
        "kind = \"mixture\"\nduration_s = 0.05\ngrid.plane_strain = true\nstepping.safety = 0.05\n{}{}[contact]\nlaw = \"spring\"\n\
         [material]\nname = \"disc\"\ngrain.density_kg_m3 = 2000.0\nelastic.E_GPa = 1.0\nelastic.nu = 0.2\ncontact.friction = 0.0\n\
         spring.k_n_N_m = 1e6\nspring.k_t_N_m = 1e6\n[records]\nrows = 100\nsnapshots = false\nfigures = false\n",
        disc(0.0, 1.0),
        disc(21.0, 0.0)
    );
    fs::write(dir.path().join("discs.toml"), scene).expect("scene");
    let second = "from = { table = \"blocks.csv\", rows = { block = 1 } }\n";
    let plan = format!(
        "title = \"A paper\"\nsource = \"A journal.\"\ncompare = \"numbers\"\n\
        [[run]]\nid = \"slow\"\nscene = \"discs.toml\"\nseeds = \"none\"\n\
        [[run]]\nid = \"fast\"\nscene = \"discs.toml\"\nseeds = \"none\"\nset = [\"block[0].velocity_m_s=[2.0, 0.0, 0.0]\"]\n\
        [[run]]\nid = \"faster\"\nscene = \"discs.toml\"\nseeds = \"none\"\nset = [\"block[0].velocity_m_s=[4.0, 0.0, 0.0]\"]\n\
        [[number]]\nwhat = \"speed | after\"\nrun = \"slow\"\nvalue = \"100*vx_m_s\"\nunit = \"cm/s\"\npaper = 80.0\n{second}series = \"speed\"\nat = 1.0\n\
        [[number]]\nwhat = \"the same fast\"\nrun = \"fast\"\nvalue = \"100*vx_m_s\"\nunit = \"cm/s\"\n{second}series = \"speed\"\nat = 2.0\n\
        [[number]]\nwhat = \"the same faster\"\nrun = \"faster\"\nvalue = \"100*vx_m_s\"\nunit = \"cm/s\"\n{second}series = \"speed\"\nat = 4.0\n\
        [[number]]\nwhat = \"time of the impact\"\nrun = \"slow\"\nvalue = \"vx_m_s - 0.5\"\ntake = \"time_above_zero\"\nunit = \"s\"\n{second}\
        [[fit]]\nwhat = \"speed over speed before\"\nseries = \"speed\"\nbase = \"x\"\nexponent = 1.0\nfactor = 100\n\
        [[figure]]\nname = \"fig1\"\ntitle = \"Fig. 1\"\npaper = \"Speeds.\"\nhere = \"Speeds.\"\n[figure.draw]\nof = \"graph\"\n\
        x = {{ label = \"time (s)\", column = \"time_s\" }}\ny = {{ label = \"speed (m/s)\", column = \"speed_m_s\" }}\n\
        curves = [{{ label = \"slow\", run = \"slow\", from = {{ table = \"blocks.csv\", rows = {{ block = 1 }} }}, x = \"time_s\", y = \"vx_m_s\" }}]\n\
        laws = [{{ label = \"all of it\", value = \"1 + 0*x\", between = [0.0, 0.05] }}]\npublished = [{{ label = \"paper\", points = [[0.05, 0.8]] }}]\n\
        [[figure]]\nname = \"fig2\"\ntitle = \"Fig. 2\"\npaper = \"Discs.\"\n[figure.draw]\nof = \"bodies\"\nruns = [\"slow\"]\n"
    );
    fs::write(dir.path().join("plan.toml"), plan).expect("plan");
    dir
}

/// Numbers are expressions of the columns of chosen rows; each stands beside the paper's, and a power law goes through those of a series.
#[test]
fn numbers_of_runs_stand_beside_those_of_the_paper() {
    let dir = numbers();
    call(&dir, &["plan.toml", "--out", "out"], 0);
    let table = text(&dir, "out/report/comparison.csv");
    let here = column(&table, "here");
    // an elastic impact of equal masses hands over the whole speed; the gap of 1 mm takes a millisecond
    assert!((here[0] / 100.0 - 1.0).abs() < 0.01 && (here[1] / 200.0 - 1.0).abs() < 0.01, "{here:?}");
    assert!((0.001..0.02).contains(&here[3]), "{here:?}");
    assert!(table.lines().nth(1).is_some_and(|line| line.contains(",80,")), "{table}");
    let report = text(&dir, "out/report/README.md");
    assert!(
        report.contains("| speed \\| after | 80 cm/s | 99.") || report.contains("| speed \\| after | 80 cm/s | 100"),
        "{report}"
    );
    assert!(report.contains("| speed over speed before | 1 | 1 | 100 |"), "{report}");
    let graph = text(&dir, "out/report/fig1/fig1.csv");
    assert!(graph.contains("slow") && graph.contains("all of it") && graph.contains("paper"), "{graph}");
    assert!(dir.path().join("out/report/fig2/slow/bodies.svg").exists());
}

#[test]
fn numbers_that_cannot_be_read_are_told_before_anything_runs() {
    let dir = numbers();
    let plan = text(&dir, "plan.toml");
    for (from, to, says) in [
        ("compare = \"numbers\"\n", "", "number = speed | after: needs compare = \"numbers\""),
        ("run = \"slow\"\nvalue", "run = \"slower\"\nvalue", "number[0].run = slower: is no run of the plan"),
        ("value = \"100*vx_m_s\"", "value = \"100*\"", "`100*` is no expression"),
        (
            "table = \"blocks.csv\"",
            "table = \"../blocks.csv\"",
            "number[0].from.table = ../blocks.csv: must be the name of a file of a run",
        ),
        ("series = \"speed\"\nbase", "series = \"spin\"\nbase", "fit[0].series = spin: is no series of the plan's numbers"),
        ("base = \"x\"", "base = \"x + y\"", "`y` is not known"),
        ("take = \"time_above_zero\"", "take = \"best\"", "unknown variant `best`"),
        ("run = \"slow\", from", "run = \"slower\", from", "figure fig1 = slower: is no run of the plan"),
    ] {
        let changed = plan.replacen(from, to, 1);
        assert_ne!(changed, plan, "{from}");
        fs::write(dir.path().join("plan.toml"), changed).expect("plan");
        let told = said(&call(&dir, &["plan.toml"], 2));
        assert!(told.contains(says), "{says}: {told}");
    }
    // a column that no table has is told when the report is written, by its name
    fs::write(dir.path().join("plan.toml"), plan.replacen("100*vx_m_s", "100*v_m_s", 1)).expect("plan");
    assert!(said(&call(&dir, &["plan.toml", "--out", "out"], 2)).contains("no column `v_m_s`"));
}

/// The plan of Jiang et al. 2020 names valid scenes.
#[test]
fn the_plan_of_the_blocks_names_valid_scenes() {
    let plan = comminute::reproduce::Plan::read(&format!("{ROOT}/experiments/jiang2020.toml")).expect("plan");
    for run in &plan.runs {
        for job in plan.jobs(run, std::path::Path::new("out")).expect("jobs") {
            job.load().unwrap_or_else(|e| panic!("{}: {e}", run.id));
        }
    }
}

/// Eqs (13)–(15): with every length multiplied by N, the specimen's too, nothing but lengths changes. So what differs between two scales in one
/// oedometer is how many grains stand between its walls.
#[test]
fn upscaling_with_the_specimen_scaled_too_changes_nothing() {
    let dir = folder();
    let run = |args: &[&str]| {
        called::call(&dir, &[&["run"], args].concat(), 0);
    };
    run(&["crushes.toml", "--quiet", "--out", "one"]);
    let specimen = text(&dir, "one/specimen.csv");
    let twice: Vec<String> = specimen.lines().filter(|l| !l.starts_with("# hash")).map(doubled).collect();
    fs::write(dir.path().join("twice.csv"), twice.join("\n")).expect("specimen");
    let sets = ["--set", "specimen.scale=8.0", "--set", "specimen.diameter_mm=400.0"];
    let columns = ["sigma_v_kPa", "k0", "axial_strain", "porosity", "coordination_number", "crush_events"];
    let both = |scene: &str| {
        run(&[scene, "--quiet", "--out", "small", "--force", "--specimen", "one/specimen.csv"]);
        run(&[&[scene, "--quiet", "--out", "large", "--force", "--specimen", "twice.csv"], &sets[..]].concat());
        let read = |folder: &str| {
            let table = text(&dir, &format!("{folder}/history.csv"));
            columns.map(|name| column(&table, name))
        };
        (read("small"), read("large"))
    };
    // rounding grows from contact to contact, so that late records show nothing
    let (small, large) = both("twin.toml");
    for (a, b) in small.iter().zip(&large) {
        assert!(a.len() > 20 && a.iter().zip(b).take(10).all(|(a, b)| (a - b).abs() <= 1e-6 * a.abs().max(1.0)), "{a:?} {b:?}");
    }
    // the first breakages; after them the paths part at once
    let (small, large) = both("crushes.toml");
    assert!(small[5][1] > 0.0 && small[5][1] == large[5][1], "{:?} {:?}", small[5], large[5]);
}

/// A column of a CSV file.
fn column(table: &str, name: &str) -> Vec<f64> {
    let at = table.lines().next().expect("header").split(',').position(|h| h == name).expect("column");
    table.lines().skip(1).map(|l| l.split(',').nth(at).expect("cell").parse().expect("number")).collect()
}

/// A line of a specimen file with every length twice as large.
fn doubled(line: &str) -> String {
    let double = |x: &str| x.trim().parse::<f64>().map_or(x.to_string(), |x| format!("{:?}", 2.0 * x));
    match line.split_once('=') {
        Some((name, value)) => format!("{name}= {}", double(value)),
        // x_m, y_m, z_m, r_m come first
        None => line
            .split(',')
            .enumerate()
            .map(|(i, cell)| if i < 4 { double(cell) } else { cell.to_string() })
            .collect::<Vec<_>>()
            .join(","),
    }
}
