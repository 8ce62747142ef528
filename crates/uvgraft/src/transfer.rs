//! A texture from one layout onto a base in another: map, padding, formats and filtering together.

use crate::color::Encoding;
use crate::filter::Filter;
use crate::map::{MapOptions, Region, SamplingMap};
use crate::pad::Padding;
use crate::pair::{Direction, Pair};
use crate::resample::{self, reads::Reads};
use crate::texture::{Channels, Depth, Size, Texels, Texture, Value};

/// How a texture is carried across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferOptions {
    /// How values between texels are made.
    pub filter: Filter,
    /// How the map is built.
    pub map: MapOptions,
    /// Whether colours are averaged as light rather than as they are encoded.
    pub linear_light: bool,
}

impl Default for TransferOptions {
    /// Lanczos-3, which kept most in round trips of photographs; a gutter of 16 texels.
    fn default() -> Self {
        Self { filter: Filter::Lanczos3, map: MapOptions::default(), linear_light: false }
    }
}

/// Carries textures of one size onto bases of another; made once, used for any number of textures.
#[derive(Debug, Clone)]
pub struct Transfer {
    map: SamplingMap,
    padding: Padding,
    options: TransferOptions,
}

/// Why a texture was not carried across.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum TransferError {
    /// A texture has another size than the transfer was made for.
    #[error("{what} is {found}, this transfer was made for {wanted}")]
    Size {
        /// `"source"` or `"base"`.
        what: &'static str,
        /// The texture's size.
        found: Size,
        /// The size that was asked for.
        wanted: Size,
    },
    /// A value that is no number or infinite, where one would spoil the whole result: in a fit.
    #[error("texel ({x}, {y}) of the source holds a value that is not finite")]
    NotFinite {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
    },
}

impl Transfer {
    /// Prepares transfers of textures of `source_size` onto bases of `target_size`.
    ///
    /// # Panics
    /// If a side of a size is 0 or beyond [`Texture::MAX_SIDE`].
    pub fn new(
        pair: &Pair,
        direction: Direction,
        source_size: Size,
        target_size: Size,
        options: &TransferOptions,
    ) -> Self {
        let from = pair.from(direction);
        let map = SamplingMap::new(pair, direction, target_size, &options.map);
        let reads = Reads::new(&map, pair.to(direction), source_size, options.filter);
        let reach = reads.reach(&map, map.border_patches(), source_size, options.filter);
        let covered = Region::covered(from, source_size, &reads.tiles.widened(reach));
        let padding = Padding::new(&covered, reach, &reads.tiles);
        Self { map, padding, options: *options }
    }

    /// As [`Transfer::new`], but what lies outside a region of the source is padded, whether islands
    /// cover it or not.
    pub(crate) fn reading(
        pair: &Pair,
        direction: Direction,
        region: &Region,
        target_size: Size,
        options: &TransferOptions,
    ) -> Self {
        let map = SamplingMap::new(pair, direction, target_size, &options.map);
        let reads = Reads::new(&map, pair.to(direction), region.size(), options.filter);
        let reach = reads.reach(&map, map.patches(), region.size(), options.filter);
        Self { map, padding: Padding::new(region, reach, &reads.tiles), options: *options }
    }

    /// The map that says where each texel comes from.
    pub fn map(&self) -> &SamplingMap {
        &self.map
    }

    /// Lays a texture over a base.
    ///
    /// The result has all channels of both and the greater depth of both, and the base's encoding.
    /// Where the source is not opaque the base shows through; in [`Encoding::Data`] no channel is
    /// opacity, and values replace the base's. Texels that the map does not reach are the base's,
    /// unchanged; but under `linear_light` a float base goes to light and back, within rounding.
    ///
    /// # Errors
    /// [`TransferError::Size`] if a texture has another size than this was made for.
    pub fn apply(&self, source: Texture, base: Texture) -> Result<Texture, TransferError> {
        self.check_sizes(&source, &base)?;
        let (source, base, format) = Format::unite(source, base, self.options.linear_light);
        Ok(format.restore(self.fill(source, base)))
    }

