//! How many texels are filtered at once, and of what.

use fearless_simd::Avx2;

use crate::filter::MAX_TAPS;

/// Texels that are filtered at once.
pub(super) const GROUP: usize = 8;

/// The most values that a group has.
pub(super) const GROUP_VALUES: usize = GROUP * 4;

/// The most bytes that are read from where a row of a window begins.
pub(super) const MAX_READ: usize = 32;

/// Pairs of taps on an axis.
pub(super) const MAX_PAIRS: usize = MAX_TAPS / 2;

/// A source, and the instructions that it is read with.
pub(super) struct Source<'a> {
    pub avx2: Avx2,
    pub values: &'a [u8],
    /// Values in a row.
    pub stride: usize,
}
