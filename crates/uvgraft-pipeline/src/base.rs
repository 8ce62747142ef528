//! Base textures: an image, a colour, or nothing.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use uvgraft::{Averaging, Depth, Encoding, Filter, Size, TexelFormat, Texture};
use uvgraft_files::input::Input;
use uvgraft_image::{self as image, BandReader, Header, ReadError};

use crate::base_color;
use crate::base_source::BaseSource;
use crate::failure::{Blame, Failure, Result};
use crate::material::Values;

/// Options for loading a base.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BaseOptions<'a> {
    /// An image, a colour, or nothing.
    pub(crate) onto: Option<&'a BaseSource>,
    /// Size to resize an image to.
    pub(crate) size: Option<Size>,
    pub(crate) values: Values,
    pub(crate) filter: Filter,
    pub(crate) averaging: Averaging,
    /// Whether it is the base of a material map.
    pub(crate) is_material: bool,
}

impl BaseOptions<'_> {
    /// Checks what [`Base::new`] requires, as far as possible without decoding.
    pub(crate) fn check(&self) -> Result<()> {
        match self.onto.and_then(BaseSource::as_image) {
            // A pipe can be read only once.
            Some(Input::File(path)) if path.exists() && !path.is_file() => Ok(()),
            Some(image) => {
                image::read_header(image).map(drop).map_err(|error| not_a_base(&error, image))
            }
            None => self.size_without_image().map(drop),
        }
    }

    /// The header of an image, if it is readable and may be read twice, which a pipe may not.
    pub(crate) fn header(&self) -> Option<Header> {
        let image = self.onto.and_then(BaseSource::as_image)?;
        let is_lasting = image.path().is_none_or(Path::is_file);
        is_lasting.then(|| image::read_header(image).ok()).flatten()
    }

    fn size_without_image(&self) -> Result<Size> {
        self.size.ok_or_else(|| {
            Failure::option(if self.is_material {
                "a map without a base image must have a size: add `size` N, or `onto` ROLE=IMAGE \
                 for each map"
            } else {
                "without a base image the result must have a size: use `size` N or `onto` IMAGE"
            })
        })
    }
}

/// A base texture that sources are composited onto.
pub(crate) struct Base {
    content: Content,
    size: Size,
    /// NaN and infinite texels of its rows that were decoded so far.
    non_finite: AtomicUsize,
}

enum Content {
    /// An image decoded while it is composited, once.
    File {
        reader: Mutex<Option<BandReader>>,
        known: ImageInfo,
    },
    /// A decoded image that is reused.
    Image {
        texture: Texture,
        known: ImageInfo,
    },
    Color([f32; 4]),
}

/// Metadata of a base image.
struct ImageInfo {
    name: String,
    format: TexelFormat,
    icc: Option<Vec<u8>>,
    /// Whether colours of its texels with alpha 0 are light.
    holds_light: bool,
}

impl Base {
    /// - `is_kept`: whether to keep an image in memory, because several textures are composited
    ///   onto it, or because its colours are analysed first.
    pub(crate) fn new(options: &BaseOptions<'_>, is_kept: bool) -> Result<Self> {
        let BaseOptions { onto, size: wanted, values, filter, averaging, .. } = *options;
        let Some(BaseSource::Image(image)) = onto else {
            let unit = match onto {
                Some(BaseSource::Color(unit)) => *unit,
                _ => values.default_base(),
            };
            return Ok(Self::of(Content::Color(unit), options.size_without_image()?, 0));
        };
        let reader = BandReader::with(image, values.space());
        let reader = reader.map_err(|error| not_a_base(&error, image))?;
        let format = values.reinterpret(reader.spec().format());
        let name = image.to_string();
        let icc = reader.icc().map(<[u8]>::to_vec);
        let holds_light = reader.header().format.codec().is_premultiplied;
        let known = ImageInfo { name, format, icc, holds_light };
        let found = reader.spec().size;
        let size = wanted.unwrap_or(found);
        if !is_kept && size == found {
            let content = Content::File { reader: Mutex::new(Some(reader)), known };
            return Ok(Self::of(content, size, 0));
        }
        let (texture, failure) = reader.read_while(|_| true).or_input()?;
        if let Some((_, error)) = failure {
            return Err(Failure::input(error));
        }
        let texture = texture.with_encoding(format.encoding);
        let non_finite = texture.non_finite();
        let texture = match wanted {
            Some(size) => texture.resized(size, filter, averaging).or_input()?,
            None => texture,
        };
        Ok(Self::of(Content::Image { texture, known }, size, non_finite))
    }

