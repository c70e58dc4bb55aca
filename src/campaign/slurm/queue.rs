//! The commands of Slurm: what it is asked, and what it answers.

use laboratory::error::{Error, Result};
use laboratory::host;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

/// What Slurm says of an element of an array.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// State, as `RUNNING`.
    pub state: String,
    /// Why it waits.
    pub reason: String,
}

/// States in which an element runs no more, nor will.
const ENDED: [&str; 10] =
    ["BOOT_FAIL", "CANCELLED", "COMPLETED", "DEADLINE", "FAILED", "NODE_FAIL", "OUT_OF_MEMORY", "PREEMPTED", "REVOKED", "TIMEOUT"];

/// Reasons to wait that pass by themselves.
const ORDINARY: [&str; 7] = ["None", "Priority", "Resources", "JobArrayTaskLimit", "BeginTime", "Dependency", "Cleaning"];

impl Entry {
    /// Whether it has ended.
    pub fn ended(&self) -> bool {
        ENDED.contains(&self.state.as_str())
    }

    /// Whether it runs.
    pub fn runs(&self) -> bool {
        !self.ended() && self.state != "PENDING"
    }

    /// Why it waits, where that may never end without help.
    pub fn held(&self) -> Option<&str> {
        (self.state == "PENDING" && !ORDINARY.contains(&self.reason.as_str())).then_some(&self.reason)
    }
}

/// Elements by the name of their array and their number in it.
pub type Entries = BTreeMap<(String, usize), Entry>;

/// Asks for all elements of the arrays of these names that Slurm still knows; it forgets them some minutes after their ends.
///
/// # Errors
/// What `squeue` says where it does not answer.
pub fn entries(names: &[&str]) -> std::result::Result<Entries, String> {
    if names.is_empty() {
        return Ok(Entries::new());
    }
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
    let why = if e.kind() == std::io::ErrorKind::NotFound { "is not on the PATH".into() } else { e.to_string() };
    Error::input(
        "sbatch",
        "",
        None,
        format!("{why}; runs are submitted where Slurm's commands are, as on the login node of a cluster"),
    )
}

/// What a command has said, in one line without its own name.
fn words(said: &str, name: &str) -> String {
    let own = [format!("{name}: error: "), format!("{name}: ")];
    let bare = |line: &str| own.iter().find_map(|own| line.strip_prefix(own.as_str())).unwrap_or(line).trim().to_string();
    let lines: Vec<String> = said.lines().map(bare).filter(|line| !line.is_empty()).collect();
    if lines.is_empty() { format!("{name} says nothing") } else { lines.join("; ") }
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
    fn words_of_a_command_are_one_line() {
        let said = "sbatch: error: invalid partition specified: none\nsbatch: error: Batch job submission failed: no\n\n";
        assert_eq!(words(said, "sbatch"), "invalid partition specified: none; Batch job submission failed: no");
        assert_eq!(words("", "squeue"), "squeue says nothing");
    }
}
