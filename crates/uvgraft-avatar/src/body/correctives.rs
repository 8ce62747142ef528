//! Pose correctives: joint rotations deform the shape before it is skinned.
//!
//! Each entry of the joints' rotation matrices minus the identity is a feature, and each feature
//! moves every vertex: 486 features times 31,425 coordinates in SMPL-X, 61 MB. The kernel is
//! limited by memory bandwidth rather than arithmetic, so vertices are split into tiles whose rows
//! are contiguous in memory, features that are 0 in all frames are skipped, and several frames
//! share one pass over the data. Each coordinate is always summed in the order of the features, so
//! the result depends neither on the tiles nor on the number of frames.

use std::ops::Range;

use glam::{Mat3, Quat};
use uvgraft::threads;

/// Vertices in a tile: its rows of four features and a block's sums fit the L1 cache.
pub(super) const TILE: usize = 192;
/// Frames that share one pass over the data.
pub(super) const BLOCK: usize = 8;
/// Features added in one go, which saves loads and stores of the sums.
const AT_ONCE: usize = 4;

/// Vertex offsets for each feature, tile by tile.
#[derive(Debug, Clone)]
pub(super) struct Correctives {
    features: usize,
    tiles: Vec<Tile>,
}

#[derive(Debug, Clone)]
struct Tile {
    /// The features that move any vertex of the tile, ascending.
    features: Vec<u16>,
    /// One row of coordinates for each of these features, vertex by vertex.
    rows: Vec<f32>,
    /// Coordinates in a row.
    width: usize,
}

impl Correctives {
    /// Correctives that do nothing: rotations don't change the shape.
    ///
    /// - `vertices`, `features`: the counts of the model.
    pub(super) fn none(vertices: usize, features: usize) -> Self {
        let tile = |first: usize| {
            let width = TILE.min(vertices - first) * 3;
            Tile { features: Vec::new(), rows: Vec::new(), width }
        };
        Self { features, tiles: (0..vertices).step_by(TILE).map(tile).collect() }
    }

    /// - `offsets`: `[vertices][3][known]`, as in model files, in metres.
    /// - `known`: the features that `offsets` covers; all others move nothing.
    /// - `features`: number of features in all.
    pub(super) fn new(offsets: &[f32], known: Range<usize>, features: usize) -> Self {
        let columns = known.len();
        let tile = |offsets: &[f32]| {
            let width = offsets.len() / columns;
            let mut tile = Tile { features: Vec::new(), rows: Vec::new(), width };
            for (column, feature) in known.clone().enumerate() {
                let row = || (0..width).map(|at| offsets[at * columns + column]);
                if row().any(|offset| offset != 0.0) {
                    tile.features.push(feature as u16);
                    tile.rows.extend(row());
                }
            }
            tile
        };
        let pieces: Vec<&[f32]> = offsets.chunks(TILE * 3 * columns).collect();
        let tiles = threads::map_indices(pieces.len(), |index| tile(pieces[index]));
        Self { features, tiles }
    }

    /// Whether rotations leave the shape unchanged.
    pub(super) fn is_none(&self) -> bool {
        self.tiles.iter().all(|tile| tile.features.is_empty())
    }

    /// Corrective offsets of the vertices of a tile in several frames: offset = Σ feature · row.
    ///
    /// - `features`: for each frame, the result of [`features`].
    /// - `sums`: `[frames][vertices of the tile * 3]`, overwritten.
    pub(super) fn tile(&self, tile: usize, features: &[Vec<f32>], sums: &mut [f32]) {
        let tile = &self.tiles[tile];
        sums.fill(0.0);
        let moved = |feature: usize| features.iter().any(|frame| frame[feature] != 0.0);
        let active: Vec<(usize, &[f32])> = tile
            .features
            .iter()
            .map(|&feature| usize::from(feature))
            .zip(tile.rows.chunks_exact(tile.width))
            .filter(|&(feature, _)| moved(feature))
            .collect();
        let (groups, single) = active.as_chunks::<AT_ONCE>();
        for group in groups {
            let rows = group.map(|(_, row)| row);
            for (frame, sums) in features.iter().zip(sums.chunks_exact_mut(tile.width)) {
                add(group.map(|(feature, _)| frame[feature]), rows, sums);
            }
        }
        for &(feature, row) in single {
            for (frame, sums) in features.iter().zip(sums.chunks_exact_mut(tile.width)) {
                add([frame[feature]], [row], sums);
            }
        }
    }

