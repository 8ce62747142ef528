//! Rows into a TIFF of strips, top to bottom.
//!
//! A file is a header, strips, and a directory of 16 entries that says where they are; it has the byte order of no
//! machine, but always the same.

use std::io::{self, SeekFrom, Write};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use uvgraft::texture::{Depth, Texels};

use super::FORMAT;
use super::tags::{self, compression, extra, kind, photometric, predictor, sample_format};
use crate::codec::{self, Sink};
use crate::convert::Conversion;
use crate::{EncodeError, Loss, TextureSpec};

/// Bytes of a strip, rounded up to whole rows.
const STRIP_BYTES: u64 = 1_000_000;

/// Classic TIFF has 32-bit offsets; half a gigabyte is reserved for everything else.
const CLASSIC_BYTES: u64 = 7 << 29;

/// The resolution is a ratio of sides alone.
const NO_UNIT: u16 = 1;

/// A TIFF written while its rows arrive.
pub(super) struct RowEncoder {
    spec: TextureSpec,
    icc: Option<Vec<u8>>,
    conversion: AnyConversion,
    compress: bool,
    is_big: bool,
    /// Where the file starts in the output, once something is written.
    start: Option<u64>,
    /// Bytes written.
    length: u64,
    /// Less than a strip.
    pending: Vec<u8>,
    row_bytes: usize,
    rows_in_strip: u64,
    /// Where strips start, and their bytes.
    strips: Vec<(u64, u64)>,
}

enum AnyConversion {
    U8(Conversion<u8>),
    U16(Conversion<u16>),
    F32(Conversion<f32>),
}

impl RowEncoder {
    pub(super) fn new(spec: &TextureSpec, mut icc: Option<&[u8]>, compress: bool) -> Self {
        let conversion = match spec.depth {
            Depth::U8 => AnyConversion::U8(Conversion::new(spec, FORMAT, &mut icc)),
            Depth::U16 => AnyConversion::U16(Conversion::new(spec, FORMAT, &mut icc)),
            Depth::F32 => AnyConversion::F32(Conversion::new(spec, FORMAT, &mut icc)),
        };
        let row_bytes = (spec.row_values() * spec.depth.bytes()) as u64;
        Self {
            spec: *spec,
            icc: icc.map(<[u8]>::to_vec),
            conversion,
            compress,
            is_big: row_bytes * u64::from(spec.size.height) >= CLASSIC_BYTES,
            start: None,
            length: 0,
            pending: Vec::new(),
            row_bytes: row_bytes as usize,
            rows_in_strip: STRIP_BYTES.div_ceil(row_bytes),
            strips: Vec::new(),
        }
    }

    /// Writes the header, with the place of the directory still open. Returns where the file starts.
    fn start(&mut self, out: &mut dyn Sink) -> io::Result<u64> {
        if let Some(start) = self.start {
            return Ok(start);
        }
        let start = out.stream_position()?;
        self.start = Some(start);
        let header: &[u8] =
            if self.is_big { b"II\x2b\0\x08\0\0\0\0\0\0\0\0\0\0\0" } else { b"II\x2a\0\0\0\0\0" };
        self.put(header, out)?;
        Ok(start)
    }

    /// Writes a strip.
    fn flush(&mut self, out: &mut dyn Write) -> io::Result<()> {
        let mut strip = std::mem::take(&mut self.pending);
        let at = self.length;
        if self.compress {
            if self.spec.depth != Depth::F32 {
                for row in strip.chunks_exact_mut(self.row_bytes) {
                    take_differences(row, &self.spec);
                }
            }
            let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
            encoder.write_all(&strip)?;
            let compressed = encoder.finish()?;
            self.put(&compressed, out)?;
        } else {
            self.put(&strip, out)?;
        }
        self.strips.push((at, self.length - at));
        strip.clear();
        self.pending = strip;
        Ok(())
    }

    fn put(&mut self, bytes: &[u8], out: &mut dyn Write) -> io::Result<()> {
        self.length += bytes.len() as u64;
        out.write_all(bytes)
    }
}

