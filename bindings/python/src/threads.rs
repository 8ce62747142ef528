//! Work on thread pools, without the interpreter's lock.
//!
//! Each call has a pool to itself, from a stock of idle ones: were a pool shared, a thread that
//! waits for a part of one call's work could take up another call, which may wait for the first.
//!
//! A forked process has none of its parent's threads, so it makes pools of its own. The stock is
//! only touched while the interpreter's lock is held, and Python forks with that lock held, so no
//! child starts with the stock locked.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::error::{bad_value, failed};

/// Idle pools that are kept; more would only be used by as many Python threads at once.
const MAX_IDLE: usize = 8;

/// Most threads of a pool.
const MAX_THREADS: usize = 1024;

#[derive(Default)]
struct Stock {
    process: u32,
    /// By number of threads.
    idle: HashMap<usize, Vec<ThreadPool>>,
    /// For calls that name no number; 0 is one for each processor.
    default: usize,
}

static STOCK: Mutex<Option<Stock>> = Mutex::new(None);

/// Runs `visit` with the stock of this process.
///
/// - `_py`: shows that the interpreter's lock is held.
fn with_stock<T>(_py: Python<'_>, visit: impl FnOnce(&mut Stock) -> T) -> T {
    let mut stock = STOCK.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    let stock = stock.get_or_insert_with(Stock::default);
    if stock.process != process {
        // To drop the pools of the parent process would be to wait for threads that do not exist.
        std::mem::forget(std::mem::take(&mut stock.idle));
        stock.process = process;
    }
    visit(stock)
}

/// Checks a number of threads given by a user.
pub(crate) fn checked(threads: Option<i64>) -> PyResult<Option<usize>> {
    threads
        .map(|count| match usize::try_from(count) {
            Ok(count) if count <= MAX_THREADS => Ok(count),
            _ => Err(bad_value(format_args!(
                "threads must be from 0 (one for each processor) to {MAX_THREADS}, got {count}"
            ))),
        })
        .transpose()
}

/// Sets the number of threads of calls that name none.
pub(crate) fn set_default(py: Python<'_>, threads: usize) {
    with_stock(py, |stock| stock.default = threads);
}

/// The number of threads of calls that name none.
pub(crate) fn default(py: Python<'_>) -> usize {
    with_stock(py, |stock| stock.default)
}

/// A pool that one call has to itself.
///
/// Dropped without being given back, its threads end once they have nothing left to do.
pub(crate) struct LentPool {
    pool: ThreadPool,
    /// What was asked for; 0 is one for each processor.
    count: usize,
}

impl LentPool {
    /// An idle pool, or a new one.
    ///
    /// - `threads`: its size; `None` for the default, 0 for one thread per processor.
    ///
    /// # Errors
    /// `uvgraft.Error` if threads cannot be started.
    pub(crate) fn new(py: Python<'_>, threads: Option<usize>) -> PyResult<Self> {
        let count = threads.unwrap_or_else(|| default(py));
        let idle = with_stock(py, |stock| stock.idle.get_mut(&count).and_then(Vec::pop));
        let pool = match idle {
            Some(pool) => pool,
            None => ThreadPoolBuilder::new()
                .num_threads(count)
                .thread_name(|index| format!("uvgraft-{index}"))
                .build()
                .map_err(|error| failed(format_args!("cannot start threads: {error}")))?,
        };
        Ok(Self { pool, count })
    }

    /// The pool.
    pub(crate) fn pool(&self) -> &ThreadPool {
        &self.pool
    }

    /// Puts the pool into the stock, if there is room.
    pub(crate) fn give_back(self, py: Python<'_>) {
        let Self { pool, count } = self;
        let surplus = with_stock(py, |stock| {
            let kept: usize = stock.idle.values().map(Vec::len).sum();
            if kept < MAX_IDLE {
                stock.idle.entry(count).or_default().push(pool);
                return None;
            }
            Some(pool)
        });
        py.detach(|| drop(surplus));
    }
}

/// Runs `work` on a pool, with the interpreter's lock released.
///
/// - `threads`: the size of the pool; `None` for the default, 0 for one thread per processor.
///
/// # Errors
/// `uvgraft.Error` if threads cannot be started, and for a panic, which is a bug.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> PyResult<T> {
    let lent = LentPool::new(py, threads)?;
    let done = py.detach(|| caught(|| lent.pool.install(work)));
    lent.give_back(py);
    done
}

/// Does work; a panic, which is a bug, becomes an error.
///
/// # Errors
/// `uvgraft.Error` for a panic.
pub(crate) fn caught<T>(work: impl FnOnce() -> T) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("panic");
        failed(format_args!("internal error, please report it: {text}"))
    })
}
