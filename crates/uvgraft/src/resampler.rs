//! The resampler for source textures of one size: the sampling map, where its runs read in the
//! source, and the padding that they read.

use std::ops::Range;
use std::sync::Arc;

use fearless_simd::Level;
use uvgraft_surface::bits;
use uvgraft_surface::pair::{Direction, Pair};
use uvgraft_surface::threads::{for_each_chunk, map_indices};

use crate::filter::Filter;
use crate::formats::Formats;
use crate::map::{MapOptions, SamplingMap, TILE, TexelSet, Tiles};
use crate::pad::Padding;
use crate::resample::reads::Reads;
use crate::resample::{self, Paths};
use crate::texture::{Depth, Size, Texture, Value};

/// Which value a texel gets when several islands of the target cover it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Overlap {
    /// The value of the island that owns the texel; see [`MapOptions::prefer`].
    #[default]
    First,
    /// The mean of the values of the first and the last island there.
    Average,
}

uvgraft_surface::choices!(Overlap {
    First => "first", "Use the island selected by `prefer`";
    Average => "average", "Average all overlapping islands";
});

/// The inputs that determine a sampling map.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MapInputs<'a> {
    pub pair: &'a Pair,
    pub direction: Direction,
    pub target_size: Size,
    pub map: MapOptions,
}

/// Resamples textures of one size; built once and reusable for any number of textures.
#[derive(Debug, Clone)]
pub(crate) struct Resampler {
    filter: Filter,
    map: Arc<SamplingMap>,
    paths: Paths,
    /// Source tiles that the map reads.
    tiles: Tiles,
    /// These and those within the reach of the padding, which takes its values from them.
    widened: Tiles,
    padding: Padding,
    beneath: Option<Beneath>,
}

/// Resamples the texels shared by several islands as if the last of these islands owned them.
#[derive(Debug, Clone)]
struct Beneath {
    map: Arc<SamplingMap>,
    paths: Paths,
}

/// A padded source texture in the working format.
#[derive(Debug, Clone)]
pub(crate) struct Source {
    pub texture: Texture,
    /// Whether it is opaque wherever the map reads it.
    pub is_opaque: bool,
}

impl<'a> MapInputs<'a> {
    /// Builds the map and, for [`Overlap::Average`], the map of the islands beneath overlaps.
    pub fn maps(&self, overlap: Overlap) -> (Arc<SamplingMap>, Option<Arc<SamplingMap>>) {
        let map = SamplingMap::new(self.pair, self.direction, self.target_size, &self.map);
        let beneath = match overlap {
            Overlap::First => None,
            Overlap::Average => map.beneath(self.pair, &self.map).map(Arc::new),
        };
        (Arc::new(map), beneath)
    }
}

impl Resampler {
    /// Builds a resampler for textures of `source_size`.
    ///
    /// - `map`, `beneath`: from [`MapInputs::maps`].
    pub fn new(
        inputs: &MapInputs<'_>,
        (map, beneath): (Arc<SamplingMap>, Option<Arc<SamplingMap>>),
        source_size: Size,
        filter: Filter,
    ) -> Self {
        let (from, to) = (inputs.pair.from(inputs.direction), inputs.pair.to(inputs.direction));
        let paths = Paths::new(&map, source_size, filter);
        let mut reads = Reads::new(&map, Some(to), &paths);
        let mut reach = reads.reach(&map, map.border_patches(), source_size, filter);
        let beneath = beneath.map(|map| {
            let paths = Paths::new(&map, source_size, filter);
            let others = Reads::new(&map, Some(to), &paths);
            reads.tiles.unite(&others.tiles);
            reach = reach.max(others.reach(&map, map.border_patches(), source_size, filter));
            Beneath { map, paths }
        });
        let widened = reads.tiles.widened(reach);
        let padding =
            Padding::new(&TexelSet::covered(from, source_size, &widened), reach, &reads.tiles);
        Self { filter, map, paths, tiles: reads.tiles, widened, padding, beneath }
    }

    /// As [`Resampler::new`], but pads everything outside a region of the source, whether
    /// islands cover it or not.
    pub fn reading(inputs: &MapInputs<'_>, region: &TexelSet, filter: Filter) -> Self {
        let (map, _) = inputs.maps(Overlap::First);
        let paths = Paths::new(&map, region.size(), filter);
        let reads = Reads::new(&map, Some(inputs.pair.to(inputs.direction)), &paths);
        let reach = reads.reach(&map, map.patches(), region.size(), filter);
        let padding = Padding::new(region, reach, &reads.tiles);
        let widened = reads.tiles.widened(reach);
        Self { filter, map, paths, tiles: reads.tiles, widened, padding, beneath: None }
    }

    /// As [`Resampler::new`], for a map of any origin: as no islands of the source are known, nothing
    /// is padded, and taps read what is there.
    pub fn of_map(map: Arc<SamplingMap>, source_size: Size, filter: Filter) -> Self {
        let paths = Paths::new(&map, source_size, filter);
        let tiles = Reads::new(&map, None, &paths).tiles;
        let padding = Padding::none(source_size);
        Self { filter, map, paths, widened: tiles.clone(), tiles, padding, beneath: None }
    }

    /// The sampling map.
    pub fn map(&self) -> &Arc<SamplingMap> {
        &self.map
    }

    /// The map of the islands beneath overlaps, for [`Overlap::Average`] and if there are any.
    pub fn beneath(&self) -> Option<&Arc<SamplingMap>> {
        self.beneath.as_ref().map(|beneath| &beneath.map)
    }

    /// The source positions of the map's runs.
    pub fn paths(&self) -> &Paths {
        &self.paths
    }

    pub fn filter(&self) -> Filter {
        self.filter
    }

