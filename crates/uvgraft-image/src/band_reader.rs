//! Reads images in bands of rows, top to bottom.

use std::io::Cursor;
use std::path::PathBuf;

use uvgraft::texture::{Depth, Size, Texels, Texture};

use super::codec::{Decode, Decoded, OpenRows, RowDecoder, Source};
use super::decoder_panics::refused;
use super::header::{check_backed, detect};
use super::opened::Content;
use super::orientation::Orientation;
use super::{DeclaredSpace, Format, Header, Image, ImageError, ReadError, TextureSpec, header};
use uvgraft_files::input::Input;

/// An image decoded in bands of rows, with the same result as [`decode`].
///
/// Upright, non-interlaced PNGs are decoded on demand, with memory for a few rows. All other images
/// are decoded at once.
///
/// The last row is returned only after the rest of the file was verified, so an image read to its
/// end is complete. A caller that stops earlier knows that the file is not truncated, which is
/// checked at the start, but not that the remainder is undamaged.
///
/// [`decode`]: super::decode
pub struct BandDecoder<'a> {
    header: Header,
    icc: Option<Vec<u8>>,
    rows: Rows<'a>,
    next_row: u32,
    spare: Vec<Texels>,
    /// Length of the file.
    length: u64,
}

enum Rows<'a> {
    Decoder(Box<dyn RowDecoder + 'a>),
    Whole(Texels),
}

impl<'a> BandDecoder<'a> {
    /// Reads everything before the texels.
    ///
    /// # Errors
    /// [`ImageError`] for a header that [`decode`](super::decode) rejects, or a truncated file; for
    /// an image decoded at once, any error of [`decode`](super::decode).
    pub fn new(bytes: &'a [u8]) -> Result<Self, ImageError> {
        Self::with(bytes, DeclaredSpace::Honoured)
    }

    /// As [`BandDecoder::new`].
    ///
    /// - `space`: whether colours are converted from the colour space that the file declares.
    ///
    /// # Errors
    /// As [`BandDecoder::new`].
    pub fn with(bytes: &'a [u8], space: DeclaredSpace) -> Result<Self, ImageError> {
        Self::among(Format::ALL, bytes, space)
    }

    /// As [`BandDecoder::with`], for an image in one of the formats given, which may be those of others.
    ///
    /// - `bytes`: owned ones are kept if rows are decoded on demand.
    ///
    /// # Errors
    /// As [`BandDecoder::new`].
    pub fn among(
        formats: &[Format],
        bytes: impl AsRef<[u8]> + Send + 'a,
        space: DeclaredSpace,
    ) -> Result<Self, ImageError> {
        let all = bytes.as_ref();
        let (format, length) = (detect(formats, all)?, all.len() as u64);
        match format.codec().decode {
            Decode::Rows(open) => {
                Self::in_rows(format, open, Box::new(Cursor::new(bytes)), length, space)
            }
            Decode::Whole(decode) => {
                let header = || (format.codec().header)(&mut Cursor::new(all));
                // Whatever else is wrong with a header, decoding says.
                if let Ok(stored) = refused(format, header) {
                    check_backed(&stored.public(format), length)?;
                }
                Self::decoded(format, refused(format, || decode(all, space))?, length)
            }
        }
    }

    /// Starts to decode a file of a format that is decoded in rows.
    pub(super) fn in_rows(
        format: Format,
        open: OpenRows,
        source: Box<dyn Source + 'a>,
        length: u64,
        space: DeclaredSpace,
    ) -> Result<Self, ImageError> {
        let decoder = refused(format, || open(source, space))?;
        let stored = decoder.header();
        let icc = header::check_icc(decoder.icc())?;
        let header = stored.public(format);
        if stored.orientation != Orientation::default() || !decoder.is_sequential() {
            check_backed(&header, length)?;
            let texels = refused(format, || decoder.read_all())?;
            return Self::decoded(format, Decoded { header: stored, texels, icc }, length);
        }
        Ok(Self::from_rows(header, icc, Rows::Decoder(decoder), length))
    }

    fn decoded(format: Format, decoded: Decoded, length: u64) -> Result<Self, ImageError> {
        let header = decoded.header.public(format);
        let (texels, icc) = decoded.upright(format)?;
        Ok(Self::from_rows(header, icc, Rows::Whole(texels), length))
    }

    fn from_rows(header: Header, icc: Option<Vec<u8>>, rows: Rows<'a>, length: u64) -> Self {
        Self { header, icc, rows, next_row: 0, spare: Vec::new(), length }
    }

    /// Size, channels and depth of the whole image.
    pub const fn header(&self) -> Header {
        self.header
    }

    /// The whole image as [`BandEncoder`](super::BandEncoder) expects it.
    pub fn spec(&self) -> TextureSpec {
        let Header { format, size, channels, depth, .. } = self.header;
        TextureSpec { size, channels, depth, encoding: format.codec().encoding(depth) }
    }

