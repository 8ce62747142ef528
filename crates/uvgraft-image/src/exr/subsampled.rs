//! Scan lines of files whose chroma is subsampled.
//!
//! The `exr` crate refuses such files, though most of its codecs know of subsampling; so blocks are decompressed here
//! one by one, and what a codec takes for granted is set right before.

use ::exr::block::chunk::{Chunk, CompressedBlock};
use ::exr::compression::Compression;
use ::exr::math::Vec2;
use ::exr::meta::attribute::{
    ChannelDescription, ChannelList, IntegerBounds, LineOrder, SampleType, Text,
};
use ::exr::meta::header::Header;
use ::exr::meta::{BlockDescription, MetaData};
use ::exr::prelude::{SmallVec, f16};

use super::upsampling::upsample;
use super::{CHROMA, FORMAT, from_exr};
use crate::ImageError;

const FULL: Vec2<usize> = Vec2(1, 1);
const HALF: Vec2<usize> = Vec2(2, 2);

/// Whether any channel of any part is subsampled, for which the crate refuses the file.
pub(super) fn any(headers: &[Header]) -> bool {
    headers.iter().any(|header| subsampled(header).next().is_some())
}

fn subsampled(header: &Header) -> impl Iterator<Item = &ChannelDescription> {
    header.channels.list.iter().filter(|channel| is_subsampled(channel))
}

fn is_subsampled(channel: &ChannelDescription) -> bool {
    channel.sampling != FULL
}

/// Checks what is subsampled in the first part, and how. Those of another part are never read.
///
/// # Errors
/// [`ImageError::Unsupported`] for anything but scan lines with RY and BY at half the resolution, and
/// [`ImageError::Damaged`] for a data window that these cannot have.
pub(super) fn check(headers: &[Header]) -> Result<(), ImageError> {
    let wanted =
        "supported are scan lines with RY and BY at half the resolution in both directions";
    let unsupported = |found| ImageError::Unsupported { format: FORMAT, found, wanted };
    let (Some(first), Some(header)) = (headers.iter().flat_map(subsampled).next(), headers.first())
    else {
        return Ok(());
    };
    if header.blocks != BlockDescription::ScanLines {
        return Err(unsupported(format!("tiles and subsampled channel {}", first.name)));
    }
    for channel in subsampled(header) {
        let is_chroma = [CHROMA[0], CHROMA[2]].iter().any(|name| channel.name.eq(name));
        if !is_chroma || channel.sampling != HALF {
            let (Vec2(x, y), name) = (channel.sampling, &channel.name);
            return Err(unsupported(format!("channel {name}, subsampled {x}×{y}")));
        }
    }
    // Codecs are told the bytes of a texel, which must be a whole number.
    let bytes: usize =
        subsampled(header).map(|channel| channel.sample_type.bytes_per_sample()).sum();
    if !bytes.is_multiple_of(4) {
        return Err(unsupported("subsampled channels other than a pair of one type".to_owned()));
    }
    if subsampled(header).next().is_some() { check_window(header.data_window()) } else { Ok(()) }
}

/// Checks that chroma is at each second texel and row of the data window, from the first on.
fn check_window(window: IntegerBounds) -> Result<(), ImageError> {
    let IntegerBounds { position: Vec2(x, y), size: Vec2(width, height) } = window;
    if [x, y].iter().any(|side| side % 2 != 0) || [width, height].iter().any(|side| side % 2 != 0) {
        let reason = format_args!(
            "the data window must be divisible by 2, got {width}×{height} texels at ({x}, {y})"
        );
        return Err(ImageError::damaged(FORMAT, reason));
    }
    Ok(())
}

