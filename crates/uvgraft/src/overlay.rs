//! A texture prepared to be laid over a base in the other layout, band by band.

use std::ops::Range;
use std::sync::Arc;

use uvgraft_surface::threads::for_each_chunk;

use crate::blend::{BlendMap, Smooth, ToneCorrection, ToneError, ToningMap};
#[cfg(doc)]
use crate::color::Encoding;
use crate::formats::Formats;
use crate::map::SamplingMap;
use crate::normals::{NormalFrames, NormalOptions};
use crate::resample::store;
use crate::resampler::{Resampler, Source, TexelShape};
use crate::texture::{Depth, Size, TexelFormat, Texels, TexelsMut, Texture, Value};

/// A texture ready to be laid over a base, from [`Graft::overlay`] or [`Graft::fit`].
///
/// The base comes in bands of rows, in any order and any number of times, so it never has to be in
/// memory as a whole. Results do not depend on how it is divided into bands.
///
/// [`Graft::overlay`]: crate::Graft::overlay
/// [`Graft::fit`]: crate::Graft::fit
#[derive(Debug, Clone)]
pub struct Overlay {
    resampler: Arc<Resampler>,
    formats: Formats,
    layer: Layer,
    /// The blend weights at the map's texels, and the colour gains of its tone.
    blend: Option<(Arc<BlendMap>, ToningMap)>,
    /// For normal maps: the rotations from the source's tangent frames to the target's.
    normals: Option<(Arc<NormalFrames>, NormalOptions)>,
    /// For blends: smooth colours for parts that are collapsed to lines in the source's layout.
    smooth: Option<Arc<Smooth>>,
}

/// What laying makes of the rows of a base that an overlay leaves alone: [`Overlay::conversion`].
///
/// Overlays with equal conversions turn equal rows into equal rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct BaseConversion(Formats);

impl BaseConversion {
    /// Converts rows to the format of results.
    pub fn apply(&self, band: Texture) -> Texture {
        self.0.restore(self.0.working(band))
    }
}

/// What is laid over the base.
#[derive(Debug, Clone)]
pub(crate) enum Layer {
    /// A padded source in the working format, to be sampled.
    Sampled(Arc<Source>),
    /// Premultiplied values of every texel of the target, 1.0 for white: the result of a fit.
    Solved(Arc<Vec<f32>>),
}

