//! Writes images in bands of rows, top to bottom.

use std::collections::TryReserveError;
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use uvgraft::texture::{Depth, Size, Texels, Texture};

use super::codec::{Encode, EncodeWhole, RowEncoder};
use super::{
    EncodeError, Format, MAX_ICC_BYTES, MAX_WHOLE_TEXELS, Segment, Segments, TextureSpec,
    WriteError, WriteOptions, Written,
};
use uvgraft_files::output::AtomicFile;

/// An image encoded while bands of its rows arrive; the bytes do not depend on the heights of the
/// bands.
///
/// They need memory for a few rows, except for formats such as WebP, whose rows are collected and encoded at the end.
pub struct BandEncoder<W: Write + Seek> {
    format: Format,
    spec: TextureSpec,
    segments: Option<Segments>,
    rows_left: u32,
    out: W,
    rows: Rows,
}

enum Rows {
    Encoder(Box<dyn RowEncoder>),
    Collected { encode: EncodeWhole, texels: Texels, icc: Option<Vec<u8>>, options: WriteOptions },
}

impl<W: Write + Seek> BandEncoder<W> {
    /// Starts an image; `spec` describes all bands together.
    ///
    /// # Errors
    /// [`EncodeError`] if the format cannot store it.
    pub fn new(
        out: W,
        format: Format,
        spec: TextureSpec,
        icc: Option<&[u8]>,
        options: &WriteOptions,
    ) -> Result<Self, EncodeError> {
        let icc = check(format, &spec, icc)?;
        let rows = match format.codec().encode {
            Encode::Rows(start) => Rows::Encoder(start(&spec, icc, options)?),
            Encode::Whole(encode) => {
                let len = spec.values();
                let memory = |error| EncodeError::encoder(format, error);
                let texels = match spec.depth {
                    Depth::U8 => Texels::U8(reserve(len).map_err(memory)?),
                    Depth::U16 => Texels::U16(reserve(len).map_err(memory)?),
                    Depth::F32 => Texels::F32(reserve(len).map_err(memory)?),
                };
                Rows::Collected { encode, texels, icc: icc.map(<[u8]>::to_vec), options: *options }
            }
        };
        let segments = Segments::new(format, spec, options);
        Ok(Self { format, spec, segments, rows_left: spec.size.height, out, rows })
    }

    /// Encodes the next rows: a texture as wide as the image, with its channels, depth and
    /// encoding.
    ///
    /// # Errors
    /// [`EncodeError`] if the texture has another format, has more rows than are left, or cannot be
    /// written.
    pub fn push(&mut self, band: &Texture) -> Result<(), EncodeError> {
        let (found, wanted) = (TextureSpec::from(band), self.spec);
        let mut fitting = found;
        fitting.size.height = wanted.size.height;
        if fitting != wanted {
            return Err(EncodeError::Band { found, wanted });
        }
        let rows = band.size().height;
        if rows > self.rows_left {
            let done = u64::from(wanted.size.height - self.rows_left);
            let found = done + u64::from(rows);
            return Err(EncodeError::Rows { found, wanted: wanted.size.height });
        }
        match &mut self.rows {
            Rows::Encoder(encoder) => encoder.write(band.texels(), &mut self.out)?,
            Rows::Collected { texels, .. } => match (texels, band.texels()) {
                (Texels::U8(all), Texels::U8(values)) => all.extend_from_slice(values),
                (Texels::U16(all), Texels::U16(values)) => all.extend_from_slice(values),
                (Texels::F32(all), Texels::F32(values)) => all.extend_from_slice(values),
                _ => return Err(EncodeError::Band { found, wanted }),
            },
        }
        self.rows_left -= rows;
        Ok(())
    }

    /// How the image is divided into segments, if it is.
    pub fn segments(&self) -> Option<Segments> {
        self.segments
    }

    /// Appends the next rows as a segment that is encoded already, to the same effect as
    /// [`BandEncoder::push`] with these rows.
    ///
    /// # Errors
    /// [`EncodeError`] if it is not the next segment of this image, or cannot be written.
    pub fn push_segment(&mut self, segment: &Segment) -> Result<(), EncodeError> {
        let next_row = self.spec.size.height - self.rows_left;
        if self.segments != Some(segment.of) || segment.first_row != next_row {
            let (found, wanted) = (segment.first_row, next_row);
            return Err(EncodeError::Segment { found, wanted });
        }
        match &mut self.rows {
            Rows::Encoder(encoder) => encoder.push_segment(&*segment.content, &mut self.out)?,
            Rows::Collected { .. } => unreachable!("encoded as a whole"),
        }
        self.rows_left -= segment.rows;
        Ok(())
    }

