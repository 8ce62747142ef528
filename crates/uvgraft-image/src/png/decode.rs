//! Rows out of a PNG, top to bottom.
//!
//! The rows of common images are inflated and unfiltered here (4096², detailed, by Pillow: 79 ms;
//! the `png` crate takes 134). The crate reads what is before them, and all other images. The
//! checksum of every chunk that matters is verified.

use std::io::{BufRead, Seek};
use std::ops::Range;

use ::png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Reader, Transformations};
use uvgraft::texture::{Channels, Depth, Texels, Value};

use super::color_conversion::ColorConversion;
use super::color_space;
use super::image_data::ImageData;
use super::unfilter::{Unfilter, UnknownFilter};
use super::{FORMAT, Outline, outline};
use crate::header::{MAX_ICC_BYTES, StoredHeader};
use crate::{DeclaredSpace, ImageError, codec};

/// A PNG decoded on demand.
pub(super) struct RowDecoder<R: BufRead + Seek> {
    header: StoredHeader,
    icc: Option<Vec<u8>>,
    conversion: Option<ColorConversion>,
    is_sequential: bool,
    rows: Rows<R>,
    /// A row, or several, as stored.
    bytes: Vec<u8>,
    row_bytes: usize,
    rows_left: u32,
}

enum Rows<R: BufRead + Seek> {
    Plain(Box<(ImageData<R>, Unfilter)>),
    Other(Box<Reader<R>>),
}

/// Bytes of rows that are decoded at once where they are converted after that.
const AT_ONCE: usize = 1 << 17;

impl<R: BufRead + Seek> RowDecoder<R> {
    pub(super) fn new(mut source: R, space: DeclaredSpace) -> Result<Self, ImageError> {
        let io = |error| ImageError::from_io(FORMAT, &error);
        let Outline { header, plain } = outline(&mut source)?;
        source.rewind().map_err(io)?;
        let texel_bytes = header.channels.count() * if header.depth == Depth::U16 { 2 } else { 1 };
        let row_bytes = header.size.width as usize * texel_bytes;
        let (rows, colors, is_sequential) = if let Some(start) = plain {
            // Checks what is before the image data.
            let colors = Colors::new(reader(&mut source, &header)?.info(), &header, space)?;
            let data = ImageData::new(source, start, row_bytes + 1, header.size.height)?;
            (Rows::Plain(Box::new((data, Unfilter::new(row_bytes, texel_bytes)))), colors, true)
        } else {
            let reader = reader(source, &header)?;
            let colors = Colors::new(reader.info(), &header, space)?;
            let is_sequential = !reader.info().interlaced;
            (Rows::Other(Box::new(reader)), colors, is_sequential)
        };
        let Colors { icc, conversion } = colors;
        let rows_left = header.size.height;
        let bytes = Vec::new();
        Ok(Self { header, icc, conversion, is_sequential, rows, bytes, row_bytes, rows_left })
    }

    /// Converts decoded texels to sRGB, if they are not.
    fn convert<T: Value + Into<u16> + TryFrom<u16>>(&self, texels: &mut [T]) {
        if let Some(conversion) = &self.conversion {
            conversion.apply(texels);
        }
    }

    /// Decodes the next rows in parts.
    fn in_parts(&mut self, rows: usize, mut take: impl FnMut(&[u8])) -> Result<(), ImageError> {
        let at_once = (AT_ONCE / self.row_bytes).max(1).min(rows);
        self.bytes.resize(at_once * self.row_bytes, 0);
        let mut left = rows;
        while left > 0 {
            let part = left.min(at_once);
            let bytes = &mut self.bytes[..part * self.row_bytes];
            self.rows.read(bytes, self.row_bytes)?;
            take(bytes);
            left -= part;
            self.rows_left -= part as u32;
        }
        self.check_end()
    }

    /// What follows the texels, up to IEND, may be missing too.
    fn check_end(&mut self) -> Result<(), ImageError> {
        if self.rows_left > 0 {
            return Ok(());
        }
        match &mut self.rows {
            Rows::Plain(plain) => plain.0.finish(),
            Rows::Other(reader) => reader.finish().map_err(from_png),
        }
    }
}

impl<R: BufRead + Seek + Send> codec::RowDecoder for RowDecoder<R> {
    fn header(&self) -> StoredHeader {
        self.header
    }

    fn icc(&self) -> Option<Vec<u8>> {
        self.icc.clone()
    }

    fn is_sequential(&self) -> bool {
        self.is_sequential
    }

