//! Progress while a run goes on: on standard error, as a bar on a terminal, else a line every 15 seconds; or to the host of the run.

use super::{Activity, Progress};
use crate::host::{self, Host};
use crate::model::{Model, Rig};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Seconds between plain lines when standard error is no terminal, and before the first sign of life.
const PLAIN: Duration = Duration::from_secs(15);
const FIRST: Duration = Duration::from_secs(2);
const REDRAW: Duration = Duration::from_millis(150);

pub struct Bar {
    /// `None` when quiet, or where a host is told.
    bar: Option<ProgressBar>,
    /// The host of the run, which is told instead.
    host: Option<Arc<Host>>,
    terminal: bool,
    begun: Instant,
    last: Instant,
    last_steps: u64,
}

impl Bar {
    pub fn new(quiet: bool) -> Bar {
        let terminal = std::io::stderr().is_terminal();
        let host = host::current();
        let bar = (!quiet && host.is_none()).then(|| {
            let bar = ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::hidden());
            bar.set_style(
                ProgressStyle::with_template("{bar:24} {percent:>3}% {msg}").unwrap_or_else(|_| ProgressStyle::default_bar()),
            );
            bar
        });
        let now = Instant::now();
        Bar { bar, host, terminal, begun: now, last: now, last_steps: 0 }
    }

    pub fn show(&mut self, model: &Model, p: &Progress) {
        if !self.due() {
            return;
        }
        let since = self.last.elapsed();
        let speed = (p.steps - self.last_steps) as f64 / since.as_secs_f64();
        self.last_steps = p.steps;
        let (share, message) = describe(model, p);
        let elapsed = self.begun.elapsed().as_secs_f64();
        let mut line = format!("{message}  {speed:.0} steps/s");
        if elapsed > 10.0 && share > 0.02 && share < 1.0 && !matches!(p.activity, Activity::Preparing(_)) {
            line += &format!("  about {} left", human(p.loading_seconds * (1.0 - share) / share));
        }
        self.draw(share, line);
    }

    /// Shows the share of the run that is done and a line about it, both from `describe`, and the time left after `seconds` of
    /// work.
    pub fn show_share(&mut self, steps: u64, seconds: f64, describe: impl FnOnce() -> (f64, String)) {
        if !self.due() {
            return;
        }
        let speed = (steps - self.last_steps) as f64 / self.last.elapsed().as_secs_f64();
        self.last_steps = steps;
        let (share, mut line) = describe();
        line += &format!("  {speed:.0} steps/s");
        if seconds > 10.0 && share > 0.02 && share < 1.0 {
            line += &format!("  about {} left", human(seconds * (1.0 - share) / share));
        }
        self.draw(share, line);
    }

    /// Shows that `done` of `count` things, named by `what`, are done.
    pub fn show_count(&mut self, done: usize, count: usize, what: &str) {
        if self.due() {
            self.draw(done as f64 / count.max(1) as f64, format!("{done} of {count} {what}"));
        }
    }

    /// Whether something is to be shown now.
    fn due(&self) -> bool {
        if self.host.is_some() {
            return self.last.elapsed() >= REDRAW;
        }
        let pause = if self.terminal { REDRAW } else { PLAIN };
        self.bar.is_some() && self.last.elapsed() >= pause && self.begun.elapsed() >= FIRST
    }

    fn draw(&mut self, share: f64, line: String) {
        self.last = Instant::now();
        if let Some(host) = &self.host {
            host.show(share, line);
            return;
        }
        let Some(bar) = &self.bar else { return };
        if self.terminal {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.set_position((share * 1000.0) as u64);
            bar.set_message(line);
        } else {
            eprintln!("{:>3.0}%  {line}", share * 100.0);
        }
    }

    /// A warning while the run goes on; nothing when quiet.
    pub fn warn(&self, text: &str) {
        if let Some(host) = &self.host {
            host.warn(text.into());
        }
        if let Some(bar) = &self.bar {
            bar.suspend(|| eprintln!("warning: {text}"));
        }
    }

    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Bar {
    /// A run that ends with an error leaves the bar on the screen as it was.
    fn drop(&mut self) {
        if let Some(bar) = self.bar.as_ref().filter(|bar| !bar.is_finished()) {
            bar.abandon();
        }
    }
}

/// Share of the run that is done, and a line about its present stage.
fn describe(model: &Model, p: &Progress) -> (f64, String) {
    let n = p.state.grains.len();
    match (&p.activity, &model.rig) {
        (Activity::Preparing(prep), rig) => {
            let most = rig.specimen().map_or(1, |s| s.preparation.max_steps);
            let share = p.steps as f64 / most as f64;
            let porosity = crate::rig::preparation::porosity(&p.state);
            (share, format!("preparing ({}), porosity {porosity:.4}, {n} grains", prep.stage()))
        }
        (Activity::Testing(test), rig) => test.describe(rig, &p.state),
        (_, Rig::Assembly(rig)) => {
            let share = match (rig.steps, rig.duration) {
                (Some(steps), _) => p.state.step as f64 / steps.max(1) as f64,
                (None, Some(t)) => p.state.time / t,
                (None, None) => 0.0,
            };
            (share, format!("t = {:.4e} s, {n} grains, {} events", p.state.time, p.state.crush_events))
        }
        _ => (0.0, String::new()),
    }
}

/// A time in seconds as a person reads it: `3.2 s`, `40 s`, `12 min`, `2.5 h`.
pub fn human(seconds: f64) -> String {
    match seconds {
        s if s < 9.5 => format!("{s:.1} s"),
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
