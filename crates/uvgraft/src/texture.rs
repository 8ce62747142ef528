//! Textures: their size, channels and texels, in one of three depths.

use std::ops::Range;

pub use uvgraft_surface::size::Size;

use crate::color::Encoding;

/// The size of a texture and of the base that it is transferred to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Sizes {
    /// Size of the texture that is transferred.
    pub from: Size,
    /// Size of the base that it is laid over, and of the result.
    pub to: Size,
}

/// The channels of a texel, in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Channels {
    /// One grey value.
    Grey,
    /// Grey and alpha, not premultiplied.
    GreyAlpha,
    /// Red, green and blue.
    Rgb,
    /// Red, green, blue and alpha, not premultiplied.
    Rgba,
}

impl Channels {
    /// Number of values in a texel.
    pub const fn count(self) -> usize {
        match self {
            Self::Grey => 1,
            Self::GreyAlpha => 2,
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }

    /// Whether the last channel is alpha.
    pub const fn has_alpha(self) -> bool {
        matches!(self, Self::GreyAlpha | Self::Rgba)
    }

    /// Whether there are three colour channels rather than one.
    pub const fn has_color(self) -> bool {
        matches!(self, Self::Rgb | Self::Rgba)
    }

    /// The same colour channels with alpha.
    #[must_use]
    pub const fn with_alpha(self) -> Self {
        if self.has_color() { Self::Rgba } else { Self::GreyAlpha }
    }

    /// The same colour channels without alpha.
    #[must_use]
    pub const fn without_alpha(self) -> Self {
        if self.has_color() { Self::Rgb } else { Self::Grey }
    }

    /// The smallest set that contains the channels of both.
    #[must_use]
    pub const fn union(self, other: Self) -> Self {
        let colors = if self.has_color() { self } else { other };
        if self.has_alpha() || other.has_alpha() {
            colors.with_alpha()
        } else {
            colors.without_alpha()
        }
    }
}

/// Storage type of a value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Depth {
    /// Unsigned 8-bit: `0..=255` stands for `0.0..=1.0`.
    U8,
    /// Unsigned 16-bit: `0..=65535` stands for `0.0..=1.0`.
    U16,
    /// 32-bit float, unbounded; 1.0 is white.
    F32,
}

impl Depth {
    /// Bytes of a value.
    pub const fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::F32 => 4,
        }
    }
}

/// Row-major texels, channels interleaved, in one of three depths.
#[derive(Debug, Clone, PartialEq)]
pub enum Texels {
    /// 8 bits per value.
    U8(Vec<u8>),
    /// 16 bits per value.
    U16(Vec<u16>),
    /// 32-bit float values.
    F32(Vec<f32>),
}

/// Mutable texel values of a texture, from [`Texture::texels_mut`]; their number is fixed.
#[derive(Debug, PartialEq)]
pub enum TexelsMut<'t> {
    /// 8 bits per value.
    U8(&'t mut [u8]),
    /// 16 bits per value.
    U16(&'t mut [u16]),
    /// 32-bit float values.
    F32(&'t mut [f32]),
}

impl Texels {
    /// Number of values.
    pub const fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) => values.len(),
            Self::F32(values) => values.len(),
        }
    }

    /// Whether there are no values.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A depth as a type: converts stored values to and from `0.0..=1.0`.
///
/// Sealed: implemented for `u8`, `u16` and `f32` only, because kernels are specialised for these.
pub trait Value: sealed::Sealed + Copy + Default + Send + Sync + PartialEq + 'static {
    /// The stored value of 1.0.
    const ONE: Self;
    /// The stored number as a float: `0.0..=255.0` for 8 bits.
    fn to_level(self) -> f32;
    /// Stores a number of levels; integers are rounded to nearest and clamped to their range.
    fn from_level(level: f32) -> Self;
    /// The values as bytes, if they are 8-bit.
    fn as_bytes(_: &[Self]) -> Option<&[u8]> {
        None
    }
    /// As [`Value::as_bytes`], mutable.
    fn as_bytes_mut(_: &mut [Self]) -> Option<&mut [u8]> {
        None
    }

    /// The values as `f32`, mutable, if they are 32-bit floats.
    fn as_floats_mut(_: &mut [Self]) -> Option<&mut [f32]> {
        None
    }
    /// Converts from `0.0..=1.0`; integers are rounded and clamped.
    fn from_unit(unit: f32) -> Self {
        Self::from_level(unit * Self::ONE.to_level())
    }
    /// Converts to `0.0..=1.0`.
    fn to_unit(self) -> f32 {
        self.to_level() / Self::ONE.to_level()
    }
}

mod sealed {
    /// Prevents other crates from implementing [`Value`](super::Value).
    pub trait Sealed {}

    impl Sealed for u8 {}
    impl Sealed for u16 {}
    impl Sealed for f32 {}
}

impl Value for u8 {
    const ONE: Self = 255;

    fn to_level(self) -> f32 {
        f32::from(self)
    }
    fn from_level(level: f32) -> Self {
        truncate(level + 0.5, Self::ONE.to_level()) as Self
    }
    fn as_bytes(values: &[Self]) -> Option<&[u8]> {
        Some(values)
    }
    fn as_bytes_mut(values: &mut [Self]) -> Option<&mut [u8]> {
        Some(values)
    }
}