    /// The specification of [`Correctives::tile`], for all vertices of one frame; never tuned.
    pub(super) fn reference(&self, features: &[f32]) -> Vec<[f32; 3]> {
        assert_eq!(features.len(), self.features, "a value for each feature");
        let mut sums = Vec::new();
        for tile in &self.tiles {
            for coordinate in 0..tile.width {
                let mut sum = 0.0;
                for (row, &feature) in tile.features.iter().enumerate() {
                    sum +=
                        features[usize::from(feature)] * tile.rows[row * tile.width + coordinate];
                }
                sums.push(sum);
            }
        }
        sums.as_chunks::<3>().0.to_vec()
    }
}

/// Adds rows times their features to the sums, in the order of the features.
fn add<const N: usize>(features: [f32; N], rows: [&[f32]; N], sums: &mut [f32]) {
    if features == [0.0; N] {
        return;
    }
    let rows = rows.map(|row| &row[..sums.len()]);
    for at in 0..sums.len() {
        let mut sum = sums[at];
        for (feature, row) in features.iter().zip(&rows) {
            sum += feature * row[at];
        }
        sums[at] = sum;
    }
}

/// The features of a pose: the rotation matrix of each joint except the root, row by
/// row, minus the identity.
pub(super) fn features(rotations: &[[f32; 4]]) -> Vec<f32> {
    let matrix = |&rotation: &[f32; 4]| {
        let turned = Mat3::from_quat(Quat::from_array(rotation).normalize()) - Mat3::IDENTITY;
        // The transposed matrix has the rows as its columns.
        turned.transpose().to_cols_array()
    };
    rotations[1..].iter().flat_map(matrix).collect()
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn rows_of_matrices_less_the_identity() {
        let quarter = Quat::from_rotation_z(FRAC_PI_2).to_array();
        let still = Quat::IDENTITY.to_array();
        let found = features(&[quarter, quarter, still]);
        // A quarter turn about z maps x to y: the matrix is [0 -1 0; 1 0 0; 0 0 1].
        let wanted = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
        assert_eq!(found[9..], [0.0; 9]);
    }

    #[test]
    fn every_block_of_frames_sums_as_the_reference_does() {
        const FEATURES: usize = 27;
        let vertices = 2 * TILE + 5;
        // Values from -0.5 to 0.5 without a visible pattern.
        let value = |at: usize| (at * 7919 % 1009) as f32 / 1009.0 - 0.5;
        // The first tile has no row for feature 4.
        let unmoved = |at: usize| at % FEATURES == 4 && at < TILE * 3 * FEATURES;
        let offset = |at: usize| if unmoved(at) { 0.0 } else { value(at) };
        let offsets: Vec<f32> = (0..vertices * 3 * FEATURES).map(offset).collect();
        let correctives = Correctives::new(&offsets, 0..FEATURES, FEATURES);
        assert_eq!(correctives.tiles[0].features.len(), FEATURES - 1);
        let feature = |at: usize| if at.is_multiple_of(3) { 0.0 } else { value(31 * at) };
        let frames: Vec<Vec<f32>> = (0..BLOCK)
            .map(|frame| (0..FEATURES).map(|at| feature(at + 10 * frame)).collect())
            .collect();
        for count in [1, 3, BLOCK] {
            for tile in 0..3 {
                let first = tile * TILE;
                let width = TILE.min(vertices - first) * 3;
                let mut sums = vec![9.0; count * width];
                correctives.tile(tile, &frames[..count], &mut sums);
                for (frame, found) in frames.iter().zip(sums.chunks(width)) {
                    let wanted = &correctives.reference(frame)[first..first + width / 3];
                    assert_eq!(found, wanted.as_flattened());
                }
            }
        }
        // With a subset of the features: as if the others were 0 in the pose.
        let some = 9..12;
        let columns = |row: &[f32]| row[some.clone()].to_vec();
        let few: Vec<f32> = offsets.chunks(FEATURES).flat_map(columns).collect();
        let few = Correctives::new(&few, some.clone(), FEATURES);
        let masked = |at: usize| if some.contains(&at) { frames[0][at] } else { 0.0 };
        let masked: Vec<f32> = (0..FEATURES).map(masked).collect();
        assert_eq!(few.reference(&frames[0]), correctives.reference(&masked));
        let none = Correctives::none(vertices, FEATURES);
        assert!(none.is_none() && !few.is_none());
        assert_eq!(none.reference(&frames[0]), vec![[0.0; 3]; vertices]);
        // One sum by hand, in the order of the file.
        let by_hand: f32 = (0..FEATURES)
            .map(|feature| frames[0][feature] * offsets[(7 * 3 + 2) * FEATURES + feature])
            .sum();
        assert!((correctives.reference(&frames[0])[7][2] - by_hand).abs() < 1e-5);
    }
}
