//! Runs as elements of arrays of a scheduler. Nothing but the campaign's folder and the scheduler's queue knows what is going on, so that a call that
//! was killed, or a second one at the same time, finds the arrays of the first and waits for them.

mod array;
mod hyperqueue;
mod queue;
mod slurm;

use super::executor::{Needs, line};
use super::hold::Hold;
use super::job::Job;
use super::program::Program;
use super::progress::{Change, Progress};
use super::runner::{Outcome, PANIC, own_words};
use array::{Array, Element};
use laboratory::error::{Error, Result};
use laboratory::host;
use laboratory::interrupt::stop_asked;
use laboratory::run::{Found, last_checkpoint};
pub use queue::Scheduler;
use queue::{Entries, Entry};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// File in the folder of the arrays that a call locks while it looks and submits.
const LOCK: &str = "lock";

/// Time between two looks at the queue, from the first after something has changed to the longest.
const LOOKS: [Duration; 2] = [Duration::from_secs(1), Duration::from_secs(30)];
/// Time after which a file that a node has written is seen on every machine, also where a network file system remembers what was there.
const SEEN: Duration = Duration::from_secs(60);

/// Runs that a scheduler makes.
pub struct Crew<'a> {
    pub scheduler: Scheduler,
    pub jobs: &'a [Job],
    /// What each run asks for.
    pub needs: &'a [Needs],
    pub program: &'a Program,
    /// Options of the command that submits.
    pub options: &'a [String],
    /// Elements of an array that run at a time; 0: as many as the scheduler likes.
    pub parallel: usize,
    pub force: bool,
    pub progress: &'a Progress,
}

/// What a call knows of a run.
#[derive(Clone, Debug, Default)]
struct Watch {
    /// Folder of the run, absolute.
    out: PathBuf,
    outcome: Option<Outcome>,
    /// Whether an array with the run was in the queue during this call.
    seen: bool,
    /// When the run was first found neither in the queue nor done, since it was seen last.
    gone: Option<Instant>,
}

