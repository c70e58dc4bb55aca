//! A run can be stopped at any moment and goes on with the same bytes; a run repeats itself from what it leaves.

#[path = "common/left.rs"]
mod left;

use assert_cmd::cargo::cargo_bin;
use left::files;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

struct Finished {
    dir: PathBuf,
    files: BTreeMap<String, Vec<u8>>,
    preparation: u64,
    steps: u64,
}

fn comminute() -> Command {
    let mut command = Command::new(cargo_bin("comminute"));
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn folder() -> PathBuf {
    static DIR: OnceLock<tempfile::TempDir> = OnceLock::new();
    DIR.get_or_init(|| tempfile::tempdir().expect("folder")).path().to_path_buf()
}

/// A small crushable specimen: breakages from the start of loading.
fn scene() -> PathBuf {
    let path = folder().join("small.toml");
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/petroleum_coke/h-c-2.toml");
    let text = format!(
        "base = {:?}\n[specimen]\nscale = 4.0\ngrains = 120\nporosity = 0.48\n[preparation]\ngrowth_friction = 0.4\n\
         [loading]\nmax_stress_kPa = 150.0\n[records]\nat_kPa = [50.0]\nfigures = false\ncontacts = true\ncheckpoint_seconds = 0.05\n\
         [material]\nbase = {:?}\n[material.strength.fixed_angle]\nsigma_lim0_MPa = 100.0\n\
         [crushing]\nbirth = \"gradual\"\nlost_mass = \"grow\"\n",
        base.display().to_string(),
        base.with_file_name("../../materials/petroleum_coke.toml").display().to_string()
    );
    // several tests write the same bytes: whole or not at all
    let own = folder().join(format!("small.{:?}.tmp", std::thread::current().id()));
    std::fs::write(&own, text).expect("scene");
    std::fs::rename(&own, &path).expect("scene");
    path
}

/// The run without any interruption, on one thread.
fn whole() -> &'static Finished {
    static RUN: OnceLock<Finished> = OnceLock::new();
    RUN.get_or_init(|| {
        let dir = folder().join("whole");
        let status = comminute().arg("run").arg(scene()).arg("--out").arg(&dir).args(["--threads", "1"]).status().expect("start");
        assert!(status.success());
        let files = files(&dir);
        let summary: serde_json::Value = serde_json::from_slice(&files["summary.json"]).expect("summary");
        let count = |key: &str| summary[key].as_u64().expect("count");
        assert!(count("crush_events") >= 5, "the scene breaks grains");
        assert!(files.keys().any(|k| k.ends_with(".vtp")), "the scene leaves snapshots");
        assert!(files.keys().any(|k| k.contains("contacts_")), "the scene leaves contacts");
        let (preparation, steps) = (count("preparation_steps"), count("steps"));
        Finished { dir, files, preparation, steps }
    })
}

fn breakage_step(k: usize) -> u64 {
    let text = String::from_utf8(whole().files["breakage.csv"].clone()).expect("text");
    text.lines().nth(k + 1).expect("row").split(',').nth(1).expect("step").parse().expect("number")
}

#[track_caller]
fn same_as_whole(dir: &Path) {
    let now = files(dir);
    let names: Vec<&String> = now.keys().collect();
    assert_eq!(names, whole().files.keys().collect::<Vec<_>>());
    for (name, bytes) in &now {
        assert!(*bytes == whole().files[name], "{name} differs");
    }
}

/// Stops after the steps given, one after the other, each time on another number of threads, then runs to the end.
fn cut(name: &str, after: &[u64]) {
    let dir = folder().join(name);
    for (k, steps) in after.iter().enumerate() {
        let mut command = comminute();
        if k == 0 {
            command.arg("run").arg(scene()).arg("--out").arg(&dir);
        } else {
            command.arg("resume").arg(&dir);
        }
        let threads = (1 + (k + 1) % 2).to_string();
        let status = command.args(["--threads", &threads, "--stop-after", &steps.to_string()]).status().expect("start");
        assert_eq!(status.code(), Some(130), "a stopped run can be resumed");
        assert!(!dir.join("summary.json").exists());
    }
    assert!(comminute().arg("resume").arg(&dir).status().expect("start").success());
    same_as_whole(&dir);
}

