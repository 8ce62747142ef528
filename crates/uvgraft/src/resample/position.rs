//! Positions in a source, on one axis: whole numbers of 2⁻³² texels from its top left corner.
//!
//! Whole numbers, because sums of them do not depend on their order, and because the texel and what
//! lies beyond it are just the two halves of one. What a patch maps to is rounded to them once, by
//! 2⁻³³ texels at most; so are its slopes, which makes a position 4096 texels away wrong by 5e-7.

/// One texel.
pub(crate) const TEXEL: i64 = 1 << 32;

/// How far beyond the texture's edge positions may be: more than any window is wide.
const NEAR: i64 = 8 * TEXEL;

/// Positions beyond 2³¹ texels become the last that there are.
pub(crate) fn from_texels(texels: f64) -> i64 {
    // Casts saturate, and truncate what is rounded already.
    (texels * TEXEL as f64).round() as i64
}

pub(crate) fn in_texels(position: i64) -> f64 {
    position as f64 / TEXEL as f64
}

/// A position moved close to the texture where it is far off, as UV coordinates may be: beyond a
/// window's width nothing changes any more.
#[inline(always)]
pub(crate) fn near_texture(position: i64, count: u32) -> i64 {
    position.clamp(-NEAR, i64::from(count) * TEXEL + NEAR)
}

/// The texel that contains a position.
#[inline(always)]
pub(crate) fn containing(position: i64) -> i32 {
    (position >> 32) as i32
}

/// The last texel whose centre does not lie beyond a position, and how far the position lies beyond
/// that centre, in 2⁻³² texels.
#[inline(always)]
pub(crate) fn split(position: i64) -> (i32, u32) {
    let position = position - TEXEL / 2;
    (containing(position), position as u32)
}

/// What is taken off a position so that its whole texels are those of its window's first texel; its
/// fraction is that of [`split`].
#[inline(always)]
pub(crate) const fn before_window(taps: usize) -> i64 {
    TEXEL / 2 + (taps as i64 / 2 - 1) * TEXEL
}

/// A fraction as a float, below 1 and exact: the lowest bits are dropped.
#[inline(always)]
pub(crate) fn fraction(bits: u32) -> f32 {
    // Through a signed number, which vectors convert in one instruction.
    (bits >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
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
