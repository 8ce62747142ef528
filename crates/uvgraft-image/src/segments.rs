//! Segments of images: rows that are encoded on their own, whatever the other rows hold.

use uvgraft::texture::Texture;

use super::{EncodeError, Format, TextureSpec, WriteOptions, jpeg, png};

/// How an image is divided into segments.
///
/// Images that share rows need these encoded only once: see
/// [`BandEncoder::push_segment`](super::BandEncoder::push_segment). Equal divisions make equal
/// segments of equal rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Segments {
    spec: TextureSpec,
    method: Method,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Method {
    Png,
    Jpeg { quality: u8 },
}

/// Encoded rows of an image.
#[derive(Debug)]
pub struct Segment {
    /// The division that it belongs to.
    pub(super) of: Segments,
    pub(super) first_row: u32,
    pub(super) rows: u32,
    pub(super) content: Content,
}

#[derive(Debug)]
pub(super) enum Content {
    Png(png::Segment),
    Jpeg(jpeg::Segment),
}

impl Segments {
    /// The segments of an image: of a JPEG, or of a PNG that need not be small. `None` if it is
    /// encoded as a whole.
    pub fn new(format: Format, spec: TextureSpec, options: &WriteOptions) -> Option<Self> {
        let method = match format {
            Format::Png if !options.compress => Method::Png,
            Format::Jpeg if !spec.channels.has_alpha() => {
                Method::Jpeg { quality: options.quality() }
            }
            _ => return None,
        };
        (spec.size.texels() > 0).then_some(Self { spec, method })
    }

    /// Number of rows in each segment except for the last, which may have fewer.
    pub fn rows(&self) -> u32 {
        match self.method {
            Method::Png => png::rows_in_segment(&self.spec),
            Method::Jpeg { .. } => jpeg::ROWS_IN_SEGMENT,
        }
    }

    /// Encodes a segment.
    ///
    /// - `index`: from the top.
    ///
    /// # Errors
    /// [`EncodeError`] if the rows are not those of such a segment.
    pub fn encode(&self, index: u32, rows: &Texture) -> Result<Segment, EncodeError> {
        let first_row = index.saturating_mul(self.rows());
        let mut wanted = self.spec;
        wanted.size.height = self.spec.size.height.saturating_sub(first_row).min(self.rows());
        let found = TextureSpec::from(rows);
        if found != wanted || wanted.size.height == 0 {
            return Err(EncodeError::Band { found, wanted });
        }
        let (spec, texels) = (&self.spec, rows.texels());
        let content = match self.method {
            Method::Png => Content::Png(png::Segment::new(spec, texels, index == 0)),
            Method::Jpeg { quality } => {
                Content::Jpeg(jpeg::Segment::new(spec, quality, first_row, texels))
            }
        };
        Ok(Segment { of: *self, first_row, rows: wanted.size.height, content })
    }
}

impl Segment {
    /// Bytes that it occupies in memory.
    pub fn bytes(&self) -> usize {
        match &self.content {
            Content::Png(segment) => segment.bytes(),
            Content::Jpeg(segment) => segment.bytes(),
        }
    }
}