#[test]
fn cut_in_sample_generation() {
    let p = whole().preparation;
    cut("generation", &[1, p / 2, p - 1]);
}

#[test]
fn cut_before_in_and_after_a_breakage() {
    let (p, first) = (whole().preparation, breakage_step(0));
    // step numbers count from 0: after `first + 1` steps the breakage has just been made
    cut("breakage", &[p + first, p + first + 1, p + first + 2, p + breakage_step(3) + 1]);
}

#[test]
fn cut_at_the_seams() {
    let p = whole().preparation;
    cut("seams", &[p, p + 1, p + 1000, p + whole().steps - 1]);
}

#[test]
fn killed_and_interrupted_runs_go_on() {
    for (name, signal) in [("killed", "KILL"), ("interrupted", "INT")] {
        let dir = folder().join(name);
        let mut child = comminute().arg("run").arg(scene()).arg("--out").arg(&dir).spawn().expect("start");
        // some way into the run: a checkpoint is there and has been replaced
        let mut seen = 0;
        while seen < 4 {
            std::thread::sleep(Duration::from_millis(20));
            seen += usize::from(dir.join("checkpoint.bin").exists());
            assert!(child.try_wait().expect("child").is_none() || dir.join("summary.json").exists());
            if dir.join("summary.json").exists() {
                break;
            }
        }
        let kill = Command::new("kill").args([format!("-{signal}"), child.id().to_string()]).status().expect("kill");
        let status = child.wait().expect("child");
        if kill.success() && signal == "INT" && !dir.join("summary.json").exists() {
            assert_eq!(status.code(), Some(130));
        }
        if !dir.join("summary.json").exists() {
            assert!(comminute().arg("resume").arg(&dir).status().expect("start").success());
        }
        same_as_whole(&dir);
    }
}

#[test]
fn the_resolved_scene_repeats_the_run() {
    let dir = folder().join("repeated");
    let scene = whole().dir.join("scene.resolved.toml");
    assert!(comminute().arg("run").arg(scene).arg("--out").arg(&dir).status().expect("start").success());
    same_as_whole(&dir);
}

#[test]
fn a_specimen_used_again_gives_the_same_loading() {
    let dir = folder().join("specimen");
    let specimen = whole().dir.join("specimen.csv");
    let mut command = comminute();
    command.arg("run").arg(scene()).arg("--out").arg(&dir).arg("--specimen").arg(specimen);
    assert!(command.status().expect("start").success());
    let now = files(&dir);
    for name in ["specimen.csv", "history.csv", "gsd.csv", "breakage.csv", "grains_final.csv"] {
        assert!(now[name] == whole().files[name], "{name} differs");
    }
    // and the scene it leaves names its specimen
    let again = folder().join("specimen_again");
    let resolved = dir.join("scene.resolved.toml");
    assert!(comminute().arg("run").arg(resolved).arg("--out").arg(&again).status().expect("start").success());
    assert!(files(&again) == now);
}

/// A free scene takes up the last grains of a run as they are.
#[test]
fn final_grains_begin_a_free_scene() {
    let (path, dir) = (folder().join("imported.toml"), folder().join("imported"));
    let text = format!(
        "kind = \"assembly\"\nsteps = 20\ngrains_csv = {:?}\nmaterial = {:?}\nrecords.figures = false\n",
        whole().dir.join("grains_final.csv"),
        Path::new(env!("CARGO_MANIFEST_DIR")).join("materials/petroleum_coke.toml"),
    );
    std::fs::write(&path, text).expect("scene");
    assert!(comminute().arg("run").arg(&path).arg("--out").arg(&dir).status().expect("start").success());
    let places = |dir: &Path, name: &str| -> Vec<String> {
        let text = std::fs::read_to_string(dir.join(name)).expect("grains");
        let rows = text.lines().filter(|l| !l.starts_with('#')).skip(1);
        rows.map(|l| l.split(',').take(4).collect::<Vec<_>>().join(",")).collect()
    };
    let (last, first) = (places(&whole().dir, "grains_final.csv"), places(&dir, "specimen.csv"));
    assert!(last.len() > 150 && last == first);
}

