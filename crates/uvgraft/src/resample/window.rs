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

/// An alpha level divided by that of 1, to the bit, in multiplications, of which processors do
/// several in the time of a division. The first factor has so few bits that its product is exact,
/// and the second makes up for it.
#[inline(always)]
fn opacity<T: Value>(level: f32) -> f32 {
    /// Keeps 8 bits of a mantissa.
    const FEW_BITS: u32 = !0xFFFF;
    let one = T::ONE.to_level();
    if one == 1.0 {
        return level;
    }
    let rough = f32::from_bits((1.0 / one).to_bits() & FEW_BITS);
    let rest = (1.0 / f64::from(one) - f64::from(rough)) as f32;
    level * rough + level * rest
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
        let mut opacities = [1.0; LANES];
        for lane in 0..LANES {
            if lane % C < C - 1 {
                opacities[lane] = opacity::<T>(levels[lane / C * C + C - 1]);
            }
        }
        for lane in 0..LANES {
            levels[lane] *= opacities[lane];
        }
    }
    levels.simd_into(simd)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacities_are_quotients_to_the_bit() {
        for level in (0..=u8::MAX).map(f32::from) {
            assert_eq!(opacity::<u8>(level).to_bits(), (level / 255.0).to_bits(), "{level}");
        }
        for level in (0..=u16::MAX).map(f32::from) {
            assert_eq!(opacity::<u16>(level).to_bits(), (level / 65_535.0).to_bits(), "{level}");
        }
        assert_eq!(opacity::<f32>(0.3), 0.3);
    }
}
