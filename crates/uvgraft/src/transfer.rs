//! A texture from one layout onto a base in another: map, padding, formats and filtering together.

use std::ops::Range;

use fearless_simd::Level;

use crate::bits;
use crate::color::Encoding;
use crate::filter::Filter;
use crate::map::{MapOptions, Region, SamplingMap, TILE, Tiles};
use crate::normals::{NormalFrames, NormalOptions};
use crate::overlay::{Formats, Layer, Overlay};
use crate::pad::Padding;
use crate::pair::{Direction, Pair};
use crate::resample::reads::Reads;
use crate::resample::{self, Paths};
use crate::texture::{Channels, Depth, Size, TexelFormat, Texture};
use crate::threads::map_indices;

/// How a texture is carried across.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TransferOptions {
    /// How values between texels are made.
    pub filter: Filter,
    /// How the map is built.
    pub map: MapOptions,
    /// Whether colours are averaged as light rather than as they are encoded.
    pub linear_light: bool,
    /// What shows where islands of the target overlap. A fit shows one of them in any case.
    pub overlap: Overlap,
}

/// What shows at texels that several islands of the target cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Overlap {
    /// The island that owns them: see [`MapOptions::prefer`].
    #[default]
    First,
    /// The mean of the first and the last of the islands there.
    Average,
}

impl Default for TransferOptions {
    /// Lanczos-3, which kept most in round trips of photographs; a gutter of 16 texels.
    fn default() -> Self {
        Self {
            filter: Filter::Lanczos3,
            map: MapOptions::default(),
            linear_light: false,
            overlap: Overlap::First,
        }
    }
}

/// Carries textures of one size onto bases of another; made once, used for any number of textures.
#[derive(Debug, Clone)]
pub struct Transfer {
    map: SamplingMap,
    paths: Paths,
    source_rows: Range<u32>,
    /// The tiles of the source that the map reads.
    tiles: Tiles,
    padding: Padding,
    options: TransferOptions,
    beneath: Option<Beneath>,
}

/// What the last of several islands would have at texels that they share.
#[derive(Debug, Clone)]
pub(crate) struct Beneath {
    pub map: SamplingMap,
    pub paths: Paths,
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
    /// A band is no part of the target.
    #[error("a band of {found} from row {first_row} on is no part of a target of {target}")]
    Band {
        /// The row of the target that the band starts at.
        first_row: u32,
        /// The band's size.
        found: Size,
        /// The target's size.
        target: Size,
    },
    /// A normal map without the channels for it.
    #[error("a normal map has three channels, this texture has {}", found.count())]
    NoNormals {
        /// The texture's channels.
        found: Channels,
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
        let paths = Paths::new(&map, source_size, options.filter);
        let mut reads = Reads::new(&map, pair.to(direction), &paths);
        let mut reach = reads.reach(&map, map.border_patches(), source_size, options.filter);
        let wants_beneath = options.overlap == Overlap::Average;
        let beneath = wants_beneath.then(|| map.beneath(pair, &options.map)).flatten().map(|map| {
            let paths = Paths::new(&map, source_size, options.filter);
            let others = Reads::new(&map, pair.to(direction), &paths);
            reads.tiles.unite(&others.tiles);
            let far = others.reach(&map, map.border_patches(), source_size, options.filter);
            reach = reach.max(far);
            Beneath { map, paths }
        });
        let near = reads.tiles.widened(reach);
        let padding = Padding::new(&Region::covered(from, source_size, &near), reach, &reads.tiles);
        let source_rows = near.rows_between(source_size.height);
        Self { map, paths, source_rows, tiles: reads.tiles, padding, options: *options, beneath }
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
        let paths = Paths::new(&map, region.size(), options.filter);
        let reads = Reads::new(&map, pair.to(direction), &paths);
        let reach = reads.reach(&map, map.patches(), region.size(), options.filter);
        let padding = Padding::new(region, reach, &reads.tiles);
        let source_rows = reads.tiles.widened(reach).rows_between(paths.source().height);
        let (tiles, options) = (reads.tiles, *options);
        Self { map, paths, source_rows, tiles, padding, options, beneath: None }
    }

    /// The map that says where each texel comes from.
    pub fn map(&self) -> &SamplingMap {
        &self.map
    }

