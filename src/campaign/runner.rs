//! Works through a list of jobs, a limited number at a time, each as a process of its own.

use super::Job;
use super::executor::{Executor, Needs, args, line};
use super::hold;
use super::memory::at_a_time;
use super::program::Program;
use super::progress::{Change, Progress};
use super::scheduler;
use laboratory::error::{CANNOT_WRITE, Error, Result};
use laboratory::host;
use laboratory::interrupt::{listen, stop_asked};
use laboratory::machine::{Pace, free_memory};
use laboratory::run::{Found, look};
use laboratory::scene::{self, OF_MEMORY};
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
    pub program: Option<Program>,
    /// Who starts the runs.
    pub executor: Executor,
}

/// Outcome of a job.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The run is finished.
    Done {
        /// Content of the run's `summary.json`.
        summary: Value,
        /// Whether the run was finished before this call, or by another process meanwhile.
        before: bool,
    },
    /// The run failed.
    Failed {
        /// Error message of the run.
        reason: String,
        /// File with everything that the run wrote to standard error.
        log: PathBuf,
        /// Whether the scene is not to blame: the process was killed or stopped, or the machine had no room for its files or for its
        /// memory. The run goes on from its last checkpoint when it is run again.
        outside: bool,
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

    /// A run that failed for this reason; an error of its own that says that the machine had no room is not the scene's either.
    pub(crate) fn failed(reason: String, log: PathBuf, outside: bool) -> Outcome {
        let outside = outside || [CANNOT_WRITE, OF_MEMORY].iter().any(|words| reason.contains(words));
        Outcome::Failed { reason, log, outside }
    }
}

/// Time between two looks at a running process, and at a folder in which another process works.
const LOOK: Duration = Duration::from_millis(10);
const WAIT: Duration = Duration::from_millis(300);
/// Time after which a run that was asked to stop, but still runs, is killed.
const PATIENCE: Duration = Duration::from_secs(60);

/// Runs what is left of `jobs`, and returns the outcome of each job, in their order. After Ctrl-C
/// or SIGTERM the runs stop at a checkpoint. Fewer runs at a time than asked for are made where the memory that is free is not
/// enough for the largest of them together.
///
/// # Errors
/// Only errors found before anything is started: a scene that is not valid, a run for which there is not enough memory even by
/// itself, a folder with another run, two jobs with one folder.
pub fn run(jobs: &[Job], options: &Options) -> Result<Vec<Outcome>> {
    // of this machine; that of others is asked for
    let free = if options.executor == Executor::Local { free_memory() } else { None };
    let (pace, mut memory, mut needs) = (Pace::known(), Vec::new(), vec![Needs::default(); jobs.len()]);
    for (i, job) in jobs.iter().enumerate() {
        if jobs[..i].iter().any(|other| other.out == job.out) {
            return Err(Error::input(job.out.display(), "", None, "is the folder of two runs"));
        }
        let (scene, model) = job.load()?;
        match look(&job.out, &scene, &model)? {
            Found::Other(what) if !options.force => return Err(Error::Other { path: job.out.clone(), what }),
            Found::Finished(_) => continue,
            _ => {}
        }
        scene::fits(&scene, &model, free)?;
        let estimate = scene::estimate(&model, pace);
        memory.push(1e6 * estimate.memory_mb);
        needs[i] = Needs::of(&estimate, job.threads.unwrap_or(1));
    }
    let program = match &options.program {
        Some(program) => program.clone(),
        None => Program::running()?,
    };
    listen();
    let progress = Progress::new(jobs.len(), options.quiet);
    if let Executor::Scheduler { scheduler, folder, options: more } = &options.executor {
        let (scheduler, parallel, force) = (*scheduler, options.parallel, options.force);
        let (program, progress) = (&program, &progress);
        let crew = scheduler::Crew { scheduler, jobs, needs: &needs, program, options: more, parallel, force, progress };
        let outcomes = crew.run(folder);
        progress.finish();
        return outcomes;
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let parallel = if options.parallel == 0 { cores } else { options.parallel };
    let (parallel, fewer) = at_a_time(&memory, parallel.min(jobs.len()).max(1), free);
    let host = host::current();
    if let Some(why) = fewer
        && (host.is_some() || !options.quiet)
    {
        host::warn(&why);
    }
    let crew = Crew { program, threads: (cores / parallel).max(1), force: options.force, executor: &options.executor, progress };
    let next = AtomicUsize::new(0);
    let outcomes = Mutex::new(vec![Outcome::Stopped; jobs.len()]);
    std::thread::scope(|scope| {
        for _ in 0..parallel {
            let work = || loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let (Some(job), Some(needs)) = (jobs.get(i), needs.get(i)) else { break };
                let outcome = crew.work(job, *needs);
                outcomes.lock().unwrap_or_else(PoisonError::into_inner)[i] = outcome;
            };
            let host = host.clone();
            scope.spawn(move || host::within(host, work));
        }
    });
    crew.progress.finish();
    Ok(outcomes.into_inner().unwrap_or_else(PoisonError::into_inner))
}

