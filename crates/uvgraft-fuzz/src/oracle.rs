//! How much memory a reader may take.

use std::sync::atomic::{AtomicUsize, Ordering};

use peak_alloc::PeakAlloc;

/// What any file may take, in bytes: tables of decoders, and rows of the widest images.
pub(crate) const ANY_FILE: usize = 64 << 20;

/// What a file may take for each of its bytes: a number of JSON takes 32 of two, one of a pickle more.
pub(crate) const EACH_BYTE: usize = 50;

/// The most that one reader took since the last call of [`highest`].
static HIGHEST: AtomicUsize = AtomicUsize::new(0);

/// What a file may take for its size.
pub(crate) fn allowed(bytes: &[u8]) -> usize {
    ANY_FILE.saturating_add(EACH_BYTE.saturating_mul(bytes.len()))
}

/// Runs a reader that may take `most` bytes at a time, in a program whose allocator counts
/// ([`Allocator`](crate::Allocator)) and which does nothing else.
///
/// # Panics
/// If the reader takes more.
pub(crate) fn within<T>(what: &str, most: usize, read: impl FnOnce() -> T) -> T {
    let before = PeakAlloc.current_usage();
    PeakAlloc.reset_peak_usage();
    let read = read();
    let taken = PeakAlloc.peak_usage().saturating_sub(before);
    HIGHEST.fetch_max(taken, Ordering::Relaxed);
    assert!(taken <= most, "{what} may take {most} bytes, and took {taken}");
    read
}

/// The most memory that a reader of structured files took since the last call, in bytes.
pub fn highest() -> usize {
    HIGHEST.swap(0, Ordering::Relaxed)
}
