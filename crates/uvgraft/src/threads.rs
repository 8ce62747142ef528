//! Independent pieces of work at once: the one place that decides how this crate, and those that are built
//! on it, use threads.
//!
//! | | pieces | gives |
//! |---|---|---|
//! | [`map_indices`] | every index below a number | results in the indices' order |
//! | [`map_indices_with`] | the same, with buffers that are used again | the same |
//! | [`extend_indices`] | every index below a number | results behind those in a `Vec` |
//! | [`for_each_chunk`] | consecutive chunks of a slice | nothing: chunks are changed in place |
//! | [`for_each`] | what an iterator gives, such as chunks of several slices side by side | nothing |
//! | [`for_each_with`] | the same, with buffers that are used again | nothing |
//! | [`join`] | two of different kinds | both results |
//!
//! With the feature `threads` (default) pieces run on the caller's rayon pool: the one that the calling
//! thread belongs to, as inside `rayon::ThreadPool::install`, else rayon's global one. No pool is ever
//! made here. Without the feature pieces run one after the other, in order, on the calling thread, and no
//! thread is needed, as on `wasm32-unknown-unknown`.
//!
//! Which pieces there are is up to the work, and never follows from the number of threads; nor do results,
//! as long as each piece's depends on nothing but its own number and data. They are the same to the byte on
//! one thread, on many, and without the feature.
//!
//! All functions pass on a panic of a piece. With threads, other pieces may still run before that.

use std::sync::{Mutex, PoisonError};

/// How many threads work at once: as many as the pool has, or 1 without the feature `threads`.
///
/// For others that make threads of their own, or to bound memory; pieces of work must not follow from it.
pub fn count() -> usize {
    #[cfg(feature = "threads")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "threads"))]
    1
}

/// Runs `work` for every index in `0..count` and gathers the results in order.
///
/// Neighbouring indices run together where there are more of them than threads, so single vertices are no
/// less pieces than whole pictures.
pub fn map_indices<T: Send>(count: usize, work: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
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
///
/// A lock is taken twice for each index, so pieces should be larger than single vertices.
pub fn map_indices_with<S: Send, T: Send>(
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
pub fn extend_indices<T: Send>(
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
pub fn join<A: Send, B: Send>(
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

/// Runs `work` on consecutive chunks of `values`, with the number of each. See [`for_each`].
///
/// - `chunk`: how many values a chunk has, but for the last, which may have fewer.
///
/// # Panics
/// If `chunk` is 0.
pub fn for_each_chunk<T: Send>(
    values: &mut [T],
    chunk: usize,
    work: impl Fn(usize, &mut [T]) + Send + Sync,
) {
    for_each(values.chunks_mut(chunk), work);
}

/// Runs `work` on everything that `pieces` gives, with the number of each.
///
/// Every thread takes the next piece when it is done with one, under a lock: a thousand vertices are worth
/// that, a single one is not.
///
/// ```
/// let (mut positions, mut normals) = (vec![1.0; 5000], vec![0.5; 5000]);
/// let chunks = positions.chunks_mut(1024).zip(normals.chunks_mut(1024));
/// uvgraft::threads::for_each(chunks, |_, (positions, normals)| {
///     positions.iter_mut().zip(normals).for_each(|(p, n)| *p += *n);
/// });
/// assert_eq!(positions, [1.5; 5000]);
/// ```
pub fn for_each<T>(
    pieces: impl ExactSizeIterator<Item = T> + Send,
    work: impl Fn(usize, T) + Send + Sync,
) {
    for_each_with(pieces, || (), |(), index, piece| work(index, piece));
}

/// As [`for_each`], with buffers that are kept from one piece of work to the next, which each thread makes
/// for itself. What is in them must not show in results.
pub fn for_each_with<S, T>(
    pieces: impl ExactSizeIterator<Item = T> + Send,
    buffers: impl Fn() -> S + Send + Sync,
    work: impl Fn(&mut S, usize, T) + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        let threads = pieces.len().min(count());
        let pieces = Mutex::new(pieces.enumerate());
        // Called in two places and compiled once: kernels are large.
        let work_off: &(dyn Fn() + Sync) = &|| {
            let next = || pieces.lock().unwrap_or_else(PoisonError::into_inner).next();
            let mut own = None;
            while let Some((index, piece)) = next() {
                work(own.get_or_insert_with(&buffers), index, piece);
            }
        };
        // The calling thread works along: it would else wake others and go to sleep, and with as many
        // threads as processors the system then often lets two of them share one for a while.
        rayon::in_place_scope(|scope| {
            for _ in 1..threads {
                scope.spawn(|_| work_off());
            }
            work_off();
        });
    }
    #[cfg(not(feature = "threads"))]
    {
        let mut own = None;
        for (index, piece) in pieces.enumerate() {
            work(own.get_or_insert_with(&buffers), index, piece);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_is_worked_on_once_and_known_by_its_number() {
        let (mut a, mut b) = (vec![0; 103], vec![0; 206]);
        for_each(a.chunks_mut(10).zip(b.chunks_mut(20)), |index, (a, b)| {
            a.iter_mut().for_each(|value| *value += index);
            b.iter_mut().for_each(|value| *value += index);
        });
        assert!(a.iter().enumerate().all(|(at, &value)| value == at / 10), "{a:?}");
        assert!(b.iter().enumerate().all(|(at, &value)| value == at / 20), "{b:?}");
        for_each_chunk::<u8>(&mut [], 10, |_, _| panic!("there is no chunk"));
    }

    #[test]
    fn no_more_buffers_are_made_than_there_are_threads() {
        let made = Mutex::new(0);
        let make = || {
            *made.lock().unwrap() += 1;
            Vec::new()
        };
        let mut sums = vec![0; 1000];
        for_each_with(sums.iter_mut(), make, |buffer, index, sum| {
            buffer.clear();
            buffer.extend(0..=index);
            *sum = buffer.iter().sum();
        });
        assert!((0..1000).all(|index| sums[index] == index * (index + 1) / 2));
        assert!((1..=count()).contains(&made.lock().unwrap()));
    }
}
