//! Reads and writes images as textures: PNG, JPEG, WebP, TIFF and OpenEXR. Animations are only
//! written ([`animation`]): GIF and WebP.
//!
//! The format is detected from a file's content, never from its name. Images are turned upright
//! according to their EXIF or TIFF orientation, so written files have none. ICC profiles are passed
//! through unchanged where the format supports them; [`Written`] lists what a file does not
//! preserve. Colours of PNG and EXR in another colour space that the file declares are converted, unless
//! [`DeclaredSpace`] says otherwise.
//!
//! | | depths | channels | texture encoding | ICC | written as |
//! |---|---|---|---|---|---|
//! | PNG | 8, 16 | all | sRGB | yes | float becomes 16 bits |
//! | JPEG | 8 | grey, RGB | sRGB | yes | lossy, 4:4:4 |
//! | WebP | 8 | RGB, RGBA | sRGB | yes | lossless; grey becomes RGB |
//! | TIFF | 8, 16, float | all | sRGB, float: linear | yes | |
//! | EXR | half, float | all | linear | no | float, alpha premultiplied |
//!
//! [`BandReader`] and [`BandWriter`] do the same in bands of rows, so that the whole image need not
//! be in memory.
//!
//! Textures of another encoding are converted on writing, except for [`Encoding::Data`]. Files do
//! not record that they hold data: the caller sets this after reading, with
//! [`Texture::with_encoding`].
//!
//! With the feature `threads` (default) PNGs are compressed on the caller's rayon pool, as
//! described in [`uvgraft::threads`]; the bytes are the same without it.
//!
//! TIFF, EXR and animations are features (`tiff`, `exr`, `animation`; all default): without them their files are
//! refused as those of any unknown format are.
//!
//! [`Encoding::Data`]: uvgraft::color::Encoding::Data

#![forbid(unsafe_code)]

#[cfg(feature = "animation")]
pub mod animation;
mod band_reader;
mod band_writer;
pub mod codec;
mod color_space;
mod convert;
mod decoder_panics;
mod error;
mod exif;
#[cfg(feature = "exr")]
mod exr;
mod format;
mod header;
mod jpeg;
mod opened;
mod orientation;
mod png;
mod segments;
mod stripped;
#[cfg(feature = "tiff")]
mod tiff;
mod webp;
mod xmp;

use std::borrow::Cow;
use std::io::{BufReader, Cursor, Seek, SeekFrom, Write};
use std::path::Path;

use uvgraft::texture::{Size, Texture};

pub use self::band_reader::{BandDecoder, BandReader};
pub use self::band_writer::{BandEncoder, BandWriter, check_size};
use self::codec::{Codec, Encode, Source};
pub use self::color_space::DeclaredSpace;
pub use self::error::{EncodeError, ImageError, Loss, ReadError, WriteError};
pub use self::format::Format;
use self::header::StoredHeader;
pub use self::header::{
    Header, MAX_BYTES, MAX_ICC_BYTES, MAX_RATIO, MAX_UNBACKED_BYTES, MAX_WHOLE_TEXELS, TextureSpec,
};
pub use self::opened::{OpenImage, open};
pub use self::segments::{Segment, Segments};
pub use self::stripped::without_metadata;
use uvgraft_files::input::{self, Input};
use uvgraft_files::output::write_atomically;

/// A texture with its colour profile.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// The texels, upright.
    pub texture: Texture,
    /// The ICC profile, passed through uninterpreted.
    pub icc: Option<Vec<u8>>,
}

impl Image {
    /// Width and height.
    pub fn size(&self) -> Size {
        self.texture.size()
    }
}

impl From<Texture> for Image {
    fn from(texture: Texture) -> Self {
        Self { texture, icc: None }
    }
}

impl AsRef<Texture> for Image {
    fn as_ref(&self) -> &Texture {
        &self.texture
    }
}

/// Images can be given to a [`Graft`](uvgraft::Graft) as textures are.
impl<'t> From<&'t Image> for Cow<'t, Texture> {
    fn from(image: &'t Image) -> Self {
        Cow::Borrowed(&image.texture)
    }
}

/// As for a borrowed image; the graft may use its memory.
impl From<Image> for Cow<'_, Texture> {
    fn from(image: Image) -> Self {
        Cow::Owned(image.texture)
    }
}

