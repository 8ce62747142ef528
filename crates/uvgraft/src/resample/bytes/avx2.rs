//! Eight texels at once, with AVX2. Two of them share a vector, texel `j` in the low half and `j + 4`
//! in the high one, a channel in each number of 32 bits.

use std::marker::PhantomData;

use fearless_simd::{
    Avx2, Bytes, Simd, SimdBase, SimdCombine, SimdFrom, SimdInt, f32x8, i16x8, i16x16, i32x8,
    i64x4, u8x16, u8x32, u32x8,
};

use super::weights::{LANCZOS, Lanczos, ONE, WEIGHT_BITS, WholeTaps};
use super::{GROUP, GROUP_VALUES, Job, LOST, ROW_BITS, SUM_BITS, VALUE_BITS, share};
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3, MAX_TAPS, Taps};
use crate::resample::Walk;
use crate::resample::position::{TEXEL, fraction};
use crate::resample::prefetch::prefetch;

/// Pairs of taps on an axis.
const MAX_PAIRS: usize = MAX_TAPS / 2;

/// Bytes that are read at once.
const LOADED: usize = 16;

/// Fills rows from `first_row` on; see [`super::resample`].
pub(super) fn fill<const C: usize>(avx2: Avx2, job: &Job<'_>, first_row: u32, rows: &mut [u8]) {
    match job.paths.filter {
        Filter::Nearest => unreachable!("takes texels as they are"),
        Filter::Bilinear => fill_with::<C, Bilinear>(avx2, job, first_row, rows),
        Filter::CatmullRom => fill_with::<C, CatmullRom>(avx2, job, first_row, rows),
        Filter::Lanczos3 => fill_with::<C, Lanczos3>(avx2, job, first_row, rows),
    }
}

fn fill_with<const C: usize, F: VectorTaps>(
    avx2: Avx2,
    job: &Job<'_>,
    first_row: u32,
    rows: &mut [u8],
) {
    let source = Source { avx2, values: job.source, stride: job.paths.source.width as usize * C };
    avx2.vectorize(
        #[inline(always)]
        || {
            job.fill::<C, F>(
                first_row,
                rows,
                #[inline(always)]
                |walk, first| eight::<C, F>(&source, walk, first),
            );
        },
    );
}

/// What `fearless_simd` has no name for.
mod instructions {
    use std::arch::x86_64::{
        __m256i, _mm256_blend_epi16, _mm256_castps_si256, _mm256_castsi256_ps, _mm256_cvtps_epi32,
        _mm256_madd_epi16, _mm256_mulhrs_epi16, _mm256_packs_epi32, _mm256_packus_epi16,
        _mm256_permutevar8x32_epi32, _mm256_shuffle_ps,
    };

    use fearless_simd::{Avx2, SimdFrom, f32x8, i16x16, i32x8, u8x32};

    fearless_simd::kernel!(
        /// Products of numbers of 16 bits, those of two neighbours added up.
        #[inline(always)]
        pub fn dot(avx2: Avx2, a: i16x16<Avx2>, b: i16x16<Avx2>) -> i32x8<Avx2> {
            i32x8::simd_from(avx2, _mm256_madd_epi16(a.into(), b.into()))
        }
    );

    fearless_simd::kernel!(
        /// The high 16 bits of twice the products, rounded.
        #[inline(always)]
        pub fn product(avx2: Avx2, a: i16x16<Avx2>, b: i16x16<Avx2>) -> i16x16<Avx2> {
            i16x16::simd_from(avx2, _mm256_mulhrs_epi16(a.into(), b.into()))
        }
    );

    fearless_simd::kernel!(
        /// The numbers of a vector at some indices.
        #[inline(always)]
        pub fn at(avx2: Avx2, numbers: i32x8<Avx2>, indices: i32x8<Avx2>) -> i32x8<Avx2> {
            let result = _mm256_permutevar8x32_epi32(numbers.into(), indices.into());
            i32x8::simd_from(avx2, result)
        }
    );

    fearless_simd::kernel!(
        /// The low 16 bits of one vector's numbers and the high ones of another's.
        #[inline(always)]
        pub fn side_by_side(avx2: Avx2, low: i32x8<Avx2>, high: i32x8<Avx2>) -> i16x16<Avx2> {
            let result = _mm256_blend_epi16::<0b1010_1010>(low.into(), high.into());
            i16x16::simd_from(avx2, result)
        }
    );