/// Clamps to `0.0..=max` and truncates; NaN becomes 0. A cast does the same, but compilers do not
/// vectorise it because of the cases it has to handle; they do vectorise this.
///
/// - `max`: less than 2²³.
#[inline(always)]
fn truncate(value: f32, max: f32) -> u32 {
    /// 2²³: from here on floats have no fraction, and the low bits of their mantissa are the
    /// integer.
    const NO_FRACTION: f32 = 8_388_608.0;
    let value = if value > 0.0 { value } else { 0.0 };
    let value = if value < max { value } else { max };
    let rounded = value + NO_FRACTION;
    let up = u32::from(rounded - NO_FRACTION > value);
    rounded.to_bits() - NO_FRACTION.to_bits() - up
}

impl Value for u16 {
    const ONE: Self = 65_535;
    fn to_level(self) -> f32 {
        f32::from(self)
    }
    fn from_level(level: f32) -> Self {
        truncate(level + 0.5, Self::ONE.to_level()) as Self
    }
}

impl Value for f32 {
    const ONE: Self = 1.0;
    fn to_level(self) -> f32 {
        self
    }
    fn from_level(level: f32) -> Self {
        level
    }

    fn as_floats_mut(values: &mut [Self]) -> Option<&mut [f32]> {
        Some(values)
    }
}

/// Why a texture could not be made.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TextureError {
    /// Width or height is zero.
    #[error("a texture must have at least one texel, got {0}")]
    Empty(Size),
    /// The length of the buffer does not match the size.
    #[error("a {size} texture with {channels} channels must have {wanted} values, got {found}")]
    Length {
        /// Values in the buffer.
        found: usize,
        /// Values that the size requires.
        wanted: usize,
        /// The size that was given.
        size: Size,
        /// Channels per texel.
        channels: usize,
    },
    /// A side is too long.
    #[error("a texture must have at most {max} texels a side, got {0}", max = Texture::MAX_SIDE)]
    TooLarge(Size),
    /// Memory could not be allocated.
    #[error("not enough memory for a texture of {0}")]
    Memory(Size),
}

/// How the values of a texture are stored, and how they are encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct TexelFormat {
    /// Channels of a texel.
    pub channels: Channels,
    /// Storage type of a value.
    pub depth: Depth,
    /// Encoding of the values.
    pub encoding: Encoding,
}

/// An image in a UV layout: decoded texels, without the format and colour profile of a file. Row 0 is at
/// the top; texel `(i, j)` covers `[i, i+1) × [j, j+1)` and has its centre at `(i + 0.5, j + 0.5)`.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    size: Size,
    channels: Channels,
    encoding: Encoding,
    texels: Texels,
}

impl Texture {
    /// Maximum length of a side.
    pub const MAX_SIDE: u32 = Size::MAX_SIDE;

    /// Makes a texture of `size.texels() * channels.count()` values.
    ///
    /// # Errors
    /// [`TextureError`] if the size is empty or too large, or if the buffer has another length.
    pub fn new(
        size: Size,
        channels: Channels,
        encoding: Encoding,
        texels: Texels,
    ) -> Result<Self, TextureError> {
        if size.texels() == 0 {
            return Err(TextureError::Empty(size));
        }
        if size.width.max(size.height) > Self::MAX_SIDE {
            return Err(TextureError::TooLarge(size));
        }
        let Some(wanted) = size.texels().checked_mul(channels.count()) else {
            return Err(TextureError::Memory(size));
        };
        if texels.len() != wanted {
            let channels = channels.count();
            return Err(TextureError::Length { found: texels.len(), wanted, size, channels });
        }
        Ok(Self { size, channels, encoding, texels })
    }

    /// A texture of one colour: `unit` has one value for each of `channels`, 1.0 for white.
    ///
    /// # Errors
    /// [`TextureError`] as [`Texture::new`].
    pub fn filled(
        size: Size,
        channels: Channels,
        encoding: Encoding,
        depth: Depth,
        unit: &[f32],
    ) -> Result<Self, TextureError> {
        fn fill<T: Value>(size: Size, unit: &[f32]) -> Result<Vec<T>, TextureError> {
            let texel: Vec<T> = unit.iter().map(|&value| T::from_unit(value)).collect();
            let mut values = Vec::new();
            let count = size.texels().saturating_mul(texel.len());
            values.try_reserve_exact(count).map_err(|_| TextureError::Memory(size))?;
            values.extend_from_slice(&texel[..texel.len().min(count)]);
            while values.len() < count {
                // Doubling copies whole blocks; a repeating iterator would go value by value.
                values.extend_from_within(..values.len().min(count - values.len()));
            }
            Ok(values)
        }
        if size.width.max(size.height) > Self::MAX_SIDE {
            return Err(TextureError::TooLarge(size));
        }
        let texels = match depth {
            Depth::U8 => Texels::U8(fill(size, unit)?),
            Depth::U16 => Texels::U16(fill(size, unit)?),
            Depth::F32 => Texels::F32(fill(size, unit)?),
        };
        Self::new(size, channels, encoding, texels)
    }

