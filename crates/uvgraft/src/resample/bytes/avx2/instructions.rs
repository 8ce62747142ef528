//! AVX2 instructions that `fearless_simd` does not expose.

use std::arch::x86_64::{
    _mm256_blend_epi16, _mm256_cvtps_epi32, _mm256_madd_epi16, _mm256_mulhrs_epi16,
    _mm256_packs_epi32, _mm256_packus_epi16, _mm256_permutevar8x32_epi32,
};

use fearless_simd::{Avx2, SimdFrom, f32x8, i16x16, i32x8, u8x32};

fearless_simd::kernel!(
    /// Multiplies 16-bit lanes and adds the products of neighbours (`vpmaddwd`).
    #[inline(always)]
    pub fn dot(avx2: Avx2, a: i16x16<Avx2>, b: i16x16<Avx2>) -> i32x8<Avx2> {
        i32x8::simd_from(avx2, _mm256_madd_epi16(a.into(), b.into()))
    }
);

fearless_simd::kernel!(
    /// The high 16 bits of twice the products of 16-bit lanes, rounded (`vpmulhrsw`).
    #[inline(always)]
    pub fn mulhrs(avx2: Avx2, a: i16x16<Avx2>, b: i16x16<Avx2>) -> i16x16<Avx2> {
        i16x16::simd_from(avx2, _mm256_mulhrs_epi16(a.into(), b.into()))
    }
);

fearless_simd::kernel!(
    /// The 32-bit lanes of a vector at `indices` (`vpermd`).
    #[inline(always)]
    pub fn at(avx2: Avx2, numbers: i32x8<Avx2>, indices: i32x8<Avx2>) -> i32x8<Avx2> {
        let result = _mm256_permutevar8x32_epi32(numbers.into(), indices.into());
        i32x8::simd_from(avx2, result)
    }
);

fearless_simd::kernel!(
    /// Combines the low 16 bits of each lane of `low` with the high 16 bits of each lane of
    /// `high` (`vpblendw`).
    #[inline(always)]
    pub fn blend_words(avx2: Avx2, low: i32x8<Avx2>, high: i32x8<Avx2>) -> i16x16<Avx2> {
        let result = _mm256_blend_epi16::<0b1010_1010>(low.into(), high.into());
        i16x16::simd_from(avx2, result)
    }
);

fearless_simd::kernel!(
    /// Rounds to integers, ties to even (`vcvtps2dq`).
    #[inline(always)]
    pub fn rounded(avx2: Avx2, numbers: f32x8<Avx2>) -> i32x8<Avx2> {
        i32x8::simd_from(avx2, _mm256_cvtps_epi32(numbers.into()))
    }
);

fearless_simd::kernel!(
    /// Packs 32-bit lanes into bytes with saturation: the low halves of all vectors, then the high
    /// halves (`vpackssdw`, `vpackuswb`).
    #[inline(always)]
    pub fn pack_bytes(
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