    /// The ICC profile, passed through uninterpreted.
    pub fn icc(&self) -> Option<&[u8]> {
        self.icc.as_deref()
    }

    /// The first row of the next band.
    pub const fn next_row(&self) -> u32 {
        self.next_row
    }

    /// Skips `rows` rows, or as many as are left.
    ///
    /// # Errors
    /// [`ImageError`] if they are damaged.
    pub fn skip(&mut self, rows: u32) -> Result<(), ImageError> {
        let rows = rows.min(self.header.size.height - self.next_row);
        if let Rows::Decoder(decoder) = &mut self.rows
            && rows > 0
        {
            refused(self.header.format, || decoder.skip(rows))?;
        }
        self.next_row += rows;
        Ok(())
    }

    /// The next `rows` rows, at least 1, or as many as are left; `None` after the last.
    ///
    /// # Errors
    /// [`ImageError`] if they are damaged, and with the last of them if anything after them is.
    /// After an error the rest of the image is undefined.
    pub fn next_band(&mut self, rows: u32) -> Result<Option<Texture>, ImageError> {
        let Size { width, height } = self.header.size;
        let rows = rows.max(1).min(height - self.next_row);
        if rows == 0 {
            return Ok(None);
        }
        let spec = self.spec();
        if let Rows::Whole(whole) = &mut self.rows
            && rows == height
        {
            self.next_row = height;
            let texels = std::mem::replace(whole, Texels::U8(Vec::new()));
            return Ok(Some(Texture::new(self.header.size, spec.channels, spec.encoding, texels)?));
        }
        let mut texels = self.memory(rows as usize * spec.row_values());
        match &mut self.rows {
            Rows::Decoder(decoder) => {
                refused(self.header.format, || decoder.read(&mut texels, 0..rows))?;
            }
            Rows::Whole(whole) => {
                copy(whole, self.next_row as usize * spec.row_values(), &mut texels);
            }
        }
        self.next_row += rows;
        let size = Size::new(width, rows);
        Ok(Some(Texture::new(size, spec.channels, spec.encoding, texels)?))
    }

    /// The image at its full size, decoded from the next row for as long as `is_wanted` confirms
    /// the next row, which is queried every 32nd; rows above and below have undefined values.
    ///
    /// If decoding fails, the end of the intact rows is returned with the reason: the caller may
    /// know meanwhile that the rest is not needed.
    ///
    /// # Errors
    /// [`ImageError`] if there is no memory for it, or the file is too short for so much: see
    /// [`MAX_UNBACKED_BYTES`](super::MAX_UNBACKED_BYTES).
    pub fn read_while(
        mut self,
        mut is_wanted: impl FnMut(u32) -> bool,
    ) -> Result<(Texture, Option<(u32, ImageError)>), ImageError> {
        /// Rows between queries.
        const ROWS: u32 = 32;
        check_backed(&self.header, self.length)?;
        let mut failure = None;
        let TextureSpec { size, channels, encoding, .. } = self.spec();
        let values = size.height as usize * self.spec().row_values();
        let mut texels = match &mut self.rows {
            Rows::Whole(whole) => std::mem::replace(whole, Texels::U8(Vec::new())),
            Rows::Decoder(_) => self.memory(values),
        };
        if let Rows::Decoder(decoder) = &mut self.rows {
            while self.next_row < size.height && is_wanted(self.next_row) {
                let end = size.height.min(self.next_row + ROWS);
                let rows = self.next_row..end;
                if let Err(error) = refused(self.header.format, || decoder.read(&mut texels, rows))
                {
                    failure = Some((self.next_row, error));
                    break;
                }
                self.next_row = end;
            }
        }
        Ok((Texture::new(size, channels, encoding, texels)?, failure))
    }

    /// All remaining rows, at least one.
    pub(super) fn rest(&mut self) -> Result<Texture, ImageError> {
        check_backed(&self.header, self.length)?;
        self.next_band(u32::MAX)?
            .ok_or_else(|| ImageError::damaged(self.header.format, "the image has no rows"))
    }

    pub(super) fn take_icc(&mut self) -> Option<Vec<u8>> {
        self.icc.take()
    }

    /// Returns a band for reuse of its memory. Fresh memory costs as much as decoding.
    pub fn recycle(&mut self, band: Texture) {
        if band.depth() == self.header.depth {
            self.spare.push(band.into_texels());
        }
    }

    /// A buffer of `len` undefined values.
    fn memory(&mut self, len: usize) -> Texels {
        let mut texels = self.spare.pop().unwrap_or_else(|| match self.header.depth {
            Depth::U8 => Texels::U8(Vec::new()),
            Depth::U16 => Texels::U16(Vec::new()),
            Depth::F32 => Texels::F32(Vec::new()),
        });
        match &mut texels {
            Texels::U8(values) => resize(values, len),
            Texels::U16(values) => resize(values, len),
            Texels::F32(values) => resize(values, len),
        }
        texels
    }
}

