//! The command of HyperQueue, `hq`: what it is asked, and what it answers in its JSON (documentation of HyperQueue, *Output mode*).

use super::super::executor::Needs;
use super::array::Array;
use super::queue::{Entries, Entry, absent, words};
use laboratory::error::{Error, Result};
use serde_json::Value;
use std::process::{Command, Output, Stdio};

/// Most elements of an array: as many as it is said to take without effort.
pub const MOST: usize = 100_000;

/// Says that there is no HyperQueue here, if there is none.
///
/// # Errors
/// A machine without `hq`.
pub fn here() -> Result<()> {
    call(&["--version".into()]).map(drop)
}

/// Asks for all elements of the arrays of these names that the server knows; it forgets them when it ends without a journal.
///
/// # Errors
/// What `hq` says where it does not answer.
pub fn entries(names: &[&str]) -> std::result::Result<Entries, String> {
    let ask = |arguments: &[&str]| {
        let arguments: Vec<String> = ["--output-mode=json"].iter().chain(arguments).map(|word| (*word).into()).collect();
        read(&call(&arguments).map_err(|e| e.to_string())?)
    };
    let mut entries = Entries::new();
    for (id, name) in jobs(&ask(&["job", "list", "--all"])?, names) {
        entries.extend(tasks(&ask(&["task", "list", &id.to_string()])?, &name));
    }
    Ok(entries)
}

/// Numbers and names of the jobs of these names in what `hq job list` prints.
fn jobs(list: &Value, names: &[&str]) -> Vec<(u64, String)> {
    let job = |job: &Value| Some((job["id"].as_u64()?, job["name"].as_str()?.to_string()));
    let all = list.as_array().into_iter().flatten().filter_map(job);
    all.filter(|(_, name)| names.contains(&name.as_str())).collect()
}

/// The elements of the array `name` in what `hq task list` prints for its job.
fn tasks(list: &Value, name: &str) -> Vec<((String, usize), Entry)> {
    let entry = |task: &Value| {
        let reason = task["error"].as_str().unwrap_or("None").to_string();
        let state = match task["state"].as_str()? {
            "waiting" => "PENDING",
            "running" => "RUNNING",
            "finished" => "COMPLETED",
            "failed" if reason.to_lowercase().contains("time limit") => "TIMEOUT",
            "failed" => "FAILED",
            _ => "CANCELLED",
        };
        Some(((name.to_string(), task["id"].as_u64()? as usize), Entry { state: state.into(), reason }))
    };
    let of_job = list.as_object().into_iter().flat_map(|jobs| jobs.values());
    of_job.filter_map(Value::as_array).flatten().filter_map(entry).collect()
}

/// Submits with these arguments, and gives the number of the job.
///
/// # Errors
/// That there is no `hq`, or what it says where it refuses.
pub fn submit(arguments: &[String]) -> Result<String> {
    let refuses = |why: String| Error::input("hq submit", "", None, format!("refuses the runs: {why}"));
    let said = read(&call(arguments)?).map_err(refuses)?;
    said["id"].as_u64().map(|id| id.to_string()).ok_or_else(|| refuses(format!("it says {said}")))
}

/// Arguments of `hq` that submit an array: what runs ask for, unless an option of the user says otherwise, options of the user, and what finds the array again.
pub fn arguments(array: &Array, elements: usize, needs: Needs, options: &[String]) -> Vec<String> {
    let Needs { minutes, memory_mb, threads } = needs;
    let folder = array.folder.display();
    let of_the_runs = [format!("--time-limit={minutes}min"), format!("--resource=mem={memory_mb}"), format!("--cpus={threads}")];
    // an option may stand only once
    let key = |option: &str| option.rsplit_once('=').map_or(option, |(key, _)| key).to_string();
    let asked = of_the_runs.into_iter().filter(|ours| options.iter().all(|theirs| key(theirs) != key(ours)));
    let fixed = [
        format!("--name={}", array.told.name),
        format!("--array=1-{elements}"),
        "--stdout=none".into(),
        format!("--stderr={folder}/%{{TASK_ID}}.out"),
        "--".into(),
        "/bin/sh".into(),
        array.script().display().to_string(),
        folder.to_string(),
    ];
    let first = ["--output-mode=json", "submit"].map(String::from).into_iter();
    first.chain(asked).chain(options.iter().cloned()).chain(fixed).collect()
}

/// What `hq` prints with these arguments.
fn call(arguments: &[String]) -> Result<Output> {
    let output = Command::new("hq").args(arguments).stdin(Stdio::null()).output();
    output.map_err(|e| absent("hq", &e, "runs are submitted where HyperQueue's command is, and its server can be reached"))
}

/// The JSON that `hq` has printed; else the words of its error.
fn read(output: &Output) -> std::result::Result<Value, String> {
    let value: Option<Value> = serde_json::from_slice(&output.stdout).ok();
    let error = value.as_ref().and_then(|value| value["error"].as_str());
    match (output.status.success(), error) {
        (true, None) => value.ok_or_else(|| "it does not answer in JSON".into()),
        (_, Some(error)) => Err(words(error, "hq")),
        (false, None) => Err(words(&String::from_utf8_lossy(&output.stderr), "hq")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_hq_prints_is_read() {
        let list = serde_json::json!([
            {"id": 4, "name": "a-1", "task_count": 3, "task_stats": {"running": 1}},
            {"id": 5, "name": "another", "task_count": 1},
        ]);
        assert_eq!(jobs(&list, &["a-1", "a-2"]), [(4, "a-1".into())]);
        let list = serde_json::json!({"4": [
            {"id": 1, "state": "running", "worker": 2, "started_at": "2021-12-20T08:56:16Z"},
            {"id": 2, "state": "waiting"},
            {"id": 3, "state": "finished"},
            {"id": 4, "state": "failed", "error": "Error: Program terminated with exit code 3"},
            {"id": 5, "state": "failed", "error": "Time limit reached"},
            {"id": 6, "state": "canceled"},
        ]});
        let entries: Entries = tasks(&list, "a-1").into_iter().collect();
        let state = |n| entries[&("a-1".to_string(), n)].state.as_str();
        assert_eq!([1, 2, 3, 4, 5, 6].map(state), ["RUNNING", "PENDING", "COMPLETED", "FAILED", "TIMEOUT", "CANCELLED"]);
        assert!(entries[&("a-1".to_string(), 2)].held().is_none(), "it waits for a worker");
    }

    #[test]
    fn no_option_stands_twice() {
        let needs = Needs { minutes: 32, memory_mb: 512, threads: 2 };
        let all = arguments(&Array::example("comminute-7"), 3, needs, &["--cpus=4".into(), "--resource=mem=2000".into()]);
        assert_eq!(all[..5], ["--output-mode=json", "submit", "--time-limit=32min", "--cpus=4", "--resource=mem=2000"]);
        assert!(all.contains(&"--array=1-3".into()) && all.contains(&"--name=comminute-7".into()), "{all:?}");
    }
}
