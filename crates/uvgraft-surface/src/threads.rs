//! Data parallelism: the one place that decides how this crate, and the crates built
//! on it, use threads.
//!
//! | | work items | result |
//! |---|---|---|
//! | [`map_indices`] | every index in `0..count` | results in index order |
//! | [`map_indices_with`] | the same, with reusable buffers | the same |
//! | [`extend_indices`] | every index in `0..count` | results appended to a `Vec` |
//! | [`for_each_chunk`] | consecutive chunks of a slice | none: chunks are modified in place |
//! | [`for_each`] | items of an iterator, such as zipped chunks of several slices | none |
//! | [`for_each_with`] | the same, with reusable buffers | none |
//! | [`join`] | two closures | both results |
//!
//! With the feature `threads` (default), work runs on the caller's rayon pool: the pool that the
//! calling thread belongs to, as inside `rayon::ThreadPool::install`, or else rayon's global pool.
//! This module never creates a pool. Without the feature, work items run one after the other, in
//! order, on the calling thread; no thread support is needed, as on `wasm32-unknown-unknown`.
//!
//! How work is split depends on the work alone, never on the number of threads. Results do not
//! depend on it either, provided that each item depends on nothing but its own index and data: they
//! are identical to the byte on one thread, on many, and without the feature.
//!
//! All functions propagate a panic of a work item. With threads, other items may still run before
//! that.

use std::sync::{Mutex, PoisonError};

/// [`extend_indices`] takes this many batches of indices, if there are as many.
#[cfg(feature = "threads")]
const BATCHES: usize = 512;

/// Number of threads that work at once: the size of the pool, or 1 without the feature `threads`.
///
/// For callers that spawn their own threads, or to bound memory. The way work is split
/// must not depend on it.
pub fn count() -> usize {
    #[cfg(feature = "threads")]
    {
        rayon::current_num_threads()
    }
    #[cfg(not(feature = "threads"))]
    1
}

/// Runs `work` for every index in `0..count` and collects the results in index order.
///
/// Neighbouring indices are batched when there are many, so an item may be as small as a single vertex or as large as a
/// whole image.
pub fn map_indices<T: Send>(count: usize, work: impl Fn(usize) -> T + Send + Sync) -> Vec<T> {
    let mut values = Vec::new();
    extend_indices(&mut values, count, work);
    values
}

/// As [`map_indices`], with buffers that are reused from one work item to the next. At most one is
/// created per thread, when it is first needed. Their contents must not affect results.
///
/// A lock is taken twice per index, so items should be larger than single vertices.
pub fn map_indices_with<S: Send, T: Send>(
    count: usize,
    buffers: impl Fn() -> S + Send + Sync,
    work: impl Fn(&mut S, usize) -> T + Send + Sync,
) -> Vec<T> {
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

/// Appends the results of `work` for every index in `0..count`, in index order.
#[cfg_attr(
    feature = "threads",
    expect(unsafe_code, reason = "results are written where they stay")
)]
pub fn extend_indices<T: Send>(
    values: &mut Vec<T>,
    count: usize,
    work: impl Fn(usize) -> T + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        // Large enough that taking a batch costs little, small enough that a hundred threads end together.
        let batch = count.div_ceil(BATCHES).max(1);
        values.reserve(count);
        let slots = &mut values.spare_capacity_mut()[..count];
        for_each(slots.chunks_mut(batch), |at, slots| {
            for (index, slot) in (at * batch..).zip(slots) {
                slot.write(work(index));
            }
        });
        // SAFETY: there is capacity for `count` more values, and all of these slots have been written: without a
        // panic, every chunk has been worked on.
        unsafe { values.set_len(values.len() + count) };
    }
    #[cfg(not(feature = "threads"))]
    values.extend((0..count).map(work));
}

/// Runs two closures, in parallel if there are threads for it.
pub fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "threads")]
    {
        let (mut of_a, mut of_b) = (None, None);
        let (mut a, mut b) = (Some(a), Some(b));
        join_dyn(&mut || of_a = a.take().map(|a| a()), &mut || of_b = b.take().map(|b| b()));
        of_a.zip(of_b).expect("both have run, once")
    }
    #[cfg(not(feature = "threads"))]
    (a(), b())
}

