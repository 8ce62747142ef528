//! Independent pieces of work on the caller's thread pool, or one after the other without it.
//!
//! Pieces are fixed by the work, never by the number of threads, so results do not depend on it.

use std::sync::{Mutex, PoisonError};

/// Runs `work` for every index in `0..count` and gathers the results in order.
pub(crate) fn map_indices<T: Send>(
    count: usize,
    work: impl Fn(usize) -> T + Send + Sync,
) -> Vec<T> {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        (0..count).into_par_iter().map(work).collect()
    }
    #[cfg(not(feature = "threads"))]
    (0..count).map(work).collect()
}

/// As [`map_indices`], with buffers that are kept from one piece of work to the next: as many of them
/// as there are threads, made when they are first needed. What is in them must not show in results.
pub(crate) fn map_indices_with<S: Send, T: Send>(
    count: usize,
    buffers: impl Fn() -> S + Send + Sync,
    work: impl Fn(&mut S, usize) -> T + Send + Sync,
) -> Vec<T> {
    // Rayon's own `map_init` makes new ones each time that it divides the work.
    let idle = Mutex::new(Vec::new());
    let locked = || idle.lock().unwrap_or_else(PoisonError::into_inner);
    map_indices(count, |index| {
        let taken = locked().pop();
        let mut taken = taken.unwrap_or_else(&buffers);
        let result = work(&mut taken, index);
        locked().push(taken);
        result
    })
}

/// Appends what `work` gives for every index in `0..count`, in order.
pub(crate) fn extend_indices<T: Send>(
    values: &mut Vec<T>,
    count: usize,
    work: impl Fn(usize) -> T + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        values.par_extend((0..count).into_par_iter().map(work));
    }
    #[cfg(not(feature = "threads"))]
    values.extend((0..count).map(work));
}

/// Runs two pieces of work, at once if there are threads for it.
pub(crate) fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "threads")]
    {
        rayon::join(a, b)
    }
    #[cfg(not(feature = "threads"))]
    (a(), b())
}

/// Runs `work` on consecutive chunks of `values`, with the number of each. Every thread takes the next
/// chunk when it is done with one, the calling one too: it would else wake others and go to sleep, and
/// with as many threads as processors the system then often lets two of them share one for a while.
pub(crate) fn for_each_chunk<T: Send>(
    values: &mut [T],
    chunk: usize,
    work: impl Fn(usize, &mut [T]) + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        let threads = values.len().div_ceil(chunk).min(rayon::current_num_threads());
        let chunks = Mutex::new(values.chunks_mut(chunk).enumerate());
        let work_off = || {
            let next = || chunks.lock().unwrap_or_else(PoisonError::into_inner).next();
            while let Some((index, chunk)) = next() {
                work(index, chunk);
            }
        };
        rayon::in_place_scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|_| work_off());
            }
            work_off();
        });
    }
    #[cfg(not(feature = "threads"))]
    values.chunks_mut(chunk).enumerate().for_each(|(index, chunk)| work(index, chunk));
}