    /// The size of the textures that are carried.
    pub fn source_size(&self) -> Size {
        self.padding.size()
    }

    /// How textures are carried.
    pub fn options(&self) -> &TransferOptions {
        &self.options
    }

    pub(crate) fn padding(&self) -> &Padding {
        &self.padding
    }

    /// Refuses textures of other sizes than this was made for.
    pub(crate) fn check_sizes(
        &self,
        source: &Texture,
        base: &Texture,
    ) -> Result<(), TransferError> {
        for (what, found, wanted) in
            [("source", source.size(), self.source_size()), ("base", base.size(), self.map.size())]
        {
            if found != wanted {
                return Err(TransferError::Size { what, found, wanted });
            }
        }
        Ok(())
    }

    /// Resamples floats with `C` values a texel, none of them opacity: writes the texels of `target`
    /// that the map reaches, pads `source`.
    pub(crate) fn fill_floats<const C: usize>(&self, source: &mut [f32], target: &mut [f32]) {
        let size = self.source_size();
        assert_eq!(source.len(), size.texels() * C, "{size} with {C} channels");
        self.padding.fill::<C>(source);
        let filter = self.options.filter;
        resample::fast::resample::<f32, C, false>(&self.map, source, size, target, filter);
    }

    /// Resamples between textures of one format.
    fn fill(&self, mut source: Texture, mut target: Texture) -> Texture {
        self.padding.apply(&mut source);
        let size = source.size();
        let channels = (source.channels().count(), has_opacity(&target));
        match (source.texels(), target.texels_mut()) {
            (Texels::U8(source), Texels::U8(target)) => {
                self.resample(channels, source, size, target);
            }
            (Texels::U16(source), Texels::U16(target)) => {
                self.resample(channels, source, size, target);
            }
            (Texels::F32(source), Texels::F32(target)) => {
                self.resample(channels, source, size, target);
            }
            _ => unreachable!("both were converted to one depth"),
        }
        target
    }

    fn resample<T: Value>(
        &self,
        (channels, opacity): (usize, bool),
        source: &[T],
        size: Size,
        target: &mut [T],
    ) {
        let resample = match (channels, opacity) {
            (1, _) => resample::fast::resample::<T, 1, false>,
            (2, false) => resample::fast::resample::<T, 2, false>,
            (2, true) => resample::fast::resample::<T, 2, true>,
            (3, _) => resample::fast::resample::<T, 3, false>,
            (_, false) => resample::fast::resample::<T, 4, false>,
            (_, true) => resample::fast::resample::<T, 4, true>,
        };
        resample(&self.map, source, size, target, self.options.filter);
    }
}

/// Whether the last channel is opacity; the fourth channel of data is data.
pub(crate) fn has_opacity(texture: &Texture) -> bool {
    texture.channels().has_alpha() && texture.encoding() != Encoding::Data
}

/// What a result is stored as: all channels of source and base, the greater depth of both, and the
/// base's encoding.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Format {
    channels: Channels,
    depth: Depth,
    encoding: Encoding,
}

impl Format {
    /// Brings a source and a base to one format to be worked in, which is light as floats if that
    /// is wanted.
    pub fn unite(source: Texture, base: Texture, linear_light: bool) -> (Texture, Texture, Self) {
        let channels = source.channels().union(base.channels());
        let depth = source.depth().max(base.depth());
        let encoding = base.encoding();
        // Anything next to data is data: converting one of the two would tear them apart.
        let source = if encoding == Encoding::Data { source } else { source.encoded_as(encoding) };
        let format = Self { channels, depth, encoding };
        if linear_light && encoding == Encoding::Srgb {
            let light = |texture: Texture| {
                texture.encoded_as(Encoding::Linear).converted(channels, Depth::F32)
            };
            return (light(source), light(base), format);
        }
        (source.converted(channels, depth), base.converted(channels, depth), format)
    }

    /// Brings a result from what it was worked in to what it is stored as.
    pub fn restore(self, result: Texture) -> Texture {
        result.encoded_as(self.encoding).converted(self.channels, self.depth)
    }
}
