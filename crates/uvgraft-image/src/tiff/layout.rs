//! What the tags of a TIFF say about its samples, and which of them make a texture.

use std::io::{Read, Seek};

use uvgraft::texture::{Channels, Depth, Texture};

use super::chunks::Grid;
use super::compression::Compression;
use super::directory::{ByteOrder, Directory};
use super::tags::{self, extra, photometric, predictor, sample_format};
use super::ycbcr::YCbCr;
use super::{FORMAT, damaged, unsupported};
use crate::ImageError;
use crate::header::{StoredHeader, check_size};
use crate::orientation::Orientation;

/// Samples of a texel, of which at most 4 are used. Bounds the memory of a row.
const MAX_SAMPLES: u16 = 64;

const TO_DEPTH: &str = "save it with 8 or 16 bits or as float, for example by \
                        `magick IN.tif -depth 16 OUT.tif`";
const TO_RGB: &str = "convert it to greyscale or RGB, for example by \
                      `magick IN.tif -colorspace sRGB OUT.tif`";
const TO_PLAIN_SAMPLES: &str = "save it as greyscale or RGB with or without alpha and nothing else";

/// How an image is stored.
pub(super) struct Layout {
    pub(super) header: StoredHeader,
    pub(super) samples: Samples,
    pub(super) color: Color,
    /// For each channel of the texture but those of a palette, its place among the samples.
    pub(super) sources: Vec<usize>,
    pub(super) is_premultiplied: bool,
    pub(super) compression: Compression,
    /// Whether the first bit of each byte in the file is the lowest one.
    pub(super) is_reversed: bool,
    pub(super) predictor: Predictor,
    pub(super) grid: Grid,
}

/// How numbers are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples {
    /// 1, 2, 4, 8 or 16; as floats 16, 32 or 64. Below 8 they are packed, with rows starting at a byte.
    pub(super) bits: u16,
    pub(super) is_float: bool,
    /// Samples of a texel, those without a meaning included.
    pub(super) count: usize,
    /// Whether each strip or tile has one sample of each texel.
    pub(super) is_planar: bool,
    pub(super) order: ByteOrder,
}

/// What samples mean.
#[derive(Debug)]
pub(super) enum Color {
    /// Channels of the texture.
    Direct,
    /// Grey, where 0 is white.
    Inverted,
    /// Indices of colours, and maybe alpha.
    Palette(Vec<[u8; 3]>),
    /// Luma and colour differences.
    YCbCr(YCbCr),
}

/// What is stored instead of samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Predictor {
    /// The samples.
    None,
    /// Differences to the texel before.
    Horizontal,
    /// Differences of the bytes of a row, most significant bytes first.
    Float,
}

impl Samples {
    /// Samples of a texel in a strip or tile.
    pub(super) fn in_chunk(&self) -> usize {
        if self.is_planar { 1 } else { self.count }
    }

    /// Bytes of a row of a strip or tile.
    pub(super) fn row_bytes(&self, width: u32) -> usize {
        (width as usize * self.in_chunk() * usize::from(self.bits)).div_ceil(8)
    }
}

impl Layout {
    /// Reads the tags that say what the values are, but not where they are.
    ///
    /// # Errors
    /// [`ImageError::Unsupported`], with what to do, for all that makes no texture; others for damage.
    pub(super) fn read<R: Read + Seek>(directory: &mut Directory<R>) -> Result<Self, ImageError> {
        let [width, height] =
            [tags::IMAGE_WIDTH, tags::IMAGE_LENGTH].map(|tag| required(directory, tag));
        let (width, height) = (width?, height?);
        let interpretation = required(directory, tags::PHOTOMETRIC_INTERPRETATION)?;
        let colors = colors_of(interpretation)?;
        let mut samples = samples(directory)?;
        let alpha = alpha(directory, &samples, colors)?;
        let is_palette = interpretation == u64::from(photometric::PALETTE);
        let depth = depth(&samples, is_palette)?;
        let channels = match (is_palette || colors == 3, alpha.is_some()) {
            (false, false) => Channels::Grey,
            (false, true) => Channels::GreyAlpha,
            (true, false) => Channels::Rgb,
            (true, true) => Channels::Rgba,
        };
        let size = check_size(FORMAT, (width, height), channels, depth)?;
        let mut header = StoredHeader::new(size, channels, depth);
        let orientation = directory.number(tags::ORIENTATION)?.unwrap_or(1);
        header.orientation = Orientation::from_tag(orientation);
        // Strips and tiles as stored, until their rows are put together.
        header.scratch_bytes = header.bytes();

        let is_premultiplied = alpha.is_some_and(|alpha| alpha.is_premultiplied);
        let color = color(directory, interpretation, &samples)?;
        if is_premultiplied && !matches!(color, Color::Direct) {
            let found = "premultiplied alpha without RGB or grey that grows with brightness";
            return Err(unsupported(found, TO_RGB));
        }
        let compression = Compression::read(directory, &samples, &color)?;
        // Decoders of JPEG give RGB.
        let color = if compression.is_jpeg() && matches!(color, Color::YCbCr(_)) {
            Color::Direct
        } else {
            color
        };
        let predictor = predictor(directory, &samples, &color, &compression)?;
        if samples.count == 1 {
            samples.is_planar = false;
        }
        let grid = Grid::read(directory, size, &samples)?;
        if grid.width > Texture::MAX_SIDE || grid.height > Texture::MAX_SIDE {
            let found = format!("tiles of {}×{} texels", grid.width, grid.height);
            return Err(unsupported(found, "save it in strips or smaller tiles"));
        }
        let is_reversed = match directory.number(tags::FILL_ORDER)?.unwrap_or(1) {
            1 => false,
            2 => true,
            other => return Err(damaged(format!("FillOrder must be 1 or 2, got {other}"))),
        };
        let sources = (0..colors).chain(alpha.map(|alpha| alpha.sample)).collect();
        Ok(Self {
            header,
            samples,
            color,
            sources,
            is_premultiplied,
            compression,
            is_reversed,
            predictor,
            grid,
        })
    }
}

