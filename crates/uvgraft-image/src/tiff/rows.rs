//! Rows of stored samples, as values of a texture.

use std::io::Read;

use ::exr::prelude::f16;
use uvgraft::texture::Value;

use super::compression::{Compression, reader};
use super::directory::ByteOrder;
use super::layout::{Color, Layout, Predictor, Samples};
use super::{FORMAT, damaged};
use crate::ImageError;

/// Rows that are decompressed at once take about as many bytes, so that they stay in the cache.
const BATCH_BYTES: usize = 1 << 16;

/// The rows of a strip or tile, top to bottom.
pub(super) struct StoredRows<'a> {
    layout: &'a Layout,
    source: Source<'a>,
    buffer: Vec<u8>,
    /// Bytes of a row, before and after colours are unpacked.
    row_bytes: usize,
}

enum Source<'a> {
    /// Samples as they are.
    Memory(&'a [u8]),
    Decoded(Vec<u8>, usize),
    Stream(Box<dyn Read + 'a>),
}

impl<'a> StoredRows<'a> {
    /// - `bytes`: of the strip or tile in the file, with the highest bit first.
    /// - `rows`: that are needed, at least 1.
    pub(super) fn new(layout: &'a Layout, bytes: &'a [u8], rows: u32) -> Result<Self, ImageError> {
        let width = layout.grid.width;
        let source = match &layout.compression {
            Compression::None => Source::Memory(bytes),
            Compression::Jpeg(jpeg) => {
                Source::Decoded(jpeg.decode(bytes, width as usize, rows as usize)?, 0)
            }
            packed => Source::Stream(reader(packed, bytes)),
        };
        let row_bytes = layout.samples.row_bytes(width);
        Ok(Self { layout, source, buffer: Vec::new(), row_bytes })
    }

    /// How many rows to ask for at once.
    pub(super) fn batch(&self) -> u32 {
        let rows = (BATCH_BYTES / self.row_bytes).clamp(1, BATCH_BYTES) as u32;
        match &self.layout.color {
            Color::YCbCr(stored) => rows.next_multiple_of(stored.rows() as u32),
            _ => rows,
        }
    }

    /// The next rows, with the padding of a tile. Bytes of samples are in the order of the file, or with
    /// [`Predictor::Float`] the highest first.
    ///
    /// - `count`: multiples of rows that are stored together, but for the last.
    pub(super) fn next(&mut self, count: u32) -> Result<&[u8], ImageError> {
        let length = count as usize * self.row_bytes;
        if let Color::YCbCr(stored) = &self.layout.color {
            let width = self.layout.grid.width as usize;
            let together = stored.stored_bytes(width);
            let mut packed = vec![0; (count as usize).div_ceil(stored.rows()) * together];
            self.source.read(&mut packed)?;
            self.buffer.resize(length, 0);
            let rows = self.buffer.chunks_mut(stored.rows() * self.row_bytes);
            for (packed, rows) in packed.chunks_exact(together).zip(rows) {
                stored.unpack(packed, width, rows);
            }
            return Ok(&self.buffer);
        }
        match &mut self.source {
            Source::Memory(bytes) => {
                let Some((rows, rest)) = bytes.split_at_checked(length) else {
                    return Err(too_short(length, bytes.len()));
                };
                *bytes = rest;
                return Ok(rows);
            }
            source => {
                self.buffer.resize(length, 0);
                source.read(&mut self.buffer)?;
            }
        }
        for row in self.buffer.chunks_exact_mut(self.row_bytes) {
            undo(self.layout.predictor, &self.layout.samples, row);
        }
        Ok(&self.buffer)
    }

    /// As [`Self::next`], into the memory of a texture that has the same rows.
    pub(super) fn next_into(&mut self, rows: &mut [u8]) -> Result<(), ImageError> {
        self.source.read(rows)?;
        for row in rows.chunks_exact_mut(self.row_bytes) {
            undo(self.layout.predictor, &self.layout.samples, row);
        }
        Ok(())
    }
}

impl Source<'_> {
    fn read(&mut self, out: &mut [u8]) -> Result<(), ImageError> {
        match self {
            Self::Memory(bytes) => {
                let Some((taken, rest)) = bytes.split_at_checked(out.len()) else {
                    return Err(too_short(out.len(), bytes.len()));
                };
                *bytes = rest;
                out.copy_from_slice(taken);
            }
            Self::Decoded(bytes, from) => {
                let Some(taken) = bytes.get(*from..*from + out.len()) else {
                    return Err(too_short(out.len(), bytes.len() - *from));
                };
                *from += out.len();
                out.copy_from_slice(taken);
            }
            Self::Stream(stream) => {
                stream.read_exact(out).map_err(|error| ImageError::from_io(FORMAT, &error))?;
            }
        }
        Ok(())
    }
}

fn too_short(wanted: usize, found: usize) -> ImageError {
    damaged(format!("a strip or tile must have {wanted} more bytes, got {found}"))
}

