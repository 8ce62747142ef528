//! Threads that may fail to start, and points at which tests disturb the schedule.

use std::any::Any;
use std::sync::mpsc::sync_channel;
use std::thread::{Builder, Scope, ScopedJoinHandle};

use crate::failure::Failure;
#[cfg(feature = "threads")]
use crate::failure::{Blame, Context};

/// Starts a thread that works on `state`; returns the state if there are no more threads, for the
/// caller to work on it itself.
///
/// The thread returns `None` only if it never got the state.
pub(crate) fn spawn_with<'scope, S: Send + 'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    state: S,
    work: impl FnOnce(S) -> T + Send + 'scope,
) -> Result<ScopedJoinHandle<'scope, Option<T>>, S> {
    // A closure that could not be started is dropped with all that it owns.
    let (sender, receiver) = sync_channel::<S>(1);
    let started = start(scope, move || receiver.recv().ok().map(work));
    match started {
        Some(handle) => match sender.send(state) {
            Ok(()) => Ok(handle),
            Err(unsent) => Err(unsent.0),
        },
        None => Err(state),
    }
}

/// Starts a thread; `None` if there are no more.
pub(crate) fn start<'scope, T: Send + 'scope>(
    scope: &'scope Scope<'scope, '_>,
    work: impl FnOnce() -> T + Send + 'scope,
) -> Option<ScopedJoinHandle<'scope, T>> {
    if cfg!(not(feature = "threads")) || disturbance::keeps_threads_from_starting() {
        return None;
    }
    Builder::new().spawn_scoped(scope, work).ok()
}

/// A pool of threads, the calling thread among them; of it alone if no others start.
#[cfg(feature = "threads")]
pub(crate) fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    let pool =
        |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build();
    pool(threads).or_else(|_| pool(1)).or_work().context("cannot start threads")
}

/// The calling thread alone.
#[cfg(not(feature = "threads"))]
pub(crate) struct CallingThread;

#[cfg(not(feature = "threads"))]
impl CallingThread {
    pub(crate) fn install<T>(&self, work: impl FnOnce() -> T) -> T {
        work()
    }
}

#[cfg(not(feature = "threads"))]
pub(crate) fn pool(_threads: usize) -> Result<CallingThread, Failure> {
    Ok(CallingThread)
}

/// The message of a panic.
pub(crate) fn text_of(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("panic")
}

/// A point between steps of threads that wait for each other.
pub(crate) fn point() {
    disturbance::point();
}

#[cfg(not(test))]
mod disturbance {
    pub(super) const fn keeps_threads_from_starting() -> bool {
        false
    }

    pub(super) const fn point() {}
}

/// In tests, threads pause at random, and some do not start.
#[cfg(test)]
pub(crate) mod disturbance {
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::time::Duration;

    /// The state of the generator; 0 for none.
    static STATE: AtomicU64 = AtomicU64::new(0);

    /// Begins to disturb all threads of the process.
    pub(crate) fn begin(seed: u64) {
        STATE.store(seed | 1, Ordering::Relaxed);
    }

    pub(crate) fn end() {
        STATE.store(0, Ordering::Relaxed);
    }

    fn next() -> Option<u64> {
        let before = STATE.load(Ordering::Relaxed);
        // SplitMix64; threads that take the same state do no harm.
        let state = before.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (before != 0).then(|| {
            STATE.store(state.max(1), Ordering::Relaxed);
            let mixed = (state ^ state >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            (mixed ^ mixed >> 27).wrapping_mul(0x94d0_49bb_1331_11eb) >> 16
        })
    }

    pub(super) fn keeps_threads_from_starting() -> bool {
        next().is_some_and(|random| random % 4 == 0)
    }

    pub(super) fn point() {
        match next().map(|random| (random % 8, random >> 8 & 255)) {
            Some((0..4, _)) => std::thread::yield_now(),
            Some((4, micros)) => std::thread::sleep(Duration::from_micros(micros)),
            _ => {}
        }
    }
}
