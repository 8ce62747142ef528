//! Formats of embedded images, and why an image was refused.

use uvgraft::TextureError;
use uvgraft_io::image::{EncodeError, ImageError};

/// A format of images in GLB files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PictureFormat {
    /// Lossless; read by everything.
    Png,
    /// Lossy and without opacity; read by everything.
    Jpeg,
    /// Written lossless, smaller than PNG; needs `EXT_texture_webp`, which browsers have.
    WebP,
    /// Compressed for graphics processors, which keep it so; needs `KHR_texture_basisu`.
    Ktx2,
}

impl PictureFormat {
    /// The media type.
    pub const fn mime_type(self) -> &'static str {
        match self {
            Self::Png => "image/png",
            Self::Jpeg => "image/jpeg",
            Self::WebP => "image/webp",
            Self::Ktx2 => "image/ktx2",
        }
    }
}

/// Why an image cannot be part of a GLB file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The image is damaged, or in no format that is known.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// A format that glTF does not have.
    #[error("a GLB file must hold PNG, JPEG, WebP or KTX2 images, got {found}; convert it first")]
    Format {
        /// What it is.
        found: &'static str,
    },
    /// A KTX2 file that `KHR_texture_basisu` does not allow.
    #[error("a KTX2 image {problem}")]
    Ktx2 {
        /// What is wrong.
        problem: &'static str,
    },
    /// What stands in for an image where its format is unknown must be PNG or JPEG.
    #[error("a fallback image must be PNG or JPEG, got {found:?}")]
    Fallback {
        /// What it is.
        found: PictureFormat,
    },
    /// The encoder refused.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// There is not enough memory to resize the texture.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// This build has no encoder for it.
    #[error("KTX2 encoding needs a build with the feature `ktx2`")]
    NoKtx2,
}