    fearless_simd::kernel!(
        /// Rounds, ties to even.
        #[inline(always)]
        pub fn rounded(avx2: Avx2, numbers: f32x8<Avx2>) -> i32x8<Avx2> {
            i32x8::simd_from(avx2, _mm256_cvtps_epi32(numbers.into()))
        }
    );

    fearless_simd::kernel!(
        /// The low numbers of each pair within halves of two vectors, then the high ones.
        #[inline(always)]
        pub fn unzipped(avx2: Avx2, a: i32x8<Avx2>, b: i32x8<Avx2>) -> [i32x8<Avx2>; 2] {
            let a = _mm256_castsi256_ps(a.into());
            let b = _mm256_castsi256_ps(b.into());
            let [low, high]: [__m256i; 2] = [
                _mm256_castps_si256(_mm256_shuffle_ps::<0b1000_1000>(a, b)),
                _mm256_castps_si256(_mm256_shuffle_ps::<0b1101_1101>(a, b)),
            ];
            [i32x8::simd_from(avx2, low), i32x8::simd_from(avx2, high)]
        }
    );

    fearless_simd::kernel!(
        /// Numbers clamped to bytes: the low halves of all, then the high halves.
        #[inline(always)]
        pub fn clamped(
            avx2: Avx2,
            a: i32x8<Avx2>,
            b: i32x8<Avx2>,
            c: i32x8<Avx2>,
            d: i32x8<Avx2>,
        ) -> u8x32<Avx2> {
            let low = _mm256_packs_epi32(a.into(), b.into());
            let high = _mm256_packs_epi32(c.into(), d.into());
            u8x32::simd_from(avx2, _mm256_packus_epi16(low, high))
        }
    );
}

struct Source<'a> {
    avx2: Avx2,
    values: &'a [u8],
    /// Values in a row.
    stride: usize,
}

#[inline(always)]
fn eight<const C: usize, F: VectorTaps>(
    source: &Source<'_>,
    walk: &Walk<'_>,
    first: u32,
) -> [u8; GROUP_VALUES] {
    let lines = Lines::new::<C, F>(source, walk);
    let [columns, rows] = walk.samples();
    if [columns, rows] == [1, 1] {
        const HALF: i32 = (1 << (VALUE_BITS - 1)) + LOST;
        let mut values = windows::<C, F>(source, &lines, walk.centre(first));
        for value in &mut values {
            *value = (*value + HALF) >> VALUE_BITS;
        }
        return packed::<C>(source.avx2, values);
    }
    let mut sums = [i32x8::splat(source.avx2, 0); 4];
    for b in 0..rows {
        for a in 0..columns {
            let values = windows::<C, F>(source, &lines, walk.sample(first, a, b));
            for j in 0..4 {
                sums[j] += (values[j] + LOST) >> (VALUE_BITS - SUM_BITS);
            }
        }
    }
    let share = share([columns, rows]);
    for sum in &mut sums {
        *sum = instructions::rounded(source.avx2, sum.to_float::<f32x8<Avx2>>() * share);
    }
    packed::<C>(source.avx2, sums)
}

/// How positions go on from a group's first.
struct Lines {
    /// Texels 0, 1, 4 and 5, and 2, 3, 6 and 7: halves of them shuffle into order.
    offsets: [[i64x4<Avx2>; 2]; 2],
    /// See [`Walk::ahead`].
    ahead: isize,
}

impl Lines {
    #[inline(always)]
    fn new<const C: usize, F: VectorTaps>(source: &Source<'_>, walk: &Walk<'_>) -> Self {
        let [x, y] = walk.step();
        let times = |step: i64, k: i64| step.wrapping_mul(k);
        let low = |s: i64| i64x4::simd_from(source.avx2, [0, s, times(s, 4), times(s, 5)]);
        let high = |s: i64| low(s) + times(s, 2);
        let offsets = [[low(x), high(x)], [low(y), high(y)]];
        let ahead = walk.ahead(source.stride, C, F::TAPS);
        Self { offsets, ahead }
    }

    /// Texels and fractions on one axis, as [`split`](crate::resample::position::split).
    #[inline(always)]
    fn split(&self, avx2: Avx2, axis: usize, start: i64) -> (i32x8<Avx2>, u32x8<Avx2>) {
        let [low, high] = self.offsets[axis];
        let [low, high] = [low + start, high + start];
        let [bits, texels] = instructions::unzipped(avx2, low.bitcast(), high.bitcast());
        (texels, bits.bitcast())
    }
}