impl Crew<'_> {
    /// Submits what is left of the runs, and waits until each has an outcome or this process is asked to stop; arrays stay in the queue
    /// then. `folder` is that of the campaign.
    ///
    /// # Errors
    /// No scheduler, one that does not answer at the start or refuses all runs; files that cannot be written.
    pub fn run(&self, folder: &Path) -> Result<Vec<Outcome>> {
        self.scheduler.here()?;
        if self.parallel > 0 && self.scheduler == Scheduler::HyperQueue {
            host::warn("--jobs is not kept: HyperQueue starts as many runs as its workers have room for");
        }
        let dir = absolute(folder)?.join(self.scheduler.word());
        std::fs::create_dir_all(&dir).map_err(Error::write(&dir))?;
        let watch = |job: &Job| Ok(Watch { out: absolute(&job.out)?, ..Watch::default() });
        let mut runs: Vec<Watch> = self.jobs.iter().map(watch).collect::<Result<_>>()?;
        let mut told = BTreeSet::new();
        let mut pause = LOOKS[0];
        let mut last = None;
        while !stop_asked() {
            let now = self.look(&dir, &mut runs, &mut told, last.is_none())?;
            if runs.iter().all(|run| run.outcome.is_some()) {
                break;
            }
            let gone = runs.iter().any(|run| run.outcome.is_none() && run.gone.is_some());
            pause = if last == Some(now) && !gone { (pause * 3 / 2).min(LOOKS[1]) } else { LOOKS[0] };
            last = Some(now);
            let until = Instant::now() + pause;
            while Instant::now() < until && !stop_asked() {
                std::thread::sleep(Duration::from_millis(50));
            }
        }
        self.leave(&dir, &runs);
        Ok(runs.into_iter().map(|run| run.outcome.unwrap_or(Outcome::Stopped)).collect())
    }

    /// Looks at the queue and at the folders once, submits what has to be, and gives the numbers of runs with an outcome, in the queue and
    /// running. One call at a time does so. What was said once, in `told`, is not said again.
    fn look(&self, dir: &Path, runs: &mut [Watch], told: &mut BTreeSet<String>, first: bool) -> Result<[usize; 3]> {
        let _alone = Hold::wait_for_file(&dir.join(LOCK))?;
        let arrays = array::all(dir)?;
        let open: BTreeSet<&Path> = runs.iter().filter(|run| run.outcome.is_none()).map(|run| run.out.as_path()).collect();
        let of_ours = arrays.iter().filter(|array| array.told.runs.iter().any(|run| open.contains(run.as_path())));
        let names: Vec<&str> = of_ours.map(|array| array.told.name.as_str()).collect();
        let entries = match self.scheduler.entries(&names) {
            Ok(entries) => Some(entries),
            Err(words) if first => {
                return Err(Error::input(
                    self.scheduler.asks(),
                    "",
                    None,
                    format!("does not answer: {words}; nothing was submitted"),
                ));
            }
            Err(words) => {
                let asked = self.scheduler.asks();
                warn_once(told, format!("{asked} does not answer: {words}; it is asked again, and what is in the queue goes on"));
                None
            }
        };
        let (mut waiting, mut running, mut left, mut ended) = (0, 0, Vec::new(), Vec::new());
        for (i, run) in runs.iter_mut().enumerate().filter(|(_, run)| run.outcome.is_none()) {
            let entry = entries.as_ref().and_then(|entries| in_queue(&arrays, entries, &run.out));
            if let Some(entry) = entry {
                (run.seen, run.gone) = (true, None);
                *(if entry.runs() { &mut running } else { &mut waiting }) += 1;
                if let Some(why) = entry.held() {
                    warn_once(told, format!("runs wait in {}'s queue: {why}", self.scheduler.name()));
                }
                continue;
            }
            let job = &self.jobs[i];
            let broken = |e: Error| Judged::Ended(Outcome::failed(e.to_string(), job.log(), true));
            match self.judge(job, run, &arrays, entries.as_ref()).unwrap_or_else(broken) {
                Judged::Ended(outcome) => {
                    ended.push(i);
                    run.outcome = Some(outcome);
                }
                Judged::Waits => running += usize::from(run.seen),
                Judged::Left => left.push(i),
            }
        }
        let in_queue = waiting + running > 0;
        waiting += self.submit(dir, runs, &left, (told, in_queue))?;
        self.progress.update(Change::Queue { running, waiting });
        ended.into_iter().filter_map(|i| runs[i].outcome.as_ref()).for_each(|outcome| self.progress.count(outcome));
        Ok([runs.iter().filter(|run| run.outcome.is_some()).count(), waiting, running])
    }

    /// What has become of a run that is not in the queue. `entries`: what the queue says of ended elements; `None` where it does not answer.
    fn judge(&self, job: &Job, run: &mut Watch, arrays: &[Array], entries: Option<&Entries>) -> Result<Judged> {
        match job.found()? {
            Found::Finished(summary) => {
                remove_if_empty(&job.log());
                return Ok(Judged::Ended(Outcome::Done { summary, before: !run.seen }));
            }
            // by another call, or on a node that the queue has given up
            Found::Busy => return Ok(Judged::Waits),
            Found::Other(what) if !self.force => return Err(Error::Other { path: job.out.clone(), what }),
            _ => {}
        }
        let Some(entries) = entries else { return Ok(Judged::Waits) };
        let last = arrays.iter().rev().find_map(|array| Some((array, array.element(&run.out)?)));
        let (true, Some((array, element))) = (run.seen, last) else { return Ok(Judged::Left) };
        // the queue was asked before the folder was looked at, but not before the run could end
        let Some(gone) = run.gone else {
            run.gone = Some(Instant::now());
            return Ok(Judged::Waits);
        };
        let entry = entries.get(&(array.told.name.clone(), element));
        let state = entry.map(|entry| entry.state.as_str());
        if matches!(state, None | Some("COMPLETED")) && gone.elapsed() < SEEN {
            return Ok(Judged::Waits);
        }
        // what was taken away from a run that got further is given again
        if taken_away(state, array.code(element)) && got_further(&run.out, array) {
            run.gone = None;
            return Ok(Judged::Left);
        }
        Ok(Judged::Ended(failed(self.scheduler, job, array, element, state)))
    }

    /// Submits these runs, as one array for all that ask for the same, and gives their number; where it is refused, they are submitted at
    /// a later look if other runs are in the queue, else they have failed.
    fn submit(&self, dir: &Path, runs: &mut [Watch], left: &[usize], (told, mut in_queue): Told<'_>) -> Result<usize> {
        let mut same: Vec<usize> = left.to_vec();
        // stable: runs stay in their order
        same.sort_by_key(|&i| self.needs[i]);
        let mut submitted = 0;
        let most = if left.is_empty() { 1 } else { self.scheduler.most() };
        for some in same.chunk_by(|&a, &b| self.needs[a] == self.needs[b]).flat_map(|all| all.chunks(most)) {
            match self.array(dir, runs, some) {
                Ok(()) => {
                    for &i in some {
                        (runs[i].seen, runs[i].gone) = (true, None);
                    }
                    submitted += some.len();
                    in_queue = true;
                }
                Err(e) if in_queue => warn_once(told, format!("{e}; they are submitted again when others have ended")),
                Err(e) if runs.iter().all(|run| run.outcome.is_none()) => return Err(e),
                Err(e) => {
                    for &i in some {
                        let outcome = Outcome::Failed { reason: e.to_string(), log: dir.into(), outside: true };
                        self.progress.count(&outcome);
                        runs[i].outcome = Some(outcome);
                    }
                }
            }
        }
        Ok(submitted)
    }

    /// Submits an array of these runs, which ask for the same.
    fn array(&self, dir: &Path, runs: &[Watch], some: &[usize]) -> Result<()> {
        let Some(&first) = some.first() else { return Ok(()) };
        let element = |&i: &usize| {
            let job = &self.jobs[i];
            let line = line(self.program, job, self.needs[i].threads, self.force);
            Element { line, out: runs[i].out.clone(), log: job.log() }
        };
        for &i in some {
            let folder = runs[i].out.parent().unwrap_or(dir);
            std::fs::create_dir_all(folder).map_err(Error::write(folder))?;
        }
        let cwd = std::env::current_dir().map_err(Error::read("the working directory"))?;
        let mut array = Array::write(dir, &some.iter().map(element).collect::<Vec<_>>(), &cwd)?;
        match self.scheduler.submit(&array, some.len(), self.needs[first], self.parallel, self.options) {
            Ok(job) => {
                let name = self.scheduler.name();
                self.progress.tell(&format!("{} of {} runs submitted to {name} as job {job}", some.len(), runs.len()));
                array.submitted(job)
            }
            Err(e) => {
                array.remove();
                Err(e)
            }
        }
    }

    /// Says what stays in the queue, if this process was asked to stop; files of runs that are done and say nothing go.
    fn leave(&self, dir: &Path, runs: &[Watch]) {
        let arrays = array::all(dir).unwrap_or_default();
        let mut jobs = BTreeSet::new();
        for run in runs.iter().filter(|run| run.seen) {
            let mut with = arrays.iter().rev().filter_map(|array| Some((array, array.element(&run.out)?)));
            match &run.outcome {
                Some(Outcome::Done { .. }) => with.for_each(|(array, element)| remove_if_empty(&array.said(element))),
                None => jobs.extend(with.next().and_then(|(array, _)| array.told.job.clone())),
                _ => {}
            }
        }
        if !jobs.is_empty() {
            let jobs = jobs.into_iter().collect::<Vec<_>>().join(" ");
            let (name, cancels) = (self.scheduler.name(), self.scheduler.cancels());
            host::warn(&format!("what is left of the runs stays in {name}'s queue; out of it takes them: {cancels} {jobs}"));
        }
    }
}

