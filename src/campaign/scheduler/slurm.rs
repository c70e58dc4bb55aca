//! The commands of Slurm: what it is asked, and what it answers.

use super::super::executor::Needs;
use super::array::Array;
use super::queue::{Entries, Entry, absent, words};
use laboratory::error::{Error, Result};
use laboratory::host;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

/// Asks for all elements of the arrays of these names that Slurm still knows; it forgets them some minutes after their ends.
///
/// # Errors
/// What `squeue` says where it does not answer.
pub fn entries(names: &[&str]) -> std::result::Result<Entries, String> {
    let mut command = Command::new("squeue");
    command.args(["--noheader", "--array", "--states=all", "--format=%j|%K|%T|%r"]).arg(format!("--name={}", names.join(",")));
    let output = command.stdin(Stdio::null()).output().map_err(|e| format!("squeue: {e}"))?;
    if !output.status.success() {
        return Err(words(&String::from_utf8_lossy(&output.stderr), "squeue"));
    }
    Ok(read(&String::from_utf8_lossy(&output.stdout)))
}

/// Elements in what `squeue` prints.
fn read(text: &str) -> Entries {
    let entry = |line: &str| {
        let mut words = line.split('|');
        let key = (words.next()?.into(), words.next()?.trim().parse().ok()?);
        Some((key, Entry { state: words.next()?.trim().into(), reason: words.next()?.trim().into() }))
    };
    text.lines().filter_map(entry).collect()
}

/// Submits with these arguments, and gives the number of the job.
///
/// # Errors
/// That there is no `sbatch`, or what it says where it refuses.
pub fn submit(arguments: &[String]) -> Result<String> {
    let mut command = Command::new("sbatch");
    command.arg("--parsable").args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(missing)?;
    let mut said = String::new();
    // where the queue is full sbatch says so, and tries again for some minutes
    for line in child.stderr.take().into_iter().flat_map(|pipe| BufReader::new(pipe).lines()).map_while(std::io::Result::ok) {
        if line.contains("sleeping and retrying") && !said.contains(&line) {
            host::warn(&line);
        }
        said = said + &line + "\n";
    }
    let mut number = String::new();
    if let Some(mut pipe) = child.stdout.take() {
        pipe.read_to_string(&mut number).map_err(Error::read("sbatch"))?;
    }
    let status = child.wait().map_err(Error::read("sbatch"))?;
    // of several clusters the name follows
    match number.trim().split(';').next() {
        Some(number) if status.success() && !number.is_empty() => Ok(number.into()),
        _ => Err(Error::input("sbatch", "", None, format!("refuses the runs: {}", words(&said, "sbatch")))),
    }
}

/// Says that there is no Slurm here, if there is none.
///
/// # Errors
/// A machine without `sbatch` and `squeue`.
pub fn here() -> Result<()> {
    for name in ["sbatch", "squeue"] {
        let output = Command::new(name).arg("--version").stdin(Stdio::null()).output();
        output.map_err(|e| if name == "sbatch" { missing(e) } else { Error::Read { path: name.into(), source: e } })?;
    }
    Ok(())
}

/// Most elements of an array: what the cluster allows, or what Slurm does where nothing is said.
pub fn most() -> usize {
    let output = Command::new("scontrol").args(["show", "config"]).stdin(Stdio::null()).output();
    let text = output.map_or(String::new(), |o| String::from_utf8_lossy(&o.stdout).into_owned());
    let size = text.lines().find_map(|line| line.strip_prefix("MaxArraySize")?.trim_start_matches([' ', '=']).trim().parse().ok());
    // elements are numbered below it, and from 1
    size.unwrap_or(1001_usize).saturating_sub(1).max(1)
}

fn missing(e: std::io::Error) -> Error {
    absent("sbatch", &e, "runs are submitted where Slurm's commands are, as on the login node of a cluster")
}

/// Arguments of `sbatch`: what runs ask for, options of the user, which replace it, and what finds the array again, which nothing does.
/// `parallel`: elements that run at a time, 0: as many as Slurm likes.
pub fn arguments(array: &Array, elements: usize, needs: Needs, parallel: usize, options: &[String]) -> Vec<String> {
    let Needs { minutes, memory_mb, threads } = needs;
    let of_the_runs =
        [format!("--time={minutes}"), format!("--mem={memory_mb}M"), format!("--cpus-per-task={threads}"), "--requeue".into()];
    let at_a_time = if parallel == 0 { String::new() } else { format!("%{parallel}") };
    let folder = array.folder.display();
    let fixed = [
        format!("--job-name={}", array.told.name),
        format!("--array=1-{elements}{at_a_time}"),
        format!("--output={folder}/%a.out"),
        "--open-mode=append".into(),
        array.script().display().to_string(),
        folder.to_string(),
    ];
    of_the_runs.into_iter().chain(options.iter().cloned()).chain(fixed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_squeue_prints_is_read() {
        let entries = read("a-1|3|RUNNING|None\na-1|4|PENDING|Resources\nb|N/A|COMPLETED|None\na-2|1|TIMEOUT|TimeLimit\n");
        assert_eq!(entries.len(), 3);
        let of = |name: &str, n| entries.get(&(name.to_string(), n)).expect("there");
        assert!(of("a-1", 3).runs() && !of("a-1", 3).ended());
        assert!(!of("a-1", 4).runs() && !of("a-1", 4).ended() && of("a-1", 4).held().is_none());
        assert!(of("a-2", 1).ended());
        let held = Entry { state: "PENDING".into(), reason: "PartitionTimeLimit".into() };
        assert_eq!(held.held(), Some("PartitionTimeLimit"));
    }

    #[test]
    fn options_of_the_user_replace_what_runs_ask_for_and_nothing_hides_the_array() {
        let array = Array::example("comminute-7");
        let needs = Needs { minutes: 32, memory_mb: 512, threads: 2 };
        let all = arguments(&array, 2, needs, 3, &["--time=5".into(), "--job-name=mine".into()]);
        let at = |word: &str| all.iter().position(|a| a == word).unwrap_or_else(|| panic!("no {word} in {all:?}"));
        assert!(at("--time=32") < at("--time=5") && at("--job-name=mine") < at("--job-name=comminute-7"));
        assert!(at("--mem=512M") < at("--array=1-2%3") && at("--cpus-per-task=2") < at("--requeue"));
    }
}