/// The values of eight windows, as [`super::filtered`].
///
/// - `at`: the position of the first.
#[inline(always)]
fn windows<const C: usize, F: VectorTaps>(
    source: &Source<'_>,
    lines: &Lines,
    at: [i64; 2],
) -> [i32x8<Avx2>; 4] {
    const BELOW: u32 = WEIGHT_BITS - ROW_BITS;
    let avx2 = source.avx2;
    let pairs = F::TAPS / 2;
    let before = TEXEL / 2 + (F::TAPS as i64 / 2 - 1) * TEXEL;
    let (x, bits_x) = lines.split(avx2, 0, at[0].wrapping_sub(before));
    let (y, bits_y) = lines.split(avx2, 1, at[1].wrapping_sub(before));
    let starts: [i32; GROUP] = (y * source.stride as i32 + x * C as i32).into();
    let (across, down) = (F::Weights::new(avx2, bits_x), F::Weights::new(avx2, bits_y));
    for k in [0, GROUP - 1] {
        prefetch(source.values, starts[k] as u32 as isize + lines.ahead);
    }
    // From a window's first value to its last as one slice, so that one check does.
    let span = (F::TAPS - 1) * source.stride + load_of(pairs - 1, C) + LOADED;
    let mut values = [i32x8::splat(avx2, 0); 4];
    for j in 0..4 {
        let windows = [
            &source.values[starts[j] as u32 as usize..][..span],
            &source.values[starts[j + 4] as u32 as usize..][..span],
        ];
        let (across, down) = (across.of_both(avx2, j), down.of_both(avx2, j));
        for pair in 0..pairs {
            let start = 2 * pair * source.stride;
            let upper = row::<C, F>(avx2, windows, start, &across);
            let lower = row::<C, F>(avx2, windows, start + source.stride, &across);
            // The 16 bits of both that are kept.
            let both = instructions::side_by_side(avx2, upper >> BELOW, lower << (16 - BELOW));
            let term = instructions::dot(avx2, both, down[pair]);
            values[j] = if pair == 0 { term } else { values[j] + term };
        }
    }
    values
}

/// Where the bytes begin that a pair of taps is taken from, in a row of a window: with the pairs
/// before it, if all are in reach.
const fn load_of(pair: usize, channels: usize) -> usize {
    if (pair * 2 + 2) * channels <= LOADED { 0 } else { pair * 2 * channels }
}

/// A row of two windows, filtered.
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

/// For each pair of taps, what shuffles their texels in each half of a vector into pairs of 16 bits,
/// one for each channel.
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

/// What a shuffle gives zero for.
const NONE: u8 = 0x80;

/// A filter whose weights there are for eight texels at once.
trait VectorTaps: WholeTaps {
    type Weights: Weights;
}

/// A filter's weights for eight texels on one axis, as [`WholeTaps::whole_weights`].
trait Weights {
    fn new(avx2: Avx2, bits: u32x8<Avx2>) -> Self;

    /// Those of texels `j` and `j + 4` for their halves of a vector: for each pair of taps the two
    /// weights, as often as there is room.
    fn of_both(&self, avx2: Avx2, j: usize) -> [i16x16<Avx2>; MAX_PAIRS];
}

impl VectorTaps for Bilinear {
    type Weights = Pairs<Self>;
}

impl VectorTaps for CatmullRom {
    type Weights = Pairs<Self>;
}

impl VectorTaps for Lanczos3 {
    type Weights = Phases;
}

/// Weights that are computed: those of two taps in each number of 32 bits.
struct Pairs<F>([i32x8<Avx2>; MAX_PAIRS], PhantomData<F>);

impl<F: WholeTaps> Weights for Pairs<F> {
    #[inline(always)]
    fn new(avx2: Avx2, bits: u32x8<Avx2>) -> Self {
        let mut pairs = [i32x8::splat(avx2, 0); MAX_PAIRS];
        if F::TAPS == Bilinear::TAPS {
            let high: i32x8<Avx2> = (bits >> (32 - WEIGHT_BITS)).bitcast();
            pairs[0] = (i32::from(ONE) - high) | (high << 16);
            return Self(pairs, PhantomData);
        }
        let bits: [u32; GROUP] = bits.into();
        let mut weights = [[0.0; GROUP]; MAX_TAPS];
        for k in 0..GROUP {
            let of_texel = F::weights(fraction(bits[k]));
            for tap in 0..F::TAPS {
                weights[tap][k] = of_texel[tap];
            }
        }
        for pair in 0..F::TAPS / 2 {
            let low = f32x8::simd_from(avx2, weights[pair * 2]) * f32::from(ONE);
            let high = f32x8::simd_from(avx2, weights[pair * 2 + 1]) * f32::from(ONE);
            let low = instructions::rounded(avx2, low);
            let high = instructions::rounded(avx2, high);
            pairs[pair] = instructions::side_by_side(avx2, low, high << 16).bitcast();
        }
        Self(pairs, PhantomData)
    }

