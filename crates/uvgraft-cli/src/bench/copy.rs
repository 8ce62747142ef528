//! Memory copy bandwidth: the upper bound for stages that read and write as many bytes.

use std::hint::black_box;

use rayon::prelude::*;
use serde::Serialize;

use super::measure::time;

/// Bytes of each of the two buffers: several times what caches hold.
const BUFFER: usize = 128 << 20;

/// Chunk per thread: small enough to balance the load, large enough to stream.
const PIECE: usize = 1 << 20;

/// Memory copy bandwidth.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct CopyRate {
    /// 10⁹ bytes per second, reads plus writes, in the best run.
    gigabytes_per_second: f64,
    buffer_bytes: usize,
}

impl CopyRate {
    /// Copies between two buffers with all threads of the pool, `runs` times and at least 5.
    ///
    /// # Source
    /// As McCalpin's STREAM copy: buffers touched before, the best of several runs, bytes counted
    /// both ways.
    pub(super) fn measured(runs: u32) -> Self {
        // Neither is zero: zero pages may share one physical page until they are written.
        let (from, mut to) = (vec![1u8; BUFFER], vec![2u8; BUFFER]);
        let seconds = (0..runs.max(5)).map(|_| {
            let copy = || {
                let pieces = to.par_chunks_mut(PIECE).zip(from.par_chunks(PIECE));
                pieces.for_each(|(to, from)| to.copy_from_slice(from));
            };
            let (_, seconds) = time(copy);
            black_box(&to);
            seconds
        });
        let best = seconds.min_by(f64::total_cmp).unwrap_or(f64::INFINITY);
        Self { gigabytes_per_second: 2.0 * BUFFER as f64 / best / 1e9, buffer_bytes: BUFFER }
    }

    pub(super) fn gigabytes_per_second(self) -> f64 {
        self.gigabytes_per_second
    }

    /// Milliseconds to copy a number of bytes, reads plus writes.
    pub(super) fn ms(self, bytes: usize) -> f64 {
        bytes as f64 / self.gigabytes_per_second / 1e6
    }
}
