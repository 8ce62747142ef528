//! Rows into a baseline JPEG, top to bottom, without subsampling.
//!
//! Each row of blocks is a restart interval: it depends on no other, so rows of blocks are encoded
//! in parallel and reused. That makes files some 0.1 % larger.

use std::any::Any;
use std::io::{self, Write};

use uvgraft::texture::Texels;
use uvgraft::threads;

use super::FORMAT;
use super::blocks::{Block, Quantisation, SIDE, ZIGZAG, grey, luma_and_chroma};
use super::entropy::{Bits, CHROMA_AC, CHROMA_DC, Codes, LUMA_AC, LUMA_DC};
use crate::codec::{self, EncodedRows, Sink};
use crate::convert::Conversion;
use crate::{EncodeError, Loss, TextureSpec};

/// Rows of a segment: a few rows of blocks.
pub(super) const ROWS_IN_SEGMENT: u32 = 2 * SIDE as u32;

/// Rows converted and encoded at once, which bounds memory.
const ROWS_AT_ONCE: usize = 256;

/// Row of blocks that a thread encodes at once.
const ROW: usize = SIDE;

/// A JPEG written while its rows arrive.
pub(super) struct RowEncoder {
    /// What precedes the rows, until it is written.
    header: Vec<u8>,
    conversion: Conversion<u8>,
    blocks: BlockRows,
    /// Less than a row of blocks.
    pending: Vec<u8>,
    /// Row of blocks that comes next.
    next: u32,
}

/// Encodes rows of blocks.
struct BlockRows {
    width: usize,
    is_grey: bool,
    luma: (Quantisation, Codes),
    chroma: (Quantisation, Codes),
}

/// Rows of a JPEG that are encoded on their own.
#[derive(Debug)]
pub(super) struct Segment {
    bytes: Box<[u8]>,
    rows_of_blocks: u32,
    is_clamped: bool,
}

impl RowEncoder {
    pub(super) fn new(spec: &TextureSpec, mut icc: Option<&[u8]>, quality: u8) -> Self {
        let conversion = Conversion::new(spec, FORMAT, &mut icc);
        let blocks = BlockRows::new(spec, quality);
        let header = blocks.header(spec, icc);
        Self { header, conversion, blocks, pending: Vec::new(), next: 0 }
    }

    fn begin(&mut self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(&std::mem::take(&mut self.header))
    }
}

impl codec::RowEncoder for RowEncoder {
    fn write(&mut self, texels: &Texels, out: &mut dyn Sink) -> Result<(), EncodeError> {
        self.begin(out)?;
        let Self { conversion, blocks, pending, next, .. } = self;
        let row = blocks.row_values();
        for start in (0..texels.len()).step_by(ROWS_AT_ONCE * row) {
            let range = start..texels.len().min(start + ROWS_AT_ONCE * row);
            let values = conversion.apply(texels, range);
            let mut values = &*values;
            if !pending.is_empty() {
                let missing = (ROW * row - pending.len()).min(values.len());
                pending.extend_from_slice(&values[..missing]);
                values = &values[missing..];
                if pending.len() == ROW * row {
                    *next += blocks.write(pending, *next, out)?;
                    pending.clear();
                }
            }
            let (whole, rest) = values.split_at(values.len() / (ROW * row) * (ROW * row));
            *next += blocks.write(whole, *next, out)?;
            pending.extend_from_slice(rest);
        }
        Ok(())
    }

    fn push_segment(
        &mut self,
        segment: &dyn EncodedRows,
        out: &mut dyn Sink,
    ) -> Result<(), EncodeError> {
        let segment = Segment::of(segment);
        self.begin(out)?;
        self.conversion.note_clamped(segment.is_clamped);
        self.next += segment.rows_of_blocks;
        Ok(out.write_all(&segment.bytes)?)
    }

    fn finish(self: Box<Self>, out: &mut dyn Sink) -> Result<Vec<Loss>, EncodeError> {
        self.blocks.write(&self.pending, self.next, out)?;
        out.write_all(&[0xff, super::END_OF_IMAGE])?;
        Ok(self.conversion.losses())
    }
}

impl Segment {
    fn of(rows: &dyn EncodedRows) -> &Self {
        let rows: &dyn Any = rows;
        rows.downcast_ref().expect("segments are those of the same format")
    }

    /// Encodes the rows of a segment.
    ///
    /// - `spec`: of the whole image.
    pub(super) fn new(spec: &TextureSpec, quality: u8, first_row: u32, texels: &Texels) -> Self {
        let mut conversion = Conversion::new(spec, FORMAT, &mut None);
        let blocks = BlockRows::new(spec, quality);
        let values = conversion.apply(texels, 0..texels.len());
        let mut bytes = Vec::new();
        let mut rows_of_blocks = 0;
        for rows in values.chunks(ROW * blocks.row_values()) {
            blocks.encode(rows, first_row / SIDE as u32 + rows_of_blocks, &mut bytes);
            rows_of_blocks += 1;
        }
        Self { bytes: bytes.into(), rows_of_blocks, is_clamped: conversion.is_clamped() }
    }
}

impl EncodedRows for Segment {
    fn bytes(&self) -> usize {
        self.bytes.len()
    }
}

impl BlockRows {
    fn new(spec: &TextureSpec, quality: u8) -> Self {
        Self {
            width: spec.size.width as usize,
            is_grey: !spec.channels.has_color(),
            luma: (Quantisation::new(quality, false), Codes::new(&LUMA_DC, &LUMA_AC)),
            chroma: (Quantisation::new(quality, true), Codes::new(&CHROMA_DC, &CHROMA_AC)),
        }
    }