    #[inline(always)]
    fn of_both(&self, avx2: Avx2, j: usize) -> [i16x16<Avx2>; MAX_PAIRS] {
        let which = i32x8::simd_from(avx2, BOTH[j]);
        let mut both = [i16x16::splat(avx2, 0); MAX_PAIRS];
        for pair in 0..F::TAPS / 2 {
            both[pair] = instructions::at(avx2, self.0[pair], which).bitcast();
        }
        both
    }
}

/// Weights from a table.
struct Phases {
    table: &'static Lanczos,
    bits: [u32; GROUP],
    /// How far beyond phases, twice in each number of 32 bits.
    parts: i32x8<Avx2>,
}

impl Weights for Phases {
    #[inline(always)]
    fn new(_: Avx2, bits: u32x8<Avx2>) -> Self {
        let part = (bits << Lanczos::PHASE_BITS) >> (32 - Lanczos::PART_BITS);
        Self { table: &LANCZOS, bits: bits.into(), parts: (part | (part << 16)).bitcast() }
    }

    #[inline(always)]
    fn of_both(&self, avx2: Avx2, j: usize) -> [i16x16<Avx2>; MAX_PAIRS] {
        let (first, _) = Lanczos::split(self.bits[j]);
        let (second, _) = Lanczos::split(self.bits[j + 4]);
        let phases = &self.table.phases;
        let low =
            i16x8::simd_from(avx2, phases[first]).combine(i16x8::simd_from(avx2, phases[second]));
        let high = i16x8::simd_from(avx2, phases[first + 1])
            .combine(i16x8::simd_from(avx2, phases[second + 1]));
        let parts = instructions::at(avx2, self.parts, i32x8::simd_from(avx2, BOTH[j])).bitcast();
        let weights: u8x32<Avx2> = (low + instructions::product(avx2, high - low, parts)).bitcast();
        let mut both = [i16x16::splat(avx2, 0); MAX_PAIRS];
        for pair in 0..MAX_PAIRS {
            let order = u8x32::simd_from(avx2, const { words() }[pair]);
            both[pair] = weights.swizzle_dyn_within_blocks(order).bitcast();
        }
        both
    }
}

/// Which texels' weights go with the texels of one vector.
const BOTH: [[i32; 8]; 4] = [
    [0, 0, 0, 0, 4, 4, 4, 4],
    [1, 1, 1, 1, 5, 5, 5, 5],
    [2, 2, 2, 2, 6, 6, 6, 6],
    [3, 3, 3, 3, 7, 7, 7, 7],
];

/// For each of a half's words of 32 bits, what shuffles it all over the half.
const fn words() -> [[u8; 32]; MAX_PAIRS] {
    let mut orders = [[0; 32]; MAX_PAIRS];
    let mut k = 0;
    while k < MAX_PAIRS * 32 {
        orders[k / 32][k % 32] = (k / 32 * 4 + k % 4) as u8;
        k += 1;
    }
    orders
}

/// The levels of eight texels as bytes one after the other, clamped.
#[inline(always)]
fn packed<const C: usize>(avx2: Avx2, [a, b, c, d]: [i32x8<Avx2>; 4]) -> [u8; GROUP_VALUES] {
    // Four bytes for each texel.
    let bytes = instructions::clamped(avx2, a, b, c, d);
    if C == 4 {
        return bytes.into();
    }
    let order = u8x32::simd_from(avx2, const { close_up(C) });
    let words = i32x8::simd_from(avx2, const { halves_together(C) });
    let bytes = bytes.swizzle_dyn_within_blocks(order);
    let bytes: u8x32<Avx2> = instructions::at(avx2, bytes.bitcast(), words).bitcast();
    bytes.into()
}

/// Shuffles four texels of each half of a vector together.
const fn close_up(channels: usize) -> [u8; 32] {
    let mut order = [NONE; 32];
    let mut k = 0;
    while k < 4 * channels {
        order[k] = (k / channels * 4 + k % channels) as u8;
        order[16 + k] = order[k];
        k += 1;
    }
    order
}

/// Which words of 32 bits to take so that four texels of each half are side by side.
const fn halves_together(channels: usize) -> [i32; 8] {
    let mut words = [7; 8];
    let mut k = 0;
    while k < channels {
        words[k] = k as i32;
        words[channels + k] = (4 + k) as i32;
        k += 1;
    }
    words
}
