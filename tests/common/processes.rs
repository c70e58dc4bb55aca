//! Processes of the program found by where they work: those that campaigns have started.
#![allow(dead_code)] // each test binary uses its part

use std::fs;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

/// The process of a run that was started in the folder `dir` with an output folder whose name begins with `out`.
fn of_run(dir: &Path, out: &str) -> Option<u32> {
    fs::read_dir("/proc").expect("processes").flatten().find_map(|entry| {
        let pid = entry.file_name().to_str()?.parse().ok()?;
        let line = fs::read(entry.path().join("cmdline")).ok()?;
        let words: Vec<String> = line.split(|b| *b == 0).map(|word| String::from_utf8_lossy(word).into_owned()).collect();
        let run = words.get(1)? == "run" && words.windows(2).any(|w| w[0] == "--out" && w[1].starts_with(out));
        let here = fs::read_link(entry.path().join("cwd")).ok()? == dir.canonicalize().ok()?;
        (run && here).then_some(pid)
    })
}

/// Sends a signal to a process.
pub fn signal(pid: u32, name: &str) -> bool {
    Command::new("kill").args([format!("-{name}"), pid.to_string()]).status().expect("kill").success()
}

/// Waits until `ready`, while the campaign `child` goes on.
pub fn wait_until(child: &mut Child, ready: impl Fn() -> bool) {
    while !ready() {
        assert!(child.try_wait().expect("child").is_none(), "ended too early");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Kills (SIGKILL) the process of a run of the campaign `child`, once there is one and `ready`.
pub fn kill_run(child: &mut Child, dir: &Path, out: &str, ready: impl Fn() -> bool) {
    wait_until(child, || ready() && of_run(dir, out).is_some_and(|pid| signal(pid, "KILL")));
}
