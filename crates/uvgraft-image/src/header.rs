//! Headers of images, and the limits checked before decoding.

use uvgraft::color::Encoding;
use uvgraft::listing::listed;
use uvgraft::texture::{Channels, Depth, Size, TexelFormat, Texels, Texture};

use super::exif::FocalLength;
use super::orientation::Orientation;
use super::{Format, ImageError};

/// Memory limit of a decoded image: 32,768 × 32,768 RGBA texels of 8 bits, or 16,384 × 16,384 of
/// float; half of that with 32-bit addresses, where no buffer may be larger.
pub const MAX_BYTES: u64 = if usize::BITS < 64 { isize::MAX as u64 } else { 4 << 30 };

/// Images that are decoded at once and take more memory than this must be in a file of at least
/// 1/[`MAX_RATIO`] of it: no more is believed of a header, since a megabyte can decompress to
/// gigabytes of a single colour.
pub const MAX_UNBACKED_BYTES: u64 = 256 << 20;

/// See [`MAX_UNBACKED_BYTES`].
pub const MAX_RATIO: u64 = 200;

/// Maximum number of texels of an image that is encoded at once, as WebP is: 8,192 × 8,192.
pub const MAX_WHOLE_TEXELS: u64 = 1 << 26;

/// Maximum size of an ICC profile. Just below the capacity of a JPEG's 255 segments; profiles of
/// displays have a few kilobytes, those of printers a few megabytes.
pub const MAX_ICC_BYTES: usize = 16_000_000;

/// Properties of an image, known before decoding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// The format of the content, regardless of the file name.
    pub format: Format,
    /// The size after applying the orientation.
    pub size: Size,
    /// The channels of the texture.
    pub channels: Channels,
    /// The depth of the texture.
    pub depth: Depth,
    /// Memory that decoding the whole image takes at most, its texels included, apart from the file's bytes.
    pub decoding_bytes: u64,
}

/// Everything about a texture except its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TextureSpec {
    /// Width and height.
    pub size: Size,
    /// Which channels a texel has.
    pub channels: Channels,
    /// How a value is stored.
    pub depth: Depth,
    /// What the values mean.
    pub encoding: Encoding,
}

impl TextureSpec {
    /// The specification of a texture with a size and format.
    pub const fn new(size: Size, format: TexelFormat) -> Self {
        let TexelFormat { channels, depth, encoding } = format;
        Self { size, channels, depth, encoding }
    }

    /// How values are stored, and what they mean.
    pub const fn format(&self) -> TexelFormat {
        TexelFormat { channels: self.channels, depth: self.depth, encoding: self.encoding }
    }

    /// Number of values in a row.
    pub(super) const fn row_values(&self) -> usize {
        self.size.width as usize * self.channels.count()
    }

    /// Number of values; `usize::MAX` if there are more.
    pub(super) const fn values(&self) -> usize {
        self.size.texels().saturating_mul(self.channels.count())
    }
}

impl From<&Texture> for TextureSpec {
    fn from(texture: &Texture) -> Self {
        Self::new(texture.size(), texture.format())
    }
}

impl std::fmt::Display for TextureSpec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { size, channels, depth, encoding } = self;
        write!(f, "{size} texels ({channels:?}, {depth:?}, {encoding:?})")
    }
}

/// A header with details needed for decoding. The size is as stored, before applying the
/// orientation.
#[derive(Debug, Clone, Copy)]
pub struct StoredHeader {
    /// The size, as stored.
    pub size: Size,
    /// The channels of the texture.
    pub channels: Channels,
    /// The depth of the texture.
    pub depth: Depth,
    /// How the image is turned upright.
    pub orientation: Orientation,
    /// What the camera says about its focal length.
    pub focal: FocalLength,
    /// Memory that decoding takes at most, beside the texels as stored and the file.
    pub scratch_bytes: u64,
}

/// The result of a decoder: texels as stored, and their orientation.
pub struct Decoded {
    /// The header; its size is that of the texels.
    pub header: StoredHeader,
    /// The texels, as stored.
    pub texels: Texels,
    /// The ICC profile.
    pub icc: Option<Vec<u8>>,
}

