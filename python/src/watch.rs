//! Work of the library beside the interpreter, which stays free for other threads and for Ctrl-C.

use crate::error::exception;
use comminute::Error;
use comminute::host::{Host, within};
use comminute::run::Word;
use pyo3::prelude::*;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// Time between two looks at signals and progress.
const LOOK: Duration = Duration::from_millis(50);

/// Does `job` on a thread of its own and waits for it without the interpreter's lock. `tell(kind, share, text)` is called with what the job
/// shows: `progress` with the share that is done, `note` and `warning`. Where a signal (Ctrl-C) or `tell` raises an exception the job is
/// asked to stop, keeps its data as the command does, and the exception is passed on.
pub fn watched<T: Send>(
    py: Python<'_>,
    tell: Option<&Py<PyAny>>,
    job: impl FnOnce(&mut dyn FnMut(Word)) -> comminute::Result<T> + Send,
) -> PyResult<T> {
    let host = Arc::new(Host::default());
    let words = Mutex::new(Vec::new());
    let (done, ended) = channel::<()>();
    let ended = Mutex::new(ended);
    std::thread::scope(|scope| {
        let (inner, words) = (host.clone(), &words);
        let worker = scope.spawn(move || {
            // whoever waits hears of the end by this being dropped, after a panic as well
            let _done = done;
            let mut say = |word| words.lock().unwrap_or_else(PoisonError::into_inner).push(word);
            within(Some(inner), || job(&mut say))
        });
        let look = || {
            py.check_signals()?;
            let said = std::mem::take(&mut *words.lock().unwrap_or_else(PoisonError::into_inner));
            let Some(tell) = tell else { return Ok(()) };
            for word in said {
                match word {
                    Word::Note(text) => tell.call1(py, ("note", 0.0, text))?,
                    Word::Warning(text) => tell.call1(py, ("warning", 0.0, text))?,
                };
            }
            for text in host.warnings() {
                tell.call1(py, ("warning", 0.0, text))?;
            }
            if let Some((share, text)) = host.shown() {
                tell.call1(py, ("progress", share, text))?;
            }
            PyResult::Ok(())
        };
        let mut refused = None;
        loop {
            let over = py.detach(|| {
                let ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
                !matches!(ended.recv_timeout(LOOK), Err(RecvTimeoutError::Timeout))
            });
            if refused.is_none()
                && let Err(exception) = look()
            {
                host.ask_to_stop();
                refused = Some(exception);
            }
            if over {
                break;
            }
        }
        let outcome = match py.detach(|| worker.join()) {
            Ok(outcome) => outcome,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        match (outcome, refused) {
            (Ok(outcome), None) => Ok(outcome),
            (Err(error), None) => Err(exception(py, &error)),
            (outcome, Some(refused)) => {
                if let Err(error @ Error::Interrupted { .. }) = outcome {
                    refused
                        .value(py)
                        .call_method1("add_note", (format!("{error}; comminute.resume(folder) goes on from there"),))?;
                }
                Err(refused)
            }
        }
    })
}
