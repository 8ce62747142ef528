//! A texture that is ready to be laid over a base in another layout, band by band.

use fearless_simd::Level;

use crate::blend::{BlendMap, Finish, Toning, Undercoat};
use crate::color::Encoding;
use crate::map::SamplingMap;
use crate::normals::{NormalFrames, NormalOptions};
use crate::resample::{self, Paths, store};
use crate::texture::{Channels, Depth, TexelFormat, Texels, Texture, Value};
use crate::threads::for_each_chunk;
use crate::transfer::{Beneath, TransferError};

/// A texture that is ready to be laid over a base, from [`Transfer::overlay`] or [`Fit::overlay`].
///
/// The base comes in bands of rows, in any order and as often as wanted, so it never has to be in
/// memory whole; results do not depend on how it is cut.
///
/// [`Transfer::overlay`]: crate::Transfer::overlay
/// [`Fit::overlay`]: crate::Fit::overlay
#[derive(Debug, Clone)]
pub struct Overlay<'a> {
    map: &'a SamplingMap,
    formats: Formats,
    layer: Layer<'a>,
    blend: Option<(Option<Undercoat<'a>>, Finish<'a>)>,
    /// For normal maps: what turns the normals of one layout into those of the other.
    normals: Option<(&'a NormalFrames, NormalOptions)>,
}

/// What is laid over.
#[derive(Debug, Clone)]
pub(crate) enum Layer<'a> {
    /// A padded source in the working format, where it is read, and whether it is opaque there.
    Sampled { paths: &'a Paths, beneath: Option<&'a Beneath>, source: Texture, is_opaque: bool },
    /// Premultiplied values of every texel of the target, 1.0 for white.
    Solved(Vec<f32>),
}