impl Decoded {
    /// Upright texels and the profile, both checked.
    pub(super) fn upright(self, format: Format) -> Result<(Texels, Option<Vec<u8>>), ImageError> {
        let Self { header, texels, icc } = self;
        let icc = check_icc(icc)?;
        if texels.len() != header.values() {
            let (found, wanted) = (texels.len(), header.values());
            let reason = format_args!("must decode to {wanted} values, got {found}");
            return Err(ImageError::damaged(format, reason));
        }
        Ok((header.orientation.apply(texels, header.size, header.channels), icc))
    }
}

impl StoredHeader {
    /// Of an upright image that is decoded without further memory.
    pub fn new(size: Size, channels: Channels, depth: Depth) -> Self {
        let (orientation, focal) = (Orientation::default(), FocalLength::default());
        Self { size, channels, depth, orientation, focal, scratch_bytes: 0 }
    }

    /// The public part.
    pub(super) fn public(&self, format: Format) -> Header {
        let Self { size, channels, depth, orientation, .. } = *self;
        // Transposed into memory of their own, when the scratch is free again.
        let turned = if orientation.is_transposed() { self.bytes() } else { 0 };
        let decoding_bytes = self.bytes() + turned.max(self.scratch_bytes);
        Header { format, size: orientation.size(size), channels, depth, decoding_bytes }
    }

    /// Bytes of the decoded image.
    pub(super) fn bytes(&self) -> u64 {
        (self.values() * self.depth.bytes()) as u64
    }

    /// Number of values in a stored row.
    pub fn row_values(&self) -> usize {
        self.size.width as usize * self.channels.count()
    }

    /// Number of values in the decoded image.
    pub fn values(&self) -> usize {
        self.size.texels() * self.channels.count()
    }
}

/// Checks an image that is decoded at once against the length of its file: see
/// [`MAX_UNBACKED_BYTES`].
pub(super) fn check_backed(header: &Header, file: u64) -> Result<(), ImageError> {
    let Header { format, size, channels, depth, .. } = *header;
    let bytes = size.texels() as u64 * (channels.count() * depth.bytes()) as u64;
    let least = bytes / MAX_RATIO;
    if bytes > MAX_UNBACKED_BYTES && file < least {
        return Err(ImageError::Unbacked { format, size, found: file, least });
    }
    Ok(())
}

/// The format of the content among those given, or an error that shows its first bytes.
pub(super) fn detect(formats: &[Format], bytes: &[u8]) -> Result<Format, ImageError> {
    let found = formats.iter().copied().find(|format| (format.codec().is_start)(bytes));
    found.ok_or_else(|| ImageError::NotAnImage {
        start: bytes[..bytes.len().min(8)].to_vec(),
        wanted: listed(formats),
    })
}

/// Checks the size of a texture whose `depth` and `channels` must fit into [`MAX_BYTES`].
///
/// # Errors
/// [`ImageError`] if it is empty or too large.
pub fn check_size(
    format: Format,
    (width, height): (u64, u64),
    channels: Channels,
    depth: Depth,
) -> Result<Size, ImageError> {
    check_bytes(format, (width, height), (channels.count() * depth.bytes()) as u64)
}

/// As [`check_size`], for texels that take `texel_bytes` while decoding.
pub(super) fn check_bytes(
    format: Format,
    (width, height): (u64, u64),
    texel_bytes: u64,
) -> Result<Size, ImageError> {
    let max = u64::from(Texture::MAX_SIDE);
    if width > max || height > max {
        return Err(ImageError::TooLarge { format, width, height });
    }
    if width == 0 || height == 0 {
        return Err(ImageError::damaged(
            format,
            format_args!("an image of {width}×{height} texels"),
        ));
    }
    // Both are at most MAX_SIDE by now.
    let size = Size::new(width as u32, height as u32);
    let found = width * height * texel_bytes;
    if found > MAX_BYTES {
        return Err(ImageError::TooManyBytes { format, size, found, max: MAX_BYTES });
    }
    Ok(size)
}

/// Rejects oversized profiles.
pub(super) fn check_icc(icc: Option<Vec<u8>>) -> Result<Option<Vec<u8>>, ImageError> {
    match icc {
        Some(icc) if icc.len() > MAX_ICC_BYTES => {
            Err(ImageError::IccTooLarge { found: icc.len(), max: MAX_ICC_BYTES })
        }
        icc => Ok(icc.filter(|icc| !icc.is_empty())),
    }
}
