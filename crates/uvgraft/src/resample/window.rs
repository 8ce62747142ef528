//! Filters a window of texels: rows are vectors of values, combined downwards first, then across.

use fearless_simd::{Simd, SimdBase, SimdInto, SimdSplit, f32x4, f32x8};

use super::windows::BATCH;
use crate::filter::{MAX_TAPS, Taps};
use crate::texture::Value;

/// Weights of a batch, indexed by axis, tap and texel.
pub(super) type Weights = [[[f32; BATCH]; MAX_TAPS]; 2];

/// Lanes of the vectors in which rows of a window are read.
pub(super) const LANES: usize = 8;

/// Maximum number of vectors in a row of a window.
const MAX_VECTORS: usize = (MAX_TAPS * 4).div_ceil(LANES);

/// Maximum number of values that are read from a row of a window.
pub(super) const MAX_VALUES: usize = MAX_VECTORS * LANES;

/// The filtered value of a window, in the first `C` lanes. The separable filter
/// `Σa wx[a] · Σb wy[b] · texel[a, b]` runs down the columns first, since whole rows load as
/// contiguous vectors without shuffling channels.
///
/// - `rows`: one slice per row of the window, which begins at value `start` of each. Rows are read
///   in whole vectors, so up to 7 values past the window must exist.
/// - `k`: index of the texel in the batch, which selects its weights.
#[inline(always)]
pub(super) fn filtered<S: Simd, T: Value, const C: usize, const ALPHA: bool, F: Taps>(
    simd: S,
    rows: &[&[T]; MAX_TAPS],
    start: usize,
    weights: &Weights,
    k: usize,
) -> f32x4<S> {
    let [across, down] = weights;
    let vectors = (F::TAPS * C).div_ceil(LANES);
    // Sums start with their first term: adding it to zero would cost as much as any other addition.
    let mut columns = [f32x8::splat(simd, 0.0); MAX_VECTORS];
    for b in 0..F::TAPS {
        let row = &rows[b][start..start + vectors * LANES];
        for (vector, column) in columns[..vectors].iter_mut().enumerate() {
            let term = levels::<S, T, C, ALPHA>(simd, &row[vector * LANES..]) * down[b][k];
            *column = if b == 0 { term } else { *column + term };
        }
    }
    let mut value = f32x4::splat(simd, 0.0);
    for a in 0..F::TAPS {
        let (index, shift) = (a * C / 4, a * C % 4);
        let texel = match shift {
            0 => quad(&columns, index),
            1 => quad(&columns, index).slide::<1>(quad(&columns, index + 1)),
            2 => quad(&columns, index).slide::<2>(quad(&columns, index + 1)),
            _ => quad(&columns, index).slide::<3>(quad(&columns, index + 1)),
        };
        let term = texel * across[a][k];
        value = if a == 0 { term } else { value + term };
    }
    value
}

/// Four values of a row.
#[inline(always)]
fn quad<S: Simd>(row: &[f32x8<S>; MAX_VECTORS], index: usize) -> f32x4<S> {
    let (low, high) = row[index / 2].split();
    if index.is_multiple_of(2) { low } else { high }
}

/// Eight values as levels, premultiplied with `ALPHA`; as [`super::load`] for each texel.
#[inline(always)]
fn levels<S: Simd, T: Value, const C: usize, const ALPHA: bool>(simd: S, values: &[T]) -> f32x8<S> {
    let values: &[T; LANES] = values.first_chunk().expect("a whole vector");
    // Keep the reference: a copy would be held in one 64-bit register, and its values
    // extracted by shifts.
    let mut levels = [0.0; LANES];
    for lane in 0..LANES {
        levels[lane] = values[lane].to_level();
    }
    if ALPHA {
        for texel in levels.chunks_exact_mut(C) {
            let opacity = texel[C - 1] / T::ONE.to_level();
            for level in &mut texel[..C - 1] {
                *level *= opacity;
            }
        }
    }
    levels.simd_into(simd)
}
