//! Formats of embedded images, and errors for them.

use uvgraft::{Choice, TextureError};
use uvgraft_image::{EncodeError, Format, ImageError};

/// An image format of GLB files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum EmbeddedFormat {
    /// Lossless; supported by all readers.
    Png,
    /// Lossy, without alpha; supported by all readers.
    Jpeg,
    /// Written lossless and smaller than PNG; needs `EXT_texture_webp`, which browsers support.
    WebP,
    /// Stays compressed in GPU memory; needs `KHR_texture_basisu`.
    Ktx2,
}

uvgraft::choices!(EmbeddedFormat {
    Png => "png", "Lossless, supported everywhere";
    Jpeg => "jpeg", "Lossy and small, supported everywhere";
    WebP => "webp", "Lossless and smaller than PNG, supported by browsers and Blender";
    Ktx2 => "ktx2", "Stays compressed on the GPU; needs a build with the feature `ktx2`";
});

impl EmbeddedFormat {
    /// The format of an image file; `None` for those that glTF does not support.
    pub fn of(format: Format) -> Option<Self> {
        let is_it = |it: &Self| it.mime_type() == format.codec().media_type;
        Self::ALL.iter().copied().find(is_it)
    }

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

/// Why an image cannot be embedded in a GLB file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EmbedError {
    /// The image is damaged, or its format is unknown.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// An image format that glTF does not support.
    #[error("a GLB file must hold PNG, JPEG, WebP or KTX2 images, got {found}; convert it first")]
    Format {
        /// The format.
        found: &'static str,
    },
    /// A KTX2 file that `KHR_texture_basisu` does not allow.
    #[error("a KTX2 image {problem}")]
    Ktx2 {
        /// The problem, to complete "a KTX2 image ...".
        problem: &'static str,
    },
    /// The encoder failed.
    #[error(transparent)]
    Encode(#[from] EncodeError),
    /// There is not enough memory to resize the texture.
    #[error(transparent)]
    Texture(#[from] TextureError),
    /// This build has no KTX2 encoder.
    #[error("KTX2 encoding needs a build with the feature `ktx2`")]
    NoKtx2,
}
