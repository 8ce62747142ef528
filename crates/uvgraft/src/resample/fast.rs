//! The fast path: rows in parallel, kernels compiled per filter, channel count and SIMD level.
//!
//! A run is processed in batches of texels: first the positions and weights of all of them, then
//! their windows. Each window is filtered by [`window::filtered`], which performs the arithmetic of
//! the reference in the same order.

use fearless_simd::{Level, Simd, SimdInto, f32x4};
use uvgraft_surface::threads::for_each_chunk;

use super::prefetch::prefetch;
use super::stretch::Job;
use super::window::{self, LANES, MAX_VALUES, Weights};
use super::windows::{BATCH, Windows};
use super::{Paths, ROWS, Walk, bytes, composite, nearest};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3, MAX_TAPS, Taps};
use crate::map::SamplingMap;
use crate::simd::dispatch;
use crate::texture::{Size, Value};

/// Number of texels that share one prefetch, issued for the first of them.
const PREFETCHED: usize = 8;

/// A source texture's values and size.
#[derive(Clone, Copy)]
struct Source<'a, T> {
    values: &'a [T],
    size: Size,
}

/// As [`super::reference::resample`], identical to the bit except for the sign of zeros, on some
/// rows of the target.
///
/// - `source`: `[height * width * C]` values, of the size that `paths` is for.
/// - `rows`: the rows of the target from `first_row` on.
pub(crate) fn resample<T: Value, const C: usize, const ALPHA: bool>(
    level: Level,
    map: &SamplingMap,
    paths: &Paths,
    source: &[T],
    first_row: u32,
    rows: &mut [T],
) {
    if !ALPHA
        && paths.filter != Filter::Nearest
        && let (Some(source), Some(rows)) = (T::as_bytes(source), T::as_bytes_mut(rows))
    {
        return bytes::resample::<C>(level, map, paths, source, first_row, rows);
    }
    let source = Source { values: source, size: paths.source };
    let width = map.size().width as usize * C;
    for_each_chunk(rows, width * ROWS, |chunk, rows| {
        let first_row = first_row + (chunk * ROWS) as u32;
        match paths.filter {
            Filter::Nearest => {
                let job = Job { map, paths, source: source.values };
                dispatch!(level, simd =>
                    nearest::fill::<_, T, C, ALPHA>(simd, &job, first_row, rows));
            }
            Filter::Bilinear => dispatch!(level, simd =>
                smooth::<_, T, C, ALPHA, Bilinear>(simd, map, paths, source, first_row, rows)),
            Filter::CatmullRom => dispatch!(level, simd =>
                smooth::<_, T, C, ALPHA, CatmullRom>(simd, map, paths, source, first_row, rows)),
            Filter::Lanczos3 => dispatch!(level, simd =>
                smooth::<_, T, C, ALPHA, Lanczos3>(simd, map, paths, source, first_row, rows)),
        }
    });
}

