//! What makes an image format: one description in a file of its own. [`Format::ALL`](crate::Format::ALL) lists
//! those that are built in; functions that take formats work with others too.

use std::any::Any;
use std::fmt::Debug;
use std::io::{BufRead, Seek, Write};
use std::ops::Range;

use uvgraft::color::Encoding;
use uvgraft::texture::{Depth, Texels, Texture};

pub use super::convert::{AtDepth, Conversion};
pub use super::exif::FocalLength;
pub use super::header::{Decoded, StoredHeader, check_size};
pub use super::orientation::Orientation;
use super::{DeclaredSpace, EncodeError, ImageError, Loss, TextureSpec, WriteOptions};

/// All about a format that others ask for.
pub struct Codec {
    /// Its common name.
    pub name: &'static str,
    /// Its file extensions, in lower case without the dot, the usual one first.
    pub extensions: &'static [&'static str],
    /// Its media type, such as `image/png`.
    pub media_type: &'static str,
    /// Whether a file of this format begins with such bytes; 12 are enough.
    pub is_start: fn(&[u8]) -> bool,
    /// The depths of its textures, and what their values mean: files hardly specify it, so convention decides.
    pub depths: &'static [(Depth, Encoding)],
    /// Whether it stores alpha.
    pub has_alpha: bool,
    /// Whether stored colours are multiplied by alpha, so that there can be light without coverage.
    pub is_premultiplied: bool,
    /// Whether texels are stored approximately, as well as [`WriteOptions::jpeg_quality`] says.
    pub is_lossy: bool,
    /// Whether [`WriteOptions::compress`] makes its files smaller.
    pub compresses: bool,
    /// The most texels that a side may have.
    pub max_side: u32,
    /// Reads the header from the start of a file: all of it that can be known without decoding. Sizes are
    /// checked by [`check_size`].
    pub header: fn(&mut dyn Source) -> Result<StoredHeader, ImageError>,
    /// How files are decoded. One that is cut short must be an error.
    pub decode: Decode,
    /// How textures are encoded.
    pub encode: Encode,
    /// Encodes rows of an image apart from others, if it can.
    pub segments: Option<SegmentCodec>,
    /// The bytes of a file with nothing but its picture and, if it is given, this EXIF block; `None` for a file
    /// whose parts don't follow each other as they must. See [`without_metadata`](crate::without_metadata).
    pub without_metadata: Option<StripMetadata>,
}

impl Codec {
    /// What values mean that are stored at a depth.
    pub(crate) fn encoding(&self, depth: Depth) -> Encoding {
        let found = self.depths.iter().find(|found| found.0 == depth);
        found.map_or(Encoding::Srgb, |found| found.1)
    }

    /// Whether textures of this depth keep it.
    pub fn holds(&self, depth: Depth) -> bool {
        self.depths.iter().any(|found| found.0 == depth)
    }

    /// Whether a file is decoded all at once, not while its rows are asked for.
    pub const fn is_decoded_whole(&self) -> bool {
        matches!(self.decode, Decode::Whole(_))
    }

    /// Whether a texture is encoded all at once, not while its rows arrive. There is a
    /// [limit](crate::MAX_WHOLE_TEXELS) then.
    pub const fn is_encoded_whole(&self) -> bool {
        matches!(self.encode, Encode::Whole(_))
    }
}

/// How files of a format are decoded.
#[derive(Clone, Copy)]
pub enum Decode {
    /// In rows, while the file is read.
    Rows(OpenRows),
    /// All at once, from all bytes.
    Whole(fn(&[u8], DeclaredSpace) -> Result<Decoded, ImageError>),
}

/// Starts to decode a file in rows.
pub type OpenRows =
    for<'a> fn(Box<dyn Source + 'a>, DeclaredSpace) -> Result<Box<dyn RowDecoder + 'a>, ImageError>;

/// How textures are encoded into a format. Profiles that are given are neither empty nor too long.
#[derive(Clone, Copy)]
pub enum Encode {
    /// In rows, as they arrive.
    Rows(StartRows),
    /// All at once. Returns the losses.
    Whole(EncodeWhole),
}

