//! PNG, through the `png` crate.

use std::io::{BufRead, Cursor, Read, Seek, Write};

use ::png::{
    BitDepth, ColorType, Compression, Decoder, DecodingError, Encoder, EncodingError, Filter, Info,
    Limits, Transformations,
};
use uvgraft::texture::{Channels, Depth, Texels};

use super::convert::Source;
use super::header::{MAX_ICC_BYTES, StoredHeader, check_size};
use super::orientation::Orientation;
use super::{Decoded, EncodeError, Format, ImageError};

const FORMAT: Format = Format::Png;

/// Walks the chunks to the end, because EXIF may stand behind the image. Decodes nothing.
pub(super) fn header(reader: &mut (impl BufRead + Seek)) -> Result<StoredHeader, ImageError> {
    let io = |error| ImageError::from_io(FORMAT, &error);
    let mut start = [0; 8 + 8 + 13 + 4];
    reader.read_exact(&mut start).map_err(io)?;
    let [_, _, _, _, _, _, _, _, _, _, _, _, b'I', b'H', b'D', b'R', rest @ ..] = start else {
        return Err(ImageError::damaged(FORMAT, "it does not begin with an IHDR chunk"));
    };
    let [w0, w1, w2, w3, h0, h1, h2, h3, bits, color, ..] = rest;
    let width = u32::from_be_bytes([w0, w1, w2, w3]);
    let height = u32::from_be_bytes([h0, h1, h2, h3]);
    let depth = if bits == 16 { Depth::U16 } else { Depth::U8 };
    let mut has_alpha = color & 4 != 0;
    let mut orientation = Orientation::default();
    loop {
        let mut chunk = [0; 8];
        reader.read_exact(&mut chunk).map_err(io)?;
        let [l0, l1, l2, l3, kind @ ..] = chunk;
        let mut left = i64::from(u32::from_be_bytes([l0, l1, l2, l3]));
        match &kind {
            b"IEND" => break,
            b"tRNS" => has_alpha = true,
            b"eXIf" => {
                // The orientation stands near the start; thumbnails further behind don't matter.
                let mut exif = Vec::new();
                let taken = reader.take(left.min(1 << 16) as u64).read_to_end(&mut exif);
                left -= taken.map_err(io)? as i64;
                orientation = Orientation::from_exif(&exif);
            }
            _ => {}
        }
        const CHECKSUM: i64 = 4;
        reader.seek_relative(left + CHECKSUM).map_err(io)?;
    }
    let channels = Channels::new(color & 2 != 0, has_alpha);
    let size = check_size(FORMAT, (width.into(), height.into()), channels, depth)?;
    Ok(StoredHeader { size, channels, depth, orientation })
}

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageError> {
    let header = header(&mut Cursor::new(bytes))?;
    // The limit is for chunks that are kept in memory, of which the profile is the only large one.
    let limits = Limits { bytes: 4 * MAX_ICC_BYTES };
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), limits);
    decoder.set_ignore_text_chunk(true);
    // Palettes, 1 to 4 bits and colour keys become channels of 8 bits.
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(from_png)?;
    let (color, depth) = reader.output_color_type();
    let found = match color {
        ColorType::Grayscale => Channels::Grey,
        ColorType::GrayscaleAlpha => Channels::GreyAlpha,
        ColorType::Rgb | ColorType::Indexed => Channels::Rgb,
        ColorType::Rgba => Channels::Rgba,
    };
    let len = header.values() * if depth == BitDepth::Sixteen { 2 } else { 1 };
    if found != header.channels || reader.output_buffer_size() != Some(len) {
        return Err(ImageError::damaged(FORMAT, "a tRNS chunk stands where it does not count"));
    }
    let mut data = vec![0; len];
    reader.next_frame(&mut data).map_err(from_png)?;
    // Up to IEND: what follows the texels may be missing too.
    reader.finish().map_err(from_png)?;
    let icc = reader.info().icc_profile.as_deref().map(<[u8]>::to_vec);
    let texels = match depth {
        BitDepth::Sixteen => {
            Texels::U16(data.as_chunks().0.iter().map(|&bytes| u16::from_be_bytes(bytes)).collect())
        }
        _ => Texels::U8(data),
    };
    Ok(Decoded { header, texels, icc })
}

fn from_png(error: DecodingError) -> ImageError {
    match error {
        DecodingError::IoError(error) => ImageError::from_io(FORMAT, &error),
        error => ImageError::damaged(FORMAT, error),
    }
}

pub(super) fn encode(
    source: &mut Source<'_>,
    compress: bool,
    out: &mut impl Write,
) -> Result<(), EncodeError> {
    let (depth, bytes) = match source.texture.depth() {
        Depth::U8 => (BitDepth::Eight, source.values::<u8>()),
        Depth::U16 | Depth::F32 => {
            let values = source.values::<u16>();
            (BitDepth::Sixteen, values.iter().flat_map(|value| value.to_be_bytes()).collect())
        }
    };
    let size = source.texture.size();
    let mut info = Info::with_size(size.width, size.height);
    info.bit_depth = depth;
    info.color_type = match source.texture.channels() {
        Channels::Grey => ColorType::Grayscale,
        Channels::GreyAlpha => ColorType::GrayscaleAlpha,
        Channels::Rgb => ColorType::Rgb,
        Channels::Rgba => ColorType::Rgba,
    };
    info.icc_profile = source.icc.map(Into::into);
    let mut encoder = Encoder::with_info(out, info).map_err(to_encode_error)?;
    // Measured for 4096² RGB texels on one core, smooth and with grain: Fast with Sub takes 0.04 and
    // 0.09 s for 5.8 and 33 MB; Adaptive takes a third more for 4.9 and 31 MB, Up and Avg a little
    // more, and Paeth doubles the time of reading. Balanced with Adaptive takes 0.3 and 2.9 s for
    // 1.1 and 15 MB; no single filter is both faster and smaller there.
    if compress {
        encoder.set_compression(Compression::Balanced);
        encoder.set_filter(Filter::Adaptive);
    } else {
        encoder.set_compression(Compression::Fast);
        encoder.set_filter(Filter::Sub);
    }
    let mut writer = encoder.write_header().map_err(to_encode_error)?;
    writer.write_image_data(&bytes).map_err(to_encode_error)?;
    writer.finish().map_err(to_encode_error)
}

fn to_encode_error(error: EncodingError) -> EncodeError {
    match error {
        EncodingError::IoError(error) => EncodeError::Io(error),
        error => EncodeError::encoder(FORMAT, error),
    }
}
