//! Options that say who starts the runs of a campaign.

use comminute::campaign::{Executor, Scheduler, Template};
use comminute::error::{Error, Result};
use std::path::Path;

/// Who starts the runs.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Who starts the runs. A second call goes on, also with another one
    #[arg(long, value_enum, value_name = "NAME", default_value = "local")]
    executor: Name,

    /// Shell command that makes a run with --executor command: {command} stands for the run's, {word} for it in quotes, {threads}, {memory_MB} and {minutes} for what it needs
    #[arg(long, value_name = "TEMPLATE")]
    executor_command: Option<String>,

    /// Options of sbatch with --executor slurm, as in "--partition=long --account=soil", or of hq submit with --executor hyperqueue; they replace what the program asks for. May be given several times
    #[arg(long, value_name = "OPTIONS", allow_hyphen_values = true)]
    executor_options: Vec<String>,
}

#[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
enum Name {
    /// This machine, each run a process
    Local,
    /// Slurm, each run an element of an array, with time and memory from what `check` expects
    Slurm,
    /// HyperQueue, each run a task of an array, with the same
    #[value(name = "hyperqueue")]
    HyperQueue,
    /// A shell command of yours, whose exit code is the run's
    Command,
}

impl Args {
    /// The executor of a campaign in `folder`.
    ///
    /// # Errors
    /// Options of another executor, and a template that is missing or has no place for the command of a run.
    pub fn of(&self, folder: &Path) -> Result<Executor> {
        let stray = |option: &str, of: &str| Err(Error::input(option, "", None, format!("is only for --executor {of}")));
        if self.executor != Name::Command && self.executor_command.is_some() {
            return stray("--executor-command", "command");
        }
        let scheduler = match self.executor {
            Name::Slurm => Some(Scheduler::Slurm),
            Name::HyperQueue => Some(Scheduler::HyperQueue),
            Name::Local | Name::Command => None,
        };
        if scheduler.is_none() && !self.executor_options.is_empty() {
            return stray("--executor-options", "slurm and hyperqueue");
        }
        if let Some(scheduler) = scheduler {
            let words = self.executor_options.iter().flat_map(|text| text.split_whitespace());
            let options: Vec<String> = words.map(String::from).collect();
            if let Some(word) = options.iter().find(|word| !word.starts_with('-')) {
                let message = format!("is no option of {}: write values with =, as in --name=value", scheduler.submits());
                return Err(Error::input("--executor-options", "", None, format!("`{word}` {message}")));
            }
            return Ok(Executor::Scheduler { scheduler, folder: folder.into(), options });
        }
        match self.executor {
            Name::Command => match &self.executor_command {
                Some(text) => Ok(Executor::Command(Template::parse(text)?)),
                None => {
                    let message = "needs --executor-command, as in --executor-command 'ssh node {word}'";
                    Err(Error::input("--executor command", "", None, message))
                }
            },
            _ => Ok(Executor::Local),
        }
    }

    /// Threads of each run: as asked for, else one where this machine's cores say nothing; `None`: the runner shares them out.
    pub fn threads(&self, asked: Option<u16>) -> Option<usize> {
        asked.map(usize::from).or((self.executor != Name::Local).then_some(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn of(words: &[&str]) -> std::result::Result<Executor, String> {
        let line = Line::try_parse_from([&["comminute"], words].concat()).map_err(|e| e.to_string())?;
        line.args.of(Path::new("runs/e")).map_err(|e| e.to_string())
    }

    #[test]
    fn options_belong_to_their_executor() {
        assert_eq!(of(&[]), Ok(Executor::Local));
        let slurm = ["--executor", "slurm", "--executor-options", "--partition=long --mem=4G", "--executor-options=-A soil"];
        assert!(of(&slurm).expect_err("a value by itself").contains("`soil` is no option of sbatch"));
        let options = vec!["--partition=long".into(), "--mem=4G".into()];
        let of_slurm = Executor::Scheduler { scheduler: Scheduler::Slurm, folder: "runs/e".into(), options };
        assert_eq!(of(&slurm[..4]), Ok(of_slurm));
        let hyperqueue = of(&["--executor", "hyperqueue", "--executor-options=--cpus=2"]).expect("a scheduler");
        assert!(matches!(hyperqueue, Executor::Scheduler { scheduler: Scheduler::HyperQueue, .. }), "{hyperqueue:?}");
        for (words, says) in [
            (&["--executor", "command"][..], "--executor command: needs --executor-command"),
            (&["--executor", "command", "--executor-command", "ssh node"], "`ssh node` has no place for the command of a run"),
            (&["--executor-command", "{command}"], "--executor-command: is only for --executor command"),
            (&["--executor-options=--mem=1G"], "--executor-options: is only for --executor slurm and hyperqueue"),
            (&["--executor", "pbs"], "invalid value 'pbs'"),
        ] {
            let said = of(words).expect_err("refused");
            assert!(said.contains(says), "{said}");
        }
    }
}
