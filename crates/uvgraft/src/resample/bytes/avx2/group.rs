//! The sizes of a group of texels that are filtered at once, and their source.

use fearless_simd::Avx2;

use crate::filter::MAX_TAPS;

/// Texels that are filtered at once.
pub(super) const GROUP: usize = 8;

/// Maximum number of values in a group.
pub(super) const GROUP_VALUES: usize = GROUP * 4;

/// Maximum number of pairs of taps on an axis.
pub(super) const MAX_PAIRS: usize = MAX_TAPS / 2;

/// A source texture, with the SIMD token.
pub(super) struct Source<'a> {
    pub avx2: Avx2,
    pub values: &'a [u8],
    /// Values per row.
    pub stride: usize,
}