/// Reads channels of the first part at the resolution of its data window.
///
/// - `meta`: its headers were accepted by [`check`].
/// - `file`: all bytes.
/// - `table`: those after the headers, where the table of offsets is.
/// - `sources`: indices of the channels that are read, none of which is of integers.
///
/// Returns the samples of each of `sources`, row by row.
///
/// # Errors
/// [`ImageError`] for a truncated or damaged file, and for a compression that the crate cannot undo.
pub(super) fn read(
    meta: &MetaData,
    file: &[u8],
    table: &[u8],
    sources: &[usize],
) -> Result<Vec<Vec<f32>>, ImageError> {
    validate(meta)?;
    let mut header = meta.headers[0].clone();
    let truncated = ImageError::Truncated { format: FORMAT };
    let Some(table) = table.get(..8 * header.chunk_count) else { return Err(truncated) };
    let mut planes = Planes::new(&header.channels, sources);
    // Offsets are from the top to the bottom, whatever the order of the blocks is.
    for (index, offset) in table.as_chunks::<8>().0.iter().enumerate() {
        let area = block_area(&header, index);
        let chunk = chunk_at(meta, file, u64::from_le_bytes(*offset))?;
        let CompressedBlock::ScanLine(block) = chunk.compressed_block else {
            return Err(ImageError::damaged(FORMAT, "a block of another kind"));
        };
        if chunk.layer_index != 0 || block.y_coordinate != area.position.1 {
            let (wanted, found) = (area.position.1, block.y_coordinate);
            let reason = format_args!("block {index} must start at row {wanted}, got {found}");
            return Err(ImageError::damaged(FORMAT, reason));
        }
        planes.push(&mut header, block.compressed_pixels_le, area)?;
    }
    let Vec2(width, height) = header.layer_size;
    Ok(sources
        .iter()
        .map(|&source| {
            let samples = std::mem::take(&mut planes.samples[source]);
            let is_half = is_subsampled(&header.channels.list[source]);
            if is_half { upsample(&samples, width / 2, height / 2) } else { samples }
        })
        .collect())
}

/// What the crate checks of a file, apart from its subsampling.
fn validate(meta: &MetaData) -> Result<(), ImageError> {
    let mut headers = meta.headers.clone();
    headers
        .iter_mut()
        .flat_map(|header| &mut header.channels.list)
        .for_each(|channel| channel.sampling = FULL);
    MetaData::validate(&headers, false).map(drop).map_err(from_exr)
}

/// The texels of a block of scan lines.
fn block_area(header: &Header, index: usize) -> IntegerBounds {
    let IntegerBounds { position, size: Vec2(width, height) } = header.data_window();
    let lines = header.compression.scan_lines_per_block();
    let skipped = index * lines;
    // Heights are limited by then.
    let top = position.1 + skipped as i32;
    IntegerBounds::new(Vec2(position.0, top), Vec2(width, lines.min(height - skipped)))
}

fn chunk_at(meta: &MetaData, file: &[u8], offset: u64) -> Result<Chunk, ImageError> {
    let start = usize::try_from(offset).unwrap_or(usize::MAX);
    let Some(mut bytes) = file.get(start..) else {
        return Err(ImageError::Truncated { format: FORMAT });
    };
    Chunk::read(&mut bytes, meta).map_err(from_exr)
}

/// The samples of all channels, as far as they are read.
struct Planes<'a> {
    sources: &'a [usize],
    /// For each channel of the file; empty for those that are not read.
    samples: Vec<Vec<f32>>,
}

impl<'a> Planes<'a> {
    fn new(channels: &ChannelList, sources: &'a [usize]) -> Self {
        Self { sources, samples: vec![Vec::new(); channels.list.len()] }
    }

    /// Appends the rows of a block.
    ///
    /// - `header`: its number of bytes of a texel is changed to that of this block on average.
    fn push(
        &mut self,
        header: &mut Header,
        compressed: Vec<u8>,
        area: IntegerBounds,
    ) -> Result<(), ImageError> {
        let bytes: usize = rows(&header.channels, area).map(|(_, length)| length).sum();
        let compression = header.compression;
        if matches!(compression, Compression::B44 | Compression::B44A) && compressed.len() != bytes
        {
            return self.push_b44(header, &compressed, area);
        }
        header.channels.bytes_per_pixel = bytes / area.size.area();
        let block = compression
            .decompress_image_section_from_le(header, compressed, area, false)
            .map_err(from_exr)?;
        let mut rest = &block[..];
        for (channel, length) in rows(&header.channels, area) {
            let row = rest.split_off(..length).ok_or_else(too_short)?;
            self.extend(channel, &header.channels, row);
        }
        Ok(())
    }

