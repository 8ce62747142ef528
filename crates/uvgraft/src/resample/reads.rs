//! Which parts of a source a map reads, and how far beyond a region.

use std::ops::Range;

use uvgraft_surface::bits;
use uvgraft_surface::mesh::Mesh;
use uvgraft_surface::raster::corners_px;
use uvgraft_surface::threads::map_indices;

use super::path::{Paths, footprint};
use super::position::in_texels;
use crate::filter::Filter;
use crate::map::{FAR_PX, Patch, SamplingMap, Tiles};
use crate::texture::Size;

/// The parts of a source of one size that a map reads.
pub(crate) struct Reads {
    /// All tiles that the window of any sample touches, and some more.
    pub tiles: Tiles,
    /// Bit set of the patches that have any texels.
    patches: Vec<u64>,
}

impl Reads {
    /// Finds what a map reads, at a cost per patch rather than per run where possible.
    ///
    /// A patch's texels lie within a fixed distance of its target triangle, so the bounding box of
    /// the triangle's source corners, grown by a margin, contains everything that the patch reads.
    /// Only patches with a large margin or corners far off, and pieces that are a part of a face,
    /// are traced run by run.
    ///
    /// - `target`: the mesh that the map fills; without it, all patches are traced run by run.
    pub fn new(map: &SamplingMap, target: Option<&Mesh>, paths: &Paths) -> Self {
        let boxes = boxes(map, target, paths);
        let linked = map.linked_patches();
        let mut has_box = vec![false; pieces(map)];
        for (found, patch) in boxes.iter().zip(linked) {
            has_box[patch.piece as usize] = found.is_some();
        }
        let mut all = Self::traced(map, paths, &has_box);
        let owns = all.owners(map);
        for (found, patch) in boxes.iter().zip(linked) {
            if let Some([columns, rows]) = found.as_ref().filter(|_| owns[patch.piece as usize]) {
                all.tiles.insert(columns, rows);
            }
        }
        all
    }

    /// The patches that have texels, and what the runs read of those whose piece has no box.
    fn traced(map: &SamplingMap, paths: &Paths, has_box: &[bool]) -> Self {
        /// Blocks of rows of the target, traced in parallel.
        const BLOCKS: usize = 16;
        let source = paths.source;
        let height = map.size().height as usize;
        let words = bits::words(map.patches().len() as u32);
        let none = || Self { tiles: Tiles::none(source), patches: vec![0; words] };
        let blocks = map_indices(BLOCKS, |block| {
            let mut reads = none();
            for row in height * block / BLOCKS..height * (block + 1) / BLOCKS {
                for &run in map.row(row as u32) {
                    bits::insert(&mut reads.patches, run.patch);
                    if has_box[map.patches()[run.patch as usize].piece as usize] {
                        continue;
                    }
                    let walk = paths.walk(row as u32, run);
                    let ends = [walk.centre(0), walk.centre(run.len - 1)];
                    let [columns, rows] =
                        [(0, source.width), (1, source.height)].map(|(axis, count)| {
                            let ends = ends.map(|at| in_texels(at[axis]));
                            around(ends, in_texels(walk.reach()[axis]), count)
                        });
                    reads.tiles.insert(&columns, &rows);
                }
            }
            reads
        });
        let mut all = none();
        for Self { tiles, patches } in blocks {
            all.tiles.unite(&tiles);
            bits::unite(&mut all.patches, &patches);
        }
        all
    }

    /// For each piece, whether any texel takes its source position from it.
    fn owners(&self, map: &SamplingMap) -> Vec<bool> {
        let mut owns = vec![false; pieces(map)];
        for patch in bits::members(&self.patches) {
            owns[map.patches()[patch as usize].piece as usize] = true;
        }
        owns
    }

