//! Rows out of a PNG, top to bottom, through the `png` crate, which checks the CRC of every chunk.
//!
//! Measured for 4096² RGB texels on one core, smooth and with grain (9 and 35 MB): row by row into
//! memory that is used again 121 and 158 ms, as one frame into fresh memory 134 and 202 ms. Of
//! these, inflating takes 111 and 128 ms, and undoing the filter 13 ms, so that a second thread for
//! the latter would gain little. `zlib-rs` inflates in 132 and 186 ms, libdeflate in 162 and 202 ms
//! (into fresh memory).

use std::io::{BufRead, Seek};
use std::ops::Range;

use ::png::{BitDepth, ColorType, Decoder, DecodingError, Limits, Reader, Transformations};
use uvgraft::texture::{Channels, Depth, Texels};

use super::{FORMAT, header};
use crate::image::ImageError;
use crate::image::header::{MAX_ICC_BYTES, StoredHeader};

/// A PNG decoded on demand.
pub(in crate::image) struct RowDecoder<R: BufRead + Seek> {
    header: StoredHeader,
    reader: Reader<R>,
    row: Vec<u8>,
    rows_left: u32,
}

impl<R: BufRead + Seek> RowDecoder<R> {
    pub(in crate::image) fn new(mut source: R) -> Result<Self, ImageError> {
        let io = |error| ImageError::from_io(FORMAT, &error);
        let header = header(&mut source)?;
        source.rewind().map_err(io)?;
        // The limit applies to chunks kept in memory, of which only the profile is large.
        let limits = Limits { bytes: 4 * MAX_ICC_BYTES };
        let mut decoder = Decoder::new_with_limits(source, limits);
        decoder.set_ignore_text_chunk(true);
        // Palettes, 1 to 4 bits and colour keys become 8-bit channels.
        decoder.set_transformations(Transformations::EXPAND);
        let reader = decoder.read_info().map_err(from_png)?;
        let (color, depth) = reader.output_color_type();
        let found = match color {
            ColorType::Grayscale => Channels::Grey,
            ColorType::GrayscaleAlpha => Channels::GreyAlpha,
            ColorType::Rgb | ColorType::Indexed => Channels::Rgb,
            ColorType::Rgba => Channels::Rgba,
        };
        let len = header.values() * if depth == BitDepth::Sixteen { 2 } else { 1 };
        if found != header.channels || reader.output_buffer_size() != Some(len) {
            return Err(ImageError::damaged(FORMAT, "misplaced tRNS chunk"));
        }
        let row = vec![0; len / header.size.height as usize];
        Ok(Self { header, reader, row, rows_left: header.size.height })
    }

    /// The header; the size is as stored.
    pub(in crate::image) fn header(&self) -> StoredHeader {
        self.header
    }

    /// The profile, which precedes the rows.
    pub(in crate::image) fn icc(&self) -> Option<Vec<u8>> {
        self.reader.info().icc_profile.as_deref().map(<[u8]>::to_vec)
    }

    /// Whether rows are stored in order.
    pub(in crate::image) fn is_sequential(&self) -> bool {
        !self.reader.info().interlaced
    }

    /// Skips rows.
    pub(in crate::image) fn skip(&mut self, rows: u32) -> Result<(), ImageError> {
        for _ in 0..rows {
            self.reader.read_row(&mut self.row).map_err(from_png)?;
        }
        self.rows_left -= rows;
        self.check_end()
    }

    /// Decodes the next rows into the rows `places` of `texels`. With the last row, the rest of the
    /// file is verified.
    pub(in crate::image) fn read(
        &mut self,
        texels: &mut Texels,
        places: Range<u32>,
    ) -> Result<(), ImageError> {
        let values = self.header.row_values();
        let part = places.start as usize * values..places.end as usize * values;
        match texels {
            Texels::U8(texels) => {
                for row in texels[part].chunks_exact_mut(values) {
                    self.reader.read_row(row).map_err(from_png)?;
                    self.rows_left -= 1;
                }
            }
            Texels::U16(texels) => {
                for row in texels[part].chunks_exact_mut(values) {
                    self.reader.read_row(&mut self.row).map_err(from_png)?;
                    for (value, &bytes) in row.iter_mut().zip(self.row.as_chunks().0) {
                        *value = u16::from_be_bytes(bytes);
                    }
                    self.rows_left -= 1;
                }
            }
            Texels::F32(_) => unreachable!("PNG holds integers"),
        }
        self.check_end()
    }

    /// Decodes all rows at once, in any stored order.
    pub(in crate::image) fn read_all(mut self) -> Result<Texels, ImageError> {
        let mut data = vec![0; self.row.len() * self.rows_left as usize];
        self.reader.next_frame(&mut data).map_err(from_png)?;
        self.rows_left = 0;
        self.check_end()?;
        Ok(match self.header.depth {
            Depth::U16 => Texels::U16(
                data.as_chunks().0.iter().map(|&bytes| u16::from_be_bytes(bytes)).collect(),
            ),
            _ => Texels::U8(data),
        })
    }

    /// What follows the texels, up to IEND, may be missing too.
    fn check_end(&mut self) -> Result<(), ImageError> {
        if self.rows_left == 0 { self.reader.finish().map_err(from_png) } else { Ok(()) }
    }
}

fn from_png(error: DecodingError) -> ImageError {
    match error {
        DecodingError::IoError(error) => ImageError::from_io(FORMAT, &error),
        error => ImageError::damaged(FORMAT, error),
    }
}
