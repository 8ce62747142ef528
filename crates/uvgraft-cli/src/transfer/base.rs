//! What textures are laid over: an image, a colour, or nothing.

use std::borrow::Cow;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use anyhow::Context;
use uvgraft::{Channels, Depth, Encoding, Size, TexelFormat, Texture};
use uvgraft_io::image::{self, BandReader, ReadError};

use super::Args;
use super::treatment::Treatment;
use crate::failure::{OrBadInput, bad_input};
use crate::onto::Onto;

/// What textures are laid over.
pub(super) struct Base {
    content: Content,
    size: Size,
}

enum Content {
    /// An image that is decoded as it is laid over, once.
    File {
        reader: Mutex<Option<BandReader>>,
        known: Known,
    },
    /// An image that is used again and again.
    Image {
        texture: Texture,
        known: Known,
    },
    Color([f32; 4]),
}

/// What is known of a base image.
struct Known {
    name: String,
    format: TexelFormat,
    icc: Option<Vec<u8>>,
}

impl Base {
    /// - `onto`: an image's path, a colour, or nothing.
    /// - `again`: whether more than one texture is laid over it, or it is looked at before.
    pub(super) fn new(
        args: &Args,
        treatment: Treatment,
        onto: Option<&Onto>,
        again: bool,
    ) -> anyhow::Result<Self> {
        let Some(Onto::Image(path)) = onto else {
            let unit = match onto {
                Some(Onto::Color(unit)) => *unit,
                _ => treatment.nothing(),
            };
            return Ok(Self { content: Content::Color(unit), size: size_without_image(args)? });
        };
        let reader = BandReader::open(path).map_err(|error| not_a_base(&error, path))?;
        let format = treatment.meant(reader.spec().format());
        let name = path.display().to_string();
        let known = Known { name, format, icc: reader.icc().map(<[u8]>::to_vec) };
        let found = reader.spec().size;
        let size = args.size.unwrap_or(found);
        if !again && size == found {
            let content = Content::File { reader: Mutex::new(Some(reader)), known };
            return Ok(Self { content, size });
        }
        let (texture, failure) = reader.read_while(|_| true).or_bad_input()?;
        if let Some((_, error)) = failure {
            return Err(bad_input(error));
        }
        let texture = texture.with_encoding(format.encoding);
        let texture = match args.size {
            Some(size) => {
                texture.resized(size, treatment.filter(args), args.linear_light).or_bad_input()?
            }
            None => texture,
        };
        Ok(Self { content: Content::Image { texture, known }, size })
    }

    /// Refuses what [`Base::new`] would, as far as that shows without decoding.
    pub(super) fn check(args: &Args, onto: Option<&Onto>) -> anyhow::Result<()> {
        match onto.and_then(Onto::path) {
            // A pipe can be read only once.
            Some(path) if path.exists() && !path.is_file() => Ok(()),
            Some(path) => {
                image::read_header(path).map(drop).map_err(|error| not_a_base(&error, path))
            }
            None => size_without_image(args).map(drop),
        }
    }

    pub(super) fn size(&self) -> Size {
        self.size
    }

    /// Bytes that it keeps in memory.
    pub(super) fn bytes(&self) -> u64 {
        match &self.content {
            Content::Image { texture, .. } => bytes_of(texture.size(), texture.format()),
            Content::File { .. } | Content::Color(_) => 0,
        }
    }

