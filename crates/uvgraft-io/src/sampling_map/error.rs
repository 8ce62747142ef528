//! Errors of maps from other tools.

use uvgraft::PositionsError;

use crate::arrays::ArraysError;
use crate::beginning;
use uvgraft_image::ImageError;

/// What is read.
const WANTED: &str = if cfg!(feature = "exr") {
    "an NPY array, an NPZ archive with uv_grid and pix_to_face, or an ST map (EXR)"
} else {
    "an NPY array or an NPZ archive with uv_grid and pix_to_face, in a build without EXR"
};

/// Why the bytes of a map were rejected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapFileError {
    /// The file has another format.
    #[error("must be {WANTED}; {}", beginning(start))]
    Foreign {
        /// How it begins.
        start: Vec<u8>,
    },
    /// A matrix, which says what is filtered but not where.
    #[error(
        "must hold positions, got a sparse matrix, which is applied in SciPy: H @ texture; export \
         the map as .npy, .npz or .exr"
    )]
    Matrix,
    /// A damaged array, or none of the name.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// An array of an unexpected shape.
    #[error("{name} must have the shape {wanted}, got {found:?}")]
    Shape {
        /// Its name.
        name: &'static str,
        /// The required shape.
        wanted: String,
        /// Its shape.
        found: Vec<usize>,
    },
    /// A convention that does not exist.
    #[error("convention must be reference or exact, got `{found}`")]
    Convention {
        /// Its name.
        found: String,
    },
    /// The convention is exact, but the size of the source is missing or impossible.
    #[error("source_size must be a width and a height from 1 to 32768 for the convention exact")]
    SourceSize,
    /// A damaged image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// An image without the channels of positions.
    #[error("an ST map must have the channels R and G, got a greyscale image")]
    Channels,
    /// An image that is transparent everywhere.
    #[error("an ST map must have an alpha of 1 at covered texels, got at most {found}")]
    Transparent {
        /// The largest alpha.
        found: f32,
    },
    /// Positions that make no map.
    #[error(transparent)]
    Positions(#[from] PositionsError),
}
