//! A texture that is laid over a base in the other layout, band by band.

use std::sync::Arc;

use crate::blend::{BlendMap, Gains, Smooth, Toning, ToningError};
#[cfg(doc)]
use crate::color::Encoding;
use crate::formats::Formats;
use crate::map::SamplingMap;
use crate::normals::{NormalFrames, NormalOptions};
use crate::resample::store;
use crate::resampler::{Resampler, Source, TexelShape};
use crate::texture::{Size, TexelFormat, Texels, TexelsMut, Texture, Value};
use crate::threads::for_each_chunk;

/// A texture that is ready to be laid over a base, from [`Graft::overlay`] or [`Graft::fit`].
///
/// The base comes in bands of rows, in any order and as often as wanted, so it never has to be in
/// memory whole; results do not depend on how it is cut.
///
/// [`Graft::overlay`]: crate::Graft::overlay
/// [`Graft::fit`]: crate::Graft::fit
#[derive(Debug, Clone)]
pub struct Overlay {
    resampler: Arc<Resampler>,
    formats: Formats,
    layer: Layer,
    /// How it is blended in, and the tone that was found.
    blend: Option<(Arc<BlendMap>, Gains)>,
    /// For normal maps: what turns the normals of one layout into those of the other.
    normals: Option<(Arc<NormalFrames>, NormalOptions)>,
    /// Of a blend: what parts have that are next to lines in the texture.
    smooth: Option<Arc<Smooth>>,
}

/// What is laid over.
#[derive(Debug, Clone)]
pub(crate) enum Layer {
    /// A padded source in the working format.
    Sampled(Arc<Source>),
    /// Premultiplied values of every texel of the target, 1.0 for white.
    Solved(Arc<Vec<f32>>),
}

