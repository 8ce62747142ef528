//! JPEG: read through `zune-jpeg`, written by ourselves.

mod blocks;
mod cleaned;
mod encode;
mod entropy;
mod frame;
mod narrow;
mod stripped;
mod ycbcr;

use std::io::{self, BufRead, Cursor, Read, Seek};

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use self::cleaned::cleaned;
use self::encode::{RowEncoder, Segment};
use self::frame::Frame;
use super::codec::{Codec, Decode, Decoded, Encode, SegmentCodec, Source};
use super::exif::FocalLength;
use super::header::StoredHeader;
use super::orientation::Orientation;
use super::{Format, ImageError};

impl Format {
    /// 8 bits, no alpha, ICC profile, lossy.
    pub const JPEG: Self = Self::new(&CODEC);
}

const FORMAT: Format = Format::JPEG;

static CODEC: Codec = Codec {
    name: "JPEG",
    extensions: &["jpg", "jpeg"],
    media_type: "image/jpeg",
    is_start: |bytes| bytes.starts_with(&[0xff, 0xd8, 0xff]),
    depths: &[(Depth::U8, Encoding::Srgb)],
    has_alpha: false,
    is_premultiplied: false,
    is_lossy: true,
    compresses: false,
    max_side: Texture::MAX_SIDE,
    header,
    decode: Decode::Whole(|bytes, _| decode(bytes)),
    encode: Encode::Rows(|spec, icc, options| {
        Ok(Box::new(RowEncoder::new(spec, icc, options.quality())))
    }),
    segments: Some(SegmentCodec {
        rows: |spec, _| (!spec.channels.has_alpha()).then_some(encode::ROWS_IN_SEGMENT),
        encode: |spec, options, first_row, texels| {
            Box::new(Segment::new(spec, options.quality(), first_row, texels))
        },
    }),
    without_metadata: Some(stripped::stripped),
};

/// Markers without a length: restarts, and those without meaning in a file.
const ALONE: [u8; 11] = [0x01, 0xd0, 0xd1, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0x00];
const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;
const APP0: u8 = 0xe0;
const APP1: u8 = 0xe1;
/// What an APP1 segment with XMP starts with.
const XMP: &[u8] = b"http://ns.adobe.com/xap/1.0/\0";

/// What decides how the scans are decoded.
struct Signs {
    frame: Frame,
    is_jfif: bool,
}

/// Reads the segments up to the first scan.
fn header(mut reader: &mut dyn Source) -> Result<StoredHeader, ImageError> {
    open(&mut reader).map(|(header, _)| header)
}

fn open(reader: &mut (impl BufRead + Seek)) -> Result<(StoredHeader, Signs), ImageError> {
    let io = |error| ImageError::from_io(FORMAT, &error);
    let mut frame = None;
    let (mut exif, mut xmp) = (Vec::new(), Vec::new());
    let mut focal = FocalLength::default();
    let mut is_jfif = false;
    loop {
        let marker = next_marker(reader).map_err(io)?;
        match marker {
            END_OF_IMAGE | START_OF_SCAN => break,
            alone if ALONE.contains(&alone) => continue,
            _ => {}
        }
        let mut segment = Vec::new();
        let length = read_u16(reader).map_err(io)?.saturating_sub(2);
        reader.take(length.into()).read_to_end(&mut segment).map_err(io)?;
        match (marker, &segment[..]) {
            (APP1, [b'E', b'x', b'i', b'f', 0, 0, ..]) => {
                focal = FocalLength::from_exif(&segment);
                exif = segment;
            }
            (APP1, segment) if segment.starts_with(XMP) => xmp = segment.to_vec(),
            // A shorter one says nothing.
            (APP0, segment) => is_jfif |= segment.starts_with(b"JFIF\0") && segment.len() >= 14,
            (marker, content) => frame = Frame::new(marker, content).or(frame),
        }
    }
    let frame = frame.ok_or_else(|| ImageError::damaged(FORMAT, "no frame before the scan"))?;
    let (size, channels) = frame.layout()?;
    let orientation = Orientation::from_blocks(&exif, &xmp);
    let (depth, scratch_bytes) = (Depth::U8, frame.scratch_bytes());
    let header = StoredHeader { size, channels, depth, orientation, focal, scratch_bytes };
    Ok((header, Signs { frame, is_jfif }))
}

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageError> {
    let (header, signs) = open(&mut Cursor::new(bytes))?;
    // A code has at least one bit, and a block of 8×8 texels at least one code. So a short file
    // cannot make the decoder allocate and fill gigabytes.
    let Size { width, height } = header.size;
    let blocks = u64::from(width.div_ceil(8)) * u64::from(height.div_ceil(8));
    if !is_whole(bytes) || bytes.len() as u64 * 8 < blocks {
        return Err(ImageError::Truncated { format: FORMAT });
    }
    let decoded = match decode_scans(bytes, &header, &signs) {
        // Only then, since common files need no copy.
        Err(error) => cleaned(bytes)
            .and_then(|cleaned| decode_scans(&cleaned, &header, &signs).ok())
            .ok_or(error),
        decoded => decoded,
    };
    let (values, icc) = decoded.map_err(|error| match error {
        DecodeErrors::ExhaustedData => ImageError::Truncated { format: FORMAT },
        error => ImageError::damaged(FORMAT, format_args!("{error:?}")),
    })?;
    Ok(Decoded { header, texels: Texels::U8(values), icc })
}

