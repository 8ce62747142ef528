//! Maps from a source position for each texel, as other tools store them.
//!
//! Texels of a row are joined into runs as long as one affine function meets all their positions
//! within the accuracy of 32-bit floats; where nothing is affine, runs have one texel.

use std::sync::atomic::{AtomicUsize, Ordering};

use uvgraft_surface::pair::Direction;
use uvgraft_surface::threads::map_indices;

use super::rows::{BLOCK_ROWS, Draft, RowLists};
use super::{Affine, MapStats, Patch, Run, SamplingMap};
use crate::texture::{Size, Texture};

/// Why positions do not make a map.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PositionsError {
    /// A target without texels, or one larger than textures may be.
    #[error("a map must have sides from 1 to {max} texels, got {0}", max = Texture::MAX_SIDE)]
    Size(Size),
    /// Another number of positions than texels.
    #[error("a map of {size} texels must have {} positions, got {found}", size.texels())]
    Length {
        /// The target size.
        size: Size,
        /// The number of positions.
        found: usize,
    },
    /// An infinite position, or one that no texture layout has.
    #[error(
        "the position of texel ({x}, {y}) must be NaN or lie between -{max} and {max}, got \
         ({}, {})", found[0], found[1], max = SamplingMap::MAX_UV
    )]
    Position {
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// The position.
        found: [f32; 2],
    },
    /// No texel has a position.
    #[error("a map must have a position for at least one texel, got none")]
    Empty,
    /// Positions without any coherence: memory would be exhausted.
    #[error(
        "a map must consist of at most {} runs of texels with affine positions, got more",
        SamplingMap::MAX_RUNS
    )]
    Runs,
}

impl SamplingMap {
    /// Maximum absolute source coordinate in [`SamplingMap::from_positions`]: far beyond any tile.
    pub const MAX_UV: f32 = 1024.0;

    /// Maximum number of runs in [`SamplingMap::from_positions`]: as many as 4096² texels without
    /// any coherence have. They take 4 GB.
    pub const MAX_RUNS: usize = 1 << 24;

    /// The map with a given source position for each texel.
    ///
    /// - `size`: the target's size.
    /// - `src_uv`: `[height * width]` source positions (u, v) of the centres of texels, row-major
    ///   from the top; (0, 0) is the top left corner of the source, (1, 1) the bottom right one.
    ///   Texels with a NaN in their position are not covered.
    ///
    /// Positions are met within 2⁻²³, or that fraction of coordinates beyond 1. The footprints of
    /// filters are estimated from differences between neighbouring texels, of which the shorter one
    /// counts, because at a border of islands one of them leads to another island. The map has no
    /// gutter, and as it knows no triangles, all its patches have face 0.
    ///
    /// # Errors
    /// [`PositionsError`].
    pub fn from_positions(size: Size, src_uv: &[[f32; 2]]) -> Result<Self, PositionsError> {
        if size.texels() == 0 || size.width.max(size.height) > Texture::MAX_SIDE {
            return Err(PositionsError::Size(size));
        }
        if src_uv.len() != size.texels() {
            return Err(PositionsError::Length { size, found: src_uv.len() });
        }
        let grid = Grid { size, src_uv };
        let count = AtomicUsize::new(0);
        let blocks = map_indices(size.height.div_ceil(BLOCK_ROWS) as usize, |block| {
            let first = block as u32 * BLOCK_ROWS;
            grid.block(first, (first + BLOCK_ROWS).min(size.height), &count)
        });
        let (mut patches, mut rows) = (Vec::new(), Vec::with_capacity(blocks.len()));
        let mut covered = 0;
        for block in blocks {
            let (mut draft, more) = block?;
            for run in &mut draft.items {
                run.patch += patches.len() as u32;
                covered += run.len as usize;
            }
            patches.extend(more);
            rows.push(draft.block());
        }
        for (piece, patch) in (0..).zip(&mut patches) {
            patch.piece = piece;
        }
        if patches.is_empty() {
            return Err(PositionsError::Empty);
        }
        let gutter_patches = patches.len() as u32;
        let stats = MapStats { linked: covered, gutter: 0, covered, overlapping: 0 };
        let (direction, runs) = (Direction::Forward, RowLists::new(rows));
        Ok(Self { size, direction, runs, patches, gutter_patches, stats })
    }
}

/// Positions of all texels.
#[derive(Clone, Copy)]
struct Grid<'a> {
    size: Size,
    src_uv: &'a [[f32; 2]],
}

