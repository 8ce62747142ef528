//! Calls that run on threads of their own.

use std::any::Any;
use std::sync::atomic::{AtomicUsize, Ordering};

use uvgraft::threads;

use crate::failure::{Failure, Result};
use crate::spawn::text_of;

/// Runs calls on threads of their own, and counts those in flight.
///
/// A caller's pool must not be used: while one of its threads waits for others, it takes up further
/// calls, and these may need the very graft that it is building. Threads that outlive a call would
/// be missing in a process forked from this one.
#[derive(Default)]
pub(crate) struct Isolated {
    in_flight: AtomicUsize,
}

impl Isolated {
    /// Runs a call. As many threads as the caller has are shared out among the calls in flight.
    ///
    /// # Errors
    /// As a failure of the work if threads cannot be started, or if the call panics.
    pub(crate) fn run<T: Send>(&self, call: impl FnOnce() -> T + Send) -> Result<T> {
        let in_flight = InFlight::enter(&self.in_flight);
        let ended = on_own_threads((threads::count() / in_flight.calls).max(1), call)?;
        ended.map_err(|panic| Failure::work(format!("internal error: {}", text_of(&*panic))))
    }
}

/// What a call returned, or its panic.
type Ended<T> = std::result::Result<T, Box<dyn Any + Send>>;

#[cfg(feature = "threads")]
fn on_own_threads<T: Send>(threads: usize, call: impl FnOnce() -> T + Send) -> Result<Ended<T>> {
    use std::thread;

    use crate::failure::{Blame, Context};

    let what = "cannot start threads";
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.or_work().context(what)?;
    // From a thread outside all pools: one of the caller's would take up further calls while it
    // waits here, each with its texture in memory.
    let ended = thread::scope(|scope| {
        let waiting = thread::Builder::new().spawn_scoped(scope, || pool.install(call));
        waiting.map(thread::ScopedJoinHandle::join)
    });
    ended.or_work().context(what)
}

#[cfg(not(feature = "threads"))]
fn on_own_threads<T: Send>(_threads: usize, call: impl FnOnce() -> T + Send) -> Result<Ended<T>> {
    Ok(std::panic::catch_unwind(std::panic::AssertUnwindSafe(call)))
}

/// A call in flight, until it is dropped.
struct InFlight<'a> {
    counter: &'a AtomicUsize,
    /// The number of calls in flight, this one included.
    calls: usize,
}

impl<'a> InFlight<'a> {
    fn enter(counter: &'a AtomicUsize) -> Self {
        Self { counter, calls: counter.fetch_add(1, Ordering::Relaxed) + 1 }
    }
}

impl Drop for InFlight<'_> {
    fn drop(&mut self) {
        self.counter.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(all(test, feature = "threads"))]
mod tests {
    use rayon::prelude::*;

    use super::*;
    use crate::failure::Fault;

    #[test]
    fn a_panic_is_a_failure_of_its_call() {
        let calls = Isolated::default();
        let results: Vec<Result<u32>> = (0..8)
            .into_par_iter()
            .map(|index| {
                calls.run(move || {
                    assert_ne!(index, 3, "three");
                    index
                })
            })
            .collect();
        for (index, result) in (0..).zip(results) {
            match result {
                Ok(value) => assert_eq!(value, index),
                Err(failure) => {
                    assert_eq!((index, failure.fault()), (3, Fault::Work));
                    assert!(failure.to_string().contains("three"), "{failure}");
                }
            }
        }
        assert_eq!(calls.in_flight.into_inner(), 0);
    }

    #[test]
    fn calls_have_threads_of_their_own() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let calls = Isolated::default();
        let threads = || rayon::current_num_threads();
        let found = pool.install(|| calls.run(|| (threads(), calls.run(threads))));
        // The second call is made while the first is in flight.
        assert_eq!(found.unwrap(), (3, Ok(1)));
    }
}