    fn of(content: Content, size: Size, non_finite: usize) -> Self {
        Self { content, size, non_finite: non_finite.into() }
    }

    /// Whether colours of texels with alpha 0 are light without coverage, as in EXR.
    pub(crate) fn holds_light(&self) -> bool {
        match &self.content {
            Content::File { known, .. } | Content::Image { known, .. } => known.holds_light,
            Content::Color(_) => false,
        }
    }

    /// A warning if there were NaN or infinite texels among the rows that were decoded so far.
    pub(crate) fn non_finite(&self) -> Option<String> {
        let texels = match self.non_finite.load(Ordering::Relaxed) {
            0 => return None,
            1 => "1 texel is".to_owned(),
            count => format!("{count} texels are"),
        };
        let name = &self.known()?.name;
        Some(format!("{name}: {texels} NaN or infinite, also in the result where the base shows"))
    }

    pub(crate) fn size(&self) -> Size {
        self.size
    }

    /// Bytes that it occupies in memory.
    pub(crate) fn bytes(&self) -> u64 {
        match &self.content {
            Content::Image { texture, .. } => bytes_of(texture.size(), texture.format()),
            Content::File { .. } | Content::Color(_) => 0,
        }
    }

    /// Its colours: the decoded image, or a single texel of a colour.
    pub(crate) fn colors(&self) -> Result<Cow<'_, Texture>> {
        match &self.content {
            Content::Image { texture, .. } => Ok(Cow::Borrowed(texture)),
            Content::Color(unit) => Ok(Cow::Owned(base_color::texel(*unit).or_work()?)),
            Content::File { .. } => Err(Failure::work("the base is not in memory")),
        }
    }

    /// The decoded image, if it is one that is kept.
    pub(crate) fn image(&self) -> Option<&Texture> {
        match &self.content {
            Content::Image { texture, .. } => Some(texture),
            Content::File { .. } | Content::Color(_) => None,
        }
    }

    /// What messages call an image.
    pub(crate) fn name(&self) -> Option<&str> {
        self.known().map(|known| &*known.name)
    }

    fn known(&self) -> Option<&ImageInfo> {
        match &self.content {
            Content::File { known, .. } | Content::Image { known, .. } => Some(known),
            Content::Color(_) => None,
        }
    }

    pub(crate) fn is_image(&self) -> bool {
        self.known().is_some()
    }

    /// Storage type of an image's values; `None` for a colour, which adopts the format of the
    /// source.
    pub(crate) fn depth(&self) -> Option<Depth> {
        self.known().map(|known| known.format.depth)
    }

    /// Whether it is a colour that is partly transparent.
    pub(crate) fn is_clear_color(&self) -> bool {
        matches!(&self.content, Content::Color([.., alpha]) if *alpha < 1.0)
    }

    /// A warning about differing ICC profiles of the base and a source.
    pub(crate) fn mismatch(&self, icc: Option<&[u8]>, name: &Path) -> Option<String> {
        let base = self.known()?;
        let (name, base_name) = (name.display(), &base.name);
        let found = match (icc, base.icc.as_deref()) {
            (source, base) if source == base => return None,
            (Some(_), Some(_)) => {
                format!(
                    "{name} and {base_name} have different ICC profiles; the result gets that of \
                     {base_name}"
                )
            }
            (Some(_), None) => {
                format!("{name} has an ICC profile but {base_name} has none; the result gets none")
            }
            (None, _) => {
                format!(
                    "{base_name} has an ICC profile but {name} has none; the result gets that of \
                     {base_name}"
                )
            }
        };
        Some(format!("{found}; values are not converted"))
    }

    /// The format of the base for a source of the given format, and the ICC profile of the result.
    pub(crate) fn under(
        &self,
        source: TexelFormat,
        icc: Option<&[u8]>,
    ) -> (TexelFormat, Option<Vec<u8>>) {
        match &self.content {
            Content::File { known, .. } | Content::Image { known, .. } => {
                (known.format, known.icc.clone())
            }
            Content::Color(unit) => {
                (base_color::format_under(*unit, source), icc.map(<[u8]>::to_vec))
            }
        }
    }

    /// Its rows, in a format returned by [`Base::under`].
    pub(crate) fn bands(&self, format: TexelFormat) -> Result<Bands<'_>> {
        Ok(match &self.content {
            Content::File { reader, .. } => {
                let mut reader = reader.lock().unwrap_or_else(PoisonError::into_inner);
                let reader = reader.take().ok_or_else(|| Failure::work("the base is read once"))?;
                let encoding = format.encoding;
                Bands::File { reader: Box::new(reader), encoding, non_finite: &self.non_finite }
            }
            Content::Image { .. } | Content::Color(_) => {
                Bands::Memory { base: self, format, next: 0, spare: None }
            }
        })
    }

    /// Whether its rows are at hand in any order and any number of times: [`Base::rows`].
    pub(crate) fn is_in_memory(&self) -> bool {
        !matches!(self.content, Content::File { .. })
    }

    /// Bytes of a row, in a format returned by [`Base::under`].
    pub(crate) fn row_bytes(&self, format: TexelFormat) -> usize {
        bytes_of(Size::new(self.size.width, 1), format) as usize
    }

    /// Some of its rows, in a format returned by [`Base::under`], unless it is decoded while it is
    /// composited.
    ///
    /// - `spare`: a band to reuse.
    pub(crate) fn rows(
        &self,
        rows: Range<u32>,
        format: TexelFormat,
        spare: Option<Texture>,
    ) -> Result<Texture> {
        let size = Size::new(self.size.width, rows.end - rows.start);
        match &self.content {
            Content::File { .. } => Err(Failure::work("the base is not in memory")),
            Content::Image { texture, .. } => {
                let fits =
                    |band: &Texture| (band.size(), band.format()) == (size, texture.format());
                Ok(match spare.filter(fits) {
                    Some(mut band) => {
                        band.copy_rows(texture, rows.start);
                        band
                    }
                    None => texture.rows(rows),
                })
            }
            Content::Color(unit) => base_color::filled(*unit, size, format).or_work(),
        }
    }
}

