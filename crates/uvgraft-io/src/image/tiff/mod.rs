//! TIFF: read through the `tiff` crate.

mod encode;

use std::io::{BufRead, Cursor, Seek};

use ::tiff::decoder::ifd::Value;
use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::tags::{ExtraSamples, SampleFormat, Tag};
use ::tiff::{ColorType, TiffError};
use uvgraft::texture::{Channels, Depth, Texels};

use super::convert::unpremultiply;
use super::exif::{EXIF_DIRECTORY, FocalLength};
use super::header::{MAX_BYTES, MAX_ICC_BYTES, StoredHeader, check_size};
use super::orientation::Orientation;
use super::{Decoded, Format, ImageError};

pub(super) use self::encode::RowEncoder;

const FORMAT: Format = Format::Tiff;

/// The format of stored samples, in addition to the header.
struct SampleLayout {
    header: StoredHeader,
    /// Bits of a stored value; below 8 they are packed, with rows starting at a byte.
    bits: u8,
    is_premultiplied: bool,
}

pub(super) fn header(reader: &mut (impl BufRead + Seek)) -> Result<StoredHeader, ImageError> {
    Ok(open(reader)?.1.header)
}

/// The focal length, which is in a directory of its own. Malformed ones are ignored, as in EXIF
/// blocks.
pub(super) fn focal_length(reader: &mut (impl BufRead + Seek)) -> FocalLength {
    let numbers = || {
        let mut decoder = Decoder::new(reader).ok()?;
        let pointer = decoder.find_tag(Tag::from_u16_exhaustive(EXIF_DIRECTORY)).ok()??;
        let directory = decoder.read_directory(pointer.into_ifd_pointer().ok()?).ok()?;
        let mut tags = decoder.read_directory_tags(&directory);
        Some(FocalLength::from_numbers(|tag| {
            match tags.find_tag(Tag::from_u16_exhaustive(tag)).ok()?? {
                Value::Short(value) => Some(value.into()),
                Value::Unsigned(value) => Some(value.into()),
                Value::Rational(over, under) => Some(f64::from(over) / f64::from(under)),
                _ => None,
            }
        }))
    };
    numbers().unwrap_or_default()
}