/// Turns the outcomes of a campaign into its result: `Ok` if every job is done.
///
/// # Errors
/// [`Error::Stopped`] if the campaign was stopped before every job had ended, else [`Error::Campaign`]; both with each job that
/// failed, and why.
pub fn close(jobs: &[Job], outcomes: &[Outcome]) -> Result<()> {
    let failed: Vec<(PathBuf, String)> = jobs
        .iter()
        .zip(outcomes)
        .filter_map(|(job, outcome)| match outcome {
            Outcome::Failed { reason, log, .. } => Some((job.out.clone(), format!("{reason} ({})", log.display()))),
            _ => None,
        })
        .collect();
    let of = jobs.len();
    if outcomes.contains(&Outcome::Stopped) {
        let done = outcomes.iter().filter(|o| o.summary().is_some()).count();
        return Err(Error::Stopped { failed, done, of });
    }
    if failed.is_empty() { Ok(()) } else { Err(Error::Campaign { failed, of }) }
}

/// Data that the workers share.
struct Crew<'a> {
    program: Program,
    /// Threads of a run of this machine.
    threads: usize,
    force: bool,
    executor: &'a Executor,
    progress: Progress,
}

impl Crew<'_> {
    /// Works on one job until it has an outcome; waits while another process works on it.
    fn work(&self, job: &Job, needs: Needs) -> Outcome {
        let mut waits = false;
        let outcome = loop {
            if stop_asked() {
                break Outcome::Stopped;
            }
            match self.attempt(job, needs) {
                Ok(Some(outcome)) => break outcome,
                Ok(None) if waits => {}
                Ok(None) => self.progress.update(Change::Waits),
                Err(e) => break Outcome::Failed { reason: e.to_string(), log: job.log(), outside: true },
            }
            waits = true;
            std::thread::sleep(WAIT);
        };
        if waits {
            self.progress.update(Change::WaitsNoMore);
        }
        self.progress.count(&outcome);
        outcome
    }

    /// Takes a finished run as done, else runs the job; `None` while another process works on it.
    fn attempt(&self, job: &Job, needs: Needs) -> Result<Option<Outcome>> {
        match job.found()? {
            Found::Busy => return Ok(None),
            Found::Finished(summary) => return Ok(Some(Outcome::Done { summary, before: true })),
            _ => {}
        }
        let path = job.log();
        let Some(log) = hold::log(&path)? else { return Ok(None) };
        // once more, now that no other campaign can begin it
        if let Found::Finished(summary) = job.found()? {
            remove_empty(&log, &path)?;
            return Ok(Some(Outcome::Done { summary, before: true }));
        }
        log.set_len(0).map_err(Error::write(&path))?;
        self.progress.update(Change::Starts);
        let outcome = self.child(job, needs, &log);
        self.progress.update(Change::Ends);
        outcome
    }

    /// Runs the job as a process, and reads what that process leaves in the folder and the log.
    fn child(&self, job: &Job, needs: Needs, log: &File) -> Result<Option<Outcome>> {
        let path = job.log();
        let (mut command, group) = match self.executor {
            Executor::Command(template) => (template.process(&line(&self.program, job, needs.threads, self.force), needs), true),
            _ => {
                let mut command = Command::new(&self.program.file);
                command.args(&self.program.first).args(args(job, self.threads, self.force));
                (command, false)
            }
        };
        command.stdin(Stdio::null()).stdout(Stdio::null());
        command.stderr(log.try_clone().map_err(Error::write(&path))?);
        command.env("COMMINUTE_SIMD", engine::math::real::name(engine::math::real::arch()));
        let program = PathBuf::from(command.get_program());
        let mut child = command.spawn().map_err(Error::read(&program))?;
        // the command has the log open as well
        drop(command);
        let (status, stopped) = wait(&mut child, group).map_err(Error::read(&program))?;
        let said = std::fs::read_to_string(&path).unwrap_or_default();
        let found = job.found()?;
        if status.success() {
            remove_empty(log, &path)?;
            return Ok(Some(match found {
                Found::Finished(summary) => Outcome::Done { summary, before: false },
                _ => Outcome::Failed { reason: "ended without a summary".into(), log: path, outside: true },
            }));
        }
        let of_its_own = matches!(status.code(), Some(1..=3));
        if stopped && !of_its_own {
            let _ = std::fs::remove_file(&path);
            return Ok(Some(Outcome::Stopped));
        }
        // somebody else has begun the run just before
        if let Found::Busy | Found::Finished(_) = found {
            let _ = std::fs::remove_file(&path);
            return Ok(None);
        }
        let reason = reason(status, &said);
        // the exit code of a command may be that of something else, which does not speak as a run does
        let of_the_run = of_its_own && (!group || own_words(&said).is_some());
        Ok(Some(Outcome::failed(reason, path, !of_the_run && status.code() != Some(PANIC))))
    }
}