/// The values, and the profile.
fn decode_scans(
    bytes: &[u8],
    header: &StoredHeader,
    signs: &Signs,
) -> Result<(Vec<u8>, Option<Vec<u8>>), DecodeErrors> {
    let Signs { frame, is_jfif } = signs;
    let is_grey = header.channels == Channels::Grey;
    let mut decoder = decoder(bytes, if is_grey { ColorSpace::Luma } else { ColorSpace::RGB });
    if header.size.width <= narrow::MAX_WIDTH && frame.has_chroma_of_half_width() {
        decoder.decode_headers()?;
        if decoder.input_colorspace() == Some(ColorSpace::YCbCr) {
            let mut values = self::decoder(bytes, ColorSpace::YCbCr).decode()?;
            narrow::repeat_chroma(&mut values, header.size, frame.has_chroma_of_half_height());
            return Ok((values, decoder.icc_profile()));
        }
    }
    let mut values = decoder.decode()?;
    // JFIF counts more than an Adobe segment or components named R, G and B, by which the decoder
    // takes values for RGB that libjpeg takes for YCbCr.
    if *is_jfif && !is_grey && decoder.input_colorspace() == Some(ColorSpace::RGB) {
        ycbcr::to_rgb(&mut values);
    }
    Ok((values, decoder.icc_profile()))
}

fn decoder(bytes: &[u8], color: ColorSpace) -> JpegDecoder<ZCursor<&[u8]>> {
    // Strict, because otherwise a truncated scan is filled with grey.
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(Texture::MAX_SIDE as usize)
        .set_max_height(Texture::MAX_SIDE as usize)
        .jpeg_set_out_colorspace(color);
    JpegDecoder::new_with_options(ZCursor::new(bytes), options)
}

/// Whether the image ends before the file does. Decoders fill in missing data, some of them even in
/// strict mode, so the file must have its end-of-image marker. (A truncated file with such a marker
/// appended passes: only decoding its codes twice would reveal it.)
pub(super) fn is_whole(bytes: &[u8]) -> bool {
    let mut reader = Cursor::new(bytes);
    loop {
        match next_marker(&mut reader) {
            Ok(END_OF_IMAGE) => return true,
            Ok(alone) if ALONE.contains(&alone) => {}
            Ok(_) => {
                let Ok(length) = read_u16(&mut reader) else { return false };
                reader.set_position(reader.position() + u64::from(length.saturating_sub(2)));
            }
            Err(_) => return false,
        }
    }
}

/// Skips to the next marker, also over texel data, where a byte of 0xff is written as 0xff 0x00.
fn next_marker(reader: &mut impl BufRead) -> io::Result<u8> {
    reader.skip_until(0xff)?;
    loop {
        let mut marker = [0];
        reader.read_exact(&mut marker)?;
        // Any number of 0xff may precede a marker.
        if marker != [0xff] {
            return Ok(marker[0]);
        }
    }
}

fn read_u16(reader: &mut impl Read) -> io::Result<u16> {
    let mut bytes = [0; 2];
    reader.read_exact(&mut bytes)?;
    Ok(u16::from_be_bytes(bytes))
}