/// Encoding options.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct WriteOptions {
    /// Whether to spend seconds on smaller files instead of fractions of a second: PNG, TIFF and
    /// EXR.
    pub compress: bool,
    /// Quality of a JPEG in `1..=100`; values outside are clamped, and `None` is 95.
    pub jpeg_quality: Option<u8>,
    /// Whether colours of texels with alpha 0 are light without coverage, as in an EXR that a texture
    /// was read from, and are written to EXR as they are. Otherwise they are hidden leftovers, and lost.
    pub keeps_light: bool,
}

impl WriteOptions {
    /// Sets whether files should be small rather than fast to write.
    #[must_use]
    pub const fn compress(self, compress: bool) -> Self {
        Self { compress, ..self }
    }

    /// Sets the quality of JPEGs.
    #[must_use]
    pub const fn jpeg_quality(self, jpeg_quality: u8) -> Self {
        Self { jpeg_quality: Some(jpeg_quality), ..self }
    }

    /// Sets whether colours of texels with alpha 0 are written to EXR.
    #[must_use]
    pub const fn keeps_light(self, keeps_light: bool) -> Self {
        Self { keeps_light, ..self }
    }

    /// The quality of a JPEG, or of another lossy format.
    pub fn quality(&self) -> u8 {
        self.jpeg_quality.unwrap_or(95)
    }

    /// Checks that the options that are given mean something to one of the formats.
    ///
    /// # Errors
    /// What the first option that means nothing is for: `jpeg_quality` or `compress`.
    pub fn check(&self, formats: &[Format]) -> Result<(), Unused> {
        let any = |is: fn(&Codec) -> bool| formats.iter().any(|format| is(format.codec()));
        if self.jpeg_quality.is_some() && !any(|format| format.is_lossy) {
            Err(Unused::Quality)
        } else if self.compress && !any(|format| format.compresses) {
            Err(Unused::Compress)
        } else {
            Ok(())
        }
    }
}

/// An encoding option that means nothing to any of the formats.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Unused {
    /// [`WriteOptions::jpeg_quality`] without a JPEG.
    #[error("`quality` is for {} files only", Format::names_of(|format| format.is_lossy, "and"))]
    Quality,
    /// [`WriteOptions::compress`] for JPEG and WebP files alone.
    #[error("`compress` is for {} files only", Format::names_of(|format| format.compresses, "and"))]
    Compress,
}

/// The result of writing an image.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[must_use = "losses are worth a warning"]
pub struct Written {
    /// What the file does not preserve. The lossy compression of JPEG itself is not listed.
    pub losses: Vec<Loss>,
}

/// Decodes an image in any of the formats.
///
/// Uses the first frame of an animation and the first page of a TIFF. CMYK is rejected: without its
/// profile it has no defined colour.
///
/// # Errors
/// [`ImageError`] for anything but a complete image of an acceptable size; a truncated file is
/// never accepted as complete.
pub fn decode(bytes: &[u8]) -> Result<Image, ImageError> {
    decode_with(bytes, DeclaredSpace::Honoured)
}

/// As [`decode`].
///
/// - `space`: whether colours are converted from the colour space that the file declares.
///
/// # Errors
/// As [`decode`].
pub fn decode_with(bytes: &[u8], space: DeclaredSpace) -> Result<Image, ImageError> {
    let mut bands = BandDecoder::with(bytes, space)?;
    Ok(Image { texture: bands.rest()?, icc: bands.take_icc() })
}

/// Reads and decodes an image.
///
/// # Errors
/// [`ReadError`], with the path or name, if the file cannot be read or [`decode`] rejects it.
pub fn read(input: impl Into<Input>) -> Result<Image, ReadError> {
    read_with(input, DeclaredSpace::Honoured)
}

/// As [`read`], with a choice as in [`decode_with`].
///
/// # Errors
/// As [`read`].
pub fn read_with(input: impl Into<Input>, space: DeclaredSpace) -> Result<Image, ReadError> {
    BandReader::with(input, space)?.read_whole()
}

/// Enough for an uncompressed image of the largest size, its profile and its tags.
const MAX_FILE_BYTES: u64 = MAX_BYTES + (1 << 26);