/// A vector allocated as zeroed by the system, which filling would touch once more.
fn resize<T: Copy + Default>(values: &mut Vec<T>, len: usize) {
    if values.capacity() < len {
        *values = vec![T::default(); len];
    } else {
        values.resize(len, T::default());
    }
}

fn copy(whole: &Texels, from: usize, to: &mut Texels) {
    fn part<T: Copy>(whole: &[T], from: usize, to: &mut [T]) {
        to.copy_from_slice(&whole[from..from + to.len()]);
    }
    match (whole, to) {
        (Texels::U8(whole), Texels::U8(to)) => part(whole, from, to),
        (Texels::U16(whole), Texels::U16(to)) => part(whole, from, to),
        (Texels::F32(whole), Texels::F32(to)) => part(whole, from, to),
        _ => unreachable!("memory is made for the depth of the image"),
    }
}

/// A [`BandDecoder`] of a file or of bytes, with the path or name in its errors.
///
/// PNGs of files are decoded while they are read, which is faster than reading them first: touching fresh
/// memory costs more than the copy.
pub struct BandReader {
    path: PathBuf,
    decoder: BandDecoder<'static>,
}

impl BandReader {
    /// Opens an image and reads everything before its texels.
    ///
    /// # Errors
    /// [`ReadError`], with the path, if the file cannot be read, or as [`BandDecoder::new`].
    pub fn open(input: impl Into<Input>) -> Result<Self, ReadError> {
        Self::with(input, DeclaredSpace::Honoured)
    }

    /// As [`BandReader::open`], with a choice as in [`BandDecoder::with`].
    ///
    /// # Errors
    /// As [`BandReader::open`].
    pub fn with(input: impl Into<Input>, space: DeclaredSpace) -> Result<Self, ReadError> {
        let input = input.into();
        let path = input.name().to_path_buf();
        match Content::open(&input) {
            Ok(content) => Self::of(path, content, space),
            Err(reason) => Err(ReadError::Io { path, reason }),
        }
    }

    pub(super) fn of(
        path: PathBuf,
        content: Content,
        space: DeclaredSpace,
    ) -> Result<Self, ReadError> {
        match content.into_decoder(space) {
            Ok(Ok(decoder)) => Ok(Self { path, decoder }),
            Ok(Err(reason)) => Err(ReadError::Content { path, reason }),
            Err(reason) => Err(ReadError::Io { path, reason }),
        }
    }

    /// As [`BandDecoder::header`].
    pub const fn header(&self) -> Header {
        self.decoder.header()
    }

    /// As [`BandDecoder::spec`].
    pub fn spec(&self) -> TextureSpec {
        self.decoder.spec()
    }

    /// As [`BandDecoder::icc`].
    pub fn icc(&self) -> Option<&[u8]> {
        self.decoder.icc()
    }

    /// As [`BandDecoder::next_row`].
    pub const fn next_row(&self) -> u32 {
        self.decoder.next_row()
    }

    /// As [`BandDecoder::skip`].
    ///
    /// # Errors
    /// [`ReadError`], with the path.
    pub fn skip(&mut self, rows: u32) -> Result<(), ReadError> {
        let Self { path, decoder } = self;
        decoder.skip(rows).map_err(|reason| ReadError::Content { path: path.clone(), reason })
    }

    /// As [`BandDecoder::next_band`].
    ///
    /// # Errors
    /// [`ReadError`], with the path.
    pub fn next_band(&mut self, rows: u32) -> Result<Option<Texture>, ReadError> {
        let Self { path, decoder } = self;
        decoder.next_band(rows).map_err(|reason| ReadError::Content { path: path.clone(), reason })
    }

    /// As [`BandDecoder::read_while`].
    ///
    /// # Errors
    /// [`ReadError`], with the path.
    pub fn read_while(
        self,
        is_wanted: impl FnMut(u32) -> bool,
    ) -> Result<(Texture, Option<(u32, ReadError)>), ReadError> {
        let Self { path, decoder } = self;
        let named = |reason| ReadError::Content { path: path.clone(), reason };
        let (texture, failure) = decoder.read_while(is_wanted).map_err(named)?;
        Ok((texture, failure.map(|(row, reason)| (row, named(reason)))))
    }

    pub(super) fn read_whole(self) -> Result<Image, ReadError> {
        let Self { path, mut decoder } = self;
        let texture = decoder.rest().map_err(|reason| ReadError::Content { path, reason })?;
        Ok(Image { texture, icc: decoder.take_icc() })
    }

    /// As [`BandDecoder::recycle`].
    pub fn recycle(&mut self, band: Texture) {
        self.decoder.recycle(band);
    }
}