/// Exit code of a program in Rust that has found a fault of its own.
pub const PANIC: i32 = 101;

/// Removes the log of a run that had nothing to say.
fn remove_empty(log: &File, path: &PathBuf) -> Result<()> {
    if log.metadata().is_ok_and(|m| m.len() == 0) { std::fs::remove_file(path).map_err(Error::write(path)) } else { Ok(()) }
}

/// Waits for a process to end, and asks it to stop when this process is asked to, together with its group if it has one of its own.
/// Returns the exit status, and whether a stop was asked for.
fn wait(child: &mut Child, group: bool) -> std::io::Result<(ExitStatus, bool)> {
    let mut asked: Option<Instant> = None;
    loop {
        if let Some(status) = child.try_wait()? {
            // a shell ends at once, what it has started writes a checkpoint first
            while group && asked.is_some_and(|since| since.elapsed() < PATIENCE) && still_there(child) {
                std::thread::sleep(LOOK);
            }
            return Ok((status, asked.is_some() || stop_asked()));
        }
        match asked {
            None if stop_asked() => {
                ask_to_stop(child, group);
                asked = Some(Instant::now());
            }
            Some(since) if since.elapsed() > PATIENCE => kill_all(child, group)?,
            _ => {}
        }
        std::thread::sleep(LOOK);
    }
}

#[cfg(unix)]
fn ask_to_stop(child: &Child, group: bool) {
    use nix::sys::signal::{Signal, kill, killpg};
    use nix::unistd::Pid;
    // The process has not been waited for, so its id is still valid; a signal to a process that has
    // just ended has no effect.
    let pid = Pid::from_raw(child.id() as i32);
    let _ = if group { killpg(pid, Signal::SIGTERM) } else { kill(pid, Signal::SIGTERM) };
}

/// Whether a process of the group of `child` is still there.
#[cfg(unix)]
fn still_there(child: &Child) -> bool {
    nix::sys::signal::killpg(nix::unistd::Pid::from_raw(child.id() as i32), None).is_ok()
}

#[cfg(not(unix))]
fn still_there(_: &Child) -> bool {
    false
}

