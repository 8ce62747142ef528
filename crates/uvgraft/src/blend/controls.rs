//! Per-texel controls from labels: how far each target texel takes on another tone, and how
//! much of it is transferred.

use std::sync::Arc;

use crate::filter::Filter;
use crate::formats::{Averaging, Formats};
use crate::labels::Labels;
use crate::map::{MapOptions, SamplingMap};
use crate::resampler::{MapInputs, Resampler, Source, TexelShape};
use crate::texture::Texels;

use super::selection::BlendDomain;

/// Labels, ready to be sampled at the texels of a map: they are resampled as the texture is.
#[derive(Debug)]
pub(crate) struct Controls {
    resampler: Resampler,
    labels: Source,
    /// Whether any texel is transferred less than fully.
    leaves_out: bool,
}

/// Values per texel: tone and transfer weight; 255 is full.
pub(super) const VALUES: usize = 2;

impl Controls {
    /// - `leaves_out`: whether any texel is transferred less than fully.
    pub fn new(
        domain: &BlendDomain,
        map: &Arc<SamplingMap>,
        labels: &Labels,
        leaves_out: bool,
    ) -> Self {
        let inputs = MapInputs {
            pair: domain.pair(),
            direction: domain.direction(),
            target_size: map.size(),
            map: MapOptions::default(),
        };
        let maps = (Arc::clone(map), None);
        let resampler = Resampler::new(&inputs, maps, labels.size(), Filter::Bilinear);
        let texture = labels.controls();
        let formats = Formats::new(texture.format(), texture.format(), Averaging::Encoded);
        let labels = resampler.source(&formats, texture);
        Self { resampler, labels, leaves_out }
    }

    /// Whether any texel is transferred less than fully.
    pub fn leaves_out(&self) -> bool {
        self.leaves_out
    }

    /// The controls of the texels of some rows; meaningless where the map does not reach.
    pub fn rows(&self, first_row: u32, count: u32, rows: &mut Vec<u8>) {
        let width = self.resampler.map().size().width as usize;
        rows.resize(width * VALUES * count as usize, 0);
        let shape = TexelShape { channels: VALUES, has_alpha: false, is_opaque: false };
        if let Texels::U8(labels) = self.labels.texture.texels() {
            self.resampler.fill(shape, labels, first_row, rows, |_, _| {});
        }
    }
}

/// Tone and transfer weight of a texel of a run, 0 to 1; both 1 without controls.
#[inline(always)]
pub(super) fn at(controls: &[u8], texel: usize) -> [f32; 2] {
    match controls.get(texel * VALUES..texel * VALUES + VALUES) {
        Some(&[tone, share]) => as_shares([tone, share]),
        _ => [1.0, 1.0],
    }
}

/// Controls as fractions, 0 to 1.
#[inline(always)]
pub(super) fn as_shares(values: [u8; VALUES]) -> [f32; VALUES] {
    values.map(|value| f32::from(value) * (1.0 / 255.0))
}
