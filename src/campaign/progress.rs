//! The line that shows the progress of a campaign.

use super::runner::Outcome;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use laboratory::host::{self, Host};
use std::io::IsTerminal;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Number of runs in each state.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    /// Runs that were finished before this call.
    before: usize,
    done: usize,
    failed: usize,
    running: usize,
    waiting: usize,
    /// In the queue of a scheduler.
    queued: usize,
}

pub struct Progress {
    /// `None` when quiet.
    bar: Option<ProgressBar>,
    /// The host of the campaign, which is told as well.
    host: Option<Arc<Host>>,
    terminal: bool,
    of: usize,
    begun: Instant,
    counts: Mutex<Counts>,
}

/// A change in the state of one run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The run was finished before, by this campaign or another one.
    DoneBefore,
    /// A process for the run begins, and has ended.
    Starts,
    Ends,
    /// Another process is working on the run.
    Waits,
    WaitsNoMore,
    /// So many runs are made by a scheduler, and so many wait in its queue.
    Queue {
        running: usize,
        waiting: usize,
    },
    Done,
    Failed,
}

impl Progress {
    pub fn new(of: usize, quiet: bool) -> Progress {
        let terminal = std::io::stderr().is_terminal();
        let bar = (!quiet).then(|| {
            let target = if terminal { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
            let bar = ProgressBar::with_draw_target(Some(of as u64), target);
            let style = ProgressStyle::with_template("{bar:24} {msg}  {elapsed}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar.enable_steady_tick(Duration::from_secs(1));
            bar
        });
        Progress { bar, host: host::current(), terminal, of, begun: Instant::now(), counts: Mutex::default() }
    }

    pub fn update(&self, change: Change) {
        // after a panic of another worker the counts are still good enough to show
        let mut c = self.counts.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        match change {
            Change::DoneBefore => c.before += 1,
            Change::Starts => c.running += 1,
            Change::Ends => c.running -= 1,
            Change::Waits => c.waiting += 1,
            Change::WaitsNoMore => c.waiting -= 1,
            Change::Queue { running, waiting } => (c.running, c.queued) = (running, waiting),
            Change::Done => c.done += 1,
            Change::Failed => c.failed += 1,
        }
        if let Some(host) = &self.host {
            host.show((c.before + c.done + c.failed) as f64 / self.of.max(1) as f64, self.line(&c));
        }
        let Some(bar) = &self.bar else { return };
        let line = self.line(&c);
        bar.set_position((c.before + c.done + c.failed) as u64);
        if !self.terminal && matches!(change, Change::Done | Change::Failed | Change::Waits) {
            eprintln!("{line}");
        }
        bar.set_message(line);
    }

    /// Counts how a run has ended.
    pub fn count(&self, outcome: &Outcome) {
        match outcome {
            Outcome::Done { before: true, .. } => self.update(Change::DoneBefore),
            Outcome::Done { .. } => self.update(Change::Done),
            Outcome::Failed { .. } => self.update(Change::Failed),
            Outcome::Stopped => {}
        }
    }

    /// Says something of the campaign, unless quiet.
    pub fn tell(&self, text: &str) {
        match &self.bar {
            Some(bar) if self.terminal => bar.println(text),
            Some(_) => eprintln!("{text}"),
            None => {}
        }
    }

    fn line(&self, c: &Counts) -> String {
        let mut line = format!("{} of {} done", c.before + c.done, self.of);
        for (count, what) in
            [(c.running, "running"), (c.queued, "in the queue"), (c.failed, "failed"), (c.waiting, "waiting for another process")]
        {
            if count > 0 {
                line += &format!(", {count} {what}");
            }
        }
        let left = self.of - c.before - c.done - c.failed;
        let ended = c.done + c.failed;
        if ended > 0 && left > 0 {
            let seconds = self.begun.elapsed().as_secs_f64() * left as f64 / ended as f64;
            line += &format!(", about {} left", laboratory::run::human(seconds));
        }
        line
    }

    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
