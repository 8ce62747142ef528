//! Recolours the skin of a base before anything is laid over it.

use std::ops::Range;

use fearless_simd::{Level, Simd};
use uvgraft_surface::threads::for_each_with;

use super::compose::Composition;
use super::field::{Line, LinearValue};
use super::skin_mask::SkinMask;
use super::stretch::{Plane, RowGains, STRETCH, join, lanes, split};
use super::tone::{Matrix, toned};
use crate::color::{Encoding, linear_from_srgb, srgb_from_linear};
use crate::map::SamplingMap;
use crate::simd::dispatch;
use crate::skin::SkinModel;
use crate::texture::{Channels, Value};

/// How the texels of a base are recoloured.
#[derive(Debug, Clone)]
pub(crate) struct BaseLayer<'a> {
    /// The base's whole layout.
    pub map: &'a SamplingMap,
    /// For each patch, the gains of red, green and blue; empty if there are none.
    pub gains: &'a [[LinearValue; 3]],
    /// Colour transform applied before the gains.
    pub matrix: Option<Matrix>,
    /// Which texels change.
    pub skin: SkinCriterion<'a>,
}

/// How skin is recognised in a base.
#[derive(Debug, Clone, Copy)]
pub(crate) enum SkinCriterion<'a> {
    /// By its colour.
    Model(SkinModel),
    /// By a mask.
    Mask(&'a SkinMask),
}

/// Buffers for one row.
#[derive(Default)]
struct Buffers {
    hidden: Vec<Range<u32>>,
    gains: RowGains,
}