    fn skip(&mut self, rows: u32) -> Result<(), ImageError> {
        self.in_parts(rows as usize, |_| {})
    }

    fn read(&mut self, texels: &mut Texels, places: Range<u32>) -> Result<(), ImageError> {
        let values = self.header.row_values();
        let part = places.start as usize * values..places.end as usize * values;
        match texels {
            Texels::U8(texels) => {
                let texels = &mut texels[part];
                self.rows.read(texels, self.row_bytes)?;
                self.rows_left -= places.len() as u32;
                self.convert(texels);
                self.check_end()
            }
            Texels::U16(texels) => {
                let texels = &mut texels[part];
                let mut rest = texels.iter_mut();
                self.in_parts(places.len(), |bytes| {
                    for (&bytes, value) in bytes.as_chunks().0.iter().zip(&mut rest) {
                        *value = u16::from_be_bytes(bytes);
                    }
                })?;
                self.convert(texels);
                Ok(())
            }
            Texels::F32(_) => unreachable!("PNG holds integers"),
        }
    }

    fn read_all(mut self: Box<Self>) -> Result<Texels, ImageError> {
        let mut data = vec![0; self.row_bytes * self.rows_left as usize];
        match &mut self.rows {
            Rows::Other(reader) => {
                let _ = reader.next_frame(&mut data).map_err(from_png)?;
            }
            rows => rows.read(&mut data, self.row_bytes)?,
        }
        self.rows_left = 0;
        self.check_end()?;
        Ok(if self.header.depth == Depth::U16 {
            let values = data.as_chunks().0.iter().map(|&bytes| u16::from_be_bytes(bytes));
            let mut values: Vec<_> = values.collect();
            self.convert(&mut values);
            Texels::U16(values)
        } else {
            self.convert(&mut data);
            Texels::U8(data)
        })
    }
}

impl<R: BufRead + Seek> Rows<R> {
    /// Fills `bytes` with the next rows.
    fn read(&mut self, bytes: &mut [u8], row_bytes: usize) -> Result<(), ImageError> {
        match self {
            Self::Plain(plain) => {
                let (data, unfilter) = &mut **plain;
                let mut rest = bytes;
                while !rest.is_empty() {
                    let filtered = data.rows(rest.len() / row_bytes)?;
                    let (rows, after) =
                        rest.split_at_mut(filtered.len() / (row_bytes + 1) * row_bytes);
                    unfilter.apply(filtered, rows).map_err(|UnknownFilter(number)| {
                        ImageError::damaged(FORMAT, format_args!("unknown filter {number}"))
                    })?;
                    rest = after;
                }
            }
            Self::Other(reader) => {
                for row in bytes.chunks_exact_mut(row_bytes) {
                    reader.read_row(row).map_err(from_png)?;
                }
            }
        }
        Ok(())
    }
}

/// Reads everything before the rows.
fn reader<R: BufRead + Seek>(source: R, header: &StoredHeader) -> Result<Reader<R>, ImageError> {
    // The limit applies to chunks kept in memory, of which only the profile is large: it is there as it is
    // stored, and inflated.
    let limits = Limits { bytes: 2 * MAX_ICC_BYTES + (1 << 20) };
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
    Ok(reader)
}

/// What becomes of the colours.
struct Colors {
    icc: Option<Vec<u8>>,
    conversion: Option<ColorConversion>,
}

impl Colors {
    fn new(
        info: &Info<'_>,
        header: &StoredHeader,
        space: DeclaredSpace,
    ) -> Result<Self, ImageError> {
        // Checked before it is copied.
        if let Some(found) = info.icc_profile.as_ref().map(|icc| icc.len())
            && found > MAX_ICC_BYTES
        {
            return Err(ImageError::IccTooLarge { found, max: MAX_ICC_BYTES });
        }
        let icc = || info.icc_profile.as_deref().map(<[u8]>::to_vec);
        if space == DeclaredSpace::Ignored {
            return Ok(Self { icc: icc(), conversion: None });
        }
        let conversion = color_space::declared(info)?
            .and_then(|space| ColorConversion::new(&space, header.channels, header.depth));
        // A profile describes the values as stored, and counts less than cICP.
        let icc = if color_space::code_points(info).is_some() { None } else { icc() };
        Ok(Self { icc, conversion })
    }
}

fn from_png(error: DecodingError) -> ImageError {
    match error {
        DecodingError::IoError(error) => ImageError::from_io(FORMAT, &error),
        error => ImageError::damaged(FORMAT, error),
    }
}
