//! A window of texels, filtered: rows as vectors of values, downwards first, then across.

use fearless_simd::{Simd, SimdBase, SimdInto, SimdSplit, f32x4, f32x8};

use super::places::BATCH;
use crate::filter::{MAX_TAPS, Taps};
use crate::texture::Value;

/// Weights by axis, tap and texel of a batch.
pub(super) type Weights = [[[f32; BATCH]; MAX_TAPS]; 2];

/// Values in the vectors that rows of a window are read in.
pub(super) const LANES: usize = 8;

/// Most vectors in a row of a window.
const MAX_VECTORS: usize = (MAX_TAPS * 4).div_ceil(LANES);

/// The most values that are read from a row of a window.
pub(super) const MAX_VALUES: usize = MAX_VECTORS * LANES;

/// The value at a position in a window, in the first `C` lanes.
///
/// - `rows`: one for each row of the window, which begins at value `start` of each; read in whole
///   vectors, so that up to 7 values behind the window must be there.
/// - `k`: which texel of the batch's weights counts.
#[inline(always)]
pub(super) fn filtered<S: Simd, T: Value, const C: usize, const OPACITY: bool, F: Taps>(
    simd: S,
    rows: &[&[T]; MAX_TAPS],
    start: usize,
    weights: &Weights,
    k: usize,
) -> f32x4<S> {
    let [across, down] = weights;
    let vectors = (F::TAPS * C).div_ceil(LANES);
    // Sums begin with their first term: adding it to zero would cost as much as adding another.
    let mut columns = [f32x8::splat(simd, 0.0); MAX_VECTORS];
    for b in 0..F::TAPS {
        let row = &rows[b][start..start + vectors * LANES];
        for (vector, column) in columns[..vectors].iter_mut().enumerate() {
            let term = levels::<S, T, C, OPACITY>(simd, &row[vector * LANES..]) * down[b][k];
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

/// Eight values as levels, colours multiplied by opacity; as [`super::load`] for each texel.
#[inline(always)]
fn levels<S: Simd, T: Value, const C: usize, const OPACITY: bool>(
    simd: S,
    values: &[T],
) -> f32x8<S> {
    let values: &[T; LANES] = values.first_chunk().expect("a whole vector");
    // By reference: as one number of 64 bits they would be shifted apart.
    let mut levels = [0.0; LANES];
    for lane in 0..LANES {
        levels[lane] = values[lane].to_level();
    }
    if OPACITY {
        for texel in levels.chunks_exact_mut(C) {
            let opacity = texel[C - 1] / T::ONE.to_level();
            for level in &mut texel[..C - 1] {
                *level *= opacity;
            }
        }
    }
    levels.simd_into(simd)
}
