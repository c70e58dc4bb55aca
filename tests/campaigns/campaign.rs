//! Ensembles and sweeps from the command line: each run a process in its own folder, and nothing done twice.

use crate::ROOT;
use crate::called::{call, command, said, text};
#[cfg(target_os = "linux")]
use crate::{left, processes};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, SystemTime};
use tempfile::TempDir;

/// A folder with `scene.toml`, a small crushable specimen that is pressed in well under a second.
fn folder() -> TempDir {
    let dir = tempfile::tempdir().expect("folder");
    let text = format!(
        "base = \"{ROOT}/experiments/petroleum_coke/h-c-2.toml\"\nname = \"small\"\n[specimen]\nscale = 4.0\ngrains = 100\nporosity = 0.48\n\
         [preparation]\ngrowth_friction = 0.4\ngrowth_steps = 1000\nporosity_tolerance = 0.05\nmax_steps = 30000\n\
         [loading]\nmax_stress_kPa = 60.0\nprogramme = \"adaptive\"\nsettle_steps = 100\n\
         [records]\nat_kPa = []\nfigures = false\nsnapshots = false\ncheckpoint_seconds = 0.02\n\
         [material]\nbase = \"{ROOT}/materials/petroleum_coke.toml\"\n[material.strength.fixed_angle]\nsigma_lim0_MPa = 60.0\n"
    );
    fs::write(dir.path().join("scene.toml"), text).expect("scene");
    dir
}

/// When each history was last written: a run that is done again changes it.
fn written(dir: &TempDir, folders: &[&str]) -> Vec<SystemTime> {
    folders.iter().map(|f| changed(dir, &format!("{f}/history.csv")).expect("history")).collect()
}

/// When a file was last written; `None` where there is none. A run writes `scene.resolved.toml` when it begins, and never again.
fn changed(dir: &TempDir, file: &str) -> Option<SystemTime> {
    fs::metadata(dir.path().join(file)).and_then(|m| m.modified()).ok()
}

/// Runs that a campaign has made itself, from its closing lines.
fn made(said: &str) -> usize {
    let line = said.lines().find(|l| l.contains(" runs done")).unwrap_or_else(|| panic!("{said}"));
    let numbers: Vec<usize> = line.split(' ').filter_map(|word| word.parse().ok()).collect();
    numbers[0] - numbers.get(2).unwrap_or(&0)
}

/// A column of a CSV file as numbers, empty cells left out.
fn column(table: &str, name: &str) -> Vec<f64> {
    let at = table.lines().next().expect("header").split(',').position(|h| h == name).unwrap_or_else(|| panic!("no {name}"));
    table.lines().skip(1).filter_map(|l| l.split(',').nth(at)?.parse().ok()).collect()
}