/// Replaces what a predictor left of a row by the samples.
fn undo(predictor: Predictor, samples: &Samples, row: &mut [u8]) {
    match predictor {
        Predictor::None => {}
        Predictor::Horizontal => match samples.bits {
            8 => add_up_bytes(row, samples.in_chunk()),
            16 => add_up::<2>(row, samples),
            32 => add_up::<4>(row, samples),
            _ => add_up::<8>(row, samples),
        },
        Predictor::Float => {
            add_up_bytes(row, samples.in_chunk());
            let planes = row.to_vec();
            let bytes = usize::from(samples.bits / 8);
            for (place, plane) in planes.chunks_exact(row.len() / bytes).enumerate() {
                let values = row.iter_mut().skip(place).step_by(bytes);
                values.zip(plane).for_each(|(value, &byte)| *value = byte);
            }
        }
    }
}

/// Adds to each byte the one of the texel before.
fn add_up_bytes(row: &mut [u8], samples: usize) {
    /// With sums in registers.
    fn of<const N: usize>(row: &mut [u8]) {
        let mut sums = [0u8; N];
        for texel in row.as_chunks_mut::<N>().0 {
            for (sum, value) in sums.iter_mut().zip(texel) {
                *sum = sum.wrapping_add(*value);
                *value = *sum;
            }
        }
    }
    match samples {
        1 => of::<1>(row),
        2 => of::<2>(row),
        3 => of::<3>(row),
        4 => of::<4>(row),
        _ => {
            for at in samples..row.len() {
                row[at] = row[at].wrapping_add(row[at - samples]);
            }
        }
    }
}

/// Adds to each number of `N` bytes that of the texel before.
fn add_up<const N: usize>(row: &mut [u8], samples: &Samples) {
    let mut sums = vec![0u64; samples.in_chunk()];
    for texel in row.chunks_exact_mut(N * samples.in_chunk()) {
        for (sum, value) in sums.iter_mut().zip(texel.as_chunks_mut::<N>().0) {
            *sum = sum.wrapping_add(samples.order.number(value));
            // The lowest bytes are the sum of numbers of that many bytes.
            match samples.order {
                ByteOrder::Little => value.copy_from_slice(&sum.to_le_bytes()[..N]),
                ByteOrder::Big => value.copy_from_slice(&sum.to_be_bytes()[8 - N..]),
            }
        }
    }
}

/// A value of a texture that samples become.
pub(super) trait Stored: Value {
    /// Appends the samples of a row, as parts of the whole range.
    ///
    /// - `count`: number of samples.
    fn unpack(samples: &Samples, order: ByteOrder, row: &[u8], count: usize, out: &mut Vec<Self>);

    /// White for black.
    fn inverted(self) -> Self;
}

impl Stored for u8 {
    fn unpack(samples: &Samples, _: ByteOrder, row: &[u8], count: usize, out: &mut Vec<Self>) {
        match samples.bits {
            8 => out.extend_from_slice(&row[..count]),
            // 1, 2 and 4 bits; 255 is a multiple of the largest.
            bits => {
                let scale = 255 / ((1 << bits) - 1);
                out.extend(packed(row, bits, count).map(|value| value * scale));
            }
        }
    }

    fn inverted(self) -> Self {
        Self::MAX - self
    }
}

impl Stored for u16 {
    fn unpack(_: &Samples, order: ByteOrder, row: &[u8], count: usize, out: &mut Vec<Self>) {
        unpack_words(order, row, count, out, Self::from_le_bytes);
    }

    fn inverted(self) -> Self {
        Self::MAX - self
    }
}

impl Stored for f32 {
    fn unpack(samples: &Samples, order: ByteOrder, row: &[u8], count: usize, out: &mut Vec<Self>) {
        match samples.bits {
            16 => unpack_words(order, row, count, out, |it| f16::from_le_bytes(it).to_f32()),
            32 => unpack_words(order, row, count, out, Self::from_le_bytes),
            _ => unpack_words(order, row, count, out, |it| f64::from_le_bytes(it) as Self),
        }
    }

    fn inverted(self) -> Self {
        1.0 - self
    }
}

/// - `value`: the value of little-endian bytes.
fn unpack_words<T, const N: usize>(
    order: ByteOrder,
    row: &[u8],
    count: usize,
    out: &mut Vec<T>,
    value: impl Fn([u8; N]) -> T,
) {
    let words = row.as_chunks().0[..count].iter().copied();
    match order {
        ByteOrder::Little => out.extend(words.map(value)),
        ByteOrder::Big => out.extend(words.map(|mut word| {
            word.reverse();
            value(word)
        })),
    }
}

/// Samples of 1, 2 or 4 bits, the first in the highest bits of a byte.
fn packed(row: &[u8], bits: u16, count: usize) -> impl Iterator<Item = u8> {
    let (bits, in_byte) = (usize::from(bits), 8 / usize::from(bits));
    (0..count).map(move |index| {
        let shift = 8 - bits * (index % in_byte + 1);
        row[index / in_byte] >> shift & ((1 << bits) - 1)
    })
}

/// The indices of a palette in a row: samples as they are.
pub(super) fn indices(samples: &Samples, row: &[u8], count: usize) -> Vec<u16> {
    match samples.bits {
        8 => row[..count].iter().map(|&index| index.into()).collect(),
        16 => row.as_chunks::<2>().0[..count]
            .iter()
            .map(|it| samples.order.number(it) as u16)
            .collect(),
        bits => packed(row, bits, count).map(u16::from).collect(),
    }
}