fn required<R: Read + Seek>(directory: &mut Directory<R>, tag: u16) -> Result<u64, ImageError> {
    directory.number(tag)?.ok_or_else(|| damaged(format!("tag {tag} is missing")))
}

/// Samples of a colour: 1 or 3.
fn colors_of(interpretation: u64) -> Result<usize, ImageError> {
    let found = match interpretation {
        0 | 1 | 3 => return Ok(1),
        2 | 6 => return Ok(3),
        4 => "a transparency mask",
        5 => "CMYK colours",
        8 => "CIELab colours",
        9 => "ICCLab colours",
        10 => "ITULab colours",
        32_803 => "a raw photo (colour filter array)",
        34_892 => "a raw photo (linear)",
        32_844 | 32_845 => "SGI LogLuv colours",
        other => return Err(unsupported(format!("colours of kind {other}"), TO_RGB)),
    };
    Err(unsupported(found, TO_RGB))
}

fn samples<R: Read + Seek>(directory: &mut Directory<R>) -> Result<Samples, ImageError> {
    let count = directory.short(tags::SAMPLES_PER_PIXEL)?.unwrap_or(1);
    if count == 0 {
        return Err(damaged("texels have no samples"));
    }
    if count > MAX_SAMPLES {
        return Err(unsupported(format!("{count} samples a texel"), TO_PLAIN_SAMPLES));
    }
    // A single number holds for all samples.
    let alike = |numbers: Option<Vec<u16>>, default: u16, what: &str| match numbers {
        None => Ok(default),
        Some(numbers) if numbers.iter().all(|&number| number == numbers[0]) => Ok(numbers[0]),
        Some(numbers) => Err(unsupported(format!("{what} {numbers:?}"), TO_DEPTH)),
    };
    let bits = alike(directory.shorts(tags::BITS_PER_SAMPLE)?, 1, "samples of bits")?;
    let formats = directory.shorts(tags::SAMPLE_FORMAT)?;
    let format = alike(formats, sample_format::UNSIGNED, "samples of formats")?;
    let is_float = match format {
        sample_format::UNSIGNED | sample_format::VOID => false,
        sample_format::FLOAT => true,
        sample_format::SIGNED => {
            return Err(unsupported(format!("{bits}-bit signed integers"), TO_DEPTH));
        }
        5 | 6 => return Err(unsupported("complex numbers", TO_DEPTH)),
        other => return Err(unsupported(format!("samples of format {other}"), TO_DEPTH)),
    };
    let is_planar = match directory.number(tags::PLANAR_CONFIGURATION)?.unwrap_or(1) {
        1 => false,
        2 => true,
        other => return Err(damaged(format!("PlanarConfiguration must be 1 or 2, got {other}"))),
    };
    let order = directory.order();
    Ok(Samples { bits, is_float, count: count.into(), is_planar, order })
}

/// The depth of the texture.
fn depth(samples: &Samples, is_palette: bool) -> Result<Depth, ImageError> {
    match (samples.bits, samples.is_float) {
        (1 | 2 | 4 | 8 | 16, false) if is_palette => Ok(Depth::U8),
        (1 | 2 | 4 | 8, false) => Ok(Depth::U8),
        (16, false) => Ok(Depth::U16),
        (16 | 32 | 64, true) if !is_palette => Ok(Depth::F32),
        // 32 bits hold counts and identifiers as often as colours: their range is anyone's guess.
        (bits, false) => Err(unsupported(format!("{bits}-bit integers"), TO_DEPTH)),
        (bits, true) => Err(unsupported(format!("{bits}-bit floats"), TO_DEPTH)),
    }
}

