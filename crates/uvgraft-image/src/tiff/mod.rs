//! TIFF, read and written by ourselves, with decoders of other crates for what strips and tiles are compressed with.

mod chunks;
mod compression;
mod directory;
mod embedded_jpeg;
mod encode;
mod layout;
mod rows;
mod tags;
mod ycbcr;

use std::borrow::Cow;
use std::io::{Cursor, Read, Seek};

use uvgraft::color::Encoding;
use uvgraft::texture::{Depth, Texels, Texture};

use self::chunks::Place;
use self::directory::{ByteOrder, Directory};
use self::encode::RowEncoder;
use self::layout::{Color, Layout, Predictor};
use self::rows::{Stored, StoredRows, indices};
use super::codec::{Codec, Decode, Decoded, Encode, Source};
use super::convert::unpremultiply;
use super::exif::{EXIF_DIRECTORY, FocalLength};
use super::header::StoredHeader;
use super::{Format, ImageError};

impl Format {
    /// 8 and 16 bits and float, alpha, ICC profile, lossless.
    pub const TIFF: Self = Self::new(&CODEC);
}

const FORMAT: Format = Format::TIFF;

static CODEC: Codec = Codec {
    name: "TIFF",
    extensions: &["tif", "tiff"],
    media_type: "image/tiff",
    // The second of each is BigTIFF.
    is_start: |bytes| matches!(bytes, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..]),
    // Float is linear like EXR, because painting programs interpret it so.
    depths: &[
        (Depth::U8, Encoding::Srgb),
        (Depth::U16, Encoding::Srgb),
        (Depth::F32, Encoding::Linear),
    ],
    has_alpha: true,
    is_premultiplied: false,
    is_lossy: false,
    compresses: true,
    max_side: Texture::MAX_SIDE,
    header,
    decode: Decode::Whole(|bytes, _| decode(bytes)),
    encode: Encode::Rows(|spec, icc, options| {
        Ok(Box::new(RowEncoder::new(spec, icc, options.compress)))
    }),
    segments: None,
    without_metadata: None,
};

fn damaged(reason: impl std::fmt::Display) -> ImageError {
    ImageError::damaged(FORMAT, reason)
}

fn unsupported(found: impl Into<String>, wanted: &'static str) -> ImageError {
    ImageError::Unsupported { format: FORMAT, found: found.into(), wanted }
}

fn header(reader: &mut dyn Source) -> Result<StoredHeader, ImageError> {
    let mut directory = Directory::first(reader)?;
    let mut header = Layout::read(&mut directory)?.header;
    header.focal = focal_length(&mut directory).unwrap_or_default();
    Ok(header)
}

/// The focal length, which is in a directory of its own. Malformed ones are ignored, as in EXIF
/// blocks.
fn focal_length(directory: &mut Directory<impl Read + Seek>) -> Option<FocalLength> {
    let at = directory.number(EXIF_DIRECTORY).ok()??;
    directory.go_to(at).ok()?;
    Some(FocalLength::from_numbers(|tag| match directory.fractions(tag).ok()??[..] {
        [number] => Some(number),
        _ => None,
    }))
}

fn decode(bytes: &[u8]) -> Result<Decoded, ImageError> {
    let mut directory = Directory::first(Cursor::new(bytes))?;
    let layout = Layout::read(&mut directory)?;
    let icc = directory.bytes(tags::ICC_PROFILE)?;
    let chunks = layout.grid.find(&mut directory, bytes)?;
    let texels = match layout.header.depth {
        Depth::U8 => Texels::U8(read_texels(&layout, &chunks)?),
        Depth::U16 => Texels::U16(read_texels(&layout, &chunks)?),
        Depth::F32 => Texels::F32(read_texels(&layout, &chunks)?),
    };
    Ok(Decoded { header: layout.header, texels, icc })
}

/// Reads all strips or tiles.
fn read_texels<T: Stored>(layout: &Layout, chunks: &[&[u8]]) -> Result<Vec<T>, ImageError> {
    let mut texels = vec![T::default(); layout.header.values()];
    for (index, bytes) in chunks.iter().enumerate() {
        let place = layout.grid.place(index);
        // Nothing of this plane is used.
        if layout.samples.is_planar && !layout.sources.contains(&place.plane) {
            continue;
        }
        read_chunk(layout, bytes, place, &mut texels)?;
    }
    if layout.is_premultiplied {
        unpremultiply(&mut texels, layout.header.channels);
    }
    Ok(texels)
}