    fn row_values(&self) -> usize {
        self.width * if self.is_grey { 1 } else { 3 }
    }

    /// Encodes rows of blocks in parallel, and returns their number.
    fn write(&self, values: &[u8], first: u32, out: &mut dyn Write) -> io::Result<u32> {
        let rows: Vec<&[u8]> = values.chunks(ROW * self.row_values()).collect();
        let encoded = threads::map_indices(rows.len(), |index| {
            let mut bytes = Vec::with_capacity(rows[index].len() / 3);
            self.encode(rows[index], first + index as u32, &mut bytes);
            bytes
        });
        encoded.iter().try_for_each(|bytes| out.write_all(bytes))?;
        Ok(rows.len() as u32)
    }

    /// Encodes a row of blocks, which the last row and the last column of texels fill.
    fn encode(&self, values: &[u8], index: u32, out: &mut Vec<u8>) {
        if let Some(before) = index.checked_sub(1) {
            out.extend([0xff, 0xd0 + (before % 8) as u8]);
        }
        let rows: Vec<&[u8]> = values.chunks_exact(self.row_values()).collect();
        let rows: [&[u8]; SIDE] = std::array::from_fn(|row| rows[row.min(rows.len() - 1)]);
        let mut bits = Bits::new(out);
        if self.is_grey {
            self.grey(&rows, &mut bits);
        } else {
            self.colored(&rows, &mut bits);
        }
        bits.finish();
    }

    fn grey(&self, rows: &[&[u8]; SIDE], bits: &mut Bits<'_>) {
        let (quantisation, codes) = &self.luma;
        let mut before = 0;
        for x in (0..self.width).step_by(SIDE) {
            let block = rows.map(|row| grey(&texels::<1, SIDE>(row, x)));
            let coefficients = quantisation.coefficients(&block);
            codes.write(&coefficients, before, bits);
            before = coefficients[0];
        }
    }

    fn colored(&self, rows: &[&[u8]; SIDE], bits: &mut Bits<'_>) {
        let mut before = [0; 3];
        for x in (0..self.width).step_by(SIDE) {
            let mut planes: [Block; 3] = [[[0.0; SIDE]; SIDE]; 3];
            for (y, row) in rows.iter().enumerate() {
                let values = luma_and_chroma(&texels::<3, { 3 * SIDE }>(row, x));
                for (plane, values) in planes.iter_mut().zip(values) {
                    plane[y] = values;
                }
            }
            let components = [&self.luma, &self.chroma, &self.chroma];
            for ((plane, before), (quantisation, codes)) in
                planes.iter().zip(&mut before).zip(components)
            {
                let coefficients = quantisation.coefficients(plane);
                codes.write(&coefficients, *before, bits);
                *before = coefficients[0];
            }
        }
    }

    /// Everything before the rows.
    fn header(&self, spec: &TextureSpec, icc: Option<&[u8]>) -> Vec<u8> {
        const JFIF: &[u8] = b"JFIF\0\x01\x02\0\0\x01\0\x01\0\0";
        /// Most of a segment, less the name and the numbers of a part.
        const PART: usize = 65_533 - 14;
        let components = if self.is_grey { 1 } else { 3_u8 };
        let mut out = vec![0xff, 0xd8];
        let mut segment = |marker: u8, content: &[u8]| {
            out.extend([0xff, marker]);
            out.extend((content.len() as u16 + 2).to_be_bytes());
            out.extend(content);
        };
        segment(0xe0, JFIF);
        let parts = icc.unwrap_or_default().chunks(PART);
        let count = parts.len() as u8;
        for (number, part) in (1..).zip(parts) {
            segment(0xe2, &[b"ICC_PROFILE\0", &[number, count][..], part].concat());
        }
        let (height, width) = (spec.size.height as u16, spec.size.width as u16);
        let mut frame = vec![8];
        frame.extend(height.to_be_bytes().into_iter().chain(width.to_be_bytes()));
        frame.push(components);
        let mut scan = vec![components];
        for component in 0..components {
            let table = component.min(1);
            frame.extend([component + 1, 0x11, table]);
            scan.extend([component + 1, table << 4 | table]);
        }
        scan.extend([0, 63, 0]);
        let kinds = [(&self.luma, LUMA_DC, LUMA_AC), (&self.chroma, CHROMA_DC, CHROMA_AC)];
        let kinds = &kinds[..usize::from(components.min(2))];
        for (number, ((quantisation, _), ..)) in (0..).zip(kinds) {
            let table = ZIGZAG.map(|place| quantisation.table[usize::from(place)]);
            segment(0xdb, &[&[number][..], &table].concat());
        }
        segment(0xc0, &frame);
        for (number, (_, dc, ac)) in (0..).zip(kinds) {
            for (table, class) in [(dc, 0), (ac, 0x10)] {
                segment(0xc4, &[&[class | number], &table.counts[..], table.symbols].concat());
            }
        }
        let interval = self.width.div_ceil(SIDE) as u16;
        segment(0xdd, &interval.to_be_bytes());
        segment(super::START_OF_SCAN, &scan);
        out
    }
}

/// Eight texels of a row; beyond its end the last one.
#[inline(always)]
fn texels<const C: usize, const N: usize>(row: &[u8], x: usize) -> [u8; N] {
    match row[x * C..].first_chunk() {
        Some(texels) => *texels,
        None => std::array::from_fn(|k| {
            let texel = (x + k / C).min(row.len() / C - 1);
            row[texel * C + k % C]
        }),
    }
}
