//! Why a graft was not made, or not applied.

use crate::blend::{RegionError, ToningError};
use crate::overlay::BandError;
use crate::pair::Direction;
use crate::texture::{Channels, Size, TextureError};

/// Why a graft was not made, or not applied.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraftError {
    /// A texture has another size than the graft was made for.
    #[error("the {what} must be {wanted}, got {found}")]
    Size {
        /// `"texture"` or `"base"`.
        what: &'static str,
        /// The texture's size.
        found: Size,
        /// The size that the graft was made for.
        wanted: Size,
    },
    /// A band is no part of the target.
    #[error(transparent)]
    Band(#[from] BandError),
    /// A normal map without the channels for it.
    #[error("a normal map must have three channels, got {}", found.count())]
    Channels {
        /// The texture's channels.
        found: Channels,
    },
    /// A NaN or an infinity, where one would spoil the whole result: in a fit.
    #[error("texel ({x}, {y}) of the texture is NaN or infinite")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// The region leaves nothing to be carried.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The region or the blend is one of another pair or direction.
    #[error(
        "the {what} must belong to this pair and the direction {wanted:?}, got {} and {found:?}",
        which_pair(*is_other_pair)
    )]
    Domain {
        /// `"region"` or `"blend"`.
        what: &'static str,
        /// Whether it is of another pair.
        is_other_pair: bool,
        /// The direction that it is for.
        found: Direction,
        /// The direction of the graft.
        wanted: Direction,
    },
    /// There is no tone to be found.
    #[error("tones were not matched: {0}")]
    Toning(#[from] ToningError),
    /// A fit that contradicts how the graft was made.
    #[error("cannot fit: {0}")]
    Fit(&'static str),
    /// A size that no texture has, or no memory for one.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

const fn which_pair(is_other: bool) -> &'static str {
    if is_other { "another pair" } else { "this pair" }
}