/// What was told before, and whether runs of the campaign are in the queue.
type Told<'a> = (&'a mut BTreeSet<String>, bool);

/// What a look finds of a run that is not in the queue.
enum Judged {
    Ended(Outcome),
    /// It is to be looked at again.
    Waits,
    /// It is to be submitted.
    Left,
}

/// The element that is in the queue for the run in the folder `out`.
fn in_queue<'a>(arrays: &[Array], entries: &'a Entries, out: &Path) -> Option<&'a Entry> {
    let of = |array: &Array| entries.get(&(array.told.name.clone(), array.element(out)?)).filter(|entry| !entry.ended());
    arrays.iter().rev().find_map(of)
}

/// Whether an element has ended because it lost its place: its time was over, its node failed or was wanted, or the run was told to stop by
/// somebody who did not cancel it, as by a node that shuts down.
fn taken_away(state: Option<&str>, code: Option<i32>) -> bool {
    match state {
        Some("TIMEOUT" | "PREEMPTED" | "NODE_FAIL" | "BOOT_FAIL") => true,
        Some("FAILED") => matches!(code, Some(STOPPED | TERMINATED)),
        _ => false,
    }
}

/// Exit code of a run that was told to stop.
const STOPPED: i32 = 130;
/// That of a shell whose run the same signal (SIGTERM) ended before it listened to signals.
const TERMINATED: i32 = 128 + 15;

/// Whether a run has written a checkpoint since the array was submitted.
fn got_further(out: &Path, array: &Array) -> bool {
    matches!((last_checkpoint(out), array.since()), (Some(written), Some(since)) if written > since)
}

/// Outcome of an element that has ended without a finished run. `state`: what the queue says, where it still knows.
fn failed(scheduler: Scheduler, job: &Job, array: &Array, element: usize, state: Option<&str>) -> Outcome {
    let text = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
    let (said, of_queue, code) = (text(&job.log()), text(&array.said(element)), array.code(element));
    let number = array.told.job.as_deref().unwrap_or("?");
    let last = |text: &str| text.lines().last().map(|line| format!(": {line}"));
    let how = match (state, code) {
        (Some("COMPLETED"), _) | (None, Some(0)) => "ended without a summary".into(),
        (Some("FAILED") | None, Some(code)) => format!("ended with exit code {code}"),
        (Some(state), _) => format!("ended as {state}"),
        (None, None) => "has left the queue".into(),
    };
    let before = if code.is_none() && said.is_empty() && of_queue.is_empty() { " before it wrote anything" } else { "" };
    let words = last(&of_queue).or_else(|| last(&said)).unwrap_or_default();
    let own = own_words(&said);
    let reason = match (&own, state) {
        (Some(own), Some("FAILED") | None) => own.clone(),
        _ => format!("element {element} of {}'s job {number} {how}{before}{words}; called again, it goes on", scheduler.name()),
    };
    let to_blame = matches!(code, Some(1..=3)) && own.is_some() || code == Some(PANIC);
    let log = if said.is_empty() { array.said(element) } else { job.log() };
    Outcome::failed(reason, log, !to_blame)
}

