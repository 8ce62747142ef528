//! Which parts of a source a map reads, and with which of its patches.

use super::{Paths, footprint, near_texture};
use crate::bits;
use crate::filter::Filter;
use crate::map::{Patch, SamplingMap, Tiles};
use crate::texture::Size;
use crate::threads::map_indices;

/// What a map reads of a source of one size.
pub(crate) struct Reads {
    /// All tiles that some sample's window touches.
    pub tiles: Tiles,
    /// The patches that texels have.
    patches: Vec<u64>,
}

impl Reads {
    pub fn new(map: &SamplingMap, source: Size, filter: Filter) -> Self {
        const PIECES: usize = 16;
        let paths = Paths::new(map, source, filter);
        let height = map.size().height as usize;
        let none = || Self {
            tiles: Tiles::none(source),
            patches: vec![0; bits::words(map.patches().len() as u32)],
        };
        let pieces = map_indices(PIECES, |piece| {
            let mut reads = none();
            for row in height * piece / PIECES..height * (piece + 1) / PIECES {
                for &run in map.row(row as u32) {
                    bits::insert(&mut reads.patches, run.patch);
                    let walk = paths.walk(row as u32, run);
                    let ends = [walk.at(0), walk.at(run.len - 1)];
                    let range = |axis: usize, count: u32| {
                        let ends = ends.map(|end| near_texture(end[axis], count));
                        // Half a window, and one texel more than rounding can be off. Casts
                        // saturate, and beyond the texture's edge its edge is read.
                        let margin = walk.spread[axis] + filter.taps() as f64 * 0.5 + 1.0;
                        let first = (ends[0].min(ends[1]) - margin) as u32;
                        let last = (ends[0].max(ends[1]) + margin) as u32;
                        first.min(count - 1)..last.min(count - 1) + 1
                    };
                    reads.tiles.insert(&range(0, source.width), &range(1, source.height));
                }
            }
            reads
        });
        let mut all = none();
        for piece in pieces {
            all.tiles.unite(&piece.tiles);
            bits::unite(&mut all.patches, &piece.patches);
        }
        all
    }

    /// How many texels beyond the edge of a region a transfer may read, where `patches` lie at it.
    pub fn reach(&self, map: &SamplingMap, patches: &[Patch], source: Size, filter: Filter) -> u32 {
        /// Reached by slivers alone, which see a texel or two of background then.
        const MOST: f64 = 64.0;
        let scale = [f64::from(source.width), f64::from(source.height)];
        // A triangle too thin to own a texel is no reason to reach far.
        let mut owns =
            vec![
                false;
                map.patches().iter().map(|patch| patch.face as usize + 1).max().unwrap_or(0)
            ];
        for patch in bits::numbers(&self.patches) {
            owns[map.patches()[patch as usize].face as usize] = true;
        }
        let beside_taps = patches
            .iter()
            .filter(|patch| owns[patch.face as usize])
            .map(|patch| {
                let (samples, steps) = footprint(patch, scale, filter);
                let spread = |axis: usize| {
                    let [x, y] = steps[axis];
                    0.5 * f64::from(samples[axis] - 1) * x.hypot(y)
                };
                // What the gutter carries on beyond an edge, by the longer of the two axes.
                let carried = [0, 1].map(|k| {
                    (0..2).map(|axis| (patch.jacobian[k][axis] * scale[k]).powi(2)).sum::<f64>()
                });
                spread(0) + spread(1) + map.carried_px() * carried[0].max(carried[1]).sqrt()
            })
            .fold(0.0, f64::max);
        // Half the taps, and one more for the diagonal.
        (beside_taps.min(MOST) + filter.taps() as f64 / 2.0).ceil() as u32 + 1
    }
}