impl codec::RowEncoder for RowEncoder {
    fn write(&mut self, texels: &Texels, out: &mut dyn Sink) -> Result<(), EncodeError> {
        self.start(out)?;
        let strip_bytes = self.row_bytes * self.rows_in_strip as usize;
        let row_values = self.spec.row_values();
        // A strip at a time, whatever the height of the band.
        for row in
            (0..texels.len() / row_values).map(|row| row * row_values..(row + 1) * row_values)
        {
            let pending = &mut self.pending;
            match &mut self.conversion {
                AnyConversion::U8(conversion) => pending.extend(&*conversion.apply(texels, row)),
                AnyConversion::U16(conversion) => {
                    let values = conversion.apply(texels, row);
                    pending.extend(values.iter().flat_map(|value| value.to_le_bytes()));
                }
                AnyConversion::F32(conversion) => {
                    let values = conversion.apply(texels, row);
                    pending.extend(values.iter().flat_map(|value| value.to_le_bytes()));
                }
            }
            if self.pending.len() >= strip_bytes {
                self.flush(out)?;
            }
        }
        Ok(())
    }

    fn finish(mut self: Box<Self>, out: &mut dyn Sink) -> Result<Vec<Loss>, EncodeError> {
        let start = self.start(out)?;
        if !self.pending.is_empty() {
            self.flush(out)?;
        }
        // Directories start at even offsets.
        self.put(&[0; 1][..(self.length % 2) as usize], out)?;
        let directory = Directory::of(&self);
        let at = self.length;
        let bytes = directory.encode(at, self.is_big);
        self.put(&bytes, out)?;
        out.seek(SeekFrom::Start(start + if self.is_big { 8 } else { 4 }))?;
        if self.is_big {
            out.write_all(&at.to_le_bytes())?;
        } else {
            out.write_all(&(at as u32).to_le_bytes())?;
        }
        out.seek(SeekFrom::Start(start + self.length))?;
        Ok(match self.conversion {
            AnyConversion::U8(conversion) => conversion.losses(),
            AnyConversion::U16(conversion) => conversion.losses(),
            AnyConversion::F32(conversion) => conversion.losses(),
        })
    }
}

/// Replaces each integer of a row by the difference to the one of the same channel before it: the
/// horizontal predictor.
fn take_differences(row: &mut [u8], spec: &TextureSpec) {
    let channels = spec.channels.count();
    if spec.depth == Depth::U8 {
        for at in (channels..row.len()).rev() {
            row[at] = row[at].wrapping_sub(row[at - channels]);
        }
        return;
    }
    let value = |row: &[u8], index: usize| u16::from_le_bytes([row[2 * index], row[2 * index + 1]]);
    for index in (channels..row.len() / 2).rev() {
        let difference = value(row, index).wrapping_sub(value(row, index - channels));
        row[2 * index..2 * index + 2].copy_from_slice(&difference.to_le_bytes());
    }
}

/// The entries of a directory, by ascending tags.
struct Directory {
    entries: Vec<(u16, Values)>,
}

enum Values {
    Shorts(Vec<u16>),
    Longs(Vec<u32>),
    /// 64 bits in a BigTIFF, 32 in others.
    Offsets(Vec<u64>),
    Rational([u32; 2]),
    Undefined(Vec<u8>),
}