/// What is laid over, its values at hand.
#[derive(Clone, Copy)]
enum Values<'v, T> {
    Sampled { paths: &'v Paths, beneath: Option<&'v Beneath>, source: &'v [T], is_opaque: bool },
    Solved(&'v [f32]),
}

/// Rows that are sampled before they are blended: enough for every thread, few enough for caches.
const ROWS_AT_ONCE: usize = 64;

impl<'a> Overlay<'a> {
    pub(crate) fn new(map: &'a SamplingMap, formats: Formats, layer: Layer<'a>) -> Self {
        Self { map, formats, layer, blend: None, normals: None }
    }

    /// The same of a normal map, in its working format.
    pub(crate) fn turned(self, frames: &'a NormalFrames, options: NormalOptions) -> Self {
        Self { normals: Some((frames, options)), ..self }
    }

    /// The same without opacity in the result: what it is laid over has none, and nothing is seen
    /// through.
    #[must_use]
    pub fn opaque(mut self) -> Self {
        self.formats.stored = Channels::new(self.formats.result.channels.has_color(), false);
        self
    }

    /// The same, laid over as a blend says: only in its region, with its weights, and in the tone that
    /// was found.
    ///
    /// # Panics
    /// If the blend is one at the texels of another map.
    #[must_use]
    pub fn blended(self, blend: &'a BlendMap<'a>, toning: Option<&Toning>) -> Self {
        let finish = Finish { normals: self.normals.is_some(), ..blend.finish(self.map, toning) };
        Self { blend: Some((blend.undercoat(toning), finish)), ..self }
    }

    /// In which encoding values are laid over: for [`Blend::toning`].
    ///
    /// [`Blend::toning`]: crate::blend::Blend::toning
    pub fn working_encoding(&self) -> Encoding {
        self.formats.working_encoding()
    }

    /// What results are stored as: all channels of the source and the base, the greater depth of
    /// both, and the base's encoding.
    pub fn format(&self) -> TexelFormat {
        TexelFormat { channels: self.formats.stored, ..self.formats.result }
    }

    /// Lays the texture over a band of the base, whose first row is row `first_row` of the target.
    ///
    /// Where the source is not opaque the base shows through; in [`Encoding::Data`] no channel is
    /// opacity, and values replace the base's. Texels that the map does not reach are the base's,
    /// unchanged; but under `linear_light` a float base goes to light and back, within rounding.
    ///
    /// # Errors
    /// [`TransferError::Band`] if the band is no part of the target.
    pub fn lay(&self, first_row: u32, band: Texture) -> Result<Texture, TransferError> {
        let (size, found) = (self.map.size(), band.size());
        let last = first_row.saturating_add(found.height);
        if found.width != size.width || last > size.height {
            return Err(TransferError::Band { first_row, found, target: size });
        }
        let formats = &self.formats;
        let mut band = formats.working(band);
        match (&self.layer, band.texels_mut()) {
            (Layer::Sampled { paths, beneath, source, is_opaque }, target) => {
                let (beneath, is_opaque) = (*beneath, *is_opaque);
                match (source.texels(), target) {
                    (Texels::U8(source), Texels::U8(target)) => {
                        let values = Values::Sampled { paths, beneath, source, is_opaque };
                        self.lay_values(first_row, target, values);
                    }
                    (Texels::U16(source), Texels::U16(target)) => {
                        let values = Values::Sampled { paths, beneath, source, is_opaque };
                        self.lay_values(first_row, target, values);
                    }
                    (Texels::F32(source), Texels::F32(target)) => {
                        let values = Values::Sampled { paths, beneath, source, is_opaque };
                        self.lay_values(first_row, target, values);
                    }
                    _ => unreachable!("both were converted to one depth"),
                }
            }
            (Layer::Solved(layer), Texels::U8(target)) => {
                self.lay_values(first_row, target, Values::Solved(layer));
            }
            (Layer::Solved(layer), Texels::U16(target)) => {
                self.lay_values(first_row, target, Values::Solved(layer));
            }
            (Layer::Solved(layer), Texels::F32(target)) => {
                self.lay_values(first_row, target, Values::Solved(layer));
            }
        }
        Ok(formats.restore(band))
    }

    fn lay_values<T: Value>(&self, first_row: u32, band: &mut [T], values: Values<'_, T>) {
        let Some((undercoat, finish)) = &self.blend else {
            return self.fill(first_row, band, values);
        };
        let (channels, has_opacity) = (self.formats.result.channels, self.formats.has_opacity());
        let width = self.map.size().width as usize * channels.count();
        let mut layer = Vec::new();
        for (index, rows) in band.chunks_mut(width * ROWS_AT_ONCE).enumerate() {
            let first_row = first_row + (index * ROWS_AT_ONCE) as u32;
            if let Some(undercoat) = undercoat {
                let encoding = self.formats.working_encoding();
                let hiding = (!has_opacity).then_some(finish);
                undercoat.lay(channels, encoding, hiding, first_row, rows);
            }
            // What has opacity is laid over what is there, so nothing must be.
            if has_opacity {
                layer.clear();
            }
            layer.resize(rows.len(), T::default());
            self.fill(first_row, &mut layer, values);
            finish.lay(channels, has_opacity, first_row, &layer, rows);
        }
    }

    /// Turns the normals that were sampled into rows.
    fn turn<T: Value>(&self, map: &SamplingMap, first_row: u32, rows: &mut [T]) {
        if let (Some((frames, options)), Some(rows)) = (self.normals, T::as_floats_mut(rows)) {
            frames.turn(map, options, first_row, rows, self.formats.result.channels);
        }
    }

    /// Lays the layer as it is over rows in the working format.
    fn fill<T: Value>(&self, first_row: u32, rows: &mut [T], values: Values<'_, T>) {
        let channels = self.formats.result.channels.count();
        let has_opacity = self.formats.has_opacity();
        match values {
            // What nothing is seen through replaces what is there, at half the cost.
            Values::Sampled { paths, beneath, source, is_opaque } => {
                let format = (channels, has_opacity && !is_opaque);
                let below = beneath.filter(|beneath| {
                    let height = (rows.len() / channels) as u32 / self.map.size().width;
                    (first_row..first_row + height).any(|row| !beneath.map.row(row).is_empty())
                });
                let Some(below) = below else {
                    sample(format, self.map, paths, source, first_row, rows);
                    return self.turn(self.map, first_row, rows);
                };
                let mut others = rows.to_vec();
                sample(format, self.map, paths, source, first_row, rows);
                self.turn(self.map, first_row, rows);
                sample(format, &below.map, &below.paths, source, first_row, &mut others);
                self.turn(&below.map, first_row, &mut others);
                average(&below.map, (channels, has_opacity), first_row, &others, rows);
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
        copy(self.map, layer, first_row, band);
    }
}

/// Fills the texels of a map in rows from `first_row` on; of `format` are the number of channels and
/// whether the last one is opacity.
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

/// Takes the mean with other rows at the texels of a map; colours count by their opacity. `format` is as
/// in [`sample`].
fn average<T: Value>(
    map: &SamplingMap,
    format: (usize, bool),
    first_row: u32,
    others: &[T],
    rows: &mut [T],
) {
    let (channels, has_opacity) = format;
    let width = map.size().width as usize * channels;
    for_each_chunk(rows, width, |index, texels| {
        for run in map.row(first_row + index as u32) {
            let part = run.x as usize * channels..(run.x + run.len) as usize * channels;
            let others = &others[index * width..][part.clone()];
            let texels = texels[part].chunks_exact_mut(channels);
            for (texel, other) in texels.zip(others.chunks_exact(channels)) {
                let opacity = |texel: &[T]| texel[channels - 1].to_level().max(0.0);
                let share = match (opacity(texel), opacity(other)) {
                    (ours, theirs) if has_opacity && ours != theirs => theirs / (ours + theirs),
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

/// What results are stored as, and what they are worked out in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Formats {
    result: TexelFormat,
    /// The channels that a result is stored with.
    stored: Channels,
    /// Whether colours are worked on as light.
    as_light: bool,
    /// Whether values are worked on as floats: those of normals, which are turned before they are rounded.
    as_floats: bool,
}

impl Formats {
    /// - `linear_light`: whether colours are to be averaged as light.
    pub fn new(source: TexelFormat, base: TexelFormat, linear_light: bool) -> Self {
        let result = TexelFormat {
            channels: source.channels.union(base.channels),
            depth: source.depth.max(base.depth),
            encoding: base.encoding,
        };
        let as_light = linear_light && base.encoding == Encoding::Srgb;
        Self { result, stored: result.channels, as_light, as_floats: false }
    }

    /// The same for normals.
    #[must_use]
    pub fn of_normals(self) -> Self {
        let result = TexelFormat { encoding: Encoding::Data, ..self.result };
        Self { result, as_light: false, as_floats: true, ..self }
    }

    /// In which encoding values are worked on.
    pub fn working_encoding(&self) -> Encoding {
        if self.as_light { Encoding::Linear } else { self.result.encoding }
    }

    /// Whether the last channel is opacity; the fourth channel of data is data.
    pub fn has_opacity(&self) -> bool {
        self.result.channels.has_alpha() && self.result.encoding != Encoding::Data
    }

    /// Brings a source or a base to the format that both are worked on in.
    pub fn working(&self, texture: Texture) -> Texture {
        let Self { result, as_light, as_floats, .. } = *self;
        // Anything next to data is data: converting one of the two would tear them apart.
        let texture = match result.encoding {
            Encoding::Data => texture,
            encoding => texture.encoded_as(encoding),
        };
        if as_light {
            return texture.encoded_as(Encoding::Linear).converted(result.channels, Depth::F32);
        }
        let depth = if as_floats { Depth::F32 } else { result.depth };
        texture.converted(result.channels, depth)
    }

    /// Brings a result to what it is stored as.
    pub fn restore(&self, texture: Texture) -> Texture {
        let TexelFormat { depth, encoding, .. } = self.result;
        texture.encoded_as(encoding).converted(self.stored, depth)
    }
}
