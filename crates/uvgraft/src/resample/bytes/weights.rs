//! Filter weights in fixed point.

use std::sync::LazyLock;

use super::super::position::fraction;
use crate::filter::{Bilinear, CatmullRom, Filter, Lanczos3, MAX_TAPS, Taps};

/// Fraction bits of weights: as many as leave room for slightly more than 1 in 16 bits.
pub(super) const WEIGHT_BITS: u32 = 14;

/// A weight of 1.
pub(super) const ONE: i16 = 1 << WEIGHT_BITS;

/// A filter with fixed-point weights.
pub(super) trait WholeTaps: Taps {
    /// As [`Filter::weights`], in units of 1/[`ONE`].
    ///
    /// - `bits`: distance of a position from a texel's centre, in 2⁻³² texels.
    fn whole_weights(bits: u32) -> [i16; MAX_TAPS];
}

impl WholeTaps for Bilinear {
    #[inline(always)]
    fn whole_weights(bits: u32) -> [i16; MAX_TAPS] {
        // They add up to 1 exactly: areas of one colour keep it.
        let high = (bits >> (32 - WEIGHT_BITS)) as i16;
        [ONE - high, high, 0, 0, 0, 0]
    }
}

impl WholeTaps for CatmullRom {
    #[inline(always)]
    fn whole_weights(bits: u32) -> [i16; MAX_TAPS] {
        Self::weights(fraction(bits)).map(rounded)
    }
}

impl WholeTaps for Lanczos3 {
    #[inline(always)]
    fn whole_weights(bits: u32) -> [i16; MAX_TAPS] {
        let (phase, part) = Lanczos::split(bits);
        let [low, high] = [0, 1].map(|k| LANCZOS.phases[phase + k]);
        std::array::from_fn(|tap| {
            let rise = i32::from(high[tap] - low[tap]) * i32::from(part);
            low[tap] + ((rise + (1 << (Lanczos::PART_BITS - 1))) >> Lanczos::PART_BITS) as i16
        })
    }
}

fn rounded(weight: f32) -> i16 {
    (weight * f32::from(ONE)).round_ties_even() as i16
}

/// Tabulated weights at equally spaced phases, interpolated linearly.
pub(super) struct Lanczos {
    /// Eight weights per phase, the last two 0, to fill a vector.
    pub phases: [[i16; 8]; Self::PHASES + 1],
}

impl Lanczos {
    pub const PHASE_BITS: u32 = 10;
    const PHASES: usize = 1 << Self::PHASE_BITS;
    /// Fraction bits of the position between two phases. As many as `vpmulhrsw` shifts products by.
    pub const PART_BITS: u32 = 15;

    /// The phase before a position, and the fraction beyond it, below 2^[`Lanczos::PART_BITS`].
    #[inline(always)]
    pub fn split(bits: u32) -> (usize, i16) {
        let part = bits >> (32 - Self::PHASE_BITS - Self::PART_BITS);
        ((bits >> (32 - Self::PHASE_BITS)) as usize, (part & ((1 << Self::PART_BITS) - 1)) as i16)
    }
}

pub(super) static LANCZOS: LazyLock<Lanczos> = LazyLock::new(|| {
    let mut phases = [[0; 8]; Lanczos::PHASES + 1];
    for (phase, whole) in phases.iter_mut().enumerate() {
        let weights = Filter::Lanczos3.weights(phase as f32 / Lanczos::PHASES as f32);
        whole[..MAX_TAPS].copy_from_slice(&weights.map(rounded));
    }
    Lanczos { phases }
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_exact_within_rounding() {
        fn check<F: WholeTaps>(worst: f32) {
            for k in 0..100_000u32 {
                let bits = k.wrapping_mul(2_654_435_769);
                let (whole, exact) = (F::whole_weights(bits), F::weights(fraction(bits)));
                for (whole, exact) in whole.iter().zip(exact) {
                    let off = (f32::from(*whole) - exact * f32::from(ONE)).abs();
                    assert!(off <= worst, "{} taps, {bits}: {off}", F::TAPS);
                }
            }
        }
        check::<Bilinear>(1.001);
        check::<CatmullRom>(0.501);
        // Both the tabulated phases and the interpolation between them are rounded.
        check::<Lanczos3>(1.05);
    }
}