#[test]
fn an_ensemble_gives_means_and_bands_and_is_not_run_again() {
    let dir = folder();
    let data = dir.path().join("data.csv");
    fs::write(&data, "# label = measured\nsigma_v_kPa,porosity\n20,0.47\n50,0.46\n").expect("data");
    let args = ["ensemble", "scene.toml", "--seeds", "1..3", "--jobs", "2", "--out", "e", "--data", "data.csv"];
    call(&dir, &args, 0);
    let folders = ["e/seed-1", "e/seed-2", "e/seed-3"];
    let mean = text(&dir, "e/mean.csv");
    let (middle, low, high) = (column(&mean, "porosity_mean"), column(&mean, "porosity_low"), column(&mean, "porosity_high"));
    assert!(middle.len() > 30);
    assert!((0..middle.len()).all(|i| low[i] < middle[i] && middle[i] < high[i]), "three seeds differ everywhere");
    assert!(column(&mean, "runs").iter().all(|n| *n == 3.0));
    // the last record of each run is at nearly the same stress: its mean is that of the table's last row
    let ends: Vec<f64> =
        folders.iter().map(|f| *column(&text(&dir, &format!("{f}/history.csv")), "porosity").last().expect("row")).collect();
    assert!((middle[middle.len() - 1] - ends.iter().sum::<f64>() / 3.0).abs() < 2e-4);
    let drawn = text(&dir, "e/figures/compression.csv");
    assert!(drawn.contains("\"small, seeds 1–3\",band,") && drawn.contains("measured,data,0.02"), "{drawn}");
    assert_eq!(text(&dir, "e/figures/runs.csv").lines().count(), 4);
    assert!(!dir.path().join("e/seed-1.log").exists(), "a run that ended well had nothing to say");

    let before = written(&dir, &folders);
    let again = call(&dir, &args, 0);
    assert!(said(&again).contains("3 of 3 runs done, 3 of them before"), "{}", said(&again));
    // what they found, with its spread, and of each when they are drawn
    let found = said(&again);
    let e = found.lines().find_map(|l| l.trim().strip_prefix("void ratio at the end: ")).expect("what was found");
    assert!(e.contains(" ± ") && e.contains("of 3 runs") && found.contains("breakages: "), "{found}");
    let drawn = said(&call(&dir, &["plot", "e/seed-1", "e/seed-2", "--out", "both"], 0));
    assert!(drawn.contains("e/seed-2: up to ") && drawn.contains("(Einav)"), "{drawn}");
    assert_eq!(written(&dir, &folders), before);
    // another scene in the same folders is refused, and says what differs
    let other = call(&dir, &[&args[..], &["--set", "loading.max_stress_kPa=50"]].concat(), 2);
    assert!(said(&other).contains("max_stress_kPa = 60.0 there, max_stress_kPa = 50.0 here"), "{}", said(&other));
    assert_eq!(written(&dir, &folders), before);
    let more = call(&dir, &["ensemble", "scene.toml", "--seeds", "1,4", "--out", "e", "--json", "--quiet"], 0);
    let told: serde_json::Value = serde_json::from_slice(&more.stdout).expect("json");
    assert_eq!(told["runs"][1]["summary"]["seed"]["packing"], 4);
    assert!(more.stderr.is_empty());
}

#[test]
fn seeds_choose_one_stream_or_the_other() {
    let dir = folder();
    for (vary, packing, strength) in [("packing", 2, 1), ("strength", 1, 2)] {
        let list = call(&dir, &["ensemble", "scene.toml", "--seeds", "2", "--vary", vary, "--out", vary, "--list"], 0);
        assert!(String::from_utf8_lossy(&list.stdout).contains(&format!("--seed-{vary} 2 --out {vary}/seed-2")));
        call(&dir, &["ensemble", "scene.toml", "--seeds", "2", "--vary", vary, "--out", vary, "--quiet"], 0);
        let summary: serde_json::Value =
            serde_json::from_str(&text(&dir, &format!("{vary}/seed-2/summary.json"))).expect("summary");
        assert_eq!((&summary["seed"]["packing"], &summary["seed"]["strength"]), (&packing.into(), &strength.into()));
    }
}

#[cfg(unix)]
#[test]
fn a_list_is_run_by_a_shell_and_every_line_twice() {
    let dir = folder();
    let args = [
        "sweep",
        "scene.toml",
        "--grid",
        "material.strength.fixed_angle.m=2,3",
        "--set",
        "description=it's a \"test\"",
        "--out",
        "a b",
    ];
    let list = call(&dir, &[&args[..], &["--list"]].concat(), 0);
    let list = String::from_utf8(list.stdout).expect("text");
    assert_eq!(list.lines().count(), 2);
    assert!(!dir.path().join("a b").exists(), "a list runs nothing");
    let folders = ["a b/m-2", "a b/m-3"];
    let mut times = Vec::new();
    for _ in 0..2 {
        for line in list.lines() {
            let status = Command::new("sh").current_dir(dir.path()).args(["-c", line]).status().expect("sh");
            assert!(status.success(), "{line}");
        }
        times.push(written(&dir, &folders));
    }
    assert_eq!(times[0], times[1]);
    let gathered = call(&dir, &args, 0);
    assert!(said(&gathered).contains("2 of 2 runs done, 2 of them before"), "{}", said(&gathered));
    assert_eq!(column(&text(&dir, "a b/sweep.csv"), "material.strength.fixed_angle.m"), [2.0, 3.0]);
    assert!(text(&dir, "a b/figures/compression.csv").contains("small_m-3, seed 1"));
}