#[derive(Debug, Clone, Copy)]
struct Alpha {
    /// Its place among the samples.
    sample: usize,
    is_premultiplied: bool,
}

/// The alpha channel among the samples beyond the colour, whose number is `colors`.
///
/// A single sample whose meaning is not stated is alpha: programs of old omit the tag. Samples that
/// are said to mean nothing are left out beside RGB. Beside grey they are refused, as the rest of
/// bands that aren't a picture.
fn alpha<R: Read + Seek>(
    directory: &mut Directory<R>,
    samples: &Samples,
    colors: usize,
) -> Result<Option<Alpha>, ImageError> {
    let count = samples.count;
    let Some(beyond) = count.checked_sub(colors) else {
        return Err(damaged(format!("a colour must have {colors} samples, got {count}")));
    };
    let kinds = directory.shorts(tags::EXTRA_SAMPLES)?.unwrap_or_default();
    if beyond == 0 {
        return Ok(None);
    }
    if kinds.is_empty() && beyond == 1 {
        return Ok(Some(Alpha { sample: colors, is_premultiplied: false }));
    }
    let is_alpha = |kind: &u16| [extra::ALPHA, extra::PREMULTIPLIED_ALPHA].contains(kind);
    let alpha = kinds.iter().take(beyond).position(is_alpha);
    if alpha.is_none() && (colors == 1 || kinds.is_empty()) {
        let found =
            format!("{count} samples a texel, without a meaning from number {} on", colors + 1);
        return Err(unsupported(found, TO_PLAIN_SAMPLES));
    }
    Ok(alpha.map(|at| Alpha {
        sample: colors + at,
        is_premultiplied: kinds[at] == extra::PREMULTIPLIED_ALPHA,
    }))
}

fn color<R: Read + Seek>(
    directory: &mut Directory<R>,
    interpretation: u64,
    samples: &Samples,
) -> Result<Color, ImageError> {
    Ok(match u16::try_from(interpretation) {
        Ok(photometric::WHITE_IS_ZERO) => Color::Inverted,
        Ok(photometric::PALETTE) => Color::Palette(palette(directory, samples.bits)?),
        Ok(photometric::YCBCR) => {
            if samples.bits != 8 || samples.is_planar || samples.count != 3 {
                let found = "YCbCr colours that are not 3 samples of 8 bits side by side";
                return Err(unsupported(found, TO_RGB));
            }
            Color::YCbCr(YCbCr::read(directory)?)
        }
        _ => Color::Direct,
    })
}

/// The colours of a palette, which are stored as 16-bit numbers: all reds, greens and blues.
///
/// Their upper bytes are the colours, whether a program fills the lower ones with the same, as it should, or
/// with 0. Some programs store 8-bit numbers, which shows by none being larger.
fn palette<R: Read + Seek>(
    directory: &mut Directory<R>,
    bits: u16,
) -> Result<Vec<[u8; 3]>, ImageError> {
    let numbers = directory.shorts(tags::COLOR_MAP)?.unwrap_or_default();
    let colors = 1 << bits;
    if numbers.len() != 3 * colors {
        let (wanted, found) = (3 * colors, numbers.len());
        return Err(damaged(format!("a palette must have {wanted} numbers, got {found}")));
    }
    let shift = if numbers.iter().all(|&number| number <= u8::MAX.into()) { 0 } else { 8 };
    let level = |index: usize| (numbers[index] >> shift) as u8;
    Ok((0..colors).map(|index| [0, 1, 2].map(|channel| level(channel * colors + index))).collect())
}

fn predictor<R: Read + Seek>(
    directory: &mut Directory<R>,
    samples: &Samples,
    color: &Color,
    compression: &Compression,
) -> Result<Predictor, ImageError> {
    let stated = directory.short(tags::PREDICTOR)?.unwrap_or(predictor::NONE);
    // Part of LZW and Deflate. libtiff, by which most programs write, ignores it otherwise.
    if !matches!(compression, Compression::Lzw | Compression::Deflate) {
        return Ok(Predictor::None);
    }
    let is_plain = !matches!(color, Color::YCbCr(_));
    match stated {
        predictor::NONE => Ok(Predictor::None),
        predictor::HORIZONTAL if samples.bits >= 8 && is_plain => Ok(Predictor::Horizontal),
        predictor::FLOAT if samples.is_float => Ok(Predictor::Float),
        predictor::HORIZONTAL | predictor::FLOAT => {
            let wanted =
                "save it without a predictor, for example by `tiffcp -c zip:1 IN.tif OUT.tif`";
            Err(unsupported(format!("predictor {stated} with these samples"), wanted))
        }
        other => Err(damaged(format!("Predictor must be 1, 2 or 3, got {other}"))),
    }
}