/// A [`Layer`], its values in the working depth.
#[derive(Clone, Copy)]
enum LayerRef<'v, T> {
    Sampled { source: &'v [T], is_opaque: bool },
    Solved(&'v [f32]),
}

/// A band that does not lie within the target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a band must lie within the target of {target}, got {found} at row {first_row}")]
pub struct BandError {
    /// The row of the target that the band starts at.
    pub first_row: u32,
    /// The band's size.
    pub found: Size,
    /// The target's size.
    pub target: Size,
}

/// Rows that are sampled before they are blended: enough to occupy all threads, few enough for
/// caches.
const ROWS_AT_ONCE: usize = 64;

impl Overlay {
    pub(crate) fn new(resampler: Arc<Resampler>, formats: Formats, layer: Layer) -> Self {
        Self { resampler, formats, layer, blend: None, normals: None, smooth: None }
    }

    /// Makes it the overlay of a normal map in its working format.
    pub(crate) fn of_normals(self, frames: Arc<NormalFrames>, options: NormalOptions) -> Self {
        Self { normals: Some((frames, options)), ..self }
    }

    /// Restricts it to the region of a blend, with its weights.
    pub(crate) fn blended(self, blend: Arc<BlendMap>) -> Self {
        Self { blend: Some((blend, ToningMap::default())), ..self }
    }

    /// Uses smooth colours where the source's layout has hardly any texels.
    pub(crate) fn smoothed(self, smooth: Smooth) -> Self {
        Self { smooth: Some(Arc::new(smooth)), ..self }
    }

    /// Drops alpha from the result: for an opaque base, through which nothing can be seen.
    #[must_use]
    pub fn opaque(self) -> Self {
        Self { formats: self.formats.opaque(), ..self }
    }

    /// Applies a tone found by [`Graft::toning`]; without a blend nothing changes.
    ///
    /// # Errors
    /// [`ToneError::Domain`] if the tone is for another pair or direction.
    ///
    /// [`Graft::toning`]: crate::Graft::toning
    pub fn with_tone(mut self, toning: &ToneCorrection) -> Result<Self, ToneError> {
        if let Some((blend, toning_map)) = &mut self.blend {
            *toning_map = blend.toning_map(self.resampler.map(), toning, true)?;
        }
        Ok(self)
    }

    /// Leaves out of the region what a toning leaves out, but changes no colour: for the other maps
    /// of a material whose base colour was toned.
    ///
    /// # Errors
    /// As [`Overlay::with_tone`].
    pub fn with_exclusion(mut self, toning: &ToneCorrection) -> Result<Self, ToneError> {
        if let Some((blend, toning_map)) = &mut self.blend {
            *toning_map = blend.toning_map(self.resampler.map(), toning, false)?;
        }
        Ok(self)
    }

    /// The texels that are transferred, as in [`Graft::mask`], without those that a toning leaves out.
    ///
    /// [`Graft::mask`]: crate::Graft::mask
    pub fn mask(&self) -> Texture {
        let map = self.resampler.map();
        match &self.blend {
            Some((blend, toning_map)) => blend.weights(map, toning_map),
            None => map.mask(),
        }
    }

    /// The format of results: all channels of the source and the base, the greater depth of both,
    /// and the base's encoding.
    pub fn format(&self) -> TexelFormat {
        self.formats.stored()
    }

    /// The size of the bases that it fits.
    pub fn target_size(&self) -> Size {
        self.resampler.map().size()
    }

    /// Whether it may change texels in some rows of the target; if not, [`Overlay::lay`] only
    /// converts them, as [`Overlay::conversion`] does.
    ///
    /// A tone that adapts the base may change its whole layout.
    pub fn changes(&self, rows: Range<u32>) -> bool {
        let resampler = &self.resampler;
        let base =
            self.blend.as_ref().and_then(|(blend, toning_map)| blend.base_change(toning_map));
        let maps = [Some(&**resampler.map()), resampler.beneath().map(|map| &**map)];
        maps.into_iter()
            .chain([base.map(|base| base.map)])
            .flatten()
            .any(|map| rows.clone().any(|row| !map.row(row).is_empty()))
    }

    /// What laying makes of rows that do not change.
    pub fn conversion(&self) -> BaseConversion {
        BaseConversion(self.formats)
    }

    /// Lays the texture over a band of the base; row 0 of the band is row `first_row` of the
    /// target.
    ///
    /// The base shows through where the source is not opaque. In [`Encoding::Data`] no channel is
    /// alpha, and values replace the base's. Texels outside the map keep the base's value bit for
    /// bit, except when averaging in linear light: a float base is then converted to linear light
    /// and back, within rounding. A band whose channels or depth differ from the announced format
    /// is converted to it.
    ///
    /// # Errors
    /// [`BandError`] if the band does not lie within the target.
    pub fn lay(&self, first_row: u32, band: Texture) -> Result<Texture, BandError> {
        self.check_band(first_row, band.size())?;
        let formats = &self.formats;
        if band.format() == formats.stored() && !formats.is_kept(band.format()) {
            return Ok(self.lay_converted(first_row, band));
        }
        let mut band = formats.working(band);
        self.lay_texels(first_row, band.texels_mut());
        Ok(formats.restore(band))
    }

    /// As [`Overlay::lay`], for a band that is converted to be worked on, such as normals as floats:
    /// some rows at a time, since floats of all of it would have to go through main memory. Rows that
    /// the map does not reach stay as they are, unless they change by being converted.
    fn lay_converted(&self, first_row: u32, mut band: Texture) -> Texture {
        const ROWS: u32 = 256;
        let formats = &self.formats;
        let keeps_rest = formats.working_encoding() == band.encoding() && self.blend.is_none();
        let height = band.size().height;
        for start in (0..height).step_by(ROWS as usize) {
            let rows = start..height.min(start + ROWS);
            let is_reached = |row: u32| !self.resampler.map().row(first_row + row).is_empty();
            if keeps_rest && !rows.clone().any(is_reached) {
                continue;
            }
            let mut part = formats.working(band.rows(rows));
            self.lay_texels(first_row + start, part.texels_mut());
            band.replace_rows(start, &formats.restore(part));
        }
        band
    }

    /// As [`Overlay::lay`], in memory of the caller's: `band` holds rows of the target from
    /// `first_row` on.
    ///
    /// - `format`: that of `band`, which must be both the format of results and the one that values
    ///   are processed in: [`Overlay::works_in`].
    ///
    /// # Errors
    /// [`BandError`] if the band does not lie within the target.
    ///
    /// # Panics
    /// If values are processed in another format, or if the band does not consist of whole rows.
    pub fn lay_in_place(
        &self,
        first_row: u32,
        format: TexelFormat,
        band: TexelsMut<'_>,
    ) -> Result<(), BandError> {
        assert!(self.works_in(format), "{format:?}");
        let (values, depth) = match &band {
            TexelsMut::U8(values) => (values.len(), Depth::U8),
            TexelsMut::U16(values) => (values.len(), Depth::U16),
            TexelsMut::F32(values) => (values.len(), Depth::F32),
        };
        let width = self.target_size().width;
        let row = width as usize * format.channels.count();
        assert!(depth == format.depth && values.is_multiple_of(row), "{values} {depth:?} values");
        let height = u32::try_from(values / row).unwrap_or(u32::MAX);
        self.check_band(first_row, Size::new(width, height))?;
        self.lay_texels(first_row, band);
        Ok(())
    }

    /// Whether bands of a format are processed in that format and stay in it, as
    /// [`Overlay::lay_in_place`] requires.
    pub fn works_in(&self, format: TexelFormat) -> bool {
        self.formats.is_kept(format)
    }

    fn check_band(&self, first_row: u32, found: Size) -> Result<(), BandError> {
        let target = self.target_size();
        let last = first_row.saturating_add(found.height);
        if found.width != target.width || last > target.height {
            return Err(BandError { first_row, found, target });
        }
        Ok(())
    }

    /// - `band`: whole rows in the working format.
    fn lay_texels(&self, first_row: u32, band: TexelsMut<'_>) {
        match (&self.layer, band) {
            (Layer::Sampled(source), target) => {
                let is_opaque = source.is_opaque;
                match (source.texture.texels(), target) {
                    (Texels::U8(source), TexelsMut::U8(target)) => {
                        self.lay_values(first_row, target, LayerRef::Sampled { source, is_opaque });
                    }
                    (Texels::U16(source), TexelsMut::U16(target)) => {
                        self.lay_values(first_row, target, LayerRef::Sampled { source, is_opaque });
                    }
                    (Texels::F32(source), TexelsMut::F32(target)) => {
                        self.lay_values(first_row, target, LayerRef::Sampled { source, is_opaque });
                    }
                    _ => unreachable!("both were converted to one depth"),
                }
            }
            (Layer::Solved(layer), TexelsMut::U8(target)) => {
                self.lay_values(first_row, target, LayerRef::Solved(layer));
            }
            (Layer::Solved(layer), TexelsMut::U16(target)) => {
                self.lay_values(first_row, target, LayerRef::Solved(layer));
            }
            (Layer::Solved(layer), TexelsMut::F32(target)) => {
                self.lay_values(first_row, target, LayerRef::Solved(layer));
            }
        }
    }

    /// Lays the texture over a band in the working format. With a blend, rows are first sampled
    /// into a layer of their own, [`ROWS_AT_ONCE`] at a time, and then blended into the band.
    fn lay_values<T: Value>(&self, first_row: u32, band: &mut [T], values: LayerRef<'_, T>) {
        let Some((blend, toning_map)) = &self.blend else {
            return self.fill(first_row, band, values);
        };
        let map = self.resampler.map();
        let encoding = self.formats.working_encoding();
        let composition = blend.composition(map, toning_map, self.normals.is_some(), encoding);
        let base_layer = blend.base_change(toning_map);
        let (channels, has_alpha) = (self.formats.channels(), self.formats.has_alpha());
        let width = map.size().width as usize * channels.count();
        // A texture with alpha may be transparent there altogether.
        let smooth = self.smooth.as_ref().filter(|_| !has_alpha);
        let (mut layer, mut controls) = (Vec::new(), Vec::new());
        for (index, rows) in band.chunks_mut(width * ROWS_AT_ONCE).enumerate() {
            let first_row = first_row + (index * ROWS_AT_ONCE) as u32;
            if let Some(base_layer) = &base_layer {
                let hiding = (!has_alpha && !composition.leaves_out).then_some(&composition);
                base_layer.lay(channels, encoding, hiding, first_row, rows);
            }
            // Alpha is composited over the content of the layer, so the layer must start out empty.
            if has_alpha {
                layer.clear();
            }
            layer.resize(rows.len(), T::default());
            self.fill(first_row, &mut layer, values);
            if let Some(smooth) = smooth {
                smooth.lay(channels, first_row, &mut layer);
            }
            let height = (rows.len() / width) as u32;
            if let Some(of) = toning_map.controls() {
                of.rows(first_row, height, &mut controls);
                if let Some(smooth) = smooth {
                    smooth.settle(first_row, &mut controls);
                }
            }
            composition.lay(channels, has_alpha, first_row, &layer, rows, &controls);
        }
    }

    /// Rotates the sampled normals into the frames of the target's layout, row by row.
    fn turn<T: Value>(&self, map: &SamplingMap, first_row: u32, rows: &mut [T]) {
        if let (Some((frames, options)), Some(rows)) = (&self.normals, T::as_floats_mut(rows)) {
            frames.turn(map, *options, first_row, rows, self.formats.channels());
        }
    }

    /// Writes the layer, unblended, over rows in the working format.
    fn fill<T: Value>(&self, first_row: u32, rows: &mut [T], values: LayerRef<'_, T>) {
        let channels = self.formats.channels().count();
        let has_alpha = self.formats.has_alpha();
        match values {
            LayerRef::Sampled { source, is_opaque } => {
                let shape = TexelShape { channels, has_alpha, is_opaque };
                self.resampler.fill(shape, source, first_row, rows, |map, rows| {
                    self.turn(map, first_row, rows);
                });
            }
            LayerRef::Solved(layer) => self.copy((channels, has_alpha), layer, first_row, rows),
        }
    }

    fn copy<T: Value>(&self, values: (usize, bool), layer: &[f32], first_row: u32, band: &mut [T]) {
        let copy = match values {
            (1, _) => copy::<T, 1, false>,
            (2, false) => copy::<T, 2, false>,
            (2, true) => copy::<T, 2, true>,
            (3, _) => copy::<T, 3, false>,
            (_, false) => copy::<T, 4, false>,
            (_, true) => copy::<T, 4, true>,
        };
        copy(self.resampler.map(), layer, first_row, band);
    }
}

/// Composites a solved layer over a band, at the texels of a map.
fn copy<T: Value, const C: usize, const ALPHA: bool>(
    map: &SamplingMap,
    layer: &[f32],
    first_row: u32,
    band: &mut [T],
) {
    let width = map.size().width as usize;
    for_each_chunk(band, width * C, |row, texels| {
        let row = first_row as usize + row;
        for run in map.row(row as u32) {
            for x in run.x as usize..(run.x + run.len) as usize {
                let levels: [f32; C] = std::array::from_fn(|channel| {
                    layer[(row * width + x) * C + channel] * T::ONE.to_level()
                });
                store::<T, C, ALPHA>(levels, &mut texels[x * C..][..C]);
            }
        }
    });
}
