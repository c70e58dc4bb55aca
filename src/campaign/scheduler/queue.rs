//! What a scheduler is asked, and what it says of the elements of an array.

use super::super::executor::Needs;
use super::array::Array;
use super::{hyperqueue, slurm};
use laboratory::error::{Error, Result};
use std::collections::BTreeMap;

/// A scheduler that makes arrays of runs, by its own commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheduler {
    /// `sbatch`, `squeue`.
    Slurm,
    /// `hq`.
    HyperQueue,
}

impl Scheduler {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Scheduler::Slurm => "Slurm",
            Scheduler::HyperQueue => "HyperQueue",
        }
    }

    /// Its name as an executor, and of the folder of its arrays in that of a campaign.
    pub fn word(self) -> &'static str {
        match self {
            Scheduler::Slurm => "slurm",
            Scheduler::HyperQueue => "hyperqueue",
        }
    }

    /// The command that submits, whose options a user may give.
    pub fn submits(self) -> &'static str {
        match self {
            Scheduler::Slurm => "sbatch",
            Scheduler::HyperQueue => "hq submit",
        }
    }

    /// The command that tells what is in the queue.
    pub(super) fn asks(self) -> &'static str {
        match self {
            Scheduler::Slurm => "squeue",
            Scheduler::HyperQueue => "hq job list",
        }
    }

    /// The command that takes a job out of the queue.
    pub(super) fn cancels(self) -> &'static str {
        match self {
            Scheduler::Slurm => "scancel",
            Scheduler::HyperQueue => "hq job cancel",
        }
    }

    /// Says that its commands are not here, if they are not.
    ///
    /// # Errors
    /// A machine without them.
    pub(super) fn here(self) -> Result<()> {
        match self {
            Scheduler::Slurm => slurm::here(),
            Scheduler::HyperQueue => hyperqueue::here(),
        }
    }

    /// Most elements of an array.
    pub(super) fn most(self) -> usize {
        match self {
            Scheduler::Slurm => slurm::most(),
            Scheduler::HyperQueue => hyperqueue::MOST,
        }
    }

    /// All elements of the arrays of these names that it still knows.
    ///
    /// # Errors
    /// What its command says where it does not answer.
    pub(super) fn entries(self, names: &[&str]) -> std::result::Result<Entries, String> {
        match self {
            _ if names.is_empty() => Ok(Entries::new()),
            Scheduler::Slurm => slurm::entries(names),
            Scheduler::HyperQueue => hyperqueue::entries(names),
        }
    }

    /// Submits an array whose elements ask for `needs`, and gives the number of the job. `parallel`: elements that run at a time, 0: as many as it likes; `options` of the
    /// user.
    ///
    /// # Errors
    /// That its command is not here, or what it says where it refuses.
    pub(super) fn submit(
        self,
        array: &Array,
        elements: usize,
        needs: Needs,
        parallel: usize,
        options: &[String],
    ) -> Result<String> {
        match self {
            Scheduler::Slurm => slurm::submit(&slurm::arguments(array, elements, needs, parallel, options)),
            Scheduler::HyperQueue => hyperqueue::submit(&hyperqueue::arguments(array, elements, needs, options)),
        }
    }
}

/// What a scheduler says of an element of an array, in Slurm's words.
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

/// A command that could not be started, and `advice` where it is not here.
pub fn absent(command: &str, e: &std::io::Error, advice: &str) -> Error {
    let why = if e.kind() == std::io::ErrorKind::NotFound { "is not on the PATH".into() } else { e.to_string() };
    Error::input(command, "", None, format!("{why}; {advice}"))
}

/// What a command has said, in one line without its own name.
pub fn words(said: &str, name: &str) -> String {
    let own = [format!("{name}: error: "), format!("{name}: ")];
    let bare = |line: &str| own.iter().find_map(|own| line.strip_prefix(own.as_str())).unwrap_or(line).trim().to_string();
    let lines: Vec<String> = said.lines().map(bare).filter(|line| !line.is_empty()).collect();
    if lines.is_empty() { format!("{name} says nothing") } else { lines.join("; ") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_command_are_one_line() {
        let said = "sbatch: error: invalid partition specified: none\nsbatch: error: Batch job submission failed: no\n\n";
        assert_eq!(words(said, "sbatch"), "invalid partition specified: none; Batch job submission failed: no");
        assert_eq!(words("", "squeue"), "squeue says nothing");
    }
}
