//! Errors of images, and the losses of writing them.

use std::io;
use std::path::PathBuf;

use uvgraft::texture::{Depth, Size, Texture, TextureError};

use super::{Format, TextureSpec};
use uvgraft_files::input::beginning;

/// Why bytes were rejected as an image.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The bytes match the signature of no format.
    #[error("not a supported image ({wanted}): {}", beginning(start))]
    NotAnImage {
        /// The first bytes, at most 8.
        start: Vec<u8>,
        /// The formats that are supported.
        wanted: String,
    },
    /// A side is longer than a texture may be. Checked before anything is allocated.
    #[error(
        "{format} must have at most {max} texels a side, got {width}×{height}",
        max = Texture::MAX_SIDE
    )]
    TooLarge {
        /// The format of the file.
        format: Format,
        /// The width that the header states.
        width: u64,
        /// The height that the header states.
        height: u64,
    },
    /// Decoding would exceed the memory limit. Checked before anything is allocated.
    #[error("{format} of {size} texels must take at most {max} bytes in memory, got {found}")]
    TooManyBytes {
        /// The format of the file.
        format: Format,
        /// The size that the header states.
        size: Size,
        /// Bytes of the decoded image.
        found: u64,
        /// The limit.
        max: u64,
    },
    /// The file is too short for an image of its size, unless it hardly shows anything. Checked before
    /// anything is allocated.
    #[error("{format} of {size} texels must have at least {least} bytes, got {found}")]
    Unbacked {
        /// The format of the file.
        format: Format,
        /// The size that the header states.
        size: Size,
        /// Bytes of the file.
        found: u64,
        /// Fewest bytes of such a file.
        least: u64,
    },
    /// The file is truncated.
    #[error("truncated {format}")]
    Truncated {
        /// The format of the file.
        format: Format,
    },
    /// A valid file of a kind that cannot become a texture.
    #[error("unsupported {format}: {found}; {wanted}")]
    Unsupported {
        /// The format of the file.
        format: Format,
        /// What the file contains.
        found: String,
        /// What is supported instead.
        wanted: &'static str,
    },
    /// The file violates its format.
    #[error("damaged {format}: {reason}")]
    Damaged {
        /// The format of the file.
        format: Format,
        /// The decoder's message.
        reason: String,
    },
    /// The decoder failed in a way that says nothing about the file. Other programs may read it.
    #[error("unsupported or damaged {format}: its decoder gave up ({reason})")]
    GaveUp {
        /// The format of the file.
        format: Format,
        /// The decoder's message.
        reason: String,
    },
    /// The ICC profile is too long.
    #[error("ICC profile must have at most {max} bytes, got {found}")]
    IccTooLarge {
        /// Bytes of the profile.
        found: usize,
        /// The limit.
        max: usize,
    },
    /// The decoded texels do not form a texture.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

impl ImageError {
    /// [`ImageError::Damaged`], with a reason of any kind.
    pub fn damaged(format: Format, reason: impl std::fmt::Display) -> Self {
        Self::Damaged { format, reason: reason.to_string() }
    }

    /// Reading from memory fails only at its end, so every such failure means truncation.
    pub fn from_io(format: Format, error: &io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => Self::Truncated { format },
            _ => Self::damaged(format, error),
        }
    }
}

/// Why a file could not be read as an image.
pub type ReadError = uvgraft_files::input::ReadError<ImageError>;

/// Why a texture was not encoded.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// The texture has an alpha channel, which the format does not support.
    #[error(
        "{format} does not support transparency; use {}, or remove the alpha channel",
        Format::names_of(|format| format.has_alpha, "or")
    )]
    Alpha {
        /// The requested format.
        format: Format,
    },
    /// The texture is larger than the format allows.
    #[error("{format} supports at most {max} texels a side, got {found}")]
    TooLarge {
        /// The requested format.
        format: Format,
        /// The size of the texture.
        found: Size,
        /// The longest side of the format.
        max: u32,
    },
    /// The texture has more texels than the format can be encoded with at once.
    #[error(
        "{format} must have at most {max} texels, got {found}; use {}",
        Format::names_of(|format| !format.is_encoded_whole(), "or")
    )]
    TooManyTexels {
        /// The requested format.
        format: Format,
        /// The size of the texture.
        found: Size,
        /// The limit.
        max: u64,
    },
    /// The ICC profile is too long.
    #[error("ICC profile must have at most {max} bytes, got {found}")]
    IccTooLarge {
        /// Bytes of the profile.
        found: usize,
        /// The limit.
        max: usize,
    },
    /// A band does not belong to the image.
    #[error("rows must match an image of {wanted}, got {found}")]
    Band {
        /// The band.
        found: TextureSpec,
        /// The image as announced.
        wanted: TextureSpec,
    },
    /// The number of rows written differs from that of the image.
    #[error("an image of {wanted} rows must be written in full, got {found}")]
    Rows {
        /// Rows written.
        found: u64,
        /// Rows of the image as announced.
        wanted: u32,
    },
    /// An encoded segment does not follow the rows written so far, or belongs to another image.
    #[error("the next segment must be one of this image from row {wanted} on, got row {found}")]
    Segment {
        /// The first row of the segment.
        found: u32,
        /// Rows written so far.
        wanted: u32,
    },
    /// The encoder failed.
    #[error("{format} encoder: {reason}")]
    Encoder {
        /// The requested format.
        format: Format,
        /// The encoder's message.
        reason: String,
    },
    /// The output could not be written.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl EncodeError {
    /// [`EncodeError::Encoder`], with a reason of any kind.
    pub fn encoder(format: Format, reason: impl std::fmt::Display) -> Self {
        Self::Encoder { format, reason: reason.to_string() }
    }
}

/// Why an image file was not written. An existing file is unchanged.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The format cannot be inferred from the path.
    #[error(
        "{}: cannot infer an image format from {}; use one of {}",
        path.display(),
        path.extension().map_or("a name without an extension".to_owned(), |found| {
            format!("the extension .{}", found.display())
        }),
        Format::extension_list()
    )]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// Encoding or writing failed.
    #[error("cannot write {}: {reason}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: EncodeError,
    },
}

/// A part of an image that the written file does not preserve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Loss {
    /// The format cannot store the ICC profile.
    IccProfile {
        /// The format that was written.
        format: Format,
    },
    /// The values were converted between sRGB and linear light, so the profile no longer applies.
    IccOutdated,
    /// Values were rounded to a smaller depth.
    Precision {
        /// The depth of the texture.
        from: Depth,
        /// The depth of the file.
        to: Depth,
    },
    /// Values below 0.0, above 1.0 or NaN were clamped.
    Range,
    /// Texels with alpha 0 lost their colour, because the file stores premultiplied colours.
    HiddenColor {
        /// The format that was written.
        format: Format,
    },
}

impl std::fmt::Display for Loss {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let depth = |depth| match depth {
            Depth::U8 => "8 bits",
            Depth::U16 => "16 bits",
            Depth::F32 => "float",
        };
        match *self {
            Self::IccProfile { format } => {
                write!(f, "ICC profile dropped: {format} cannot store one")
            }
            Self::IccOutdated => f.write_str(
                "ICC profile dropped: values were converted between sRGB and linear light",
            ),
            Self::Precision { from, to } => {
                write!(f, "values rounded from {} to {}", depth(from), depth(to))
            }
            Self::Range => f.write_str("values clamped to 0.0 to 1.0"),
            Self::HiddenColor { format } => write!(
                f,
                "colours of fully transparent texels dropped: {format} stores premultiplied colours"
            ),
        }
    }
}
