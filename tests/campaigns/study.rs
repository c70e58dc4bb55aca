//! A study from the command line: its runs, once, and the report with errors, times and effects.

use crate::ROOT;
use crate::{called, scenes_small};
use std::fs;
use std::path::Path;
use std::process::Output;
use tempfile::TempDir;

/// A small crushable scene and a plan of this design beside it.
fn folder(plan: &str) -> TempDir {
    let dir = tempfile::tempdir().expect("folder");
    fs::write(dir.path().join("crushes.toml"), scenes_small::crushes(ROOT)).expect("scene");
    fs::write(dir.path().join("plan.toml"), plan).expect("plan");
    dir
}

#[track_caller]
fn call(dir: &TempDir, args: &[&str], code: i32) -> Output {
    called::call(dir, &[&["study"], args].concat(), code)
}

fn rows(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(path).expect("table");
    reader.records().map(|r| r.expect("row").iter().map(str::to_string).collect()).collect()
}

/// One factor at a time on common specimens: neighbour lists of another width change nothing, which the report shows as a difference of zero; another rate changes something.
/// What is done is not done again.
#[test]
fn a_study_tells_what_a_choice_costs() {
    let dir = folder(
        "title = \"Skin and rate\"\nscene = \"crushes.toml\"\nseeds = \"1,2\"\nset = [\"loading.programme=eq18\"]\nsame_specimens = true\nmeasures = [\"compression\", \"k0\"]\n\
         tolerance = { compression = 0.001 }\n[reference]\nname = \"slow\"\nset = [\"loading.rate=0.02\"]\n\
         [[factor]]\nname = \"skin\"\nkey = \"stepping.skin\"\nvalues = [0.05]\n\
         [[factor]]\nname = \"rate\"\nlevels = [{ name = \"fast\", set = [\"loading.rate=0.2\"] }]\n",
    );
    let list = call(&dir, &["plan.toml", "--list"], 0);
    assert_eq!(String::from_utf8_lossy(&list.stdout).lines().count(), 2, "others begin with specimens that are not there yet");
    let output = call(&dir, &["plan.toml", "--out", "runs", "--threads", "1"], 0);
    assert!(String::from_utf8_lossy(&output.stderr).contains("8 of 8 runs done"), "{}", String::from_utf8_lossy(&output.stderr));
    let report = dir.path().join("runs/report");
    let table = rows(&report.join("study.csv"));
    let of = |setting: &str, measure: &str| {
        let row = table.iter().find(|r| r[0] == setting && r[1] == measure).unwrap_or_else(|| panic!("{setting} {measure}"));
        let number = |k: usize| row[k].parse::<f64>().expect("number");
        ((number(3), number(4)), row[6].clone(), row[2].clone())
    };
    assert_eq!(of("skin 0.05", "compression"), ((0.0, 0.0), "within".into(), "2".into()));
    assert_eq!(of("skin 0.05", "k0").0, (0.0, 0.0));
    let ((difference, half), ..) = of("rate fast", "compression");
    assert!(difference > 0.0 && half > 0.0, "{difference} {half}");
    let page = fs::read_to_string(report.join("README.md")).expect("page");
    assert!(page.contains("| skin 0.05 | 2 |") && page.contains("**") && page.contains("time_error_compression.svg"), "{page}");
    let specimen = |of: &str| fs::read(dir.path().join(format!("runs/{of}/seed-1/specimen.csv"))).expect("specimen");
    assert_eq!(specimen("slow"), specimen("the_scene"));

    let again = call(&dir, &["plan.toml", "--out", "runs", "--threads", "1"], 0);
    assert!(String::from_utf8_lossy(&again.stderr).contains("8 of 8 runs done, 8 of them before"));
}

/// A factorial has effects and interactions, in a table and a figure. The scene that lends the specimens is that of the reference here, and nothing to choose.
#[test]
fn a_factorial_has_effects() {
    let dir = folder(
        "title = \"Four\"\nscene = \"crushes.toml\"\nset = [\"loading.max_stress_kPa=20\", \"loading.programme=eq18\", \"loading.rate=0.1\"]\nseeds = \"1,2\"\ndesign = \"full\"\nsame_specimens = true\nmeasures = [\"k0\"]\n\
         [[factor]]\nname = \"rate\"\nkey = \"loading.rate\"\nvalues = [0.1, 0.2]\n\
         [[factor]]\nname = \"damping\"\nkey = \"damping.local\"\nvalues = [0.05, 0.5]\n",
    );
    call(&dir, &["plan.toml", "--out", "runs", "--report", "report", "--threads", "1", "--quiet"], 0);
    let effects = rows(&dir.path().join("report/effects.csv"));
    let names: Vec<&str> = effects.iter().map(|r| r[0].as_str()).collect();
    assert_eq!(names, ["rate: 0.1 → 0.2", "damping: 0.05 → 0.5", "rate: 0.1 → 0.2 × damping: 0.05 → 0.5"]);
    assert!(dir.path().join("report/effects_k0.svg").is_file());
    let page = fs::read_to_string(dir.path().join("report/README.md")).expect("page");
    assert!(page.contains("| the scene (that of the reference) | 2 |") && !page.contains("hoose the scene"), "{page}");
    // the effect of a factor is the mean of its two differences, and the interaction their difference
    let table = rows(&dir.path().join("report/study.csv"));
    let k = |row: usize| table[row][3].parse::<f64>().expect("number");
    let effect = |row: usize| effects[row][3].parse::<f64>().expect("number");
    let [a, b, c, d] = [0, 2, 3, 4].map(k);
    assert!(effect(0) != 0.0 && effect(1) != 0.0);
    assert!((effect(0) - 0.5 * (c + d - a - b)).abs() < 1e-8 && (effect(2) - (d - c - b + a)).abs() < 1e-8);
}

/// A plan with a mistake is refused before anything runs.
#[test]
fn wrong_plans_are_refused() {
    let dir =
        folder("title = \"t\"\nscene = \"crushes.toml\"\n[[factor]]\nname = \"rate\"\nkey = \"loading.rat\"\nvalues = [0.1]\n");
    let told = |output: Output| String::from_utf8_lossy(&output.stderr).into_owned();
    let unknown = told(call(&dir, &["plan.toml"], 2));
    assert!(unknown.contains("loading.rat"), "{unknown}");
    assert!(!dir.path().join("runs").exists());
    assert!(told(call(&dir, &["nothing.toml"], 2)).contains("nothing.toml"));
}

/// The committed plans are plans, and each of their runs has a scene that is valid.
#[test]
fn committed_studies_are_valid() {
    let mut count = 0;
    for entry in fs::read_dir(format!("{ROOT}/experiments/studies")).expect("folder") {
        let path = entry.expect("entry").path();
        if path.extension().is_none_or(|e| e != "toml") {
            continue;
        }
        let plan = comminute::study::Plan::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        for setting in plan.settings() {
            let mut job = plan.jobs(&setting, Path::new("out")).expect("jobs").swap_remove(0);
            job.specimen = None;
            job.load().unwrap_or_else(|e| panic!("{}, {}: {e}", path.display(), setting.name));
        }
        count += 1;
    }
    assert!(count > 0);
}