    /// Distance, in texels, up to which a transfer may read beyond the edge of a region along
    /// which `patches` lie.
    pub fn reach(&self, map: &SamplingMap, patches: &[Patch], source: Size, filter: Filter) -> u32 {
        /// Only slivers reach farther; they pick up a texel or two of background then.
        const MAX: f64 = 64.0;
        let scale = [f64::from(source.width), f64::from(source.height)];
        // Pieces too thin to own a texel are ignored, so that they do not enlarge the reach.
        let owns = self.owners(map);
        let beside_taps = patches
            .iter()
            .filter(|patch| owns[patch.piece as usize])
            .map(|patch| {
                let (samples, steps) = footprint(patch, scale, filter, u32::MAX);
                let spread = |axis: usize| {
                    let [x, y] = steps[axis];
                    0.5 * f64::from(samples[axis] - 1) * x.hypot(y)
                };
                // Extrapolation of the gutter beyond an edge, along the longer of the two axes.
                let squared = [0, 1].map(|k| {
                    (0..2).map(|axis| (patch.jacobian[k][axis] * scale[k]).powi(2)).sum::<f64>()
                });
                spread(0) + spread(1) + map.reach_px() * squared[0].max(squared[1]).sqrt()
            })
            .fold(0.0, f64::max);
        // Half the taps, and one texel more for the diagonal.
        (beside_taps.min(MAX) + filter.taps() as f64 / 2.0).ceil() as u32 + 1
    }
}

/// For each linked patch, the columns and rows of the source around its triangle, if they hold all that
/// it reads.
fn boxes(map: &SamplingMap, target: Option<&Mesh>, paths: &Paths) -> Vec<Option<[Range<u32>; 2]>> {
    /// Patches with a larger margin around their triangle are traced run by run.
    const MAX_MARGIN_PX: f64 = 32.0;
    let source = paths.source;
    // No texel is farther from its triangle than the map extrapolates, so its source position
    // is within this distance of the bounding box of the triangle's corners.
    let margin = |patch: usize, axis: usize| {
        let [x, y] = paths.slope(patch)[axis].map(in_texels);
        map.reach_px() * x.hypot(y) + in_texels(paths.reach(patch)[axis])
    };
    let linked = map.linked_patches();
    map_indices(linked.len(), |index| {
        let patch = &linked[index];
        // The map of a part may extrapolate to positions far off at the corners of the face.
        let target = target.filter(|_| !patch.is_part)?;
        let corners = corners_px(target, patch.face as usize, map.size());
        let is_near = corners.as_flattened().iter().all(|px| px.abs() < FAR_PX);
        let has_box = is_near && (0..2).all(|axis| margin(index, axis) < MAX_MARGIN_PX);
        has_box.then(|| {
            let corners = corners.map(|corner| patch.src_uv_from_tgt_px.at(corner));
            [(0, source.width), (1, source.height)].map(|(axis, count)| {
                let corners = corners.map(|corner| corner[axis] * f64::from(count));
                around(corners, margin(index, axis), count)
            })
        })
    })
}

/// One more than the index of the last piece that has a patch.
fn pieces(map: &SamplingMap) -> usize {
    map.linked_patches().last().map_or(0, |patch| patch.piece as usize + 1)
}

/// The texels on one axis within `margin` of the bounds of some positions. Positions beyond the
/// texture are clamped, since its edge texels are read there.
fn around<const N: usize>(positions: [f64; N], margin: f64, count: u32) -> Range<u32> {
    let positions = positions.map(|position| position.clamp(0.0, f64::from(count)));
    let first = positions.into_iter().fold(f64::INFINITY, f64::min) - margin;
    let last = positions.into_iter().fold(0.0, f64::max) + margin;
    // Casts saturate.
    (first as u32).min(count - 1)..(last as u32).min(count - 1) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_around_positions_are_within_the_texture() {
        for (positions, margin, wanted) in [
            ([1.5, 3.2], 1.0, 0..5),
            ([3.2, 1.5], 0.25, 1..4),
            ([-3.0, 2.0], 1.0, 0..4),
            ([9.5, 30.0], 2.0, 7..10),
            ([20.0, 40.0], 0.5, 9..10),
            ([-9.0, -1.0], 0.5, 0..1),
        ] {
            assert_eq!(around(positions, margin, 10), wanted, "{positions:?} {margin}");
        }
    }
}
