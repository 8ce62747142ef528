//! A base whose skin takes on another tone, before anything is laid over it.

use crate::color::Encoding;
use crate::map::SamplingMap;
use crate::texture::{Channels, Value};
use crate::threads::for_each_chunk;

use super::field::{Line, Slope};
use super::skin::SkinModel;
use super::tone::{Matrix, toned};
use super::toning::srgb;

/// What is done to the texels of a base.
#[derive(Debug, Clone)]
pub(crate) struct Undercoat<'a> {
    /// All of the base's layout.
    pub map: &'a SamplingMap,
    /// For each patch, the gains of red, green and blue; empty for none.
    pub gains: Vec<[Slope; 3]>,
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
    pub fn lay<T: Value>(
        &self,
        channels: Channels,
        encoding: Encoding,
        first_row: u32,
        rows: &mut [T],
    ) {
        let count = channels.count();
        let width = self.map.size().width as usize * count;
        for_each_chunk(rows, width, |index, texels| {
            let row = first_row + index as u32;
            for run in self.map.row(row) {
                let gains = self
                    .gains
                    .get(run.patch as usize)
                    .map_or([Line::ONE; 3], |gains| [0, 1, 2].map(|k| gains[k].line(run.x, row)));
                let first = row as usize * self.map.size().width as usize + run.x as usize;
                let part = run.x as usize * count..(run.x + run.len) as usize * count;
                let texels = texels[part].chunks_exact_mut(count);
                for (k, texel) in (0..).zip(texels) {
                    let gains = gains.map(|gain| gain.at(k));
                    self.texel(channels, encoding, first + k as usize, gains, texel);
                }
            }
        });
    }

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
        let rgb = [0, 1, 2].map(|channel| of(channel).to_unit());
        let weight = match self.skin {
            Skin::Model(model) => model.weight(srgb(rgb, encoding)),
            Skin::Mask(mask) => f32::from(mask[index]) / 255.0,
        };
        if weight.is_nan() || weight <= 0.0 {
            return;
        }
        let changed = self.matrix.map_or(rgb, |matrix| matrix.apply(rgb));
        let colors = if channels.has_color() { 3 } else { 1 };
        for channel in 0..colors {
            let value = toned(changed[channel], gains[channel], 1.0);
            texel[channel] = T::from_unit(rgb[channel] + (value - rgb[channel]) * weight);
        }
    }
}
