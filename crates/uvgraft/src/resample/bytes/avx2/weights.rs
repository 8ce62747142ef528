//! Filter weights for eight texels at once.

use std::marker::PhantomData;

use fearless_simd::{
    Avx2, Bytes, SimdBase, SimdCombine, SimdFrom, f32x8, i16x8, i16x16, i32x8, u8x32, u32x8,
};

use super::super::weights::{LANCZOS, Lanczos, ONE, WEIGHT_BITS, WholeTaps};
use super::group::{GROUP, MAX_PAIRS};
use super::instructions;
use crate::filter::{Bilinear, CatmullRom, Lanczos3, MAX_TAPS, Taps};
use crate::resample::position::fraction;

/// A filter with vectorised weights.
pub(super) trait VectorTaps: WholeTaps {
    type Weights: Weights;
}

/// The weights of a filter for eight texels on one axis, equal to [`WholeTaps::whole_weights`].
pub(super) trait Weights {
    fn new(avx2: Avx2, bits: u32x8<Avx2>) -> Self;

    /// The weights of texel `j` in the low half of each vector and of texel `j + 4` in the high
    /// half: for each pair of taps one vector that repeats the two weights.
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

/// Weights that are computed, those of two taps packed into each 32-bit lane.
pub(super) struct Pairs<F>([i32x8<Avx2>; MAX_PAIRS], PhantomData<F>);

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
            pairs[pair] = instructions::blend_words(avx2, low, high << 16).bitcast();
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

/// Weights from a table of phases, interpolated.
pub(super) struct Phases {
    table: &'static Lanczos,
    bits: [u32; GROUP],
    /// Fractions beyond the phases, twice in each 32-bit lane.
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
        let weights: u8x32<Avx2> = (low + instructions::mulhrs(avx2, high - low, parts)).bitcast();
        let mut both = [i16x16::splat(avx2, 0); MAX_PAIRS];
        for pair in 0..MAX_PAIRS {
            let order = u8x32::simd_from(avx2, const { words() }[pair]);
            both[pair] = weights.swizzle_dyn_within_blocks(order).bitcast();
        }
        both
    }
}

/// For each vector of two texels, the index of the texel whose weights each lane takes.
const BOTH: [[i32; 8]; 4] = [
    [0, 0, 0, 0, 4, 4, 4, 4],
    [1, 1, 1, 1, 5, 5, 5, 5],
    [2, 2, 2, 2, 6, 6, 6, 6],
    [3, 3, 3, 3, 7, 7, 7, 7],
];

/// For each 32-bit word of a half, the byte shuffle that broadcasts it within the half.
const fn words() -> [[u8; 32]; MAX_PAIRS] {
    let mut orders = [[0; 32]; MAX_PAIRS];
    let mut k = 0;
    while k < MAX_PAIRS * 32 {
        orders[k / 32][k % 32] = (k / 32 * 4 + k % 4) as u8;
        k += 1;
    }
    orders
}