/// Reads a strip or tile into its place among the texels.
fn read_chunk<T: Stored>(
    layout: &Layout,
    bytes: &[u8],
    place: Place,
    texels: &mut [T],
) -> Result<(), ImageError> {
    let bytes = upright_bits(layout, bytes);
    let mut rows = StoredRows::new(layout, &bytes, place.height)?;
    let row_values = layout.header.row_values();
    let channels = layout.header.channels.count();
    let (mut y, end) = (place.y as usize, (place.y + place.height) as usize);
    if is_same(layout)
        && let Some(out) = T::as_bytes_mut(&mut texels[y * row_values..end * row_values])
    {
        return rows.next_into(out);
    }
    let mut scratch = Vec::new();
    let row_bytes = layout.samples.row_bytes(layout.grid.width);
    while y < end {
        let count = (rows.batch() as usize).min(end - y);
        for row in rows.next(count as u32)?.chunks_exact(row_bytes) {
            let from = y * row_values + place.x as usize * channels;
            let out = &mut texels[from..from + place.width as usize * channels];
            put_row(layout, row, place, out, &mut scratch);
            y += 1;
        }
    }
    Ok(())
}

/// The bytes of a strip or tile with the first bit in the highest one. JPEG has no other order.
fn upright_bits<'a>(layout: &Layout, bytes: &'a [u8]) -> Cow<'a, [u8]> {
    if layout.is_reversed && !layout.compression.is_jpeg() {
        bytes.iter().map(|byte| byte.reverse_bits()).collect()
    } else {
        Cow::Borrowed(bytes)
    }
}

/// Whether rows of strips are rows of a texture of 8 bits.
fn is_same(layout: &Layout) -> bool {
    let Layout { header, samples, color, grid, .. } = layout;
    samples.bits == 8
        && !samples.is_planar
        && samples.count == header.channels.count()
        && matches!(color, Color::Direct)
        && grid.width == header.size.width
}

/// Writes the samples of a row into the texels of a row.
///
/// - `row`: may be longer than `out`, by the padding of a tile.
/// - `scratch`: memory to be used again.
fn put_row<T: Stored>(
    layout: &Layout,
    row: &[u8],
    place: Place,
    out: &mut [T],
    scratch: &mut Vec<T>,
) {
    let Layout { samples, color, sources, .. } = layout;
    let channels = layout.header.channels.count();
    let stored = samples.in_chunk();
    if let Color::Palette(colors) = color
        && let Some(out) = T::as_bytes_mut(out)
    {
        put_palette(layout, colors, row, place, out);
        return;
    }
    scratch.clear();
    // The predictor of floats puts the highest byte first.
    let order = if layout.predictor == Predictor::Float { ByteOrder::Big } else { samples.order };
    T::unpack(samples, order, row, out.len() / channels * stored, scratch);
    if matches!(color, Color::Inverted) && place.plane == 0 {
        scratch.iter_mut().step_by(stored).for_each(|value| *value = value.inverted());
    }
    if !samples.is_planar && samples.count == channels {
        out.copy_from_slice(scratch);
        return;
    }
    for (channel, &source) in sources.iter().enumerate() {
        let Some(sample) = sample_in_chunk(layout, source, place) else { continue };
        let values = scratch.iter().skip(sample).step_by(stored);
        for (to, from) in out.iter_mut().skip(channel).step_by(channels).zip(values) {
            *to = *from;
        }
    }
}

/// Writes the colours of a row of indices, and its alpha, into the texels of a row.
fn put_palette(layout: &Layout, colors: &[[u8; 3]], row: &[u8], place: Place, out: &mut [u8]) {
    let Layout { samples, sources, .. } = layout;
    let channels = layout.header.channels.count();
    let stored = samples.in_chunk();
    let values = indices(samples, row, out.len() / channels * stored);
    let texels = |sample: usize| values.iter().skip(sample).step_by(stored);
    if let Some(sample) = sample_in_chunk(layout, 0, place) {
        for (texel, &index) in out.chunks_exact_mut(channels).zip(texels(sample)) {
            texel[..3].copy_from_slice(&colors[usize::from(index)]);
        }
    }
    if let Some(&alpha) = sources.get(1)
        && let Some(sample) = sample_in_chunk(layout, alpha, place)
    {
        let largest = (1u32 << samples.bits) - 1;
        for (texel, &value) in out.chunks_exact_mut(channels).zip(texels(sample)) {
            texel[3] = ((u32::from(value) * 255 + largest / 2) / largest) as u8;
        }
    }
}

/// The place of a sample in a strip or tile; `None` if it belongs to another plane.
fn sample_in_chunk(layout: &Layout, sample: usize, place: Place) -> Option<usize> {
    if layout.samples.is_planar { (sample == place.plane).then_some(0) } else { Some(sample) }
}