fn warn_once(told: &mut BTreeSet<String>, text: String) {
    if told.insert(text.clone()) {
        host::warn(&text);
    }
}

fn remove_if_empty(path: &Path) {
    if path.metadata().is_ok_and(|m| m.len() == 0) {
        let _ = std::fs::remove_file(path);
    }
}

fn absolute(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).map_err(Error::read(path))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An array of two runs, submitted as job 17.
    fn array(dir: &Path) -> (Job, Array) {
        let job = Job::new("scene.toml", dir.join("seed-2"));
        let element = |n: u32| Element { line: "true".into(), out: dir.join(format!("seed-{n}")), log: job.log() };
        let mut array = Array::write(dir, &[element(1), element(2)], dir).expect("written");
        array.submitted("17".into()).expect("written");
        (job, array)
    }

    #[test]
    fn an_element_that_ends_is_told_by_name_and_the_scene_is_to_blame_for_its_own_errors_alone() {
        let dir = tempfile::tempdir().expect("folder");
        let (job, array) = array(dir.path());
        let told = |state| match failed(Scheduler::Slurm, &job, &array, 2, state) {
            Outcome::Failed { reason, log, outside } => (reason, log, outside),
            other => panic!("{other:?}"),
        };
        let (reason, log, outside) = told(None);
        assert_eq!(reason, "element 2 of Slurm's job 17 has left the queue before it wrote anything; called again, it goes on");
        assert!(outside && log == array.said(2));
        std::fs::write(array.said(2), "prolog\nslurmstepd: error: Detected 1 oom-kill event\n").expect("written");
        let (reason, _, outside) = told(Some("OUT_OF_MEMORY"));
        assert!(reason.contains("job 17 ended as OUT_OF_MEMORY: slurmstepd: error: Detected 1 oom-kill event; called"), "{reason}");
        assert!(outside);
        std::fs::write(array.said(2), "").expect("written");
        std::fs::write(job.log(), "error: step 3: it stood still\nadvice\n").expect("written");
        std::fs::write(array.folder.join("2.code"), "3\n").expect("written");
        for state in [Some("FAILED"), None] {
            assert_eq!(told(state), ("step 3: it stood still".into(), job.log(), false));
        }
        std::fs::write(job.log(), "error: a.csv: cannot write: no space\n").expect("written");
        assert!(told(Some("FAILED")).2, "a full disk");
        std::fs::write(job.log(), "sh: comminute: not found\n").expect("written");
        std::fs::write(array.folder.join("2.code"), "127\n").expect("written");
        let (reason, _, outside) = told(Some("FAILED"));
        assert!(outside && reason.contains("ended with exit code 127: sh: comminute: not found"), "{reason}");
    }

    #[test]
    fn what_is_taken_away_is_given_again_where_the_run_got_further() {
        for (state, code, again) in [
            (Some("TIMEOUT"), Some(130), true),
            (Some("NODE_FAIL"), None, true),
            (Some("FAILED"), Some(130), true),
            (Some("FAILED"), Some(143), true),
            (Some("CANCELLED"), Some(130), false),
            (Some("FAILED"), Some(3), false),
            (Some("FAILED"), Some(137), false),
            (Some("OUT_OF_MEMORY"), None, false),
            (None, Some(130), false),
        ] {
            assert_eq!(taken_away(state, code), again, "{state:?} {code:?}");
        }
        let dir = tempfile::tempdir().expect("folder");
        let (job, array) = array(dir.path());
        std::fs::create_dir(&job.out).expect("folder");
        assert!(!got_further(&job.out, &array), "no checkpoint");
        let checkpoint = std::fs::File::create(job.out.join("checkpoint.bin")).expect("written");
        let submitted = array.since().expect("submitted");
        for (seconds, further) in [(-1.0, false), (1.0, true)] {
            let offset = Duration::from_secs_f64(f64::abs(seconds));
            let when = if seconds < 0.0 { submitted - offset } else { submitted + offset };
            checkpoint.set_modified(when).expect("a time");
            assert_eq!(got_further(&job.out, &array), further);
        }
    }
}
