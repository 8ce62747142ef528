//! PNG: a decoder and an encoder of our own for what is common, and the `png` crate.

mod color_conversion;
mod color_space;
mod decode;
mod deflate;
mod encode;
mod image_data;
mod piece_reader;
mod pieces;
mod stripped;
mod text;
mod unfilter;
mod wave;

use std::io::{self, BufRead, Read, Seek};

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Texture};

use self::decode::RowDecoder;
use self::encode::{RowEncoder, Segment};
use super::codec::{Codec, Decode, Encode, SegmentCodec, Source};
use super::exif::{self, FocalLength};
use super::header::{StoredHeader, check_size};
use super::orientation::Orientation;
use super::{Format, ImageError};

impl Format {
    /// 8 and 16 bits, alpha, ICC profile, lossless.
    pub const PNG: Self = Self::new(&CODEC);
}

const FORMAT: Format = Format::PNG;

static CODEC: Codec = Codec {
    name: "PNG",
    extensions: &["png"],
    media_type: "image/png",
    is_start: |bytes| bytes.starts_with(b"\x89PNG"),
    depths: &[(Depth::U8, Encoding::Srgb), (Depth::U16, Encoding::Srgb)],
    has_alpha: true,
    is_premultiplied: false,
    is_lossy: false,
    compresses: true,
    max_side: Texture::MAX_SIDE,
    header,
    decode: Decode::Rows(|source, space| Ok(Box::new(RowDecoder::new(source, space)?))),
    encode: Encode::Rows(|spec, icc, options| {
        Ok(Box::new(RowEncoder::new(spec, icc, options.compress)?))
    }),
    segments: Some(SegmentCodec {
        rows: |spec, options| (!options.compress).then(|| encode::rows_in_segment(spec)),
        encode: |spec, _, first_row, texels| Box::new(Segment::new(spec, texels, first_row == 0)),
    }),
    without_metadata: Some(stripped::stripped),
};

/// The header of a file that is complete.
fn header(mut reader: &mut dyn Source) -> Result<StoredHeader, ImageError> {
    outline(&mut reader).map(|outline| outline.header)
}

/// What the chunks say.
struct Outline {
    header: StoredHeader,
    /// Where the image data starts, if it is of the common kind: whole bytes that are the channels
    /// of the texture, not interlaced, in one sequence of chunks, before other chunks that may be
    /// ignored.
    plain: Option<u64>,
}

/// Up to `most` bytes of a chunk of which `left` bytes are unread, before and after.
fn beginning(reader: &mut impl Read, left: &mut i64, most: u64) -> io::Result<Vec<u8>> {
    let mut content = Vec::new();
    let taken = reader.take(most.min(*left as u64)).read_to_end(&mut content)?;
    *left -= taken as i64;
    Ok(content)
}

/// Walks the chunks to the end without decoding, because EXIF may follow the image; this also
/// detects truncation.
fn outline(reader: &mut (impl BufRead + Seek)) -> Result<Outline, ImageError> {
    let io = |error| ImageError::from_io(FORMAT, &error);
    let mut start = [0; 8 + 8 + 13 + 4];
    reader.read_exact(&mut start).map_err(io)?;
    let [_, _, _, _, _, _, _, _, _, _, _, _, b'I', b'H', b'D', b'R', rest @ ..] = start else {
        return Err(ImageError::damaged(FORMAT, "must start with an IHDR chunk"));
    };
    let [w0, w1, w2, w3, h0, h1, h2, h3, bits, color, _, _, interlacing, ..] = rest;
    let width = u32::from_be_bytes([w0, w1, w2, w3]);
    let height = u32::from_be_bytes([h0, h1, h2, h3]);
    let depth = if bits == 16 { Depth::U16 } else { Depth::U8 };
    let mut has_alpha = color & 4 != 0;
    let (mut exif_tag, mut text_tag) = (None, None);
    let mut focal = FocalLength::default();
    let mut is_plain = matches!(bits, 8 | 16) && matches!(color, 0 | 2 | 4 | 6) && interlacing == 0;
    let mut first_data = None;
    let mut previous = *b"IHDR";
    let mut at = start.len() as u64;
    loop {
        let mut chunk = [0; 8];
        reader.read_exact(&mut chunk).map_err(io)?;
        let [l0, l1, l2, l3, kind @ ..] = chunk;
        let len = u32::from_be_bytes([l0, l1, l2, l3]);
        let mut left = i64::from(len);
        match &kind {
            b"IEND" => {
                reader.seek_relative(left).map_err(io)?;
                reader.read_exact(&mut [0; 4]).map_err(io)?;
                break;
            }
            b"IDAT" => {
                is_plain &= first_data.is_none() || previous == *b"IDAT";
                first_data.get_or_insert(at);
            }
            b"tRNS" => {
                has_alpha = true;
                is_plain = false;
            }
            // Checked here, since the crate calls these merely invalid data.
            b"cICP" if left == 4 => {
                let mut content = [0; 4];
                reader.read_exact(&mut content).map_err(io)?;
                left = 0;
                color_space::check_code_points(content)?;
            }
            // Animations may start with a part of the image.
            b"acTL" | b"fcTL" | b"fdAT" => is_plain = false,
            b"eXIf" => {
                // Orientation and focal length are near the start; thumbnails after them are
                // irrelevant.
                let exif = beginning(reader, &mut left, 1 << 16).map_err(io)?;
                exif_tag = exif::orientation(&exif);
                focal = FocalLength::from_exif(&exif);
            }
            b"tEXt" | b"zTXt" | b"iTXt" if left <= text::MAX_BYTES as i64 => {
                is_plain &= first_data.is_none() || left <= 1 << 16;
                let content = beginning(reader, &mut left, text::MAX_BYTES).map_err(io)?;
                text_tag = text_tag.or_else(|| text::orientation(kind, &content));
            }
            // Critical after the image, or large.
            _ if first_data.is_some() && (kind[0].is_ascii_uppercase() || left > 1 << 16) => {
                is_plain = false;
            }
            _ => {}
        }
        previous = kind;
        at += (chunk.len() + 4) as u64 + u64::from(len);
        const CHECKSUM: i64 = 4;
        reader.seek_relative(left + CHECKSUM).map_err(io)?;
    }
    let colors = if color & 2 != 0 { Channels::Rgb } else { Channels::Grey };
    let channels = if has_alpha { colors.with_alpha() } else { colors };
    let size = check_size(FORMAT, (width.into(), height.into()), channels, depth)?;
    let orientation = Orientation::from_tag(exif_tag.or(text_tag).unwrap_or(1));
    let mut header = StoredHeader { size, channels, depth, orientation, focal, scratch_bytes: 0 };
    if depth == Depth::U16 {
        // Images that are decoded at once, from pairs of bytes.
        header.scratch_bytes = header.bytes();
    }
    Ok(Outline { header, plain: first_data.filter(|_| is_plain) })
}
