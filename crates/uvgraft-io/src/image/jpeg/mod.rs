//! JPEG: read through `zune-jpeg`, written by ourselves.

mod blocks;
mod encode;
mod entropy;

use std::io::{self, BufRead, Cursor, Read, Seek};

use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::exif::FocalLength;
use super::header::{StoredHeader, check_size};
use super::orientation::Orientation;
use super::{Decoded, Format, ImageError};
pub(super) use encode::{ROWS_IN_SEGMENT, RowEncoder, Segment};

const FORMAT: Format = Format::Jpeg;

/// Markers without a length: restarts, and those without meaning in a file.
const ALONE: [u8; 11] = [0x01, 0xd0, 0xd1, 0xd2, 0xd3, 0xd4, 0xd5, 0xd6, 0xd7, 0xd8, 0x00];
const END_OF_IMAGE: u8 = 0xd9;
const START_OF_SCAN: u8 = 0xda;
const APP1: u8 = 0xe1;

/// Reads the segments up to the first scan.
pub(super) fn header(reader: &mut (impl BufRead + Seek)) -> Result<StoredHeader, ImageError> {
    let io = |error| ImageError::from_io(FORMAT, &error);
    let mut frame = None;
    let mut orientation = Orientation::default();
    let mut focal = FocalLength::default();
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
                orientation = Orientation::from_exif(&segment);
                focal = FocalLength::from_exif(&segment);
            }
            // Every start of a frame, except for the other markers in the range: DHT, JPG and DAC.
            (0xc0..=0xcf, &[bits, h0, h1, w0, w1, components, ..])
                if ![0xc4, 0xc8, 0xcc].contains(&marker) =>
            {
                let side = |high, low| u64::from(u16::from_be_bytes([high, low]));
                frame = Some((side(w0, w1), side(h0, h1), bits, components));
            }
            _ => {}
        }
    }
    let (width, height, bits, components) =
        frame.ok_or_else(|| ImageError::damaged(FORMAT, "no frame before the scan"))?;
    let wanted = "supported are 8-bit greyscale and RGB; convert it first";
    let unsupported = |found| Err(ImageError::Unsupported { format: FORMAT, found, wanted });
    let channels = match (bits, components) {
        (8, 1) => Channels::Grey,
        (8, 3) => Channels::Rgb,
        (8, 4) => return unsupported("CMYK colours".to_owned()),
        _ => return unsupported(format!("{components} channels of {bits} bits")),
    };
    let size = check_size(FORMAT, (width, height), channels, Depth::U8)?;
    Ok(StoredHeader { size, channels, depth: Depth::U8, orientation, focal })
}

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageError> {
    let header = header(&mut Cursor::new(bytes))?;
    // A code has at least one bit, and a block of 8×8 texels at least one code. So a short file
    // cannot make the decoder allocate and fill gigabytes.
    let Size { width, height } = header.size;
    let blocks = u64::from(width.div_ceil(8)) * u64::from(height.div_ceil(8));
    if !is_whole(bytes) || bytes.len() as u64 * 8 < blocks {
        return Err(ImageError::Truncated { format: FORMAT });
    }
    let color = if header.channels == Channels::Grey { ColorSpace::Luma } else { ColorSpace::RGB };
    // Strict, because otherwise a truncated scan is filled with grey.
    let options = DecoderOptions::default()
        .set_strict_mode(true)
        .set_max_width(Texture::MAX_SIDE as usize)
        .set_max_height(Texture::MAX_SIDE as usize)
        .jpeg_set_out_colorspace(color);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    let values = decoder.decode().map_err(|error| match error {
        DecodeErrors::ExhaustedData => ImageError::Truncated { format: FORMAT },
        error => ImageError::damaged(FORMAT, format_args!("{error:?}")),
    })?;
    Ok(Decoded { header, texels: Texels::U8(values), icc: decoder.icc_profile() })
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
