//! Filters eight windows. Two of them share a vector, texel `j` in the low half and `j + 4` in the
//! high half, with one channel per 32-bit lane.

use fearless_simd::{Avx2, Bytes, SimdBase, SimdCombine, SimdFrom, i16x16, i32x8, u8x16, u8x32};

use super::super::ROW_BITS;
use super::super::weights::WEIGHT_BITS;
use super::group::{GROUP, GROUP_VALUES, MAX_PAIRS, Source};
use super::instructions;
use super::weights::{VectorTaps, Weights};

/// Bytes per load.
const LOADED: usize = 16;

/// The filtered values of eight windows.
///
/// Rows are taken in pairs. Each row is filtered with multiply-adds of two taps, truncated to
/// [`ROW_BITS`] fraction bits and interleaved with the other row as 16-bit values, so that
/// one more multiply-add applies both vertical weights. Pairing taps this way does two of
/// them per instruction.
///
/// - `starts`: index of each window's first value in the source.
/// - `across`, `down`: horizontal and vertical weights.
#[inline(always)]
pub(super) fn windows<const C: usize, F: VectorTaps>(
    source: &Source<'_>,
    starts: &[u32; GROUP],
    across: &F::Weights,
    down: &F::Weights,
) -> [i32x8<Avx2>; 4] {
    const BELOW: u32 = WEIGHT_BITS - ROW_BITS;
    let avx2 = source.avx2;
    let pairs = F::TAPS / 2;
    // One slice from a window's first value to its last, so that one bounds check suffices.
    let span = (F::TAPS - 1) * source.stride + load_of(pairs - 1, C) + LOADED;
    let mut values = [i32x8::splat(avx2, 0); 4];
    for j in 0..4 {
        let windows = [
            &source.values[starts[j] as usize..][..span],
            &source.values[starts[j + 4] as usize..][..span],
        ];
        let (across, down) = (across.of_both(avx2, j), down.of_both(avx2, j));
        for pair in 0..pairs {
            let start = 2 * pair * source.stride;
            let upper = row::<C, F>(avx2, windows, start, &across);
            let lower = row::<C, F>(avx2, windows, start + source.stride, &across);
            // The 16 bits that are kept of both rows.
            let both = instructions::blend_words(avx2, upper >> BELOW, lower << (16 - BELOW));
            let term = instructions::dot(avx2, both, down[pair]);
            values[j] = if pair == 0 { term } else { values[j] + term };
        }
    }
    values
}

/// Offset, in a row of a window, of the load from which a pair of taps is taken: 0 if all taps up
/// to this pair fit one load, which is then shared.
const fn load_of(pair: usize, channels: usize) -> usize {
    if (pair * 2 + 2) * channels <= LOADED { 0 } else { pair * 2 * channels }
}

/// Filters a row of two windows.
#[inline(always)]
fn row<const C: usize, F: VectorTaps>(
    avx2: Avx2,
    windows: [&[u8]; 2],
    start: usize,
    across: &[i16x16<Avx2>; MAX_PAIRS],
) -> i32x8<Avx2> {
    let mut sum = i32x8::splat(avx2, 0);
    let mut texels = u8x32::splat(avx2, 0);
    for pair in 0..F::TAPS / 2 {
        let at = load_of(pair, C);
        if pair == 0 || at > 0 {
            let [low, high] = windows;
            let low = u8x16::from_slice(avx2, &low[start + at..][..LOADED]);
            texels = low.combine(u8x16::from_slice(avx2, &high[start + at..][..LOADED]));
        }
        let order = u8x32::simd_from(avx2, const { pair_orders(C) }[pair]);
        let taps = texels.swizzle_dyn_within_blocks(order).bitcast();
        let term = instructions::dot(avx2, taps, across[pair]);
        sum = if pair == 0 { term } else { sum + term };
    }
    sum
}

/// For each pair of taps, the byte shuffle that gathers its texels, in each half of a vector, into
/// pairs of 16-bit values, one pair per channel.
const fn pair_orders(channels: usize) -> [[u8; 32]; MAX_PAIRS] {
    let mut orders = [[NONE; 32]; MAX_PAIRS];
    let mut k = 0;
    while k < MAX_PAIRS * channels {
        let (pair, channel) = (k / channels, k % channels);
        let from = pair * 2 * channels - load_of(pair, channels);
        let mut half = 0;
        while half < 32 {
            orders[pair][half + channel * 4] = (from + channel) as u8;
            orders[pair][half + channel * 4 + 2] = (from + channels + channel) as u8;
            half += 16;
        }
        k += 1;
    }
    orders
}

/// Shuffle index that yields zero.
const NONE: u8 = 0x80;

/// The levels of eight texels as contiguous bytes, clamped.
#[inline(always)]
pub(super) fn packed<const C: usize>(
    avx2: Avx2,
    [a, b, c, d]: [i32x8<Avx2>; 4],
) -> [u8; GROUP_VALUES] {
    // Four bytes per texel.
    let bytes = instructions::pack_bytes(avx2, a, b, c, d);
    if C == 4 {
        return bytes.into();
    }
    let order = u8x32::simd_from(avx2, const { pack_texels(C) });
    let words = i32x8::simd_from(avx2, const { join_halves(C) });
    let bytes = bytes.swizzle_dyn_within_blocks(order);
    let bytes: u8x32<Avx2> = instructions::at(avx2, bytes.bitcast(), words).bitcast();
    bytes.into()
}

/// The byte shuffle that packs the four texels in each half of a vector.
const fn pack_texels(channels: usize) -> [u8; 32] {
    let mut order = [NONE; 32];
    let mut k = 0;
    while k < 4 * channels {
        order[k] = (k / channels * 4 + k % channels) as u8;
        order[16 + k] = order[k];
        k += 1;
    }
    order
}

/// The 32-bit words to take so that the packed texels of both halves are contiguous.
const fn join_halves(channels: usize) -> [i32; 8] {
    let mut words = [7; 8];
    let mut k = 0;
    while k < channels {
        words[k] = k as i32;
        words[channels + k] = (4 + k) as i32;
        k += 1;
    }
    words
}