    /// Lays a texture over a base.
    ///
    /// The result has all channels of both and the greater depth of both, and the base's encoding.
    /// What becomes of the values is told by [`Overlay::lay`].
    ///
    /// # Errors
    /// [`TransferError::Size`] if a texture has another size than this was made for.
    pub fn apply(&self, source: Texture, base: Texture) -> Result<Texture, TransferError> {
        self.check_base(&base)?;
        self.overlay(source, base.format())?.lay(0, base)
    }

    /// Makes a texture ready to be laid over a base of some format, band by band.
    ///
    /// # Errors
    /// [`TransferError::Size`] if the texture has another size than this was made for.
    pub fn overlay(
        &self,
        source: Texture,
        base: TexelFormat,
    ) -> Result<Overlay<'_>, TransferError> {
        self.check_source(&source)?;
        let formats = Formats::new(source.format(), base, self.options.linear_light);
        let mut source = formats.working(source);
        self.padding.apply(&mut source);
        // Floats would come out a last bit beside 1.
        let is_opaque =
            formats.has_opacity() && source.depth() != Depth::F32 && self.is_opaque(&source);
        let layer = self.sampled(source, is_opaque);
        Ok(Overlay::new(&self.map, formats, layer))
    }

    /// As [`Transfer::overlay`], for a tangent-space normal map: its normals are turned into the frames of
    /// the target's layout, and made as long as they have to be. Values are data, and worked on as
    /// floats.
    ///
    /// - `frames`: of the same pair and direction.
    ///
    /// # Errors
    /// [`TransferError::Size`] if the texture has another size than the transfer was made for;
    /// [`TransferError::NoNormals`] if it has fewer than three channels.
    pub fn normal_overlay<'a>(
        &'a self,
        source: Texture,
        base: TexelFormat,
        frames: &'a NormalFrames,
        options: NormalOptions,
    ) -> Result<Overlay<'a>, TransferError> {
        self.check_source(&source)?;
        if !source.channels().has_color() {
            return Err(TransferError::NoNormals { found: source.channels() });
        }
        let formats = Formats::new(source.format(), base, false).of_normals();
        let mut source = formats.working(source.with_encoding(Encoding::Data));
        self.padding.apply(&mut source);
        let layer = self.sampled(source, true);
        Ok(Overlay::new(&self.map, formats, layer).turned(frames, options))
    }

    fn sampled(&self, source: Texture, is_opaque: bool) -> Layer<'_> {
        Layer::Sampled { paths: &self.paths, beneath: self.beneath.as_ref(), source, is_opaque }
    }

    /// Whether a source's last channel is 1 wherever the map reads.
    fn is_opaque(&self, source: &Texture) -> bool {
        let Size { width, height } = source.size();
        let rows = map_indices(self.tiles.count(), |row| {
            let rows = row as u32 * TILE..((row as u32 + 1) * TILE).min(height);
            bits::ranges(self.tiles.row(row)).all(|columns| {
                let columns = columns.start * TILE..(columns.end * TILE).min(width);
                rows.clone().all(|row| source.is_opaque(row, columns.clone()))
            })
        });
        rows.into_iter().all(|is_opaque| is_opaque)
    }

    /// The rows of the source that results depend on; what the others hold does not matter.
    pub fn source_rows(&self) -> Range<u32> {
        self.source_rows.clone()
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

    pub(crate) fn check_source(&self, source: &Texture) -> Result<(), TransferError> {
        check_size("source", source, self.source_size())
    }

    pub(crate) fn check_base(&self, base: &Texture) -> Result<(), TransferError> {
        check_size("base", base, self.map.size())
    }

    /// Resamples floats with `C` values a texel, none of them opacity: writes the texels of `target`
    /// that the map reaches, pads `source`.
    pub(crate) fn fill_floats<const C: usize>(&self, source: &mut [f32], target: &mut [f32]) {
        let size = self.source_size();
        assert_eq!(source.len(), size.texels() * C, "{size} with {C} channels");
        self.padding.fill::<C>(source);
        let level = Level::new();
        resample::fast::resample::<f32, C, false>(level, &self.map, &self.paths, source, 0, target);
    }
}

/// Refuses a texture of another size than a transfer was made for.
fn check_size(what: &'static str, texture: &Texture, wanted: Size) -> Result<(), TransferError> {
    let found = texture.size();
    if found == wanted { Ok(()) } else { Err(TransferError::Size { what, found, wanted }) }
}