impl Directory {
    fn of(image: &RowEncoder) -> Self {
        let RowEncoder { spec, compress, strips, .. } = image;
        let channels = spec.channels.count();
        let predicted = *compress && spec.depth != Depth::F32;
        let short = |value: u16| Values::Shorts(vec![value]);
        let interpretation =
            if spec.channels.has_color() { photometric::RGB } else { photometric::BLACK_IS_ZERO };
        let format = match spec.depth {
            Depth::F32 => sample_format::FLOAT,
            Depth::U8 | Depth::U16 => sample_format::UNSIGNED,
        };
        let method = if *compress { compression::DEFLATE } else { compression::NONE };
        let difference = if predicted { predictor::HORIZONTAL } else { predictor::NONE };
        let rows = image.rows_in_strip.min(u32::MAX.into()) as u32;
        let mut entries = vec![
            (tags::IMAGE_WIDTH, Values::Longs(vec![spec.size.width])),
            (tags::IMAGE_LENGTH, Values::Longs(vec![spec.size.height])),
            (tags::BITS_PER_SAMPLE, Values::Shorts(vec![8 * spec.depth.bytes() as u16; channels])),
            (tags::COMPRESSION, short(method)),
            (tags::PHOTOMETRIC_INTERPRETATION, short(interpretation)),
            (tags::STRIP_OFFSETS, Values::Offsets(strips.iter().map(|&(at, _)| at).collect())),
            (tags::SAMPLES_PER_PIXEL, short(channels as u16)),
            (tags::ROWS_PER_STRIP, Values::Longs(vec![rows])),
            (
                tags::STRIP_BYTE_COUNTS,
                Values::Offsets(strips.iter().map(|&(_, len)| len).collect()),
            ),
            (tags::X_RESOLUTION, Values::Rational([1, 1])),
            (tags::Y_RESOLUTION, Values::Rational([1, 1])),
            (tags::RESOLUTION_UNIT, short(NO_UNIT)),
            (tags::PREDICTOR, short(difference)),
        ];
        if spec.channels.has_alpha() {
            entries.push((tags::EXTRA_SAMPLES, short(extra::ALPHA)));
        }
        entries.push((tags::SAMPLE_FORMAT, Values::Shorts(vec![format; channels])));
        if let Some(icc) = &image.icc {
            entries.push((tags::ICC_PROFILE, Values::Undefined(icc.clone())));
        }
        Self { entries }
    }

    /// The bytes of the directory, and after it the values that do not fit an entry.
    ///
    /// - `at`: its offset in the file.
    fn encode(&self, at: u64, is_big: bool) -> Vec<u8> {
        let (entry_bytes, inline) = if is_big { (20, 8) } else { (12, 4) };
        let [count_bytes, next_bytes] = if is_big { [8, 8] } else { [2, 4] };
        let length = count_bytes + entry_bytes * self.entries.len() + next_bytes;
        let (mut bytes, mut values) = (Vec::new(), Vec::new());
        let offset = |bytes: &mut Vec<u8>, value: u64| {
            // The file was checked to be short enough for 32 bits.
            bytes.extend(&value.to_le_bytes()[..inline]);
        };
        bytes.extend(&(self.entries.len() as u64).to_le_bytes()[..count_bytes]);
        for (tag, entry) in &self.entries {
            let (kind, count, data) = entry.encode(is_big);
            bytes.extend(tag.to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            offset(&mut bytes, count);
            if data.len() <= inline {
                bytes.extend(&data);
                bytes.resize(bytes.len() + inline - data.len(), 0);
            } else {
                offset(&mut bytes, at + (length + values.len()) as u64);
                values.extend(data);
                // Values start at even offsets.
                values.resize(values.len().next_multiple_of(2), 0);
            }
        }
        // No further directory.
        bytes.resize(length, 0);
        bytes.extend(values);
        bytes
    }
}

impl Values {
    /// The type, the number of values, and their bytes.
    fn encode(&self, is_big: bool) -> (u16, u64, Vec<u8>) {
        let bytes_of = |values: &[u32]| values.iter().flat_map(|it| it.to_le_bytes()).collect();
        match self {
            Self::Shorts(values) => {
                let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
                (kind::SHORT, values.len() as u64, bytes)
            }
            Self::Longs(values) => (kind::LONG, values.len() as u64, bytes_of(values)),
            Self::Offsets(values) if is_big => {
                let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
                (kind::LONG8, values.len() as u64, bytes)
            }
            Self::Offsets(values) => {
                let values: Vec<u32> = values.iter().map(|&value| value as u32).collect();
                (kind::LONG, values.len() as u64, bytes_of(&values))
            }
            Self::Rational(value) => (kind::RATIONAL, 1, bytes_of(value)),
            Self::Undefined(bytes) => (kind::UNDEFINED, bytes.len() as u64, bytes.clone()),
        }
    }
}
