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

/// Runs `work` on consecutive chunks of `values`, with the number of each.
pub(crate) fn for_each_chunk<T: Send>(
    values: &mut [T],
    chunk: usize,
    work: impl Fn(usize, &mut [T]) + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        // Rayon would give each thread a few long rows of chunks, and who has the empty ones is done
        // early.
        let chunks = values.par_chunks_mut(chunk).enumerate().with_max_len(1);
        chunks.for_each(|(index, chunk)| work(index, chunk));
    }
    #[cfg(not(feature = "threads"))]
    values.chunks_mut(chunk).enumerate().for_each(|(index, chunk)| work(index, chunk));
}