/// The properties of an image, from its header alone. [`open`] gives the texels too.
///
/// # Errors
/// [`ReadError`], with the path or name, if the file cannot be read or its header is one that
/// [`decode`] rejects.
pub fn read_header(input: impl Into<Input>) -> Result<Header, ReadError> {
    let input = input.into();
    let header = match &input {
        Input::File(path) => match input::open(path) {
            Ok((file, _)) => camera_header_of(&mut BufReader::new(file)).map(|(header, _)| header),
            Err(reason) => return Err(ReadError::Io { path: path.clone(), reason }),
        },
        Input::Bytes { bytes, .. } => decode_header(bytes),
    };
    header.map_err(|reason| ReadError::Content { path: input.name().into(), reason })
}

/// The properties of an image in memory, from its header alone.
///
/// # Errors
/// [`ImageError`] if the header is one that [`decode`] rejects.
pub fn decode_header(bytes: &[u8]) -> Result<Header, ImageError> {
    camera_header_of(&mut Cursor::new(bytes)).map(|(header, _)| header)
}

/// The focal length of a photo's camera in pixels of the upright image, by its EXIF data; `None` if
/// they don't say, or are damaged. [`open`] gives it for files, with the texels.
///
/// It is that of JPEG, PNG, WebP and TIFF files with the focal length on 35 mm film
/// (`FocalLengthIn35mmFilm`, taken to have the same diagonal field of view), or with the actual one
/// and the resolution of the sensor (`FocalLength`, `FocalPlaneXResolution`). The image may have
/// been scaled, but not cropped.
///
/// # Errors
/// As [`decode_header`].
pub fn decode_focal_length_px(bytes: &[u8]) -> Result<Option<f64>, ImageError> {
    camera_header_of(&mut Cursor::new(bytes)).map(|(_, focal_length_px)| focal_length_px)
}

/// The header, and what the camera says about its focal length, in pixels.
fn camera_header_of(reader: &mut dyn Source) -> Result<(Header, Option<f64>), ImageError> {
    let (format, stored) = stored_header_of(Format::ALL, reader)?;
    let header = stored.public(format);
    Ok((header, stored.focal.pixels(header.size)))
}

/// Reads the header from `reader`, and rejects images that are too large.
fn stored_header_of(
    formats: &[Format],
    reader: &mut dyn Source,
) -> Result<(Format, StoredHeader), ImageError> {
    /// Enough to detect any format.
    const START: usize = 12;
    let mut start = Vec::with_capacity(START);
    let io = |error| ImageError::damaged(Format::PNG, error);
    while start.len() < START {
        let available = reader.fill_buf().map_err(io)?;
        let taken = available.len().min(START - start.len());
        if taken == 0 {
            break;
        }
        start.extend_from_slice(&available[..taken]);
        reader.consume(taken);
    }
    reader.seek(SeekFrom::Start(0)).map_err(io)?;
    let format = header::detect(formats, &start)?;
    let stored = decoder_panics::refused(format, || (format.codec().header)(reader))?;
    Ok((format, stored))
}

/// Encodes an image.
///
/// # Errors
/// [`EncodeError`] if the format cannot store the texture, or `out` cannot be written.
pub fn encode(
    image: &Image,
    format: Format,
    options: &WriteOptions,
    out: &mut (impl Write + Seek),
) -> Result<Written, EncodeError> {
    let Image { texture, icc } = image;
    let (spec, icc) = (TextureSpec::from(texture), icc.as_deref());
    if let Encode::Whole(encode) = format.codec().encode {
        let icc = band_writer::check(format, &spec, icc)?;
        return Ok(Written { losses: encode(texture, icc, options, out)? });
    }
    let mut encoder = BandEncoder::new(out, format, spec, icc, options)?;
    encoder.push(texture)?;
    Ok(encoder.finish()?.0)
}

/// Encodes an image in the format of the path's extension and writes it.
///
/// # Errors
/// [`WriteError`], with the path, if the extension is missing or unknown, or encoding or writing
/// fails; an existing file is then unchanged.
pub fn write(
    image: &Image,
    path: impl AsRef<Path>,
    options: &WriteOptions,
) -> Result<Written, WriteError> {
    let path = path.as_ref();
    let format =
        Format::from_path(path).ok_or_else(|| WriteError::Extension { path: path.into() })?;
    let mut written = Written::default();
    write_atomically(path, |out| {
        written = encode(image, format, options, out)?;
        Ok(())
    })
    .map_err(|reason| WriteError::Encode { path: path.into(), reason })?;
    Ok(written)
}
