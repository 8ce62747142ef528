//! Which parts of a source a map reads, and how far beside a region.

use std::ops::Range;

use super::position::in_texels;
use super::{Path, Paths, footprint};
use crate::bits;
use crate::filter::Filter;
use crate::map::{FAR_PX, Patch, SamplingMap, Tiles, corners_px};
use crate::mesh::Mesh;
use crate::texture::Size;
use crate::threads::map_indices;

/// What a map reads of a source of one size.
pub(crate) struct Reads {
    /// All tiles that some sample's window touches, and some more.
    pub tiles: Tiles,
    /// The patches that texels have.
    patches: Vec<u64>,
}

impl Reads {
    /// - `target`: the mesh that the map fills.
    pub fn new(map: &SamplingMap, target: &Mesh, paths: &Paths) -> Self {
        const PIECES: usize = 16;
        /// Patches that read farther around their triangle are looked at run by run.
        const TAME_PX: f64 = 32.0;
        let source = paths.source;
        // No texel is farther from the triangle that it takes its position from than what the map
        // carries on, so its position is no farther from the triangle's corners' than this.
        let margin = |path: &Path, axis: usize| {
            let [x, y] = path.slope[axis].map(in_texels);
            map.carried_px() * x.hypot(y) + in_texels(path.reach[axis])
        };
        let linked = map.linked_patches();
        let boxes = map_indices(linked.len(), |index| {
            let (path, patch) = (&paths.patches[index], &linked[index]);
            // What a part's map is beyond the part may be far off.
            if patch.is_part {
                return None;
            }
            let corners = corners_px(target, patch.face as usize, map.size());
            let is_near = corners.as_flattened().iter().all(|px| px.abs() < FAR_PX);
            let is_tame = is_near && (0..2).all(|axis| margin(path, axis) < TAME_PX);
            is_tame.then(|| {
                let corners = corners.map(|corner| patch.src_uv_from_tgt_px.at(corner));
                [(0, source.width), (1, source.height)].map(|(axis, count)| {
                    let corners = corners.map(|corner| corner[axis] * f64::from(count));
                    around(corners, margin(path, axis), count)
                })
            })
        });
        let mut is_tame = vec![false; pieces(map)];
        for (found, patch) in boxes.iter().zip(linked) {
            is_tame[patch.piece as usize] = found.is_some();
        }
        let height = map.size().height as usize;
        let pieces = map_indices(PIECES, |piece| {
            let mut tiles = Tiles::none(source);
            let mut patches = vec![0; bits::words(map.patches().len() as u32)];
            for row in height * piece / PIECES..height * (piece + 1) / PIECES {
                for &run in map.row(row as u32) {
                    bits::insert(&mut patches, run.patch);
                    if is_tame[map.patches()[run.patch as usize].piece as usize] {
                        continue;
                    }
                    let walk = paths.walk(row as u32, run);
                    let ends = [walk.centre(0), walk.centre(run.len - 1)];
                    let [columns, rows] =
                        [(0, source.width), (1, source.height)].map(|(axis, count)| {
                            let ends = ends.map(|at| in_texels(at[axis]));
                            around(ends, in_texels(walk.reach()[axis]), count)
                        });
                    tiles.insert(&columns, &rows);
                }
            }
            (tiles, patches)
        });
        let mut all = Self {
            tiles: Tiles::none(source),
            patches: vec![0; bits::words(map.patches().len() as u32)],
        };
        for (tiles, patches) in pieces {
            all.tiles.unite(&tiles);
            bits::unite(&mut all.patches, &patches);
        }
        let owns = all.owners(map);
        for (found, patch) in boxes.iter().zip(linked) {
            if let Some([columns, rows]) = found.as_ref().filter(|_| owns[patch.piece as usize]) {
                all.tiles.insert(columns, rows);
            }
        }
        all
    }

    /// For each piece, whether any texel takes its position from it.
    fn owners(&self, map: &SamplingMap) -> Vec<bool> {
        let mut owns = vec![false; pieces(map)];
        for patch in bits::numbers(&self.patches) {
            owns[map.patches()[patch as usize].piece as usize] = true;
        }
        owns
    }

    /// How many texels beyond the edge of a region a transfer may read, where `patches` lie at it.
    pub fn reach(&self, map: &SamplingMap, patches: &[Patch], source: Size, filter: Filter) -> u32 {
        /// Reached by slivers alone, which see a texel or two of background then.
        const MOST: f64 = 64.0;
        let scale = [f64::from(source.width), f64::from(source.height)];
        // A piece too thin to own a texel is no reason to reach far.
        let owns = self.owners(map);
        let beside_taps = patches
            .iter()
            .filter(|patch| owns[patch.piece as usize])
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

/// The number of the last piece that has a patch, and one more.
fn pieces(map: &SamplingMap) -> usize {
    map.linked_patches().last().map_or(0, |patch| patch.piece as usize + 1)
}

/// The texels on one axis within `margin` of some positions; beyond the texture's edge its edge is
/// read.
fn around<const N: usize>(positions: [f64; N], margin: f64, count: u32) -> Range<u32> {
    let positions = positions.map(|position| position.clamp(0.0, f64::from(count)));
    let first = positions.into_iter().fold(f64::INFINITY, f64::min) - margin;
    let last = positions.into_iter().fold(0.0, f64::max) + margin;
    // Casts saturate.
    (first as u32).min(count - 1)..(last as u32).min(count - 1) + 1
}