#[test]
fn a_run_that_fails_is_told_and_the_others_go_on() {
    let dir = folder();
    fs::write(dir.path().join("points.csv"), "specimen.porosity,seed.strength\n0.2,\n0.48,5\n").expect("table");
    let args = ["sweep", "scene.toml", "--table", "points.csv", "--out", "s"];
    let output = call(&dir, &args, 1);
    assert!(said(&output).contains("s/porosity-0.2: step 30001: preparation"), "{}", said(&output));
    assert!(said(&output).contains("1 of 2 runs failed"), "{}", said(&output));
    assert!(text(&dir, "s/porosity-0.2.log").starts_with("error: step 30001"));
    let table = text(&dir, "s/sweep.csv");
    assert!(
        table.contains("\nporosity-0.2,failed,0.2,,") && table.contains("\nporosity-0.48_strength-5,done,0.48,5,1,5,"),
        "{table}"
    );
    assert!(table.contains("preparation"));
    assert!(dir.path().join("s/figures/compression.svg").exists(), "what is done is drawn");
}

#[test]
fn everything_wrong_is_refused_before_anything_runs() {
    let dir = folder();
    fs::write(dir.path().join("points.csv"), "loading.rate\n0.01\nfast\n").expect("table");
    for (args, says) in [
        (&["ensemble", "scene.toml", "--seeds", "3..1"][..], "counts down"),
        (&["ensemble", "scene.toml", "--seeds", "1,x"], "`x` is no seed"),
        (&["ensemble", "none.toml"], "no such file"),
        (&["ensemble", "scene.toml", "--set", "loading.rate=-1"], "must be > 0"),
        (&["ensemble", "scene.toml", "--data", "none.csv"], "none.csv: no such file"),
        (&["ensemble", "scene.toml", "--jobs", "0"], "0"),
        (&["ensemble", "scene.toml", "--executor", "pbs"], "[possible values: local, slurm, hyperqueue, command]"),
        (&["ensemble", "scene.toml", "--executor", "command", "--executor-command", "ssh node"], "`ssh node` has no place"),
        (&["ensemble", "scene.toml", "--executor-options=--mem=1G"], "is only for --executor slurm"),
        (&["sweep", "scene.toml"], "needs at least one --grid"),
        (&["sweep", "scene.toml", "--grid", "loading.rate=0.01,-1"], "loading.rate=-1: must be > 0"),
        (&["sweep", "scene.toml", "--grid", "loading.rat=1"], "did you mean loading.rate?"),
        (&["sweep", "scene.toml", "--table", "points.csv"], "loading.rate=fast: must be a number"),
        (&["sweep", "scene.toml", "--table", "points.csv", "--list"], "loading.rate=fast: must be a number"),
        (&["sweep", "scene.toml", "--grid", "loading.rate=0.1", "--vary", "packing"], "--seeds"),
    ] {
        let output = call(&dir, &[args, &["--out", "out"]].concat(), 2);
        assert!(said(&output).contains(says), "{args:?}\n{}", said(&output));
        assert!(output.stdout.is_empty() && !dir.path().join("out").exists());
    }
}