/// Starts to encode an image of this specification with its profile.
pub type StartRows =
    fn(&TextureSpec, Option<&[u8]>, &WriteOptions) -> Result<Box<dyn RowEncoder>, EncodeError>;

/// Encodes a whole texture with its profile.
pub type EncodeWhole =
    fn(&Texture, Option<&[u8]>, &WriteOptions, &mut dyn Sink) -> Result<Vec<Loss>, EncodeError>;

/// Removes metadata from the bytes of a file.
///
/// - Second argument: an EXIF block to write instead of the file's.
pub type StripMetadata = fn(&[u8], Option<&[u8]>) -> Option<Vec<u8>>;

/// What a file is read from, from its start.
pub trait Source: BufRead + Seek + Send {}

impl<T: BufRead + Seek + Send> Source for T {}

/// What a file is written to. It may start anywhere in it.
pub trait Sink: Write + Seek {}

impl<T: Write + Seek> Sink for T {}

/// A file of which rows are decoded when they are asked for.
pub trait RowDecoder: Send {
    /// The header; the size is as stored.
    fn header(&self) -> StoredHeader;

    /// The ICC profile.
    fn icc(&self) -> Option<Vec<u8>>;

    /// Whether rows are stored in order.
    fn is_sequential(&self) -> bool {
        true
    }

    /// Skips the next rows.
    ///
    /// - `rows`: at most as many as are left.
    ///
    /// # Errors
    /// [`ImageError`] if they are damaged.
    fn skip(&mut self, rows: u32) -> Result<(), ImageError>;

    /// Decodes the next rows into the rows `places` of `texels`. With the last row, the rest of the file is
    /// verified.
    ///
    /// - `texels`: of the depth of the header, and with its channels; row after row, as wide as the
    ///   image, and at least up to the end of `places`.
    ///
    /// # Errors
    /// [`ImageError`] if they are damaged.
    fn read(&mut self, texels: &mut Texels, places: Range<u32>) -> Result<(), ImageError>;

    /// Decodes all rows at once, in any stored order, and verifies the rest of the file.
    ///
    /// # Errors
    /// [`ImageError`] if they are damaged.
    fn read_all(self: Box<Self>) -> Result<Texels, ImageError>;
}

/// A file that is written while its rows arrive.
pub trait RowEncoder: Send {
    /// Encodes the next rows, whole ones.
    ///
    /// - `texels`: of the width, depth and channels that [`StartRows`] was given.
    ///
    /// # Errors
    /// [`EncodeError`] if they cannot be written.
    fn write(&mut self, texels: &Texels, out: &mut dyn Sink) -> Result<(), EncodeError>;

    /// Appends a segment, after whole segments only.
    ///
    /// # Errors
    /// [`EncodeError`] if it cannot be written, or is none of the format's.
    fn push_segment(
        &mut self,
        segment: &dyn EncodedRows,
        _out: &mut dyn Sink,
    ) -> Result<(), EncodeError> {
        unreachable!("a format without segments was given {segment:?}")
    }

    /// Writes the remaining data, and returns the losses.
    ///
    /// # Errors
    /// [`EncodeError`] if it cannot be written.
    fn finish(self: Box<Self>, out: &mut dyn Sink) -> Result<Vec<Loss>, EncodeError>;
}

/// How a format encodes segments: see [`Segments`](crate::Segments).
#[derive(Clone, Copy)]
pub struct SegmentCodec {
    /// Number of rows in each segment of an image but the last; `None` if options don't allow segments.
    pub rows: fn(&TextureSpec, &WriteOptions) -> Option<u32>,
    /// Encodes the rows of a segment.
    ///
    /// - Specification: of the whole image.
    /// - Row: the first one of the segment.
    pub encode: fn(&TextureSpec, &WriteOptions, u32, &Texels) -> Box<dyn EncodedRows>,
}

/// Rows that were encoded apart from others.
pub trait EncodedRows: Any + Debug + Send + Sync {
    /// Bytes that they occupy in memory.
    fn bytes(&self) -> usize;
}
