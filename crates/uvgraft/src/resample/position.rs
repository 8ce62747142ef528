//! Source positions on one axis: 32.32 fixed point, in units of 2⁻³² texels from the top left
//! corner.
//!
//! Fixed point, because sums of integers do not depend on their order, and because the texel and
//! the fraction are the two halves of one integer. A patch's origin is rounded once, by at most
//! 2⁻³³ texels, and so are its slopes, which makes a position 4096 texels away wrong by 5e-7.

/// One texel.
pub(crate) const TEXEL: i64 = 1 << 32;

/// Distance beyond the texture's edge at which positions are clamped: wider than any window.
const NEAR: i64 = 8 * TEXEL;

/// Positions beyond 2³¹ texels saturate.
pub(crate) fn from_texels(texels: f64) -> i64 {
    // Casts saturate; truncation has no effect after rounding.
    (texels * TEXEL as f64).round() as i64
}

pub(crate) fn in_texels(position: i64) -> f64 {
    position as f64 / TEXEL as f64
}

/// Clamps a position to the vicinity of the texture, since UV coordinates may be far off: more than
/// a window's width outside, the result no longer changes.
#[inline(always)]
pub(crate) fn near_texture(position: i64, count: u32) -> i64 {
    position.clamp(-NEAR, i64::from(count) * TEXEL + NEAR)
}

/// The texel that contains a position.
#[inline(always)]
pub(crate) fn containing(position: i64) -> i32 {
    (position >> 32) as i32
}

/// The texels and the fractions of positions, by the half that comes first in memory and the one that
/// comes second.
#[inline(always)]
pub(super) fn halves<V>(first: V, second: V) -> (V, V) {
    if cfg!(target_endian = "little") { (second, first) } else { (first, second) }
}

/// The last texel whose centre is not beyond a position, and the position's distance from that
/// centre, in 2⁻³² texels.
#[inline(always)]
pub(crate) fn split(position: i64) -> (i32, u32) {
    let position = position - TEXEL / 2;
    (containing(position), position as u32)
}

/// The offset to subtract from a position so that its integer part is the first texel of its
/// window; the fraction remains that of [`split`].
#[inline(always)]
pub(crate) const fn before_window(taps: usize) -> i64 {
    TEXEL / 2 + (taps as i64 / 2 - 1) * TEXEL
}

/// A fraction as a float, exact and below 1: the 8 lowest bits are dropped.
#[inline(always)]
pub(crate) fn fraction(bits: u32) -> f32 {
    // Via a signed integer, which SIMD converts in one instruction.
    (bits >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_by_hand() {
        assert_eq!(from_texels(1.5), 3 * TEXEL / 2);
        assert_eq!(from_texels(1e30), i64::MAX);
        assert_eq!(in_texels(-TEXEL / 4), -0.25);
        assert_eq!(split(from_texels(0.25)), (-1, 3 << 30));
        assert_eq!(split(from_texels(2.5)), (2, 0));
        assert_eq!(containing(from_texels(2.99)), 2);
        assert_eq!(near_texture(i64::MAX, 64), 72 * TEXEL);
        assert_eq!(near_texture(i64::MIN, 64), -8 * TEXEL);
        assert_eq!(fraction(3 << 30), 0.75);
        assert!(fraction(u32::MAX) < 1.0);
    }
}
