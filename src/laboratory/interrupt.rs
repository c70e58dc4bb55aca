//! A user's wish to stop the program: Ctrl-C and SIGTERM set a flag that the loops of runs read.

use crate::host;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C and SIGTERM.
static STOP: AtomicBool = AtomicBool::new(false);

/// Installs a handler for Ctrl-C and SIGTERM that sets the flag of [`stop_asked`]. A handler that the program has installed
/// before stays; the flag is then never set. Within a [`host`], which answers signals by itself, no handler is installed.
pub fn listen() {
    static ONCE: Once = Once::new();
    if host::current().is_some() {
        return;
    }
    // an error means that the program has a handler of its own
    ONCE.call_once(|| {
        let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));
    });
}

/// Lets a write beyond the size that files may have (`ulimit -f`) fail with an error, as on a full disk, where the system would end
/// the program without a word. For this thread and those that it starts from now on; programs that it starts are not affected.
pub fn outlive_size_limit() {
    #[cfg(unix)]
    {
        use nix::sys::signal::{SigSet, Signal};
        let mut signals = SigSet::empty();
        signals.add(Signal::SIGXFSZ);
        // an error cannot be: the set holds a signal that there is
        let _ = signals.thread_block();
    }
}

/// Whether Ctrl-C or SIGTERM has arrived since [`listen`], or the [`host`] of this thread has asked to stop. A run then writes its checkpoint and stops at the next step.
pub fn stop_asked() -> bool {
    STOP.load(Ordering::Relaxed) || host::asks_to_stop()
}
