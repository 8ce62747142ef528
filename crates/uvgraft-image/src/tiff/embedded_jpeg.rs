//! Strips and tiles that are JPEG files, often without their tables.
//!
//! # Source
//! TIFF Technical Note 2.

use std::io::{Read, Seek};

use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::directory::Directory;
use super::layout::{Color, Samples};
use super::{FORMAT, damaged, tags, unsupported};
use crate::header::{MAX_RATIO, MAX_UNBACKED_BYTES};
use crate::{ImageError, jpeg};

const START: [u8; 2] = [0xff, 0xd8];
const END: [u8; 2] = [0xff, 0xd9];

/// What strips and tiles have in common.
#[derive(Debug)]
pub(super) struct EmbeddedJpeg {
    /// Segments that belong before those of each strip or tile.
    tables: Vec<u8>,
    /// 1 or 3.
    samples: usize,
    /// Whether luma and colour differences become RGB.
    is_converted: bool,
}

impl EmbeddedJpeg {
    pub(super) fn read<R: Read + Seek>(
        directory: &mut Directory<R>,
        samples: &Samples,
        color: &Color,
    ) -> Result<Self, ImageError> {
        let wanted = "save it with ZIP (Deflate) compression, for example by \
                      `magick IN.tif -compress zip OUT.tif`";
        if samples.bits != 8 {
            return Err(unsupported(format!("JPEG of {} bits", samples.bits), wanted));
        }
        if ![1, 3].contains(&samples.in_chunk()) {
            let found = format!("JPEG of {} samples a texel", samples.in_chunk());
            return Err(unsupported(found, wanted));
        }
        let tables = directory.bytes(tags::JPEG_TABLES)?.unwrap_or_default();
        let tables = tables.strip_prefix(&START).unwrap_or(&tables);
        let tables = tables.strip_suffix(&END).unwrap_or(tables).to_vec();
        let is_converted = matches!(color, Color::YCbCr(_));
        Ok(Self { tables, samples: samples.in_chunk(), is_converted })
    }

    /// The samples of a strip or tile.
    ///
    /// - `width`, `rows`: what it must have; more rows are left out.
    pub(super) fn decode(
        &self,
        bytes: &[u8],
        width: usize,
        rows: usize,
    ) -> Result<Vec<u8>, ImageError> {
        let Some(rest) = bytes.strip_prefix(&START) else {
            return Err(damaged("a strip or tile does not start as a JPEG"));
        };
        if !jpeg::is_whole(bytes) {
            return Err(ImageError::Truncated { format: FORMAT });
        }
        let whole = [&START, &self.tables[..], rest].concat();
        let failed = |error| match error {
            DecodeErrors::ExhaustedData => ImageError::Truncated { format: FORMAT },
            error => damaged(format!("{error:?}")),
        };
        let options = DecoderOptions::default().set_strict_mode(true);
        let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&whole[..]), options);
        decoder.decode_headers().map_err(failed)?;
        let found = decoder.dimensions().unwrap_or_default();
        if found.0 != width || found.1 < rows {
            let reason = format!(
                "a strip or tile must have {width}×{rows} texels, its JPEG has {}×{}",
                found.0, found.1
            );
            return Err(damaged(reason));
        }
        let length = found.0 as u64 * found.1 as u64 * self.samples as u64;
        if length > MAX_UNBACKED_BYTES && (bytes.len() as u64) < length / MAX_RATIO {
            return Err(damaged("a strip or tile is too short for its size"));
        }
        let stored = decoder.input_colorspace().unwrap_or(ColorSpace::Unknown);
        let color = match (self.samples, stored) {
            (1, _) => ColorSpace::Luma,
            (3, ColorSpace::YCbCr) if self.is_converted => ColorSpace::RGB,
            // As stored.
            (_, stored) => stored,
        };
        decoder.set_options(options.jpeg_set_out_colorspace(color));
        let mut values = decoder.decode().map_err(failed)?;
        if values.len() as u64 != length {
            let reason = format!("a strip or tile must have {length} values, got {}", values.len());
            return Err(damaged(reason));
        }
        values.truncate(width * rows * self.samples);
        Ok(values)
    }
}