#[test]
fn run_with_continue_does_only_what_is_left() {
    let dir = folder();
    let args = ["run", "scene.toml", "--out", "r", "--continue", "--quiet"];
    call(&dir, &[&args[..], &["--stop-after", "1500"]].concat(), 130);
    assert!(dir.path().join("r/checkpoint.bin").exists());
    call(&dir, &args, 0);
    call(&dir, &["run", "scene.toml", "--out", "whole", "--quiet"], 0);
    assert_eq!(text(&dir, "r/history.csv"), text(&dir, "whole/history.csv"));
    let before = written(&dir, &["r"]);
    let done = call(&dir, &[&args[..], &["--json"]].concat(), 0);
    assert!(String::from_utf8_lossy(&done.stdout).contains("\"crush_events\""));
    assert_eq!(written(&dir, &["r"]), before);
    // killed before its first checkpoint: begins again
    fs::remove_file(dir.path().join("r/summary.json")).expect("removed");
    fs::write(dir.path().join("r/history.csv"), "cut").expect("written");
    call(&dir, &args, 0);
    assert_eq!(text(&dir, "r/history.csv"), text(&dir, "whole/history.csv"));
    let other = call(&dir, &[&args[..], &["--seed", "2"]].concat(), 2);
    assert!(said(&other).contains("a run of another scene ([seed] packing = 1 there, packing = 2 here)"), "{}", said(&other));
    call(&dir, &[&args[..], &["--seed", "2", "--force"]].concat(), 0);
    assert_ne!(text(&dir, "r/history.csv"), text(&dir, "whole/history.csv"));
    // another specimen is another run, though the scene's text is the same
    fs::copy(dir.path().join("whole/specimen.csv"), dir.path().join("given.csv")).expect("copied");
    let given = ["run", "scene.toml", "--specimen", "given.csv", "--out", "g", "--continue", "--quiet"];
    call(&dir, &given, 0);
    call(&dir, &given, 0);
    fs::copy(dir.path().join("r/specimen.csv"), dir.path().join("given.csv")).expect("copied");
    assert!(said(&call(&dir, &given, 2)).contains("another specimen"));
}