fn open<R: BufRead + Seek>(reader: R) -> Result<(Decoder<R>, SampleLayout), ImageError> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = usize::try_from(MAX_BYTES).unwrap_or(usize::MAX);
    limits.intermediate_buffer_size = limits.decoding_buffer_size;
    limits.ifd_value_size = 2 * MAX_ICC_BYTES;
    let mut decoder = Decoder::new(reader).map_err(from_tiff)?.with_limits(limits);
    let (width, height) = decoder.dimensions().map_err(from_tiff)?;
    let color = decoder.colortype().map_err(from_tiff)?;
    let numbers = |decoder: &mut Decoder<R>, tag| {
        decoder.find_tag_unsigned_vec::<u16>(tag).map(Option::unwrap_or_default).map_err(from_tiff)
    };
    let formats = numbers(&mut decoder, Tag::SampleFormat)?;
    let extra = numbers(&mut decoder, Tag::ExtraSamples)?.first().copied();
    let is_alpha = |extra: Option<u16>| {
        [ExtraSamples::AssociatedAlpha, ExtraSamples::UnassociatedAlpha]
            .map(|kind| Some(kind.to_u16()))
            .contains(&extra)
    };
    let (channels, bits) = match color {
        ColorType::Gray(bits) => (Some(Channels::Grey), bits),
        ColorType::GrayA(bits) => (Some(Channels::GreyAlpha), bits),
        ColorType::Multiband { bit_depth, num_samples: 2 } if is_alpha(extra) => {
            (Some(Channels::GreyAlpha), bit_depth)
        }
        ColorType::RGB(bits) => (Some(Channels::Rgb), bits),
        ColorType::RGBA(bits) => (Some(Channels::Rgba), bits),
        _ => (None, 0),
    };
    let float = SampleFormat::IEEEFP.to_u16();
    let unsigned = SampleFormat::Uint.to_u16();
    let format = formats.first().copied().unwrap_or(unsigned);
    let depth = match bits {
        _ if formats.iter().any(|&other| other != format) => None,
        8 if format == unsigned => Some(Depth::U8),
        1 | 2 | 4 if format == unsigned && channels == Some(Channels::Grey) => Some(Depth::U8),
        16 if format == unsigned => Some(Depth::U16),
        16 | 32 if format == float => Some(Depth::F32),
        _ => None,
    };
    let (Some(channels), Some(depth)) = (channels, depth) else {
        return Err(ImageError::Unsupported {
            format: FORMAT,
            found: format!("{color:?} values of sample format {formats:?}"),
            wanted: "supported are greyscale and RGB with or without alpha, of 8 or 16 bits or 16- or \
                 32-bit float; convert it first",
        });
    };
    let size = check_size(FORMAT, (width.into(), height.into()), channels, depth)?;
    let tag = decoder.find_tag_unsigned::<u16>(Tag::Orientation).map_err(from_tiff)?;
    let orientation = Orientation::from_tag(tag.unwrap_or(1).into());
    let focal = FocalLength::default();
    let header = StoredHeader { size, channels, depth, orientation, focal };
    let is_premultiplied =
        channels.has_alpha() && extra == Some(ExtraSamples::AssociatedAlpha.to_u16());
    Ok((decoder, SampleLayout { header, bits, is_premultiplied }))
}

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageError> {
    let (mut decoder, layout) = open(Cursor::new(bytes))?;
    let SampleLayout { header, bits, is_premultiplied } = layout;
    let icc = decoder.find_tag(Tag::IccProfile).map_err(from_tiff)?;
    let icc = icc.map(|icc| icc.into_u8_vec().map_err(from_tiff)).transpose()?;
    let mut result = DecodingResult::U8(Vec::new());
    let planes = decoder.read_image_to_buffer(&mut result).map_err(from_tiff)?.planes;
    let channels = header.channels;
    let mut texels = match result {
        DecodingResult::U8(values) if bits < 8 => {
            Texels::U8(unpack(&values, bits, header.size.width as usize))
        }
        DecodingResult::U8(values) => Texels::U8(interleave(values, planes, channels)),
        DecodingResult::U16(values) => Texels::U16(interleave(values, planes, channels)),
        DecodingResult::F32(values) => Texels::F32(interleave(values, planes, channels)),
        DecodingResult::F16(values) => {
            let values = values.iter().copied().map(f32::from).collect();
            Texels::F32(interleave(values, planes, channels))
        }
        _ => return Err(ImageError::damaged(FORMAT, "the values do not match the header")),
    };
    if is_premultiplied {
        match &mut texels {
            Texels::U8(values) => unpremultiply(values, channels),
            Texels::U16(values) => unpremultiply(values, channels),
            Texels::F32(values) => unpremultiply(values, channels),
        }
    }
    Ok(Decoded { header, texels, icc })
}

/// Interleaves planes, one for each channel. Extra planes are ignored.
fn interleave<T: Copy>(values: Vec<T>, planes: usize, channels: Channels) -> Vec<T> {
    if planes <= 1 {
        return values;
    }
    let texels = values.len() / planes;
    let plane = |channel: usize| &values[channel * texels..(channel + 1) * texels];
    let used: Vec<_> = (0..planes.min(channels.count())).map(plane).collect();
    (0..texels).flat_map(|texel| used.iter().map(move |plane| plane[texel])).collect()
}

/// Unpacks values of 1, 2 or 4 bits, the first in the highest bits of a byte.
fn unpack(packed: &[u8], bits: u8, width: usize) -> Vec<u8> {
    let largest = (1u8 << bits) - 1;
    let unpack_row = |row: &[u8]| {
        let value = |x: usize| {
            let bit = x * usize::from(bits);
            let shifted = row[bit / 8] >> (8 - usize::from(bits) - bit % 8);
            (shifted & largest) * (255 / largest)
        };
        (0..width).map(value).collect::<Vec<_>>()
    };
    packed.chunks_exact((width * usize::from(bits)).div_ceil(8)).flat_map(unpack_row).collect()
}

fn from_tiff(error: TiffError) -> ImageError {
    match error {
        TiffError::IoError(error) => ImageError::from_io(FORMAT, &error),
        TiffError::UnsupportedError(error) => ImageError::Unsupported {
            format: FORMAT,
            found: format!("{error}"),
            wanted: "convert it to uncompressed RGB first",
        },
        error => ImageError::damaged(FORMAT, error),
    }
}