    /// Width and height.
    pub const fn size(&self) -> Size {
        self.size
    }

    /// Channels of a texel.
    pub const fn channels(&self) -> Channels {
        self.channels
    }

    /// Encoding of the values.
    pub const fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Storage type of a value.
    pub const fn depth(&self) -> Depth {
        match self.texels {
            Texels::U8(_) => Depth::U8,
            Texels::U16(_) => Depth::U16,
            Texels::F32(_) => Depth::F32,
        }
    }

    /// Channels, depth and encoding.
    pub const fn format(&self) -> TexelFormat {
        TexelFormat { channels: self.channels, depth: self.depth(), encoding: self.encoding }
    }

    /// The texel values.
    pub const fn texels(&self) -> &Texels {
        &self.texels
    }

    /// The texel values, mutable.
    pub fn texels_mut(&mut self) -> TexelsMut<'_> {
        match &mut self.texels {
            Texels::U8(values) => TexelsMut::U8(values),
            Texels::U16(values) => TexelsMut::U16(values),
            Texels::F32(values) => TexelsMut::F32(values),
        }
    }

    /// Extracts the texel values.
    pub fn into_texels(self) -> Texels {
        self.texels
    }

    /// A copy of a range of rows.
    ///
    /// # Panics
    /// If the range is empty or beyond the last row.
    #[must_use]
    pub fn rows(&self, rows: Range<u32>) -> Self {
        assert!(rows.start < rows.end && rows.end <= self.size.height, "rows {rows:?}");
        let values = self.size.width as usize * self.channels.count();
        let part = rows.start as usize * values..rows.end as usize * values;
        let texels = match &self.texels {
            Texels::U8(values) => Texels::U8(values[part].to_vec()),
            Texels::U16(values) => Texels::U16(values[part].to_vec()),
            Texels::F32(values) => Texels::F32(values[part].to_vec()),
        };
        let size = Size::new(self.size.width, rows.end - rows.start);
        Self { size, texels, ..*self }
    }

    /// Overwrites all rows with those of another texture, starting at its row `first_row`.
    ///
    /// # Panics
    /// If the other has another width or format, or not enough rows.
    pub fn copy_rows(&mut self, other: &Self, first_row: u32) {
        assert_eq!((self.size.width, self.format()), (other.size.width, other.format()));
        let values = self.size.width as usize * self.channels.count();
        let start = first_row as usize * values;
        let part = start..start + self.texels.len();
        match (&mut self.texels, &other.texels) {
            (Texels::U8(to), Texels::U8(from)) => to.copy_from_slice(&from[part]),
            (Texels::U16(to), Texels::U16(from)) => to.copy_from_slice(&from[part]),
            (Texels::F32(to), Texels::F32(from)) => to.copy_from_slice(&from[part]),
            _ => unreachable!("formats were found to be the same"),
        }
    }

    /// Overwrites rows from `first_row` on with those of another texture.
    ///
    /// # Panics
    /// If the other has another width or format, or too many rows.
    pub(crate) fn replace_rows(&mut self, first_row: u32, other: &Self) {
        assert_eq!((self.size.width, self.format()), (other.size.width, other.format()));
        let start = first_row as usize * self.size.width as usize * self.channels.count();
        let part = start..start + other.texels.len();
        match (&mut self.texels, &other.texels) {
            (Texels::U8(to), Texels::U8(from)) => to[part].copy_from_slice(from),
            (Texels::U16(to), Texels::U16(from)) => to[part].copy_from_slice(from),
            (Texels::F32(to), Texels::F32(from)) => to[part].copy_from_slice(from),
            _ => unreachable!("formats were found to be the same"),
        }
    }

    /// Reinterprets the same values in another encoding.
    #[must_use]
    pub const fn with_encoding(mut self, encoding: Encoding) -> Self {
        self.encoding = encoding;
        self
    }

    /// Whether the last channel is 1 in all of the given texels of a row.
    pub(crate) fn is_opaque(&self, row: u32, columns: Range<u32>) -> bool {
        fn is_one<T: Value>(values: &[T], channels: usize) -> bool {
            values.chunks_exact(channels).all(|texel| texel[channels - 1] == T::ONE)
        }
        let channels = self.channels.count();
        let first = row as usize * self.size.width as usize;
        let [start, end] =
            [columns.start, columns.end].map(|column| (first + column as usize) * channels);
        match &self.texels {
            Texels::U8(values) => is_one(&values[start..end], channels),
            Texels::U16(values) => is_one(&values[start..end], channels),
            Texels::F32(values) => is_one(&values[start..end], channels),
        }
    }

    /// One channel of one texel, 1.0 for white. For tests and small loops.
    pub fn get(&self, x: u32, y: u32, channel: usize) -> f32 {
        let index =
            (y as usize * self.size.width as usize + x as usize) * self.channels.count() + channel;
        match &self.texels {
            Texels::U8(values) => values[index].to_unit(),
            Texels::U16(values) => values[index].to_unit(),
            Texels::F32(values) => values[index],
        }
    }
}
