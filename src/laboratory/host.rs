//! The program in which a run is made, where that is not the command: it can ask the run to stop, and is told how far the run is.
//! The command needs none: its runs read the flag of Ctrl-C and draw on standard error.

use std::cell::RefCell;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A program that makes runs inside itself and answers signals by itself. Runs made [`within`] it stop when it says so, install no
/// handler of signals, and leave their progress and warnings here instead of on standard error.
#[derive(Debug, Default)]
pub struct Host {
    stop: AtomicBool,
    shown: Mutex<Option<(f64, String)>>,
    warnings: Mutex<Vec<String>>,
}

thread_local! {
    /// The host of what this thread does.
    static HOST: RefCell<Option<Arc<Host>>> = const { RefCell::new(None) };
}

impl Host {
    /// Makes the run stop at its next step, as Ctrl-C stops the command's: with a checkpoint.
    pub fn ask_to_stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Whether [`Host::ask_to_stop`] has been called.
    pub fn stop_asked(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// The share of the run that is done, 0 to 1, and a line about its present stage; `None` where nothing new was shown since the
    /// last call.
    pub fn shown(&self) -> Option<(f64, String)> {
        held(&self.shown).take()
    }

    /// The warnings since the last call.
    pub fn warnings(&self) -> Vec<String> {
        std::mem::take(&mut *held(&self.warnings))
    }

    /// Tells the host the share that is done, 0 to 1, and a line about the present stage; what was told before and not asked for is forgotten.
    pub fn show(&self, share: f64, line: String) {
        *held(&self.shown) = Some((share, line));
    }

    pub(crate) fn warn(&self, text: String) {
        held(&self.warnings).push(text);
    }
}

/// A value that several threads use. One that panicked leaves it whole: it is replaced in one go.
fn held<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does `job` on this thread as a part of `host`; `None`: of no host. The threads of a run's pool belong to the host of the thread that
/// starts it.
pub fn within<T>(host: Option<Arc<Host>>, job: impl FnOnce() -> T) -> T {
    /// Puts back what was there before, after a panic as well.
    struct Before(Option<Arc<Host>>);
    impl Drop for Before {
        fn drop(&mut self) {
            enter(self.0.take());
        }
    }
    let _before = Before(enter(host));
    job()
}

/// Makes this thread a part of `host` until it ends or [`enter`] is called again; gives the host that it belonged to.
pub(crate) fn enter(host: Option<Arc<Host>>) -> Option<Arc<Host>> {
    HOST.with(|own| own.replace(host))
}

/// The host of what this thread does; `None`: the program is the command, or does not care.
pub fn current() -> Option<Arc<Host>> {
    HOST.with(|own| own.borrow().clone())
}

/// Whether the host of what this thread does has asked to stop.
pub(crate) fn asks_to_stop() -> bool {
    HOST.with(|own| own.borrow().as_ref().is_some_and(|host| host.stop_asked()))
}

/// Warns: the host, else on standard error.
pub fn warn(text: &str) {
    match current() {
        Some(host) => host.warn(text.into()),
        None => eprintln!("warning: {text}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interrupt::stop_asked;
    use crate::run::in_pool;

    /// Two hosts at once: each stops what is its own, on every thread of its pools, and nothing else.
    #[test]
    fn a_host_stops_what_is_made_within_it() {
        let [one, other] = [(); 2].map(|()| Arc::new(Host::default()));
        one.ask_to_stop();
        let asked = || in_pool(Some(3), || Ok(rayon::broadcast(|_| stop_asked()))).expect("a pool");
        assert_eq!(within(Some(one.clone()), asked), [true; 3]);
        assert_eq!(within(Some(other), asked), [false; 3]);
        assert!(!stop_asked() && current().is_none());
        let fell = std::panic::catch_unwind(|| within(Some(one), || panic!("a fault")));
        assert!(fell.is_err() && current().is_none());
    }

    #[test]
    fn a_host_is_told_each_thing_once() {
        let host = Arc::new(Host::default());
        within(Some(host.clone()), || warn("loose"));
        host.show(0.5, "half".into());
        assert_eq!(host.warnings(), ["loose"]);
        assert_eq!(host.shown(), Some((0.5, "half".into())));
        assert!(host.warnings().is_empty() && host.shown().is_none());
    }
}