    /// Writes the remaining data, and returns the output.
    ///
    /// # Errors
    /// [`EncodeError`] if rows are missing, or it cannot be written.
    pub fn finish(self) -> Result<(Written, W), EncodeError> {
        let Self { format, spec, rows_left, mut out, rows, .. } = self;
        if rows_left > 0 {
            let wanted = spec.size.height;
            return Err(EncodeError::Rows { found: (wanted - rows_left).into(), wanted });
        }
        let losses = match rows {
            Rows::Encoder(encoder) => encoder.finish(&mut out)?,
            Rows::Collected { encode, texels, icc, options } => {
                let texture = Texture::new(spec.size, spec.channels, spec.encoding, texels)
                    .map_err(|error| EncodeError::encoder(format, error))?;
                encode(&texture, icc.as_deref(), &options, &mut out)?
            }
        };
        Ok((Written { losses }, out))
    }
}

fn reserve<T>(len: usize) -> Result<Vec<T>, TryReserveError> {
    let mut values = Vec::new();
    values.try_reserve_exact(len)?;
    Ok(values)
}

/// Checks that a format can store images of a size.
///
/// # Errors
/// [`EncodeError`] if it is too large.
pub fn check_size(format: Format, size: Size) -> Result<(), EncodeError> {
    let max = format.codec().max_side;
    if size.width.max(size.height) > max {
        return Err(EncodeError::TooLarge { format, found: size, max });
    }
    if format.codec().is_encoded_whole() && size.texels() as u64 > MAX_WHOLE_TEXELS {
        return Err(EncodeError::TooManyTexels { format, found: size, max: MAX_WHOLE_TEXELS });
    }
    Ok(())
}

/// Checks that the format can store such a texture with this profile, and returns the profile
/// unless it is empty.
pub(super) fn check<'a>(
    format: Format,
    spec: &TextureSpec,
    icc: Option<&'a [u8]>,
) -> Result<Option<&'a [u8]>, EncodeError> {
    let TextureSpec { size, channels, .. } = *spec;
    if channels.has_alpha() && !format.codec().has_alpha {
        return Err(EncodeError::Alpha { format });
    }
    check_size(format, size)?;
    if size.texels() == 0 {
        return Err(EncodeError::encoder(
            format,
            format_args!("an image cannot have {size} texels"),
        ));
    }
    match icc.filter(|icc| !icc.is_empty()) {
        Some(icc) if icc.len() > MAX_ICC_BYTES => {
            Err(EncodeError::IccTooLarge { found: icc.len(), max: MAX_ICC_BYTES })
        }
        icc => Ok(icc),
    }
}

/// A [`BandEncoder`] into a file that appears when it is finished. If dropped before, an existing
/// file is unchanged.
pub struct BandWriter {
    path: PathBuf,
    encoder: BandEncoder<BufWriter<AtomicFile>>,
}

impl BandWriter {
    /// Starts a file in the format of the path's extension.
    ///
    /// # Errors
    /// [`WriteError`], with the path, if the extension is missing or unknown, the format cannot
    /// store the image or the folder cannot be written.
    pub fn create(
        path: impl AsRef<Path>,
        spec: TextureSpec,
        icc: Option<&[u8]>,
        options: &WriteOptions,
    ) -> Result<Self, WriteError> {
        Self::create_at(path.as_ref(), spec, icc, options)
    }

    fn create_at(
        path: &Path,
        spec: TextureSpec,
        icc: Option<&[u8]>,
        options: &WriteOptions,
    ) -> Result<Self, WriteError> {
        let format =
            Format::from_path(path).ok_or_else(|| WriteError::Extension { path: path.into() })?;
        let bad = |reason| WriteError::Encode { path: path.into(), reason };
        check(format, &spec, icc).map_err(bad)?;
        let file = AtomicFile::create(path).map_err(|error| bad(error.into()))?.buffered();
        let encoder = BandEncoder::new(file, format, spec, icc, options).map_err(bad)?;
        Ok(Self { path: path.into(), encoder })
    }

    /// As [`BandEncoder::push`].
    ///
    /// # Errors
    /// [`WriteError`], with the path.
    pub fn push(&mut self, band: &Texture) -> Result<(), WriteError> {
        let Self { path, encoder } = self;
        encoder.push(band).map_err(|reason| WriteError::Encode { path: path.clone(), reason })
    }

    /// As [`BandEncoder::segments`].
    pub fn segments(&self) -> Option<Segments> {
        self.encoder.segments()
    }

    /// As [`BandEncoder::push_segment`].
    ///
    /// # Errors
    /// [`WriteError`], with the path.
    pub fn push_segment(&mut self, segment: &Segment) -> Result<(), WriteError> {
        let Self { path, encoder } = self;
        let bad = |reason| WriteError::Encode { path: path.clone(), reason };
        encoder.push_segment(segment).map_err(bad)
    }

    /// Writes the remaining data and moves the file into place.
    ///
    /// # Errors
    /// [`WriteError`], with the path; an existing file is then unchanged.
    pub fn finish(self) -> Result<Written, WriteError> {
        let Self { path, encoder } = self;
        let finish = || {
            let (written, out) = encoder.finish()?;
            out.into_inner().map_err(std::io::IntoInnerError::into_error)?.commit()?;
            Ok(written)
        };
        finish().map_err(|reason| WriteError::Encode { path, reason })
    }
}