type Block = (Draft<Run>, Vec<Patch>);

impl Grid<'_> {
    /// The runs of some rows, with a patch for each, numbered from 0.
    ///
    /// - `count`: the runs of all blocks so far.
    fn block(self, first: u32, end: u32, count: &AtomicUsize) -> Result<Block, PositionsError> {
        let (mut runs, mut patches) = (Draft::new(), Vec::new());
        for y in first..end {
            let before = patches.len();
            self.row(y, &mut runs, &mut patches)?;
            runs.end_row();
            let added = patches.len() - before;
            if count.fetch_add(added, Ordering::Relaxed) + added > SamplingMap::MAX_RUNS {
                return Err(PositionsError::Runs);
            }
        }
        Ok((runs, patches))
    }

    fn row(
        self,
        y: u32,
        runs: &mut Draft<Run>,
        patches: &mut Vec<Patch>,
    ) -> Result<(), PositionsError> {
        let width = self.size.width;
        let row = &self.src_uv[(y * width) as usize..][..width as usize];
        for (x, &found) in (0..).zip(row) {
            let is_far = |value: &f32| value.abs() > SamplingMap::MAX_UV;
            if found.iter().all(|value| !value.is_nan()) && found.iter().any(is_far) {
                return Err(PositionsError::Position { x, y, found });
            }
        }
        let mut x = 0;
        while x < width {
            let Some(origin) = self.at(x, y) else {
                x += 1;
                continue;
            };
            let (len, slope) = self.run(x, y, origin);
            let jacobian = self.jacobian(x, y, len, slope);
            let src_uv_from_tgt_px = Affine {
                origin_px: [f64::from(x) + 0.5, f64::from(y) + 0.5],
                origin_uv: origin,
                jacobian: slope.map(|by_x| [by_x, 0.0]),
            };
            runs.items.push(Run { x, len, patch: patches.len() as u32 });
            // As parts of a face, they are traced run by run instead of by the face's corners.
            let (face, piece, is_part) = (0, 0, true);
            patches.push(Patch { src_uv_from_tgt_px, jacobian, face, piece, is_part });
            x += len;
        }
        Ok(())
    }

    /// The longest run from a texel on, and its step per texel: a swing filter (Elmeleegy et al.
    /// 2009). It narrows down the slopes that pass all texels so far within the tolerance.
    fn run(self, x: u32, y: u32, origin: [f64; 2]) -> (u32, [f64; 2]) {
        /// Twice the rounding error of a float up to 1: at the first texel and at another one.
        const TOLERANCE: f64 = 1.0 / (1 << 23) as f64;
        let [mut low, mut high] = [[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]];
        let (mut len, mut slope) = (1, [0.0; 2]);
        while let Some(position) = self.at(x + len, y) {
            let mut bounds = [low, high];
            for axis in 0..2 {
                let tolerance = TOLERANCE * position[axis].abs().max(origin[axis].abs()).max(1.0);
                let (step, count) = (position[axis] - origin[axis], f64::from(len));
                bounds[0][axis] = low[axis].max((step - tolerance) / count);
                bounds[1][axis] = high[axis].min((step + tolerance) / count);
            }
            if (0..2).any(|axis| bounds[0][axis] > bounds[1][axis]) {
                break;
            }
            [low, high] = bounds;
            slope = [0, 1].map(|axis| {
                let to_last = (position[axis] - origin[axis]) / f64::from(len);
                to_last.clamp(low[axis], high[axis])
            });
            len += 1;
        }
        (len, slope)
    }

    /// The estimated derivative of the source position for the texels of a run.
    fn jacobian(self, x: u32, y: u32, len: u32, slope: [f64; 2]) -> [[f64; 2]; 2] {
        let last = x + len - 1;
        let beside = || {
            [
                self.difference((x.wrapping_sub(1), y), (x, y)),
                (len > 1).then_some(slope),
                self.difference((last, y), (last + 1, y)),
            ]
        };
        // Any two texels are collinear, even on both sides of a border; three hardly ever are.
        let by_x = if len > 2 { Some(slope) } else { shortest(beside()) };
        let middle = x + len / 2;
        let by_y = shortest([
            self.difference((middle, y.wrapping_sub(1)), (middle, y)),
            self.difference((middle, y), (middle, y + 1)),
        ]);
        let [by_x, by_y] = match (by_x, by_y) {
            (Some(by_x), Some(by_y)) => [by_x, by_y],
            // Without a neighbour the footprint is taken to be square.
            (Some(only), None) | (None, Some(only)) => [only, [-only[1], only[0]]],
            (None, None) => [[0.0; 2]; 2],
        };
        [0, 1].map(|axis| [by_x[axis], by_y[axis]])
    }

    /// The difference between the positions of two texels, if both have one.
    fn difference(self, from: (u32, u32), to: (u32, u32)) -> Option<[f64; 2]> {
        let (from, to) = (self.at(from.0, from.1)?, self.at(to.0, to.1)?);
        Some([to[0] - from[0], to[1] - from[1]])
    }

    /// The position of a texel; `None` beyond the edges and if it is not covered.
    fn at(self, x: u32, y: u32) -> Option<[f64; 2]> {
        let Size { width, height } = self.size;
        if x >= width || y >= height {
            return None;
        }
        let position = self.src_uv[y as usize * width as usize + x as usize].map(f64::from);
        position.iter().all(|value| !value.is_nan()).then_some(position)
    }
}

