//! Segments of images: rows that are encoded on their own, whatever the other rows hold.

use uvgraft::texture::Texture;

use super::codec::{EncodedRows, SegmentCodec};
use super::{EncodeError, Format, TextureSpec, WriteOptions};

/// How an image is divided into segments.
///
/// Images that share rows need these encoded only once: see
/// [`BandEncoder::push_segment`](super::BandEncoder::push_segment). Equal divisions make equal
/// segments of equal rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Segments {
    format: Format,
    spec: TextureSpec,
    /// Those that make a difference to the segments.
    options: WriteOptions,
    rows: u32,
}

/// Encoded rows of an image.
#[derive(Debug)]
pub struct Segment {
    /// The division that it belongs to.
    pub(super) of: Segments,
    pub(super) first_row: u32,
    pub(super) rows: u32,
    pub(super) content: Box<dyn EncodedRows>,
}

impl Segments {
    /// The segments of an image: of a JPEG, or of a PNG that need not be small. `None` if it is
    /// encoded as a whole.
    pub fn new(format: Format, spec: TextureSpec, options: &WriteOptions) -> Option<Self> {
        let codec = format.codec();
        let options = WriteOptions {
            compress: options.compress && codec.compresses,
            jpeg_quality: codec.is_lossy.then(|| options.quality()),
            keeps_light: options.keeps_light && codec.is_premultiplied,
        };
        let rows = (codec.segments?.rows)(&spec, &options)?;
        (spec.size.texels() > 0).then_some(Self { format, spec, options, rows })
    }

    /// Number of rows in each segment except for the last, which may have fewer.
    pub fn rows(&self) -> u32 {
        self.rows
    }

    /// Encodes a segment.
    ///
    /// - `index`: from the top.
    ///
    /// # Errors
    /// [`EncodeError`] if the rows are not those of such a segment.
    pub fn encode(&self, index: u32, rows: &Texture) -> Result<Segment, EncodeError> {
        let first_row = index.saturating_mul(self.rows);
        let mut wanted = self.spec;
        wanted.size.height = self.spec.size.height.saturating_sub(first_row).min(self.rows);
        let found = TextureSpec::from(rows);
        if found != wanted || wanted.size.height == 0 {
            return Err(EncodeError::Band { found, wanted });
        }
        let Some(SegmentCodec { encode, .. }) = self.format.codec().segments else {
            unreachable!("made for a format with segments")
        };
        let content = encode(&self.spec, &self.options, first_row, rows.texels());
        Ok(Segment { of: *self, first_row, rows: wanted.size.height, content })
    }
}

impl Segment {
    /// Bytes that it occupies in memory.
    pub fn bytes(&self) -> usize {
        self.content.bytes()
    }
}
