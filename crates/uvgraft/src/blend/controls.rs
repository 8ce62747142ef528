//! What labels say about the texels of a target: how far each takes on another tone, and how far it is carried.

use std::sync::Arc;

use crate::filter::Filter;
use crate::formats::{Averaging, Formats};
use crate::labels::Labels;
use crate::map::{MapOptions, SamplingMap};
use crate::resampler::{Resampler, Source, TexelShape, Way};
use crate::texture::Texels;

use super::selection::BlendDomain;

/// Labels, ready to be read at the texels of a map: they are carried through it as the texture is.
#[derive(Debug)]
pub(crate) struct Controls {
    resampler: Resampler,
    labels: Source,
    leaves_out: bool,
}

/// Values of a texel: its tone, and how far it is carried; 255 for wholly.
pub(super) const VALUES: usize = 2;

impl Controls {
    /// - `leaves_out`: whether anything is carried less than wholly.
    pub fn new(
        domain: &BlendDomain,
        map: &Arc<SamplingMap>,
        labels: &Labels,
        leaves_out: bool,
    ) -> Self {
        let way = Way {
            pair: domain.pair(),
            direction: domain.direction(),
            target_size: map.size(),
            map: MapOptions::default(),
        };
        let maps = (Arc::clone(map), None);
        let resampler = Resampler::new(&way, maps, labels.size(), Filter::Bilinear);
        let texture = labels.controls();
        let formats = Formats::new(texture.format(), texture.format(), Averaging::Encoded);
        let labels = resampler.source(&formats, texture);
        Self { resampler, labels, leaves_out }
    }

    /// Whether anything is carried less than wholly.
    pub fn leaves_out(&self) -> bool {
        self.leaves_out
    }

    /// The values of the texels of some rows; where the map does not reach they say nothing.
    pub fn rows(&self, first_row: u32, count: u32, rows: &mut Vec<u8>) {
        let width = self.resampler.map().size().width as usize;
        rows.resize(width * VALUES * count as usize, 0);
        let shape = TexelShape { channels: VALUES, has_opacity: false, is_opaque: false };
        if let Texels::U8(labels) = self.labels.texture.texels() {
            self.resampler.fill(shape, labels, first_row, rows, |_, _| {});
        }
    }
}

/// A texel's tone and how far it is carried, of those of a run; all of both where nothing says otherwise.
#[inline(always)]
pub(super) fn at(controls: &[u8], texel: usize) -> [f32; 2] {
    match controls.get(texel * VALUES..texel * VALUES + VALUES) {
        Some(&[tone, carried]) => as_shares([tone, carried]),
        _ => [1.0, 1.0],
    }
}

#[inline(always)]
pub(super) fn as_shares(values: [u8; VALUES]) -> [f32; VALUES] {
    values.map(|value| f32::from(value) * (1.0 / 255.0))
}