impl BaseLayer<'_> {
    /// Recolours the rows of a base from `first_row` on. Grey textures change only where their
    /// lightness is that of skin.
    ///
    /// Runs that are hidden or masked out are skipped. Adjacent runs are joined to spans, since
    /// single ones are too short to fill vectors; linear light, matrices and grey go texel by
    /// texel.
    ///
    /// - `hiding`: the opaque composition that is laid over the base, if any; texels
    ///   that it hides need not change.
    pub fn lay<T: Value>(
        &self,
        channels: Channels,
        encoding: Encoding,
        hiding: Option<&Composition<'_>>,
        first_row: u32,
        rows: &mut [T],
    ) {
        let width = self.map.size().width as usize * channels.count();
        let level = Level::new();
        for_each_with(rows.chunks_mut(width), Buffers::default, |buffers, index, texels| {
            let row = first_row + index as u32;
            buffers.hidden.clear();
            if let Some(composition) = hiding {
                composition.push_full(row, &mut buffers.hidden);
            }
            self.lay_row(level, channels, encoding, buffers, row, texels);
        });
    }

    /// Recolours a row.
    ///
    /// - `buffers`: with what is hidden of it.
    #[inline(always)]
    fn lay_row<T: Value>(
        &self,
        level: Level,
        channels: Channels,
        encoding: Encoding,
        Buffers { hidden, gains }: &mut Buffers,
        row: u32,
        texels: &mut [T],
    ) {
        let count = channels.count();
        let is_per_texel =
            encoding == Encoding::Linear || self.matrix.is_some() || !channels.has_color();
        let mut hidden = hidden.iter().peekable();
        let lay_span = |gains: &mut RowGains, end: u32, texels: &mut [T]| {
            let x = end - gains.len() as u32;
            let texels = &mut texels[x as usize * count..end as usize * count];
            if count == 3 {
                dispatch!(level, simd => self.span::<_, T, 3>(simd, [x, row], gains, texels));
            } else {
                dispatch!(level, simd => self.span::<_, T, 4>(simd, [x, row], gains, texels));
            }
            gains.clear();
        };
        let mut span_end = 0;
        for run in self.map.row(row) {
            let end = run.x + run.len;
            while hidden.next_if(|hidden| hidden.end < end).is_some() {}
            if hidden.peek().is_some_and(|hidden| hidden.start <= run.x && end <= hidden.end) {
                continue;
            }
            if let SkinCriterion::Mask(mask) = self.skin
                && mask.is_black([run.x, row], run.len)
            {
                continue;
            }
            let of_run = self
                .gains
                .get(run.patch as usize)
                .map_or([Line::ONE; 3], |gains| gains.map(|gain| gain.line(run.x, row)));
            if is_per_texel {
                let part = run.x as usize * count..end as usize * count;
                for (k, texel) in (0..).zip(texels[part].chunks_exact_mut(count)) {
                    let gains = of_run.map(|gain| gain.at(k));
                    self.texel(channels, encoding, [run.x + k, row], gains, texel);
                }
                continue;
            }
            // Runs are short, so adjacent ones are joined to one span.
            if run.x != span_end {
                lay_span(gains, span_end, texels);
            }
            gains.push(&of_run, run.len as usize);
            span_end = end;
        }
        if !is_per_texel {
            lay_span(gains, span_end, texels);
        }
    }

    /// Vectorised [`BaseLayer::texel`] for sRGB colours without a matrix.
    #[inline(always)]
    fn span<S: Simd, T: Value, const C: usize>(
        &self,
        _: S,
        [x, row]: [u32; 2],
        gains: &RowGains,
        texels: &mut [T],
    ) {
        let one = T::ONE.to_level();
        for (index, texels) in texels.chunks_mut(STRETCH * C).enumerate() {
            let first = index * STRETCH;
            let count = texels.len() / C;
            let lanes = lanes(count);
            let mut weights = [0.0_f32; STRETCH];
            if let SkinCriterion::Mask(mask) = &self.skin {
                mask.weights([x + first as u32, row], &mut weights[..count]);
                if weights[..count].iter().all(|&weight| weight == 0.0) {
                    continue;
                }
            }
            let mut values: [Plane; C] = split(texels);
            let (colors, _) = values.split_at_mut(3);
            for plane in colors.iter_mut() {
                for value in &mut plane[..lanes] {
                    *value /= one;
                }
            }
            if let (SkinCriterion::Model(model), [r, g, b]) = (&self.skin, &*colors) {
                let rgb = r.iter().zip(g).zip(b);
                for (weight, ((&r, &g), &b)) in weights[..lanes].iter_mut().zip(rgb) {
                    *weight = model.weight([r, g, b]);
                }
            }
            for (channel, values) in colors.iter_mut().enumerate() {
                let mut of_channel = [1.0; STRETCH];
                of_channel[..count].copy_from_slice(&gains.of(channel, first)[..count]);
                let change = of_channel[..lanes].iter().zip(&weights);
                for (value, (&gain, &weight)) in values.iter_mut().zip(change) {
                    let toned = toned(*value, gain, 1.0);
                    // Compared this way round so that a NaN weight becomes 0.
                    let weight = if weight > 0.0 { weight } else { 0.0 };
                    *value = (*value + (toned - *value) * weight) * one;
                }
            }
            join(&values, texels);
        }
    }

    /// Recolours one texel: the specification that [`BaseLayer::span`] is tested against.
    ///
    /// `value + (toned(matrix(value)) - value) · weight` per channel, with the weight of skin.
    #[inline(always)]
    fn texel<T: Value>(
        &self,
        channels: Channels,
        encoding: Encoding,
        at: [u32; 2],
        gains: [f32; 3],
        texel: &mut [T],
    ) {
        let of = |channel: usize| if channels.has_color() { texel[channel] } else { texel[0] };
        let is_light = encoding == Encoding::Linear;
        let stored = |value: f32| if is_light { srgb_from_linear(value) } else { value };
        let rgb = [0, 1, 2].map(|channel| stored(of(channel).to_unit()));
        let weight = match self.skin {
            SkinCriterion::Model(model) => model.weight(rgb),
            SkinCriterion::Mask(mask) => {
                let mut weight = [0.0];
                mask.weights(at, &mut weight);
                weight[0]
            }
        };
        if weight.is_nan() || weight <= 0.0 {
            return;
        }
        let changed = self.matrix.map_or(rgb, |matrix| matrix.apply(rgb));
        let colors = if channels.has_color() { 3 } else { 1 };
        for channel in 0..colors {
            let value = toned(changed[channel], gains[channel], 1.0);
            let value = rgb[channel] + (value - rgb[channel]) * weight;
            texel[channel] = T::from_unit(if is_light { linear_from_srgb(value) } else { value });
        }
    }
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;

    use super::*;
    use crate::map::MapOptions;
    use crate::texture::{Size, Texels, Texture};

    fn compare<T: Value + std::fmt::Debug, const C: usize>(value: fn(&mut fastrand::Rng) -> T) {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let mesh = Mesh::from_triangles(vec![[0.0; 3]; 3], uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let size = Size::square(50);
        let map = SamplingMap::of_layout(&mesh, size, &MapOptions::with_gutter(0));
        let mut rng = fastrand::Rng::with_seed(9);
        let coarse = Size { width: 21, height: 50 };
        let levels = Texels::U8((0..coarse.texels()).map(|_| rng.u8(..)).collect());
        let mask = Texture::new(coarse, Channels::Grey, Encoding::Data, levels).unwrap();
        let mask = SkinMask::new(&mask, size).unwrap();
        let seeds: Vec<[f32; 3]> =
            (0..40).map(|_| [0.7, 0.5, 0.4].map(|mean| mean + 0.02 * rng.f32())).collect();
        let model = SkinModel::new(&seeds, &[]).unwrap();
        let gains = vec![[0.6, 1.7, 1.0].map(LinearValue::constant); map.patches().len()];
        let base: Vec<T> = (0..size.texels() * C).map(|_| value(&mut rng)).collect();
        let channels = if C == 4 { Channels::Rgba } else { Channels::Rgb };
        for skin in [SkinCriterion::Model(model), SkinCriterion::Mask(&mask)] {
            let base_layer = BaseLayer { map: &map, gains: &gains, matrix: None, skin };
            let mut wanted = base.clone();
            for row in 0..size.height {
                for run in map.row(row) {
                    for x in run.x..run.x + run.len {
                        let texel = &mut wanted[(row * size.width + x) as usize * C..][..C];
                        base_layer.texel(
                            channels,
                            Encoding::Srgb,
                            [x, row],
                            [0.6, 1.7, 1.0],
                            texel,
                        );
                    }
                }
            }
            assert!(wanted != base);
            let mut found = base.clone();
            base_layer.lay(channels, Encoding::Srgb, None, 0, &mut found);
            assert_eq!(found, wanted);
        }
    }

    #[test]
    fn spans_match_single_texels_bit_for_bit() {
        compare::<u8, 3>(|rng| rng.u8(..));
        compare::<u8, 4>(|rng| rng.u8(100..));
        compare::<u16, 3>(|rng| rng.u16(..));
        compare::<f32, 3>(fastrand::Rng::f32);
    }
}
