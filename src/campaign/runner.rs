//! Works through a list of jobs, a limited number at a time, each as a process of its own.

use super::Job;
use super::progress::{Change, Progress};
use laboratory::error::{Error, Result};
use laboratory::interrupt::{listen, stop_asked};
use laboratory::run::Found;
use serde_json::Value;
use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How a list of jobs is worked through.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Runs at a time; 0: one for each core.
    pub parallel: usize,
    /// Whether no progress is shown.
    pub quiet: bool,
    /// Whether runs of other scenes in the folders are overwritten.
    pub force: bool,
    /// Program that runs the jobs; `None`: the program that is running now.
    pub program: Option<PathBuf>,
}

/// Outcome of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The run is finished.
    Done {
        /// Content of the run's `summary.json`.
        summary: Value,
        /// Whether the run was finished before this call.
        before: bool,
    },
    /// The run failed.
    Failed {
        /// Error message of the run.
        reason: String,
        /// File with everything that the run wrote to standard error.
        log: PathBuf,
    },
    /// The campaign was stopped first; the job goes on when it is run again.
    Stopped,
}

impl Outcome {
    /// The summary of a job that is done.
    pub fn summary(&self) -> Option<&Value> {
        match self {
            Outcome::Done { summary, .. } => Some(summary),
            _ => None,
        }
    }
}

