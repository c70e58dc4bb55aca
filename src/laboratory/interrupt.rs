//! The wish of a user to stop: Ctrl-C and SIGTERM.

use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by Ctrl-C (and SIGTERM): the run stops at the next step, everything kept.
static STOP: AtomicBool = AtomicBool::new(false);

/// Takes Ctrl-C and SIGTERM as a wish to stop, which [`stop_asked`] tells.
pub fn listen() {
    static ONCE: Once = Once::new();
    // a second handler cannot be installed; a library user who has one keeps it
    ONCE.call_once(|| {
        let _ = ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed));
    });
}

/// Whether Ctrl-C or SIGTERM has come since [`listen`].
pub fn stop_asked() -> bool {
    STOP.load(Ordering::Relaxed)
}