fn shortest<const N: usize>(differences: [Option<[f64; 2]>; N]) -> Option<[f64; 2]> {
    let length = |difference: &[f64; 2]| difference[0].hypot(difference[1]);
    let by_length = |a: &[f64; 2], b: &[f64; 2]| length(a).total_cmp(&length(b));
    differences.into_iter().flatten().min_by(by_length)
}

#[cfg(test)]
mod tests {
    use uvgraft_surface::mesh::Mesh;
    use uvgraft_surface::pair::Pair;
    use uvgraft_surface::piece::Piece;

    use super::*;
    use crate::map::MapOptions;

    /// The positions of all texels of a map as 32-bit floats.
    fn positions(map: &SamplingMap) -> Vec<[f32; 2]> {
        let width = map.size().width;
        let mut positions = vec![[f32::NAN; 2]; map.size().texels()];
        for y in 0..map.size().height {
            for run in map.row(y) {
                let affine = &map.patches()[run.patch as usize].src_uv_from_tgt_px;
                for x in run.x..run.x + run.len {
                    let at = affine.at([f64::from(x) + 0.5, f64::from(y) + 0.5]);
                    positions[(y * width + x) as usize] = at.map(|value| value as f32);
                }
            }
        }
        positions
    }

    fn of_triangles(seed: u64, size: Size) -> SamplingMap {
        let mut rng = fastrand::Rng::with_seed(seed);
        let mut mesh = || {
            let uv = (0..24).map(|_| [rng.f32(), rng.f32()]).collect();
            let faces: Vec<[u32; 3]> = (0..8).map(|face| [0, 1, 2].map(|k| face * 3 + k)).collect();
            Mesh::from_triangles(vec![[0.0; 3]; 24], uv, &faces, &faces).unwrap()
        };
        let itself = (0..8).map(|face| Piece::whole(face, face, [0, 1, 2]));
        let pair = Pair::from_pieces(mesh(), mesh(), itself).unwrap();
        SamplingMap::new(&pair, Direction::Forward, size, &MapOptions::with_gutter(2))
    }

    #[test]
    fn runs_and_footprints_come_back() {
        for seed in 0..6 {
            let size = Size::new(150 + 7 * seed as u32, 97);
            let map = of_triangles(seed, size);
            let wanted = positions(&map);
            let found = SamplingMap::from_positions(size, &wanted).unwrap();
            for (wanted, found) in wanted.iter().zip(positions(&found)) {
                for (wanted, found) in wanted.iter().zip(found) {
                    let is_same = (wanted - found).abs() < 1.5e-7;
                    assert!(is_same || wanted.is_nan() && found.is_nan(), "{wanted} {found}");
                }
            }
            let covered = map.stats().linked + map.stats().gutter;
            assert_eq!(found.stats().linked, covered);
            let runs =
                |map: &SamplingMap| (0..size.height).map(|y| map.row(y).len()).sum::<usize>();
            // Borders between triangles may be found one texel late, which takes runs of two.
            assert!(runs(&found) < 2 * runs(&map), "{} {}", runs(&found), runs(&map));
            let long = (0..size.height).flat_map(|y| map.row(y).iter().map(move |run| (y, run)));
            let mut close = [0; 2];
            for (y, run) in long.filter(|(_, run)| run.len > 8 && !map.is_gutter(**run)) {
                let wanted = map.patches()[run.patch as usize].jacobian;
                let middle = run.x + run.len / 2;
                let other = found.row(y).iter().find(|other| other.x + other.len > middle).unwrap();
                let other = found.patches()[other.patch as usize].jacobian;
                let is_close = (0..4).all(|k| {
                    let [wanted, other] = [wanted, other].map(|matrix| matrix[k / 2][k % 2]);
                    (wanted - other).abs() < 1e-6 + 1e-3 * wanted.abs()
                });
                close[usize::from(is_close)] += 1;
            }
            assert!(close[1] > 20 * close[0] && close[1] > 100, "{close:?}");
        }
    }