/// What is laid over, its values at hand.
#[derive(Clone, Copy)]
enum Values<'v, T> {
    Sampled { source: &'v [T], is_opaque: bool },
    Solved(&'v [f32]),
}

/// A band that is no part of the target.
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

/// Rows that are sampled before they are blended: enough for every thread, few enough for caches.
const ROWS_AT_ONCE: usize = 64;

impl Overlay {
    pub(crate) fn new(resampler: Arc<Resampler>, formats: Formats, layer: Layer) -> Self {
        Self { resampler, formats, layer, blend: None, normals: None, smooth: None }
    }

    /// The same of a normal map, in its working format.
    pub(crate) fn turned(self, frames: Arc<NormalFrames>, options: NormalOptions) -> Self {
        Self { normals: Some((frames, options)), ..self }
    }

    /// The same, laid over as a blend says: only in its region, with its weights.
    pub(crate) fn blended(self, blend: Arc<BlendMap>) -> Self {
        Self { blend: Some((blend, Gains::default())), ..self }
    }

    /// The same with smooth colours where the texture shows next to nothing.
    pub(crate) fn smoothed(self, smooth: Smooth) -> Self {
        Self { smooth: Some(Arc::new(smooth)), ..self }
    }

    /// The same without opacity in the result: what it is laid over has none, and nothing is seen
    /// through.
    #[must_use]
    pub fn opaque(self) -> Self {
        Self { formats: self.formats.opaque(), ..self }
    }

    /// The same in the tone that was found for it by [`Graft::toning`]; without a blend as it is.
    ///
    /// # Errors
    /// [`ToningError::Domain`] if it was found for another pair or direction.
    ///
    /// [`Graft::toning`]: crate::Graft::toning
    pub fn toned(mut self, toning: &Toning) -> Result<Self, ToningError> {
        if let Some((blend, gains)) = &mut self.blend {
            *gains = blend.gains(self.resampler.map(), toning, true)?;
        }
        Ok(self)
    }

    /// The same with what a toning leaves out of the region left out, and no colour changed: for the other maps of a
    /// material whose colours were toned.
    ///
    /// # Errors
    /// As [`Overlay::toned`].
    pub fn narrowed(mut self, toning: &Toning) -> Result<Self, ToningError> {
        if let Some((blend, gains)) = &mut self.blend {
            *gains = blend.gains(self.resampler.map(), toning, false)?;
        }
        Ok(self)
    }

    /// Which texels are carried, as [`Graft::mask`] says it, without those that a toning leaves out.
    ///
    /// [`Graft::mask`]: crate::Graft::mask
    pub fn mask(&self) -> Texture {
        let map = self.resampler.map();
        match &self.blend {
            Some((blend, gains)) => blend.weights(map, gains),
            None => map.mask(),
        }
    }

    /// What results are stored as: all channels of the source and the base, the greater depth of
    /// both, and the base's encoding.
    pub fn format(&self) -> TexelFormat {
        self.formats.stored()
    }

    /// The size of the bases that it is laid over.
    pub fn target_size(&self) -> Size {
        self.resampler.map().size()
    }

    /// Lays the texture over a band of the base, whose first row is row `first_row` of the target.
    ///
    /// Where the source is not opaque the base shows through; in [`Encoding::Data`] no channel is
    /// opacity, and values replace the base's. Texels that the map does not reach are the base's,
    /// unchanged; but where light is averaged a float base goes to light and back, within rounding. A band is
    /// taken for one of the format that was announced: one of other channels or depth is converted to it.
    ///
    /// # Errors
    /// [`BandError`] if the band is no part of the target.
    pub fn lay(&self, first_row: u32, band: Texture) -> Result<Texture, BandError> {
        let (target, found) = (self.target_size(), band.size());
        let last = first_row.saturating_add(found.height);
        if found.width != target.width || last > target.height {
            return Err(BandError { first_row, found, target });
        }
        let formats = &self.formats;
        let mut band = formats.working(band);
        match (&self.layer, band.texels_mut()) {
            (Layer::Sampled(source), target) => {
                let is_opaque = source.is_opaque;
                match (source.texture.texels(), target) {
                    (Texels::U8(source), TexelsMut::U8(target)) => {
                        self.lay_values(first_row, target, Values::Sampled { source, is_opaque });
                    }
                    (Texels::U16(source), TexelsMut::U16(target)) => {
                        self.lay_values(first_row, target, Values::Sampled { source, is_opaque });
                    }
                    (Texels::F32(source), TexelsMut::F32(target)) => {
                        self.lay_values(first_row, target, Values::Sampled { source, is_opaque });
                    }
                    _ => unreachable!("both were converted to one depth"),
                }
            }
            (Layer::Solved(layer), TexelsMut::U8(target)) => {
                self.lay_values(first_row, target, Values::Solved(layer));
            }
            (Layer::Solved(layer), TexelsMut::U16(target)) => {
                self.lay_values(first_row, target, Values::Solved(layer));
            }
            (Layer::Solved(layer), TexelsMut::F32(target)) => {
                self.lay_values(first_row, target, Values::Solved(layer));
            }
        }
        Ok(formats.restore(band))
    }

    fn lay_values<T: Value>(&self, first_row: u32, band: &mut [T], values: Values<'_, T>) {
        let Some((blend, gains)) = &self.blend else {
            return self.fill(first_row, band, values);
        };
        let map = self.resampler.map();
        let encoding = self.formats.working_encoding();
        let composition = blend.composition(map, gains, self.normals.is_some(), encoding);
        let base_layer = blend.base_change(gains);
        let (channels, has_opacity) = (self.formats.channels(), self.formats.has_opacity());
        let width = map.size().width as usize * channels.count();
        // What has opacity may be unknown there altogether.
        let smooth = self.smooth.as_ref().filter(|_| !has_opacity);
        let (mut layer, mut controls) = (Vec::new(), Vec::new());
        for (index, rows) in band.chunks_mut(width * ROWS_AT_ONCE).enumerate() {
            let first_row = first_row + (index * ROWS_AT_ONCE) as u32;
            if let Some(base_layer) = &base_layer {
                let hiding = (!has_opacity && !composition.leaves_out).then_some(&composition);
                base_layer.lay(channels, encoding, hiding, first_row, rows);
            }
            // What has opacity is laid over what is there, so nothing must be.
            if has_opacity {
                layer.clear();
            }
            layer.resize(rows.len(), T::default());
            self.fill(first_row, &mut layer, values);
            if let Some(smooth) = smooth {
                smooth.lay(channels, first_row, &mut layer);
            }
            let height = (rows.len() / width) as u32;
            if let Some(of) = gains.controls() {
                of.rows(first_row, height, &mut controls);
                if let Some(smooth) = smooth {
                    smooth.settle(first_row, &mut controls);
                }
            }
            composition.lay(channels, has_opacity, first_row, &layer, rows, &controls);
        }
    }

    /// Turns the normals that were sampled into rows.
    fn turn<T: Value>(&self, map: &SamplingMap, first_row: u32, rows: &mut [T]) {
        if let (Some((frames, options)), Some(rows)) = (&self.normals, T::as_floats_mut(rows)) {
            frames.turn(map, *options, first_row, rows, self.formats.channels());
        }
    }

    /// Lays the layer as it is over rows in the working format.
    fn fill<T: Value>(&self, first_row: u32, rows: &mut [T], values: Values<'_, T>) {
        let channels = self.formats.channels().count();
        let has_opacity = self.formats.has_opacity();
        match values {
            Values::Sampled { source, is_opaque } => {
                let shape = TexelShape { channels, has_opacity, is_opaque };
                self.resampler.fill(shape, source, first_row, rows, |map, rows| {
                    self.turn(map, first_row, rows);
                });
            }
            Values::Solved(layer) => self.copy((channels, has_opacity), layer, first_row, rows),
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

/// Lays a layer over a band where a map reaches.
fn copy<T: Value, const C: usize, const OPACITY: bool>(
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
                store::<T, C, OPACITY>(levels, &mut texels[x * C..][..C]);
            }
        }
    });
}
