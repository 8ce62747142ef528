//! Work that takes seconds, and that Ctrl-C ends.
//!
//! The work is done on threads of its own and owns what it needs. The calling thread waits with the
//! interpreter's lock released, and looks for signals meanwhile, which Python handles in its main
//! thread alone. When a handler raises, the call ends at once; the work is told, ends at its next
//! step, and nobody gets its result.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use uvgraft_pipeline::{Event, Observer, Result};

use crate::error::{failed, of_pipeline, warn_caller, with_names};
use crate::threads::{self, LentPool};

/// How often signals are looked for.
const POLL: Duration = Duration::from_millis(50);

/// What work came to, and what it assumed.
pub(crate) struct Finished<T> {
    pub(crate) result: T,
    pub(crate) notes: Vec<String>,
}

/// What work says meanwhile, and whether it is to end.
#[derive(Default)]
pub(crate) struct Log {
    is_cancelled: AtomicBool,
    said: Mutex<Said>,
}

#[derive(Default)]
struct Said {
    notes: Vec<String>,
    warnings: Vec<String>,
}

impl Log {
    /// What was warned of.
    pub(crate) fn warnings(self) -> Vec<String> {
        self.said.into_inner().unwrap_or_else(PoisonError::into_inner).warnings
    }
}

impl Observer for Log {
    fn event(&self, event: Event<'_>) {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Event::Note(text) => said.notes.push(with_names(text)),
            Event::Warning(text) => said.warnings.push(with_names(text)),
            _ => {}
        }
    }

    fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }
}

/// Does a request's work on a pool of threads, and warns of what it warns of.
///
/// - `threads`: the size of the pool; `None` for the default, 0 for one thread per processor.
///
/// # Errors
/// As the failure says, also after warnings; what a signal handler raises; and a warning, where
/// warnings are to be raised.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce(&dyn Observer) -> Result<T> + Send + 'static,
) -> PyResult<Finished<T>> {
    let lent = LentPool::new(py, threads)?;
    let log = Arc::new(Log::default());
    let (done, outcome) = mpsc::sync_channel(1);
    let of_work = Arc::clone(&log);
    lent.pool().spawn(move || {
        let outcome = threads::caught(|| work(&*of_work));
        // After an interruption nobody waits for it.
        let _ = done.send(outcome);
    });
    let waited = py.detach(move || {
        loop {
            match outcome.recv_timeout(POLL) {
                Ok(outcome) => return Ok(outcome),
                Err(RecvTimeoutError::Disconnected) => return Err(failed("the work has ended")),
                // No handler is called once the interpreter ends.
                Err(RecvTimeoutError::Timeout) => {
                    #[expect(
                        clippy::redundant_closure_for_method_calls,
                        reason = "the method itself is not one of any lifetime"
                    )]
                    Python::try_attach(|py| py.check_signals()).transpose()?;
                }
            }
        }
    });
    let outcome = waited.inspect_err(|_| log.is_cancelled.store(true, Ordering::Relaxed))?;
    lent.give_back(py);
    let said = std::mem::take(&mut *log.said.lock().unwrap_or_else(PoisonError::into_inner));
    warn_caller(py, said.warnings)?;
    let result = outcome?.map_err(of_pipeline)?;
    Ok(Finished { result, notes: said.notes })
}
