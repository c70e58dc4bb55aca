//! Who starts the runs of a campaign: this machine, a command of the user's, a scheduler.

use super::Job;
use super::job::shell_word;
use super::program::Program;
use super::scheduler::Scheduler;
use laboratory::error::{Error, Result};
use laboratory::scene::Estimate;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

/// Who starts a run, and tells how it ended. What is done and what is left is read from the folders of the runs, whoever starts them,
/// so that a later call with another executor goes on.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Executor {
    /// Each run is a process of this machine.
    #[default]
    Local,
    /// Each run is made by a shell command, whose exit code is the run's.
    Command(Template),
    /// The runs are elements of arrays of a scheduler.
    Scheduler {
        /// Which one.
        scheduler: Scheduler,
        /// Folder of the campaign, of which a folder remembers the arrays.
        folder: PathBuf,
        /// Options of its command that submits; they replace what follows from the runs.
        options: Vec<String>,
    },
}

/// What a run asks for where others give it room: more than [`laboratory::scene::estimate`] expects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Needs {
    /// Time, min.
    pub minutes: u64,
    /// Memory, MB.
    pub memory_mb: u64,
    /// Threads.
    pub threads: usize,
}

impl Needs {
    /// Time over what is expected on one thread, which is meant to be within a factor of two on a machine whose pace is known; what is left
    /// covers nodes that are slower.
    const TIME: f64 = 3.0;
    /// Time for the start of the program on a busy node and for its files, min.
    const START: f64 = 10.0;
    /// Memory over what is expected, and for the program itself, MB.
    const MEMORY: f64 = 1.5;
    const PROGRAM: f64 = 200.0;

    /// Of a run that is expected to be so. Rounded up to powers of two, so that runs that differ little ask for the same.
    pub fn of(estimate: &Estimate, threads: usize) -> Needs {
        let rounded = |x: f64| (x.ceil() as u64).next_power_of_two();
        Needs {
            minutes: rounded(Needs::TIME * estimate.seconds / 60.0 + Needs::START),
            memory_mb: rounded(Needs::MEMORY * estimate.memory_mb + Needs::PROGRAM),
            threads,
        }
    }
}

/// A shell command with places for that of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Template(String);

impl Template {
    /// Places that a template may have: the command of the run; the same as one word in quotes, for a program that gives it to another
    /// shell; what the run asks for.
    pub const PLACES: [&str; 5] = ["{command}", "{word}", "{threads}", "{memory_MB}", "{minutes}"];

    /// Of a text that has `{command}` or `{word}`.
    ///
    /// # Errors
    /// A text without either.
    pub fn parse(text: &str) -> Result<Template> {
        if !Template::PLACES[..2].iter().any(|place| text.contains(place)) {
            let message = "has no place for the command of a run: {command}, or {word} for it in quotes, as in 'ssh node {word}'";
            return Err(Error::input("--executor-command", "", None, format!("`{text}` {message}")));
        }
        Ok(Template(text.into()))
    }

    /// The shell command of a run whose command line is `line`.
    fn filled(&self, line: &str, needs: Needs) -> String {
        let values = [
            line.to_string(),
            format!("'{}'", line.replace('\'', "'\\''")),
            needs.threads.to_string(),
            needs.memory_mb.to_string(),
            needs.minutes.to_string(),
        ];
        // one pass: what is put in may have braces of its own
        let (mut text, mut rest) = (String::new(), self.0.as_str());
        while let Some(at) = rest.find('{') {
            let (before, from) = rest.split_at(at);
            text += before;
            rest = match Template::PLACES.iter().zip(&values).find(|(place, _)| from.starts_with(**place)) {
                Some((place, value)) => {
                    text += value;
                    &from[place.len()..]
                }
                None => {
                    text.push('{');
                    &from[1..]
                }
            };
        }
        text + rest
    }

    /// The process that runs a job by this template.
    pub fn process(&self, line: &str, needs: Needs) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", &self.filled(line, needs)]);
        // the shell and what it starts are stopped together
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        command
    }
}

/// Arguments with which a program does what is left of a job with so many threads.
pub fn args(job: &Job, threads: usize, force: bool) -> Vec<OsString> {
    let mut args = job.args();
    if job.threads.is_none() {
        args.extend(["--threads".into(), threads.to_string().into()]);
    }
    if force {
        args.push("--force".into());
    }
    args
}

/// The command line of a job for a shell in the working directory of this process.
pub fn line(program: &Program, job: &Job, threads: usize, force: bool) -> String {
    let words = program.words().map(OsString::from).chain(args(job, threads, force));
    words.map(|word| shell_word(&word.to_string_lossy())).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEEDS: Needs = Needs { minutes: 16, memory_mb: 512, threads: 2 };

    #[test]
    fn a_template_is_filled_once() {
        let template =
            Template::parse("run -c {threads} --mem={memory_MB}M -t {minutes} ${HOME} {command}; {word}").expect("valid");
        let filled = template.filled("comminute run 'a {minutes}.toml'", NEEDS);
        let line = "comminute run 'a {minutes}.toml'";
        let word = r"'comminute run '\''a {minutes}.toml'\'''";
        assert_eq!(filled, format!("run -c 2 --mem=512M -t 16 ${{HOME}} {line}; {word}"));
        let refused = Template::parse("ssh node").expect_err("no place").to_string();
        assert!(refused.contains("`ssh node` has no place for the command of a run: {command}"), "{refused}");
    }

    #[test]
    fn a_word_reaches_a_second_shell_whole() {
        let template = Template::parse("sh -c {word}").expect("valid");
        let said = template.process(r#"printf '%s|' 'it'\''s' "b  c""#, NEEDS).output().expect("a shell");
        assert_eq!(String::from_utf8_lossy(&said.stdout), "it's|b  c|");
    }

    #[test]
    fn a_command_line_has_threads_and_force_once() {
        let program = Program { file: "/a b/python".into(), first: vec!["-m".into(), "comminute".into()] };
        let job = Job::new("s.toml", "out");
        let start = "'/a b/python' -m comminute run s.toml --out out";
        assert_eq!(line(&program, &job, 3, false), format!("{start} --continue --quiet --threads 3"));
        let job = Job { threads: Some(2), ..job };
        assert_eq!(line(&program, &job, 3, true), format!("{start} --threads 2 --continue --quiet --force"));
    }
}