#[test]
fn a_finished_run_is_not_resumed_and_a_folder_without_checkpoint_neither() {
    for dir in [whole().dir.clone(), folder()] {
        assert_eq!(comminute().arg("resume").arg(dir).status().expect("start").code(), Some(2));
    }
}

/// A run stopped in the middle of its loading, in a folder of this name.
fn stopped(name: &str) -> PathBuf {
    let dir = folder().join(name);
    let half = (whole().preparation + whole().steps / 2).to_string();
    let mut command = comminute();
    command.arg("run").arg(scene()).arg("--out").arg(&dir).args(["--threads", "1", "--stop-after", &half]);
    assert_eq!(command.status().expect("start").code(), Some(130));
    dir
}

/// Exit code of `comminute resume`, and what it says.
fn resumed(dir: &Path) -> (Option<i32>, String) {
    let out = comminute().stderr(Stdio::piped()).arg("resume").arg(dir).arg("--quiet").output().expect("start");
    (out.status.code(), String::from_utf8_lossy(&out.stderr).into_owned())
}

/// A damaged checkpoint is not taken: the run goes on from the one before it, says so, and ends with the same bytes.
#[test]
fn a_damaged_checkpoint_costs_only_the_steps_since_the_one_before() {
    let dir = stopped("damaged");
    let path = dir.join("checkpoint.bin");
    let mut bytes = std::fs::read(&path).expect("checkpoint");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    std::fs::write(&path, bytes).expect("damaged");
    let (code, said) = resumed(&dir);
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("damaged") && said.contains("goes on from the checkpoint before it"), "{said}");
    same_as_whole(&dir);
}

/// A scene or a table that was changed since the checkpoint was written is refused, and nothing is written.
#[test]
fn changed_scenes_and_tables_that_lost_rows_are_refused() {
    let dir = stopped("changed");
    let before = files(&dir);
    let scene = dir.join("scene.resolved.toml");
    let text = std::fs::read_to_string(&scene).expect("scene");
    std::fs::write(&scene, text.replace("max_stress_kPa = 150", "max_stress_kPa = 160")).expect("changed");
    let (code, said) = resumed(&dir);
    assert!(code == Some(2) && said.contains("is not the scene that it was written for"), "{code:?} {said}");
    std::fs::write(&scene, text).expect("as it was");
    let history = dir.join("history.csv");
    std::fs::write(&history, &before["history.csv"][..100]).expect("cut");
    let (code, said) = resumed(&dir);
    assert!(code == Some(1) && said.contains("history.csv") && said.contains("rows were lost"), "{code:?} {said}");
    assert_eq!(std::fs::read(&history).expect("rows").len(), 100);
    std::fs::write(&history, &before["history.csv"]).expect("as it was");
    assert!(files(&dir) == before, "a refused run has changed nothing");
    assert_eq!(resumed(&dir).0, Some(0));
    same_as_whole(&dir);
}

/// A run killed while its figures are drawn is not finished: `resume` and `--continue` draw what is missing.
#[test]
fn figures_are_drawn_by_the_next_call_when_a_run_was_killed_while_it_drew_them() {
    let names = |dir: &Path| -> Vec<String> { files(dir).into_keys().collect() };
    let run = |dir: &Path| {
        let mut command = comminute();
        command.arg("run").arg(scene()).arg("--out").arg(dir).args(["--quiet", "--set", "records.figures=true"]);
        command
    };
    let complete = folder().join("drawn");
    assert!(run(&complete).status().expect("start").success());
    assert!(names(&complete).iter().filter(|name| name.starts_with("figures/")).count() > 10);
    let killed_and_called_again = |name: &str, resume: bool| {
        let dir = folder().join(name);
        // the signal may come when the run has just been finished: then once more
        let killed = (0..20).any(|_| {
            let _ = std::fs::remove_dir_all(&dir);
            let mut child = run(&dir).spawn().expect("start");
            while !dir.join("figures").exists() && child.try_wait().expect("child").is_none() {
                std::thread::sleep(Duration::from_millis(1));
            }
            child.kill().expect("killed");
            child.wait().expect("child");
            let summary = std::fs::read_to_string(dir.join("summary.json")).expect("summary");
            serde_json::from_str::<serde_json::Value>(&summary).expect("JSON")["figure_seconds"].is_null()
        });
        assert!(killed, "{name}: the run was always finished before it was killed");
        let mut next = if resume { comminute() } else { run(&dir) };
        if resume {
            next.arg("resume").arg(&dir)
        } else {
            next.arg("--continue")
        };
        let done = next.stderr(Stdio::piped()).output().expect("start");
        assert!(done.status.success(), "{name}: {}", String::from_utf8_lossy(&done.stderr));
        assert_eq!(names(&dir), names(&complete), "{name}");
        assert_eq!(resumed(&dir).0, Some(2), "now the run is finished");
    };
    rayon::join(|| killed_and_called_again("killed_drawing", true), || killed_and_called_again("killed_drawing_continued", false));
}