    /// As [`Self::push`], for B44, which stores one channel after the other. The crate takes too many samples for
    /// those of a subsampled channel, so each is decompressed as an image of its own.
    fn push_b44(
        &mut self,
        header: &Header,
        mut compressed: &[u8],
        area: IntegerBounds,
    ) -> Result<(), ImageError> {
        for (index, channel) in header.channels.list.iter().enumerate() {
            let Vec2(width, height) = area.size / channel.sampling;
            let texel = channel.sample_type.bytes_per_sample();
            let is_packed = channel.sample_type == SampleType::F16;
            // Whole blocks, which are always shorter than their samples: those of equal length are not unpacked.
            let side = if is_packed { 4 } else { 1 };
            let padded = Vec2(width.next_multiple_of(side), height.next_multiple_of(side));
            let length = if is_packed {
                packed_length(compressed, padded.area() / 16).ok_or_else(too_short)?
            } else {
                padded.area() * texel
            };
            let part = compressed.split_off(..length).ok_or_else(too_short)?;
            let alone = ChannelDescription { sampling: FULL, ..channel.clone() };
            let alone = single_channel(alone, padded, header.compression);
            let samples = header
                .compression
                .decompress_image_section_from_le(
                    &alone,
                    part.to_vec(),
                    IntegerBounds::new(Vec2(0, 0), padded),
                    false,
                )
                .map_err(from_exr)?;
            for row in samples.chunks_exact(padded.0 * texel).take(height) {
                self.extend(index, &header.channels, &row[..width * texel]);
            }
        }
        Ok(())
    }

    /// Appends a row of samples in the byte order of this machine.
    fn extend(&mut self, channel: usize, channels: &ChannelList, row: &[u8]) {
        if !self.sources.contains(&channel) {
            return;
        }
        let samples = &mut self.samples[channel];
        match channels.list[channel].sample_type {
            SampleType::F16 => {
                samples.extend(row.as_chunks().0.iter().map(|&at| f16::from_ne_bytes(at).to_f32()));
            }
            SampleType::F32 => {
                samples.extend(row.as_chunks().0.iter().map(|&at| f32::from_ne_bytes(at)));
            }
            SampleType::U32 => {}
        }
    }
}

/// Each row of each channel in a block, in the order of the file: the channel, and its bytes.
fn rows(channels: &ChannelList, area: IntegerBounds) -> impl Iterator<Item = (usize, usize)> {
    let width = area.size.0;
    (area.position.1..area.end().1).flat_map(move |y| {
        let in_row = move |channel: &ChannelDescription| y % channel.sampling.1 as i32 == 0;
        let stored = channels.list.iter().enumerate().filter(move |(_, channel)| in_row(channel));
        stored.map(move |(index, channel)| {
            (index, width / channel.sampling.0 * channel.sample_type.bytes_per_sample())
        })
    })
}

/// The length of B44's blocks of 4 × 4 samples: 3 bytes for equal ones, which their third byte says, else 14.
fn packed_length(bytes: &[u8], count: usize) -> Option<usize> {
    (0..count).try_fold(0, |at, _| Some(at + if *bytes.get(at + 2)? >= 13 << 2 { 3 } else { 14 }))
}

fn single_channel(
    channel: ChannelDescription,
    size: Vec2<usize>,
    compression: Compression,
) -> Header {
    let list: SmallVec<[_; 5]> = [channel].into_iter().collect();
    Header::new(Text::from("channel"), size, list).with_encoding(
        compression,
        BlockDescription::ScanLines,
        LineOrder::Increasing,
    )
}

fn too_short() -> ImageError {
    ImageError::damaged(FORMAT, "a block has too few bytes")
}

#[cfg(test)]
mod tests;
