//! Errors of making or applying a graft.

use uvgraft_surface::pair::Direction;

use crate::blend::{RegionError, ToneError};
use crate::overlay::BandError;
use crate::texture::{Channels, Size, TextureError};

/// Why a graft could not be made or applied.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraftError {
    /// A texture does not have the size that the graft was made for.
    #[error("the {what} must be {wanted}, got {found}")]
    Size {
        /// `"texture"` or `"base"`.
        what: &'static str,
        /// The texture's size.
        found: Size,
        /// The size that the graft was made for.
        wanted: Size,
    },
    /// A band does not lie within the target.
    #[error(transparent)]
    Band(#[from] BandError),
    /// A normal map with fewer than three channels.
    #[error("a normal map must have three channels, got {}", found.count())]
    Channels {
        /// The texture's channels.
        found: Channels,
    },
    /// A NaN or an infinity in a texture to be fitted, where one would spoil the whole result.
    #[error("texel ({x}, {y}) of the texture is NaN or infinite")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
    /// No linked triangles are left in the region.
    #[error(transparent)]
    Region(#[from] RegionError),
    /// The region or the blend belongs to another pair or direction.
    #[error(
        "the {what} must belong to this pair and the direction {wanted:?}, got {} and {found:?}",
        which_pair(*is_other_pair)
    )]
    Domain {
        /// `"region"` or `"blend"`.
        what: &'static str,
        /// Whether it belongs to another pair.
        is_other_pair: bool,
        /// The direction that it belongs to.
        found: Direction,
        /// The direction of the graft.
        wanted: Direction,
    },
    /// Something that needs the meshes of a pair, for a graft through a map.
    #[error("{0}, got a map without meshes")]
    NoMeshes(&'static str),
    /// No tone could be estimated.
    #[error("tones were not matched: {0}")]
    ToneCorrection(#[from] ToneError),
    /// A fit that the graft or the options do not allow.
    #[error("cannot fit: {0}")]
    Fit(&'static str),
    /// An impossible texture size, or not enough memory.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

const fn which_pair(is_other: bool) -> &'static str {
    if is_other { "another pair" } else { "this pair" }
}
