//! A base whose skin takes on another tone, before anything is laid over it.

use fearless_simd::{Level, Simd};

use crate::color::{Encoding, linear_from_srgb, srgb_from_linear};
use crate::map::SamplingMap;
use crate::simd::dispatch;
use crate::texture::{Channels, Value};
use crate::threads::for_each_chunk;

use super::compose::Finish;
use super::field::{Line, Slope};
use super::tone::{Matrix, toned};
use crate::skin::SkinModel;

/// Texels that are worked on together.
const STRETCH: usize = 16;

/// What is done to the texels of a base.
#[derive(Debug, Clone)]
pub(crate) struct Undercoat<'a> {
    /// All of the base's layout.
    pub map: &'a SamplingMap,
    /// For each patch, the gains of red, green and blue; empty for none.
    pub gains: &'a [[Slope; 3]],
    /// What is done to colours before that.
    pub matrix: Option<Matrix>,
    /// Which texels change.
    pub skin: Skin<'a>,
}

/// What is skin in a base.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Skin<'a> {
    /// What looks like it.
    Model(SkinModel),
    /// For each texel, 255 if it is.
    Mask(&'a [u8]),
}

impl Undercoat<'_> {
    /// Changes the rows of a base from `first_row` on. Grey textures are left as they are where their
    /// lightness is not that of skin.
    ///
    /// - `hiding`: what is laid over it, if that is opaque; what it hides need not change.
    pub fn lay<T: Value>(
        &self,
        channels: Channels,
        encoding: Encoding,
        hiding: Option<&Finish<'_>>,
        first_row: u32,
        rows: &mut [T],
    ) {
        let count = channels.count();
        let width = self.map.size().width as usize * count;
        let level = Level::new();
        for_each_chunk(rows, width, |index, texels| {
            let row = first_row + index as u32;
            let mut hidden = Vec::new();
            if let Some(finish) = hiding {
                finish.push_full(row, &mut hidden);
            }
            let mut hidden = hidden.iter().peekable();
            for run in self.map.row(row) {
                let end = run.x + run.len;
                while hidden.next_if(|hidden| hidden.end < end).is_some() {}
                if hidden.peek().is_some_and(|hidden| hidden.start <= run.x && end <= hidden.end) {
                    continue;
                }
                let gains = self
                    .gains
                    .get(run.patch as usize)
                    .map_or([Line::ONE; 3], |gains| [0, 1, 2].map(|k| gains[k].line(run.x, row)));
                let first = row as usize * self.map.size().width as usize + run.x as usize;
                let part = run.x as usize * count..(run.x + run.len) as usize * count;
                let texels = &mut texels[part];
                if encoding == Encoding::Linear || self.matrix.is_some() || !channels.has_color() {
                    for (k, texel) in (0..).zip(texels.chunks_exact_mut(count)) {
                        let gains = gains.map(|gain| gain.at(k));
                        self.texel(channels, encoding, first + k as usize, gains, texel);
                    }
                } else if count == 3 {
                    dispatch!(level, simd => self.stretches::<_, T, 3>(simd, first, gains, texels));
                } else {
                    dispatch!(level, simd => self.stretches::<_, T, 4>(simd, first, gains, texels));
                }
            }
        });
    }

    /// What [`Undercoat::texel`] does to sRGB colours without a matrix, some texels at a time.
    #[inline(always)]
    fn stretches<S: Simd, T: Value, const C: usize>(
        &self,
        _: S,
        first: usize,
        gains: [Line; 3],
        texels: &mut [T],
    ) {
        let one = T::ONE.to_level();
        for (index, texels) in texels.chunks_mut(STRETCH * C).enumerate() {
            let start = index * STRETCH;
            let count = texels.len() / C;
            let mut rgb = [[0.0_f32; STRETCH]; 3];
            for k in 0..count {
                for channel in 0..3 {
                    rgb[channel][k] = texels[k * C + channel].to_level() / one;
                }
            }
            let mut weights = [0.0_f32; STRETCH];
            match &self.skin {
                Skin::Model(model) => {
                    for k in 0..STRETCH {
                        weights[k] = model.weight([rgb[0][k], rgb[1][k], rgb[2][k]]);
                    }
                }
                Skin::Mask(mask) => {
                    let mask = &mask[first + start..][..count];
                    for (weight, &mask) in weights.iter_mut().zip(mask) {
                        *weight = f32::from(mask) / 255.0;
                    }
                }
            }
            for channel in 0..3 {
                for k in 0..STRETCH {
                    let (value, gain) = (rgb[channel][k], gains[channel].at((start + k) as u32));
                    let toned = toned(value, gain, 1.0);
                    // Written as it is asked: a weight that is no number is none.
                    let weight = if weights[k] > 0.0 { weights[k] } else { 0.0 };
                    rgb[channel][k] = (value + (toned - value) * weight) * one;
                }
            }
            for k in 0..count {
                for channel in 0..3 {
                    texels[k * C + channel] = T::from_level(rgb[channel][k]);
                }
            }
        }
    }

    /// What is done to one texel: the specification.
    #[inline(always)]
    fn texel<T: Value>(
        &self,
        channels: Channels,
        encoding: Encoding,
        index: usize,
        gains: [f32; 3],
        texel: &mut [T],
    ) {
        let of = |channel: usize| if channels.has_color() { texel[channel] } else { texel[0] };
        let is_light = encoding == Encoding::Linear;
        let stored = |value: f32| if is_light { srgb_from_linear(value) } else { value };
        let rgb = [0, 1, 2].map(|channel| stored(of(channel).to_unit()));
        let weight = match self.skin {
            Skin::Model(model) => model.weight(rgb),
            Skin::Mask(mask) => f32::from(mask[index]) / 255.0,
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
    use super::*;
    use crate::map::MapOptions;
    use crate::mesh::Mesh;
    use crate::texture::Size;

    fn compare<T: Value + std::fmt::Debug, const C: usize>(value: fn(&mut fastrand::Rng) -> T) {
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        let mesh = Mesh::from_triangles(vec![[0.0; 3]; 3], uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap();
        let size = Size::square(50);
        let map = SamplingMap::of_layout(&mesh, size, &MapOptions::with_gutter(0));
        let mut rng = fastrand::Rng::with_seed(9);
        let mask: Vec<u8> = (0..size.texels()).map(|_| rng.u8(..)).collect();
        let seeds: Vec<[f32; 3]> =
            (0..40).map(|_| [0.7, 0.5, 0.4].map(|mean| mean + 0.02 * rng.f32())).collect();
        let model = SkinModel::new(&seeds, &[]).unwrap();
        let gains = vec![[0.6, 1.7, 1.0].map(Slope::constant); map.patches().len()];
        let base: Vec<T> = (0..size.texels() * C).map(|_| value(&mut rng)).collect();
        let channels = if C == 4 { Channels::Rgba } else { Channels::Rgb };
        for skin in [Skin::Model(model), Skin::Mask(&mask)] {
            let undercoat = Undercoat { map: &map, gains: &gains, matrix: None, skin };
            let mut wanted = base.clone();
            for row in 0..size.height {
                for run in map.row(row) {
                    for x in run.x..run.x + run.len {
                        let index = (row * size.width + x) as usize;
                        let texel = &mut wanted[index * C..][..C];
                        undercoat.texel(channels, Encoding::Srgb, index, [0.6, 1.7, 1.0], texel);
                    }
                }
            }
            assert!(wanted != base);
            let mut found = base.clone();
            undercoat.lay(channels, Encoding::Srgb, None, 0, &mut found);
            assert_eq!(found, wanted);
        }
    }

    #[test]
    fn stretches_equal_texels_to_the_bit() {
        compare::<u8, 3>(|rng| rng.u8(..));
        compare::<u8, 4>(|rng| rng.u8(100..));
        compare::<u16, 3>(|rng| rng.u16(..));
        compare::<f32, 3>(fastrand::Rng::f32);
    }
}
