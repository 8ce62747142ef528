//! Fills a stretch of texels, eight at a time.

use fearless_simd::{Avx2, SimdBase, SimdFrom, SimdInt, f32x8, i32x8, u32x8};

use super::super::{LOST, SUM_BITS, VALUE_BITS, share};
use super::group::{GROUP, GROUP_VALUES, Source};
use super::instructions;
use super::weights::{VectorTaps, Weights};
use super::window::{packed, windows};
use crate::resample::stretch::Stretch;

/// Writes the texels of a stretch.
#[inline(always)]
pub(super) fn fill<const C: usize, F: VectorTaps>(
    source: &Source<'_>,
    stretch: &mut Stretch,
    texels: &mut [u8],
) {
    let count = stretch.count();
    if let Some(last) = count.checked_sub(GROUP) {
        for k in (0..count).step_by(GROUP) {
            // The last group starts earlier, so that it is full, and recomputes some texels.
            let first = k.min(last);
            let group = eight::<C, F>(source, stretch, first);
            texels[first * C..][..GROUP * C].copy_from_slice(&group[..GROUP * C]);
        }
    } else {
        stretch.pad::<GROUP>();
        let group = eight::<C, F>(source, stretch, 0);
        texels.copy_from_slice(&group[..count * C]);
    }
}

/// The values of eight texels.
#[inline(always)]
fn eight<const C: usize, F: VectorTaps>(
    source: &Source<'_>,
    stretch: &Stretch,
    first: usize,
) -> [u8; GROUP_VALUES] {
    let avx2 = source.avx2;
    let [columns, rows] = stretch.samples();
    if [columns, rows] == [1, 1] {
        const HALF: i32 = (1 << (VALUE_BITS - 1)) + LOST;
        let mut values = filtered::<C, F>(source, stretch, 0, first);
        for value in &mut values {
            *value = (*value + HALF) >> VALUE_BITS;
        }
        return packed::<C>(avx2, values);
    }
    let mut sums = [i32x8::splat(avx2, 0); 4];
    for sample in 0..stretch.sample_count() {
        let values = filtered::<C, F>(source, stretch, sample, first);
        for j in 0..4 {
            sums[j] += (values[j] + LOST) >> (VALUE_BITS - SUM_BITS);
        }
    }
    let share = share([columns, rows]);
    for sum in &mut sums {
        *sum = instructions::rounded(avx2, sum.to_float::<f32x8<Avx2>>() * share);
    }
    packed::<C>(avx2, sums)
}

/// The values of eight windows, as [`super::super::filtered`].
#[inline(always)]
fn filtered<const C: usize, F: VectorTaps>(
    source: &Source<'_>,
    stretch: &Stretch,
    sample: usize,
    first: usize,
) -> [i32x8<Avx2>; 4] {
    let avx2 = source.avx2;
    // A closure for both axes would not be inlined.
    let bits_x = u32x8::simd_from(avx2, *stretch.bits::<GROUP>(0, sample, first));
    let bits_y = u32x8::simd_from(avx2, *stretch.bits::<GROUP>(1, sample, first));
    let (across, down) = (F::Weights::new(avx2, bits_x), F::Weights::new(avx2, bits_y));
    windows::<C, F>(source, stretch.starts(sample, first), &across, &down)
}
