//! A window of texels, filtered: rows as vectors of values, downwards first, then across.

use fearless_simd::{Simd, SimdBase, SimdInto, SimdSplit, f32x4, f32x8};

use crate::filter::{MAX_TAPS, Taps};
use crate::texture::Value;

/// Values in the vectors that rows of a window are read in.
pub(super) const LANES: usize = 8;

/// Most vectors in a row of a window.
const MAX_VECTORS: usize = (MAX_TAPS * 4).div_ceil(LANES);

/// The most values that are read from a row of a window.
pub(super) const MAX_VALUES: usize = MAX_VECTORS * LANES;

/// The value at a position in a window, in the first `C` lanes.
///
/// - `values`: from the window's first texel on; rows follow each other after `stride` values, and
///   are read in whole vectors, so that up to 7 values behind the window must be there.
/// - `weights`: of columns and of rows.
#[inline(always)]
pub(super) fn filtered<S: Simd, T: Value, const C: usize, const OPACITY: bool, F: Taps>(
    simd: S,
    values: &[T],
    stride: usize,
    weights: [&[f32; MAX_TAPS]; 2],
) -> f32x4<S> {
    let [across, down] = weights;
    let vectors = (F::TAPS * C).div_ceil(LANES);
    let mut columns = [f32x8::splat(simd, 0.0); MAX_VECTORS];
    for b in 0..F::TAPS {
        let row = &values[b * stride..][..vectors * LANES];
        for (vector, column) in columns[..vectors].iter_mut().enumerate() {
            let levels = levels::<S, T, C, OPACITY>(simd, &row[vector * LANES..]);
            *column = *column + levels * down[b];
        }
    }
    let quad = |index: usize| {
        let (low, high) = columns[index / 2].split();
        if index % 2 == 0 { low } else { high }
    };
    let mut value = f32x4::splat(simd, 0.0);
    for a in 0..F::TAPS {
        let (index, shift) = (a * C / 4, a * C % 4);
        let texel = match shift {
            0 => quad(index),
            1 => quad(index).slide::<1>(quad(index + 1)),
            2 => quad(index).slide::<2>(quad(index + 1)),
            _ => quad(index).slide::<3>(quad(index + 1)),
        };
        value = value + texel * across[a];
    }
    value
}

/// Eight values as levels, colours multiplied by opacity; as [`super::load`] for each texel.
#[inline(always)]
fn levels<S: Simd, T: Value, const C: usize, const OPACITY: bool>(
    simd: S,
    values: &[T],
) -> f32x8<S> {
    let values: &[T; LANES] = values.first_chunk().expect("a whole vector");
    let mut levels: [f32; LANES] = values.map(T::to_level);
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