/// Time between two looks at a running process, and at a folder in which another process works.
const LOOK: Duration = Duration::from_millis(10);
const WAIT: Duration = Duration::from_millis(300);
/// Time after which a run that was asked to stop, but still runs, is killed.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs what is left of `jobs`, and returns the outcome of each job, in their order. After Ctrl-C
/// or SIGTERM the runs stop at a checkpoint.
///
/// # Errors
/// Only errors found before anything is started: a scene that is not valid, a folder with another
/// run, two jobs with one folder.
pub fn run(jobs: &[Job], options: &Options) -> Result<Vec<Outcome>> {
    for (i, job) in jobs.iter().enumerate() {
        if jobs[..i].iter().any(|other| other.out == job.out) {
            return Err(Error::input(job.out.display(), "", None, "is the folder of two runs"));
        }
        match job.found()? {
            Found::Other(what) if !options.force => return Err(Error::Other { path: job.out.clone(), what }),
            _ => {}
        }
    }
    let program = match &options.program {
        Some(program) => program.clone(),
        None => std::env::current_exe().map_err(Error::read("this program"))?,
    };
    listen();
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let parallel = if options.parallel == 0 { cores } else { options.parallel };
    let parallel = parallel.min(jobs.len()).max(1);
    let crew = Crew {
        program,
        threads: (cores / parallel).max(1),
        force: options.force,
        progress: Progress::new(jobs.len(), options.quiet),
    };
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(vec![Outcome::Stopped; jobs.len()]);
    std::thread::scope(|scope| {
        for _ in 0..parallel {
            scope.spawn(|| {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(i) else { break };
                    let outcome = crew.work(job);
                    outcomes.lock().unwrap_or_else(PoisonError::into_inner)[i] = outcome;
                }
            });
        }
    });
    crew.progress.finish();
    Ok(outcomes.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Turns the outcomes of a campaign into its result: `Ok` if every job is done.
///
/// # Errors
/// [`Error::Stopped`] if the campaign was stopped before every job had ended, also where jobs
/// failed; else [`Error::Campaign`] with each job that failed, and why.
pub fn close(jobs: &[Job], outcomes: &[Outcome]) -> Result<()> {
    let failed: Vec<(PathBuf, String)> = jobs
        .iter()
        .zip(outcomes)
        .filter_map(|(job, outcome)| match outcome {
            Outcome::Failed { reason, log } => Some((job.out.clone(), format!("{reason} ({})", log.display()))),
            _ => None,
        })
        .collect();
    let of = jobs.len();
    if outcomes.contains(&Outcome::Stopped) {
        let done = outcomes.iter().filter(|o| o.summary().is_some()).count();
        return Err(Error::Stopped { done, of });
    }
    if failed.is_empty() { Ok(()) } else { Err(Error::Campaign { failed, of }) }
}

/// Data that the workers share.
struct Crew {
    program: PathBuf,
    threads: usize,
    force: bool,
    progress: Progress,
}

impl Crew {
    /// Works on one job, whatever its folder holds: waits while another process works there, takes
    /// a finished run as done, else runs the job.
    fn work(&self, job: &Job) -> Outcome {
        let failed = |e: &Error| Outcome::Failed { reason: e.to_string(), log: job.log() };
        let mut waits = false;
        let found = loop {
            if stop_asked() {
                return Outcome::Stopped;
            }
            match job.found() {
                Ok(Found::Busy) => {
                    if !waits {
                        self.progress.update(Change::Waits);
                    }
                    waits = true;
                    std::thread::sleep(WAIT);
                }
                found => break found,
            }
        };
        if waits {
            self.progress.update(Change::WaitsNoMore);
        }
        if let Ok(Found::Finished(summary)) = found {
            self.progress.update(Change::DoneBefore);
            return Outcome::Done { summary, before: true };
        }
        self.progress.update(Change::Started);
        let outcome = self.child(job).unwrap_or_else(|e| failed(&e));
        self.progress.update(Change::Ended { well: matches!(outcome, Outcome::Done { .. }) });
        outcome
    }

    /// Runs the job as a process, and reads what that process leaves in the folder and the log.
    fn child(&self, job: &Job) -> Result<Outcome> {
        let log = job.log();
        if let Some(folder) = log.parent() {
            std::fs::create_dir_all(folder).map_err(Error::write(folder))?;
        }
        let file = File::create(&log).map_err(Error::write(&log))?;
        let mut command = Command::new(&self.program);
        command.args(job.args()).stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
        command.env("COMMINUTE_SIMD", engine::math::real::name(engine::math::real::arch()));
        if job.threads.is_none() {
            command.args(["--threads", &self.threads.to_string()]);
        }
        if self.force {
            command.arg("--force");
        }
        let mut child = command.spawn().map_err(Error::read(&self.program))?;
        let (status, stopped) = wait(&mut child).map_err(Error::read(&self.program))?;
        let said = std::fs::read_to_string(&log).unwrap_or_default();
        if status.success() {
            if said.is_empty() {
                std::fs::remove_file(&log).map_err(Error::write(&log))?;
            }
            return Ok(match job.found()? {
                Found::Finished(summary) => Outcome::Done { summary, before: false },
                _ => Outcome::Failed { reason: "ended without a summary".into(), log },
            });
        }
        if stopped {
            let _ = std::fs::remove_file(&log);
            return Ok(Outcome::Stopped);
        }
        Ok(Outcome::Failed { reason: reason(status, &said), log })
    }
}

/// Waits for a process to end, and asks it to stop when this process is asked to. Returns the exit
/// status, and whether a stop was asked for.
fn wait(child: &mut Child) -> std::io::Result<(ExitStatus, bool)> {
    let mut asked: Option<Instant> = None;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok((status, asked.is_some() || stop_asked()));
        }
        match asked {
            None if stop_asked() => {
                ask_to_stop(child);
                asked = Some(Instant::now());
            }
            Some(since) if since.elapsed() > PATIENCE => child.kill()?,
            _ => {}
        }
        std::thread::sleep(LOOK);
    }
}

#[cfg(unix)]
fn ask_to_stop(child: &Child) {
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;
    // The process has not been waited for, so its id is still valid; a signal to a process that has
    // just ended has no effect.
    let _ = kill(Pid::from_raw(child.id() as i32), Signal::SIGTERM);
}

/// Does nothing: Ctrl-C reaches every process of the console without help.
#[cfg(not(unix))]
fn ask_to_stop(_: &Child) {}

/// Why a process failed: its error messages, or its exit status with the last line that it wrote.
fn reason(status: ExitStatus, said: &str) -> String {
    let own: Vec<&str> = said.lines().filter_map(|line| line.strip_prefix("error: ")).collect();
    match own.as_slice() {
        [] => said.lines().last().map_or(status.to_string(), |line| format!("{status}: {line}")),
        lines => lines.join("; "),
    }
}
