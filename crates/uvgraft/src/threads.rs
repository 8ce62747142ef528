//! Independent pieces of work on the caller's thread pool, or one after the other without it.
//!
//! Pieces are fixed by the work, never by the number of threads, so results do not depend on it.

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

/// Runs `work` on consecutive chunks of `values`, with the number of each.
pub(crate) fn for_each_chunk<T: Send>(
    values: &mut [T],
    chunk: usize,
    work: impl Fn(usize, &mut [T]) + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        use rayon::prelude::*;
        values.par_chunks_mut(chunk).enumerate().for_each(|(index, chunk)| work(index, chunk));
    }
    #[cfg(not(feature = "threads"))]
    values.chunks_mut(chunk).enumerate().for_each(|(index, chunk)| work(index, chunk));
}