/// The rows of a base, band by band.
pub(crate) enum Bands<'a> {
    File { reader: Box<BandReader>, encoding: Encoding, non_finite: &'a AtomicUsize },
    Memory { base: &'a Base, format: TexelFormat, next: u32, spare: Option<Texture> },
}

impl Bands<'_> {
    /// The next rows, or as many as are left; `None` after the last.
    pub(crate) fn next(&mut self, rows: u32) -> Result<Option<Texture>> {
        match self {
            Self::File { reader, encoding, non_finite } => {
                let band = reader.next_band(rows).or_input()?;
                let count = band.as_ref().map_or(0, Texture::non_finite);
                non_finite.fetch_add(count, Ordering::Relaxed);
                Ok(band.map(|band| band.with_encoding(*encoding)))
            }
            Self::Memory { base, format, next, spare } => {
                let rows = *next..(*next + rows).min(base.size.height);
                *next = rows.end;
                let band = (!rows.is_empty()).then(|| base.rows(rows, *format, spare.take()));
                band.transpose()
            }
        }
    }

    /// Returns a band for reuse.
    pub(crate) fn recycle(&mut self, band: Texture) {
        match self {
            Self::File { reader, .. } => reader.recycle(band),
            Self::Memory { spare, .. } => *spare = Some(band),
        }
    }
}

fn not_a_base(error: &ReadError, image: &Input) -> Failure {
    if image.path().is_none_or(Path::exists) {
        Failure::input(error)
    } else {
        // Of a file that is not there, with no names in it.
        Failure::option(format!("{error}; `onto` must be an image or a colour such as #808080"))
    }
}

/// Bytes of a texture in memory.
pub(crate) fn bytes_of(size: Size, format: TexelFormat) -> u64 {
    size.texels() as u64 * (format.channels.count() * format.depth.bytes()) as u64
}