/// `--force` overwrites runs and nothing else: a folder of somebody else is left as it is.
#[test]
fn a_folder_that_never_held_a_run_is_not_overwritten() {
    let dir = folder().join("somebody");
    std::fs::create_dir_all(dir.join("figures")).expect("folder");
    for name in ["README.txt", "figures/own.png"] {
        std::fs::write(dir.join(name), "of somebody").expect("written");
    }
    let before = files(&dir);
    let mut command = comminute();
    let out = command.stderr(Stdio::piped()).arg("run").arg(scene()).arg("--out").arg(&dir).arg("--force").output().expect("start");
    let said = String::from_utf8_lossy(&out.stderr).into_owned();
    assert!(out.status.code() == Some(2) && said.contains("holds files but no run"), "{said}");
    assert!(files(&dir) == before);
}

/// In the folder of a run `--force` removes what the run wrote and nothing else: it refuses, by name, where snapshots or figures hold a file of somebody.
#[test]
fn a_file_of_somebody_in_a_run_is_not_overwritten() {
    let dir = folder().join("shared");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/free/sliding_to_rolling.toml");
    let run = |more: &[&str]| {
        let mut command = comminute();
        let out = command.stderr(Stdio::piped()).arg("run").arg(&scene).arg("--out").arg(&dir).args(more).output().expect("start");
        (out.status.code(), String::from_utf8_lossy(&out.stderr).into_owned())
    };
    assert_eq!(run(&[]).0, Some(0));
    assert!(dir.join("figures/tracks.png").exists() || dir.join("figures").read_dir().expect("figures").count() > 2);
    std::fs::write(dir.join("notes.txt"), "of somebody").expect("written");
    for name in ["figures/own.png", "snapshots/own.vtp"] {
        std::fs::write(dir.join(name), "of somebody").expect("written");
        let before = files(&dir);
        let (code, said) = run(&["--force"]);
        assert!(code == Some(2) && said.contains(name) && said.contains("was not written by a run"), "{said}");
        assert!(files(&dir) == before, "nothing was removed");
        std::fs::remove_file(dir.join(name)).expect("removed");
    }
    let (code, said) = run(&["--force", "--set", "records.figures=false"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(!dir.join("figures").exists() && dir.join("notes.txt").exists());
}

/// Of processes that begin a run in one folder at the same moment one makes it and the others are refused.
#[test]
fn a_folder_is_taken_by_one_of_several_runs() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("experiments/free/sliding_to_rolling.toml");
    for round in 0..5 {
        let dir = folder().join(format!("race {round}"));
        let start = || {
            let mut command = comminute();
            command.arg("run").arg(&scene).arg("--out").arg(&dir).args([
                "--set",
                "duration_s=100.0",
                "--set",
                "records.figures=false",
            ]);
            command.args(["--set", "records.every=100000"]).spawn().expect("start")
        };
        let codes: Vec<_> = [start(), start(), start()].map(|mut child| child.wait().expect("ended").code()).into();
        let of = |code: i32| codes.iter().filter(|c| **c == Some(code)).count();
        assert!(of(0) == 1 && of(2) == 2, "{codes:?}");
    }
}