    #[test]
    fn positions_by_hand() {
        // A step of 1/8 in u, a jump, a texel alone and a gap.
        let nan = f32::NAN;
        let row = [[0.0, 0.5], [0.125, 0.5], [0.25, 0.5], [0.75, 0.0], [nan, 0.0], [0.5, 1.0]];
        let map = SamplingMap::from_positions(Size::new(6, 1), &row).unwrap();
        let runs: Vec<[u32; 2]> = map.row(0).iter().map(|run| [run.x, run.len]).collect();
        assert_eq!(runs, [[0, 3], [3, 1], [5, 1]]);
        assert_eq!(map.patches()[0].src_uv_from_tgt_px.at([2.5, 0.5]), [0.25, 0.5]);
        assert_eq!(map.patches()[0].jacobian, [[0.125, -0.0], [0.0, 0.125]]);
        assert_eq!(map.patches()[2].jacobian, [[0.0; 2]; 2]);
        assert_eq!(map.stats().linked, 5);
    }

    #[test]
    fn footprints_of_short_runs_are_those_of_the_nearer_side() {
        let row = [0.0, 0.5, 0.6].map(|u| [u, 0.25]);
        let map = SamplingMap::from_positions(Size::new(3, 1), &row).unwrap();
        let runs: Vec<[u32; 2]> = map.row(0).iter().map(|run| [run.x, run.len]).collect();
        assert_eq!(runs, [[0, 2], [2, 1]]);
        for patch in map.patches() {
            assert!((patch.jacobian[0][0] - 0.1).abs() < 1e-6, "{:?}", patch.jacobian);
        }
    }

    #[test]
    fn straight_lines_are_one_run_however_far_from_the_origin() {
        for (first, step) in [(0.0, 1.0 / 700.0), (900.0, 1.0 / 7.0), (-1000.0, 0.3)] {
            let row: Vec<[f32; 2]> =
                (0..70).map(|k| [(first + step * f64::from(k)) as f32, first as f32]).collect();
            let map = SamplingMap::from_positions(Size::new(70, 1), &row).unwrap();
            assert_eq!(map.row(0).len(), 1, "from {first}");
        }
    }

    #[test]
    fn noise_takes_short_runs_and_keeps_its_positions() {
        let mut rng = fastrand::Rng::with_seed(4);
        let size = Size::new(70, 40);
        let noise: Vec<[f32; 2]> = (0..size.texels()).map(|_| [rng.f32(), rng.f32()]).collect();
        let map = SamplingMap::from_positions(size, &noise).unwrap();
        for (wanted, found) in noise.iter().zip(positions(&map)) {
            assert!((0..2).all(|axis| (wanted[axis] - found[axis]).abs() < 2e-7));
        }
    }

    #[test]
    fn what_is_refused() {
        let size = Size::new(2, 2);
        let make = |values: [f32; 4]| {
            SamplingMap::from_positions(size, &values.map(|u| [u, 0.5])).map(|_| ())
        };
        let nan = f32::NAN;
        assert_eq!(make([0.0, -3.0, nan, 1024.0]), Ok(()));
        assert_eq!(make([nan; 4]), Err(PositionsError::Empty));
        for bad in [f32::INFINITY, -1e30, 1025.0] {
            let found = [bad, 0.5];
            assert_eq!(
                make([0.0, 0.0, bad, 0.0]),
                Err(PositionsError::Position { x: 0, y: 1, found })
            );
        }
        let short = SamplingMap::from_positions(size, &[[0.0; 2]; 3]).map(|_| ());
        assert_eq!(short, Err(PositionsError::Length { size, found: 3 }));
        for size in [Size::new(0, 4), Size::new(1, Texture::MAX_SIDE + 1)] {
            let none = SamplingMap::from_positions(size, &[]).map(|_| ());
            assert_eq!(none, Err(PositionsError::Size(size)));
        }
    }
}