// Rayon is generic over what it runs. So that it is compiled once, not for each closure, it gets them by reference here:
// that made the code of this crate a fifth smaller.

#[cfg(feature = "threads")]
fn join_dyn(a: &mut (dyn FnMut() + Send), b: &mut (dyn FnMut() + Send)) {
    rayon::join(a, b);
}

/// Calls `work` on up to so many threads at once.
#[cfg(feature = "threads")]
fn on_threads(threads: usize, work: &(dyn Fn() + Sync)) {
    // The calling thread takes part in the work. Otherwise it would wake another thread and go to sleep, and with as many
    // threads as processors the system often leaves two of them on one processor for a while.
    rayon::in_place_scope(|scope| {
        for _ in 1..threads {
            scope.spawn(|_| work());
        }
        work();
    });
}

/// Runs `work` on consecutive chunks of `values`, passing the index of each. See [`for_each`].
///
/// - `chunk`: values per chunk; the last chunk may have fewer.
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

/// Runs `work` on every item of `pieces`, passing the index of each.
///
/// Each thread takes the next item under a lock when it has finished one: a chunk of a thousand
/// vertices is worth that, a single vertex is not.
///
/// ```
/// let (mut positions, mut normals) = (vec![1.0; 5000], vec![0.5; 5000]);
/// let chunks = positions.chunks_mut(1024).zip(normals.chunks_mut(1024));
/// uvgraft_surface::threads::for_each(chunks, |_, (positions, normals)| {
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

/// As [`for_each`], with buffers that are reused from one work item to the next. Each thread
/// creates its own. Their contents must not affect results.
pub fn for_each_with<S, T>(
    pieces: impl ExactSizeIterator<Item = T> + Send,
    buffers: impl Fn() -> S + Send + Sync,
    work: impl Fn(&mut S, usize, T) + Send + Sync,
) {
    #[cfg(feature = "threads")]
    {
        let threads = pieces.len().min(count());
        let pieces = Mutex::new(pieces.enumerate());
        on_threads(threads, &|| {
            let next = || pieces.lock().unwrap_or_else(PoisonError::into_inner).next();
            let mut buffer = None;
            while let Some((index, piece)) = next() {
                work(buffer.get_or_insert_with(&buffers), index, piece);
            }
        });
    }
    #[cfg(not(feature = "threads"))]
    {
        let mut buffer = None;
        for (index, piece) in pieces.enumerate() {
            work(buffer.get_or_insert_with(&buffers), index, piece);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_runs_once_with_its_index() {
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
    fn results_are_in_the_order_of_indices() {
        for count in [0, 1, 511, 512, 513, 5000] {
            let mut values = vec!["before".to_owned()];
            extend_indices(&mut values, count, |index| index.to_string());
            assert_eq!(values.len(), count + 1);
            assert!(values[1..].iter().enumerate().all(|(at, value)| *value == at.to_string()));
        }
        assert_eq!(join(|| 1, || "b".to_owned()), (1, "b".to_owned()));
    }

    #[test]
    fn a_panic_is_passed_on_and_keeps_what_was_there() {
        let mut values = vec![String::from("before")];
        let panics = |index: usize| {
            assert!(index != 700, "of an item");
            index.to_string()
        };
        let mut extend = || extend_indices(&mut values, 1000, panics);
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(&mut extend)).unwrap_err();
        assert_eq!(values, ["before"]);
        std::panic::catch_unwind(|| join(|| (), || panic!("of a half"))).unwrap_err();
    }

    #[test]
    fn creates_at_most_one_buffer_per_thread() {
        let made = Mutex::new(0);
        let make = || {
            *made.lock().unwrap() += 1;
            Vec::new()
        };
        // Miri would take ten minutes for a thousand.
        let items = if cfg!(miri) { 100 } else { 1000 };
        let mut sums = vec![0; items];
        for_each_with(sums.iter_mut(), make, |buffer, index, sum| {
            buffer.clear();
            buffer.extend(0..=index);
            *sum = buffer.iter().sum();
        });
        assert!((0..items).all(|index| sums[index] == index * (index + 1) / 2));
        assert!((1..=count()).contains(&made.lock().unwrap()));
    }
}