/// An ensemble under way, once some run has a checkpoint.
#[cfg(unix)]
fn under_way(dir: &TempDir, args: &[&str]) -> Child {
    let mut child = command(dir, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("started");
    let begun = |k: u32| dir.path().join(format!("e/seed-{k}/checkpoint.bin")).exists();
    while !(1..=4).any(begun) {
        assert!(child.try_wait().expect("child").is_none(), "ended before it could be stopped");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

#[cfg(unix)]
fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status().expect("kill");
    assert!(status.success());
}

#[cfg(unix)]
fn same_histories(dir: &TempDir, a: &str, b: &str, seeds: std::ops::RangeInclusive<u32>) {
    for k in seeds {
        let of = |e: &str| text(dir, &format!("{e}/seed-{k}/history.csv"));
        assert!(of(a) == of(b), "seed {k} differs");
    }
}

/// Stopped or killed at any moment, the same command goes on, and nothing shows that it was.
#[cfg(unix)]
#[test]
fn a_campaign_that_was_stopped_or_killed_goes_on() {
    let dir = folder();
    let args = ["ensemble", "scene.toml", "--seeds", "1..4", "--jobs", "2", "--out", "e"];
    let with = |out: &'static str| args.map(|a| if a == "e" { out } else { a });
    call(&dir, &with("whole"), 0);
    let mut child = under_way(&dir, &args);
    signal(&child, "TERM");
    assert_eq!(child.wait().expect("child").code(), Some(130));
    let left: Vec<PathBuf> = (1..=4).map(|k| dir.path().join(format!("e/seed-{k}"))).collect();
    let stopped = |d: &PathBuf| d.join("checkpoint.bin").exists() || !d.join("history.csv").exists();
    assert!(left.iter().filter(|d| !d.join("summary.json").exists()).all(stopped), "every run that had begun has a checkpoint");
    call(&dir, &args, 0);
    same_histories(&dir, "whole", "e", 1..=4);
    // killed: its runs outlive it, and the second call waits for them
    fs::remove_dir_all(dir.path().join("e")).expect("removed");
    let mut child = under_way(&dir, &args);
    signal(&child, "KILL");
    child.wait().expect("child");
    // the file's birth: a run that is just beginning may still be writing it
    let born = |k: u32| dir.path().join(format!("e/seed-{k}/scene.resolved.toml")).metadata().ok()?.created().ok();
    let begun = || (1..=4).map(born).collect::<Vec<_>>();
    let before = begun();
    call(&dir, &args, 0);
    let again = begun().into_iter().zip(&before).filter(|(now, then)| then.is_some() && now != *then).count();
    assert_eq!(again, 0, "no run that had begun is begun again: {before:?}");
    assert!(before.iter().any(Option::is_some), "births of files are told here");
    same_histories(&dir, "whole", "e", 1..=4);
    assert!(Path::new(&dir.path().join("e/mean.csv")).exists());
}

/// One run is killed as a system does that has no memory left: the others are made, and called again it alone goes on, from its checkpoint.
#[cfg(target_os = "linux")]
#[test]
fn a_killed_run_is_told_by_its_signal_and_goes_on() {
    let dir = folder();
    let args = ["ensemble", "scene.toml", "--seeds", "1..3", "--jobs", "2", "--out", "e"];
    let mut child = command(&dir, &args).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("started");
    processes::kill_run(&mut child, dir.path(), "e/seed-2", || dir.path().join("e/seed-2/checkpoint.bin").exists());
    let output = child.wait_with_output().expect("ended");
    assert_eq!(output.status.code(), Some(1), "{}", said(&output));
    assert!(said(&output).contains("error: e/seed-2: was killed by SIGKILL (from outside"), "{}", said(&output));
    assert!(said(&output).contains("error: 1 of 3 runs failed"), "{}", said(&output));
    let others = written(&dir, &["e/seed-1", "e/seed-3"]);
    let begun = changed(&dir, "e/seed-2/scene.resolved.toml");
    let again = call(&dir, &args, 0);
    assert!(said(&again).contains("3 of 3 runs done, 2 of them before"), "{}", said(&again));
    assert_eq!(written(&dir, &["e/seed-1", "e/seed-3"]), others);
    assert_eq!(changed(&dir, "e/seed-2/scene.resolved.toml"), begun, "it went on from its checkpoint");
    call(&dir, &["run", "scene.toml", "--seed", "2", "--out", "whole/seed-2", "--quiet"], 0);
    same_histories(&dir, "whole", "e", 2..=2);
}

/// A command of the user's makes the same runs: it is told what each needs, its exit code is the run's, and it is stopped with all that it
/// has started.
#[cfg(unix)]
#[test]
fn a_command_of_the_users_makes_the_runs() {
    let dir = folder();
    let by = |out: &'static str, template: &'static str| {
        [
            "ensemble",
            "scene.toml",
            "--seeds",
            "1..4",
            "--jobs",
            "2",
            "--out",
            out,
            "--executor",
            "command",
            "--executor-command",
            template,
        ]
    };
    call(&dir, &["ensemble", "scene.toml", "--seeds", "1..4", "--out", "local", "--quiet"], 0);
    // a connection that is lost before the run begins is not the scene's fault, and nothing of it stays
    let lost = call(&dir, &by("e", "echo lost connection >&2; exit 255; {command}"), 1);
    assert!(said(&lost).contains("error: e/seed-3: exit status: 255: lost connection (e/seed-3.log)"), "{}", said(&lost));
    assert!(said(&lost).contains("4 of 4 runs failed") && !dir.path().join("e/seed-1").exists(), "{}", said(&lost));
    // a shell in a shell that waits for another one
    let shells = by("e", "echo {threads} {memory_MB} {minutes} >> asked; sh -c {word} & wait $!");
    let mut child = under_way(&dir, &shells);
    signal(&child, "TERM");
    assert_eq!(child.wait().expect("child").code(), Some(130));
    let runs: Vec<PathBuf> = (1..=4).map(|k| dir.path().join(format!("e/seed-{k}"))).collect();
    let kept = |d: &PathBuf| d.join("checkpoint.bin").exists() || d.join("summary.json").exists();
    // a run writes its history from the end of the preparation
    assert!(runs.iter().any(kept) && runs.iter().filter(|d| d.join("history.csv").exists()).all(kept));
    call(&dir, &shells, 0);
    assert!(
        text(&dir, "asked").lines().count() >= 4 && text(&dir, "asked").lines().all(|line| line == "1 256 16"),
        "{}",
        text(&dir, "asked")
    );
    left::assert_same(&left::files(&dir.path().join("local")), &left::files(&dir.path().join("e")), "by a command");
    let failed = call(&dir, &[&by("f", "{command}")[..], &["--set", "specimen.porosity=0.2"]].concat(), 1);
    assert!(said(&failed).contains("f/seed-1: step 30001: preparation"), "{}", said(&failed));
}

/// Three sweeps that are started at the same moment into one folder share its runs, and leave what a single one does. (Whether figures do is
/// asked with a plan, in tests/campaigns/reproduce.rs.)
#[cfg(unix)]
#[test]
fn campaigns_in_one_folder_share_its_runs() {
    let dir = folder();
    // too many points for common figures, which take longer than the runs
    let grid = "material.strength.fixed_angle.m=2,2.5,3,3.5,4,4.5,5,6";
    let args = ["sweep", "scene.toml", "--grid", grid, "--set", "loading.max_stress_kPa=8", "--jobs", "2", "--out", "s"];
    call(&dir, &args, 0);
    let single = left::files(&dir.path().join("s"));
    for round in 0..2 {
        fs::remove_dir_all(dir.path().join("s")).expect("removed");
        let start = |_| command(&dir, &args).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("started");
        let children: Vec<Child> = (0..3).map(start).collect();
        let mut runs = 0;
        for child in children {
            let output = child.wait_with_output().expect("ended");
            assert_eq!(output.status.code(), Some(0), "round {round}: {}", said(&output));
            runs += made(&said(&output));
        }
        assert_eq!(runs, 8, "round {round}: every run is made once");
        left::assert_same(&single, &left::files(&dir.path().join("s")), "shared");
        let log = |entry: &fs::DirEntry| entry.path().extension() == Some("log".as_ref());
        assert!(!fs::read_dir(dir.path().join("s")).expect("folder").flatten().any(|entry| log(&entry)), "nothing was wrong");
    }
}

/// Runs that fit into memory one by one, but not together, are made one after the other.
#[cfg(unix)]
#[test]
fn no_more_runs_at_a_time_than_memory_has_room_for() {
    use comminute::campaign::{Job, Options, Program, run};
    use std::os::unix::fs::PermissionsExt;
    let dir = folder();
    let Some(free) = comminute::machine::free_memory() else { return };
    // writes down when it begins and ends
    let program = dir.path().join("program");
    fs::write(&program, "#!/bin/sh\ncd \"${0%/*}\"; echo begins >> times; sleep 0.1; echo ends >> times\n").expect("program");
    fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("executable");
    let times = |share: f64| {
        let grains = (share * free as f64 / 2800.0) as u64;
        let job = |k: u32| {
            let sets = [format!("specimen.grains={grains}"), "crushing.enabled=false".into(), "records.figures=false".into()];
            Job::new(dir.path().join("scene.toml"), dir.path().join(format!("{k}"))).with(&sets)
        };
        let jobs: Vec<Job> = (0..4).map(job).collect();
        let _ = fs::remove_file(dir.path().join("times"));
        let options = Options {
            parallel: 4,
            quiet: true,
            program: Some(Program { file: program.clone(), first: Vec::new() }),
            ..Options::default()
        };
        run(&jobs, &options).map(|_| text(&dir, "times"))
    };
    assert_eq!(times(0.6).expect("made"), "begins\nends\n".repeat(4));
    // what does not fit at all is refused before anything is started
    let refused = times(1.5).expect_err("too large").to_string();
    assert!(refused.contains("of memory;") && !dir.path().join("times").exists(), "{refused}");
}

#[test]
fn only_the_figures_asked_for_are_drawn() {
    let dir = folder();
    call(&dir, &["run", "scene.toml", "--quiet", "--out", "a"], 0);
    call(&dir, &["plot", "a", "--show", "k0,compression", "--quiet", "--out", "few"], 0);
    let mut files: Vec<String> = fs::read_dir(dir.path().join("few"))
        .expect("folder")
        .map(|f| f.expect("file").file_name().to_string_lossy().into_owned())
        .collect();
    files.sort();
    assert_eq!(files, ["compression.csv", "compression.png", "compression.svg", "k0.csv", "k0.png", "k0.svg", "runs.csv"]);
    let output = call(&dir, &["plot", "a", "--show", "k1", "--out", "none"], 2);
    assert!(said(&output).contains("have no k1"), "{}", said(&output));
}