/// Calls `fill` with the walk and the target texels of every run in some rows.
#[inline(always)]
fn for_each_run<T: Value, const C: usize>(
    map: &SamplingMap,
    paths: &Paths,
    first_row: u32,
    rows: &mut [T],
    mut fill: impl FnMut(&Walk<'_>, &mut [T]),
) {
    let width = map.size().width as usize * C;
    for (row, target) in (first_row..).zip(rows.chunks_mut(width)) {
        let runs = map.row(row);
        for (index, &run) in runs.iter().enumerate() {
            paths.prefetch(runs, index);
            let texels = &mut target[run.x as usize * C..][..run.len as usize * C];
            fill(&paths.walk(row, run), texels);
        }
    }
}

/// Buffers for a batch of texels.
struct Batch<T> {
    windows: Windows,
    weights: Weights,
    /// Sums of samples; only the first `C` values of each are used.
    sums: [[f32; 4]; BATCH],
    values: [T; BATCH * 4],
}

/// Fills rows using a filter with several taps.
#[inline(always)]
fn smooth<S: Simd, T: Value, const C: usize, const ALPHA: bool, F: Taps>(
    simd: S,
    map: &SamplingMap,
    paths: &Paths,
    source: Source<'_, T>,
    first_row: u32,
    rows: &mut [T],
) {
    let stride = source.size.width as usize * C;
    // A window is read in whole vectors, which may extend a few values past its end: into the texel
    // of margin to its right, or into the row below.
    let may_be_clear = stride >= LANES && source.size.height as usize >= F::TAPS;
    // All of the same length, so that one bounds check covers all rows of a window.
    let len = source.values.len().saturating_sub((F::TAPS - 1) * stride);
    let mut window_rows = [&source.values[..0]; MAX_TAPS];
    if may_be_clear {
        for b in 0..F::TAPS {
            window_rows[b] = &source.values[b * stride..][..len];
        }
    }
    let mut batch = Batch {
        windows: Windows::new(),
        weights: [[[0.0; BATCH]; MAX_TAPS]; 2],
        sums: [[0.0; 4]; BATCH],
        values: [T::default(); BATCH * 4],
    };
    for_each_run::<T, C>(
        map,
        paths,
        first_row,
        rows,
        #[inline(always)]
        |walk, texels| {
            let clear = may_be_clear && walk.stays_inside((texels.len() / C) as u32, source.size);
            for (piece, texels) in (0..).zip(texels.chunks_mut(BATCH * C)) {
                let first = piece * BATCH as u32;
                let window_rows = clear.then_some(&window_rows);
                batch.fill::<S, C, ALPHA, F>(simd, source, window_rows, walk, first, texels);
            }
        },
    );
}

impl<T: Value> Batch<T> {
    /// Fills the texels of a run from `first` on.
    #[inline(always)]
    fn fill<S: Simd, const C: usize, const ALPHA: bool, F: Taps>(
        &mut self,
        simd: S,
        source: Source<'_, T>,
        window_rows: Option<&[&[T]; MAX_TAPS]>,
        walk: &Walk<'_>,
        first: u32,
        texels: &mut [T],
    ) {
        let count = texels.len() / C;
        let [columns, rows] = walk.samples();
        let ahead = walk.ahead(source.size.width as usize * C, C, F::TAPS);
        for b in 0..rows {
            for a in 0..columns {
                let texels = (first as usize, count);
                let begins = (a, b) == (0, 0);
                if let Some(rows) = window_rows {
                    self.windows.find_starts::<S, F>(simd, source.size, walk, texels, (a, b));
                    self.weigh::<F>(count);
                    for k in (0..count).step_by(PREFETCHED) {
                        prefetch(
                            source.values,
                            ((self.windows.start[k] as usize * C) as isize).wrapping_add(ahead),
                        );
                    }
                    for k in 0..count {
                        let start = self.windows.start[k] as usize * C;
                        let value = window::filtered::<S, T, C, ALPHA, F>(
                            simd,
                            rows,
                            start,
                            &self.weights,
                            k,
                        );
                        self.add(k, value, begins);
                    }
                } else {
                    self.windows.find_corners::<F>(source.size, walk, texels, (a, b));
                    self.weigh::<F>(count);
                    for k in 0..count {
                        let value = self.filtered_clamped::<S, C, ALPHA, F>(simd, source, k);
                        self.add(k, value, begins);
                    }
                }
            }
        }
        if walk.samples() != [1, 1] {
            let share = 1.0 / (columns * rows) as f32;
            for level in self.sums[..count].as_flattened_mut() {
                *level *= share;
            }
        }
        if ALPHA {
            return composite::store_all::<S, T, C>(simd, &self.sums[..count], texels);
        }
        for (value, level) in self.values.iter_mut().zip(self.sums[..count].as_flattened()) {
            *value = T::from_level(*level);
        }
        // All four values are written wherever there is room for them; the next texel overwrites
        // what is not its own.
        let whole = if C == 1 { 0 } else { count - 1 };
        for (k, values) in self.values[..whole * 4].as_chunks::<4>().0.iter().enumerate() {
            texels[k * C..k * C + 4].copy_from_slice(values);
        }
        for (k, values) in
            self.values[..count * 4].as_chunks::<4>().0.iter().enumerate().skip(whole)
        {
            texels[k * C..][..C].copy_from_slice(&values[..C]);
        }
    }

    #[inline(always)]
    fn add<S: Simd>(&mut self, k: usize, value: f32x4<S>, begins: bool) {
        let sum: f32x4<S> = self.sums[k].simd_into(value.simd);
        self.sums[k] = if begins { value } else { sum + value }.into();
    }

    /// Computes the weights of `count` texels.
    #[inline(always)]
    fn weigh<F: Taps>(&mut self, count: usize) {
        for axis in 0..2 {
            for (k, &fraction) in self.windows.fraction[axis][..count].iter().enumerate() {
                let weights = F::weights(fraction);
                for tap in 0..F::TAPS {
                    self.weights[axis][tap][k] = weights[tap];
                }
            }
        }
    }

    /// The value of texel `k` at any source position; beyond the texture its edge texels repeat.
    #[inline(never)]
    fn filtered_clamped<S: Simd, const C: usize, const ALPHA: bool, F: Taps>(
        &self,
        simd: S,
        source: Source<'_, T>,
        k: usize,
    ) -> f32x4<S> {
        const STRIDE: usize = MAX_VALUES;
        let clamped = |at: i32, count: u32| at.clamp(0, count as i32 - 1) as usize;
        let mut window = [T::default(); STRIDE * MAX_TAPS];
        for (b, row) in (0..).zip(window.chunks_exact_mut(STRIDE).take(F::TAPS)) {
            let y = clamped(self.windows.corner[1][k] + b, source.size.height);
            for (a, texel) in (0..).zip(row.chunks_exact_mut(C).take(F::TAPS)) {
                let x = clamped(self.windows.corner[0][k] + a, source.size.width);
                let start = (y * source.size.width as usize + x) * C;
                texel.copy_from_slice(&source.values[start..start + C]);
            }
        }
        let mut rows = [&window[..STRIDE]; MAX_TAPS];
        for b in 0..F::TAPS {
            rows[b] = &window[b * STRIDE..][..STRIDE];
        }
        window::filtered::<S, T, C, ALPHA, F>(simd, &rows, 0, &self.weights, k)
    }
}