    /// The source rows that results depend on; the contents of all other rows do not matter.
    pub fn source_rows(&self) -> Range<u32> {
        self.widened.rows_between(self.paths.source().height)
    }

    /// The source tiles that results depend on; the contents of all others do not matter.
    pub fn source_tiles(&self) -> &Tiles {
        &self.widened
    }

    /// The size of source textures.
    pub fn source_size(&self) -> Size {
        self.padding.size()
    }

    pub fn padding(&self) -> &Padding {
        &self.padding
    }

    /// Converts a source texture to the working format and pads it.
    pub fn source(&self, formats: &Formats, texture: Texture) -> Source {
        let mut texture = formats.working(texture);
        self.padding.apply(&mut texture);
        // Not for floats: without blending, filtered alpha could end up one ulp away from 1.
        let is_opaque =
            formats.has_alpha() && texture.depth() != Depth::F32 && self.is_opaque(&texture);
        Source { texture, is_opaque }
    }

    /// Whether the last channel of a source is 1 wherever the map reads.
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

    /// Fills the texels that the map reaches in some rows of the target.
    ///
    /// - `shape`: of the texels of `source` and `rows`.
    /// - `source`: all texels of a source, padded, in the working format.
    /// - `rows`: whole rows of the target from `first_row` on.
    /// - `adjust`: applied to the texels that were sampled through a map, before they are averaged
    ///   with those beneath; it rotates tangent-space normals.
    pub fn fill<T: Value>(
        &self,
        shape: TexelShape,
        source: &[T],
        first_row: u32,
        rows: &mut [T],
        adjust: impl Fn(&SamplingMap, &mut [T]),
    ) {
        let (map, count) = (&*self.map, shape.channels);
        let below = self.beneath.as_ref().filter(|beneath| {
            let height = (rows.len() / count) as u32 / map.size().width;
            (first_row..first_row + height).any(|row| !beneath.map.row(row).is_empty())
        });
        // Opaque sources replace the base instead of being blended with it, at half the cost.
        let blends = shape.has_alpha && !shape.is_opaque;
        let Some(below) = below else {
            sample((count, blends), map, &self.paths, source, first_row, rows);
            return adjust(map, rows);
        };
        let mut others = rows.to_vec();
        sample((count, blends), map, &self.paths, source, first_row, rows);
        adjust(map, rows);
        sample((count, blends), &below.map, &below.paths, source, first_row, &mut others);
        adjust(&below.map, &mut others);
        average(&below.map, (count, shape.has_alpha), first_row, &others, rows);
    }

    /// Resamples floats with `C` values per texel, none of them alpha: pads `source` in place and
    /// writes the texels of `target` that the map reaches.
    ///
    /// - `source`: all texels of a source of [`Resampler::source_size`].
    /// - `target`: all texels of a target of the map's size.
    ///
    /// # Panics
    /// If `source` has another length.
    pub fn fill_floats<const C: usize>(&self, source: &mut [f32], target: &mut [f32]) {
        let size = self.source_size();
        assert_eq!(source.len(), size.texels() * C, "{size} with {C} channels");
        self.padding.fill::<C>(source);
        let level = Level::new();
        resample::fast::resample::<f32, C, false>(level, &self.map, &self.paths, source, 0, target);
    }
}

/// The channels of a texel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TexelShape {
    /// Number of channels.
    pub channels: usize,
    /// Whether the last channel is alpha.
    pub has_alpha: bool,
    /// Whether alpha is 1 wherever the source is read.
    pub is_opaque: bool,
}

/// Fills the texels that a map reaches in the rows from `first_row` on.
///
/// - `format`: the number of channels, and whether the last one is alpha.
fn sample<T: Value>(
    format: (usize, bool),
    map: &SamplingMap,
    paths: &Paths,
    source: &[T],
    first_row: u32,
    rows: &mut [T],
) {
    let resample = match format {
        (1, _) => resample::fast::resample::<T, 1, false>,
        (2, false) => resample::fast::resample::<T, 2, false>,
        (2, true) => resample::fast::resample::<T, 2, true>,
        (3, _) => resample::fast::resample::<T, 3, false>,
        (_, false) => resample::fast::resample::<T, 4, false>,
        (_, true) => resample::fast::resample::<T, 4, true>,
    };
    resample(Level::new(), map, paths, source, first_row, rows);
}

/// Averages `rows` with `others` at the texels of a map. Colours are weighted by their alpha, alpha
/// itself is averaged evenly. `format` is as in [`sample`].
fn average<T: Value>(
    map: &SamplingMap,
    format: (usize, bool),
    first_row: u32,
    others: &[T],
    rows: &mut [T],
) {
    let (channels, has_alpha) = format;
    let width = map.size().width as usize * channels;
    for_each_chunk(rows, width, |index, texels| {
        for run in map.row(first_row + index as u32) {
            let part = run.x as usize * channels..(run.x + run.len) as usize * channels;
            let others = &others[index * width..][part.clone()];
            let texels = texels[part].chunks_exact_mut(channels);
            for (texel, other) in texels.zip(others.chunks_exact(channels)) {
                let opacity = |texel: &[T]| texel[channels - 1].to_level().max(0.0);
                let share = match (opacity(texel), opacity(other)) {
                    (ours, theirs) if has_alpha && ours != theirs => theirs / (ours + theirs),
                    _ => 0.5,
                };
                for (channel, (value, other)) in texel.iter_mut().zip(other).enumerate() {
                    let share = if channel + 1 == channels { 0.5 } else { share };
                    let [ours, theirs] = [value.to_level(), other.to_level()];
                    *value = T::from_level(ours * (1.0 - share) + theirs * share);
                }
            }
        }
    });
}