#[cfg(unix)]
fn kill_all(child: &mut Child, group: bool) -> std::io::Result<()> {
    use nix::sys::signal::{Signal, killpg};
    if group {
        let _ = killpg(nix::unistd::Pid::from_raw(child.id() as i32), Signal::SIGKILL);
    }
    child.kill()
}

#[cfg(not(unix))]
fn kill_all(child: &mut Child, _: bool) -> std::io::Result<()> {
    child.kill()
}

/// Does nothing: Ctrl-C reaches every process of the console without help.
#[cfg(not(unix))]
fn ask_to_stop(_: &Child, _: bool) {}

/// Why a process failed: what ended it from outside, its error messages, or its exit status with the last line that it wrote.
fn reason(status: ExitStatus, said: &str) -> String {
    if let Some(signal) = killed(status) {
        return format!("was killed by {signal}; called again, it goes on from its last checkpoint");
    }
    own_words(said).unwrap_or_else(|| said.lines().last().map_or(status.to_string(), |line| format!("{status}: {line}")))
}

/// The error messages of a run in what it wrote; `None` where it wrote none.
pub fn own_words(said: &str) -> Option<String> {
    let own: Vec<&str> = said.lines().filter_map(|line| line.strip_prefix("error: ")).collect();
    (!own.is_empty()).then(|| own.join("; "))
}

/// The signal that ended a process, with who sends it.
#[cfg(unix)]
fn killed(status: ExitStatus) -> Option<String> {
    use nix::sys::signal::Signal;
    let number = std::os::unix::process::ExitStatusExt::signal(&status)?;
    let signal = Signal::try_from(number).ok();
    let name = signal.map_or(format!("signal {number}"), |signal| signal.as_str().into());
    Some(match signal {
        Some(Signal::SIGKILL) => format!("{name} (from outside, as by a system that has no memory left)"),
        Some(Signal::SIGSEGV | Signal::SIGBUS | Signal::SIGILL | Signal::SIGFPE | Signal::SIGABRT) => {
            format!("{name} (a fault of the program or the machine)")
        }
        _ => format!("{name} (from outside)"),
    })
}

#[cfg(not(unix))]
fn killed(_: ExitStatus) -> Option<String> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn failed(outside: bool) -> Outcome {
        Outcome::Failed { reason: "step 3: it stood still".into(), log: "b.log".into(), outside }
    }

    #[test]
    fn a_campaign_that_was_stopped_tells_what_had_failed_before() {
        let jobs = ["a", "b", "c"].map(|name| Job::new("scene.toml", name));
        let done = Outcome::Done { summary: Value::Null, before: false };
        let stopped = close(&jobs, &[done.clone(), failed(false), Outcome::Stopped]).expect_err("stopped");
        let says = "b: step 3: it stood still (b.log)\nstopped with 1 of 3 runs done and 1 failed; what is done is kept";
        assert_eq!((stopped.to_string().as_str(), stopped.exit_code()), (says, 130));
        let stopped = close(&jobs, &[done.clone(), Outcome::Stopped, Outcome::Stopped]).expect_err("stopped");
        assert_eq!(stopped.to_string(), "stopped with 1 of 3 runs done; what is done is kept");
        let ended = close(&jobs, &[done.clone(), failed(true), done.clone()]).expect_err("failed");
        assert_eq!((ended.to_string().lines().last(), ended.exit_code()), (Some("1 of 3 runs failed"), 1));
        assert!(close(&jobs, &[done.clone(), done.clone(), done]).is_ok());
    }

    #[cfg(unix)]
    #[test]
    fn a_signal_is_told_in_words() {
        use std::os::unix::process::ExitStatusExt;
        let of = |raw| reason(ExitStatus::from_raw(raw), "warning: late\n");
        assert!(of(9).starts_with("was killed by SIGKILL (from outside, as by a system that has no memory left)"), "{}", of(9));
        assert!(of(11).contains("SIGSEGV (a fault of the program or the machine)"), "{}", of(11));
        assert_eq!(of(4 << 8), "exit status: 4: warning: late");
        assert_eq!(reason(ExitStatus::from_raw(1 << 8), "error: no\nerror: never\nadvice"), "no; never");
    }
}