    /// Its colours: an image's if it is in memory, or one texel of a colour.
    pub(super) fn colors(&self) -> anyhow::Result<Cow<'_, Texture>> {
        match &self.content {
            Content::Image { texture, .. } => Ok(Cow::Borrowed(texture)),
            Content::Color(unit) => {
                let (size, depth) = (Size::square(1), Depth::F32);
                let texel = Texture::filled(size, Channels::Rgba, Encoding::Srgb, depth, unit)?;
                Ok(Cow::Owned(texel))
            }
            Content::File { .. } => anyhow::bail!("the base is not in memory"),
        }
    }

    fn known(&self) -> Option<&Known> {
        match &self.content {
            Content::File { known, .. } | Content::Image { known, .. } => Some(known),
            Content::Color(_) => None,
        }
    }

    pub(super) fn is_image(&self) -> bool {
        self.known().is_some()
    }

    /// How an image's values are stored; a colour takes after the source.
    pub(super) fn depth(&self) -> Option<Depth> {
        self.known().map(|known| known.format.depth)
    }

    /// Whether part of a colour shows what is behind it.
    pub(super) fn is_clear_color(&self) -> bool {
        matches!(&self.content, Content::Color([.., alpha]) if *alpha < 1.0)
    }

    /// What is worth knowing about the ICC profiles of the base and of a source.
    pub(super) fn mismatch(&self, icc: Option<&[u8]>, name: &Path) -> Option<String> {
        let base = self.known()?;
        let (name, base_name) = (name.display(), &base.name);
        let found = match (icc, base.icc.as_deref()) {
            (source, base) if source == base => return None,
            (Some(_), Some(_)) => {
                format!(
                    "{name} and {base_name} have different ICC profiles; the result has that of {base_name}"
                )
            }
            (Some(_), None) => {
                format!("{name} has an ICC profile, {base_name} has none; nor has the result")
            }
            (None, _) => {
                format!(
                    "{base_name} has an ICC profile, {name} has none; the result has that of {base_name}"
                )
            }
        };
        Some(format!("{found}, and values are carried as they are"))
    }

    /// The format of the base under a source of some format, and the ICC profile of the result.
    pub(super) fn under(
        &self,
        source: TexelFormat,
        icc: Option<&[u8]>,
    ) -> (TexelFormat, Option<Vec<u8>>) {
        match &self.content {
            Content::File { known, .. } | Content::Image { known, .. } => {
                (known.format, known.icc.clone())
            }
            Content::Color([r, g, b, alpha]) => {
                let colored = source.channels.has_color() || r != g || g != b;
                let clear = source.channels.has_alpha() || *alpha < 1.0;
                let format = TexelFormat { channels: Channels::new(colored, clear), ..source };
                (format, icc.map(<[u8]>::to_vec))
            }
        }
    }

    /// Its rows, in a format that [`Base::under`] gave.
    pub(super) fn bands(&self, format: TexelFormat) -> anyhow::Result<Bands<'_>> {
        Ok(match &self.content {
            Content::File { reader, .. } => {
                let mut reader = reader.lock().unwrap_or_else(PoisonError::into_inner);
                let reader = reader.take().context("the base is read once")?;
                Bands::File { reader: Box::new(reader), encoding: format.encoding }
            }
            Content::Image { texture, .. } => Bands::Image { texture, next: 0, spare: None },
            Content::Color(unit) => Bands::Color { unit: *unit, format, size: self.size, next: 0 },
        })
    }
}

/// The rows of a base, band by band.
pub(super) enum Bands<'a> {
    File { reader: Box<BandReader>, encoding: Encoding },
    Image { texture: &'a Texture, next: u32, spare: Option<Texture> },
    Color { unit: [f32; 4], format: TexelFormat, size: Size, next: u32 },
}

impl Bands<'_> {
    /// The next rows, or as many as are left; `None` after the last.
    pub(super) fn next(&mut self, rows: u32) -> anyhow::Result<Option<Texture>> {
        let part = |next: &mut u32, height: u32| {
            let rows = *next..(*next + rows).min(height);
            *next = rows.end;
            (!rows.is_empty()).then_some(rows)
        };
        match self {
            Self::File { reader, encoding } => {
                let band = reader.next_band(rows).or_bad_input()?;
                Ok(band.map(|band| band.with_encoding(*encoding)))
            }
            Self::Image { texture, next, spare } => {
                let Some(rows) = part(next, texture.size().height) else { return Ok(None) };
                let size = Size::new(texture.size().width, rows.end - rows.start);
                let fits =
                    |band: &Texture| (band.size(), band.format()) == (size, texture.format());
                Ok(Some(match spare.take().filter(fits) {
                    Some(mut band) => {
                        band.copy_rows(texture, rows.start);
                        band
                    }
                    None => texture.rows(rows),
                }))
            }
            Self::Color { unit, format, size, next } => {
                let Some(rows) = part(next, size.height) else { return Ok(None) };
                let size = Size::new(size.width, rows.end - rows.start);
                let band = Texture::filled(size, Channels::Rgba, Encoding::Srgb, Depth::U8, unit)?;
                let band = band.encoded_as(format.encoding);
                Ok(Some(band.converted(format.channels, format.depth)))
            }
        }
    }

    /// Takes back a band that is no longer needed.
    pub(super) fn recycle(&mut self, band: Texture) {
        match self {
            Self::File { reader, .. } => reader.recycle(band),
            Self::Image { spare, .. } => *spare = Some(band),
            Self::Color { .. } => {}
        }
    }
}

fn size_without_image(args: &Args) -> anyhow::Result<Size> {
    args.size.ok_or_else(|| {
        bad_input(if args.maps.is_empty() {
            "without a base image the result needs a size: give --size N or --onto IMAGE"
        } else {
            "a map without a base image needs a size: give --size N, or --onto ROLE=IMAGE for each"
        })
    })
}

fn not_a_base(error: &ReadError, path: &Path) -> anyhow::Error {
    if path.exists() {
        bad_input(error)
    } else {
        bad_input(format!("{error}; --onto wants an image or a colour such as #808080"))
    }
}

/// Bytes of a texture in memory.
pub(super) fn bytes_of(size: Size, format: TexelFormat) -> u64 {
    let value = match format.depth {
        Depth::U8 => 1,
        Depth::U16 => 2,
        Depth::F32 => 4,
    };
    size.texels() as u64 * format.channels.count() as u64 * value
}
