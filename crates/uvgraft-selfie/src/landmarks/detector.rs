//! The short-range face detector on one square crop.
//!
//! The network sees 128 × 128 texels and gives a score, a box and six keypoints for each of 896
//! anchors: two for each cell of a 16 × 16 grid and six for each cell of an 8 × 8 grid.
//!
//! # Source
//! Bazarevsky et al., "BlazeFace: Sub-millisecond Neural Face Detection on Mobile GPUs", 2019, also for
//! averaging overlapping boxes instead of dropping all but one.

use uvgraft::sampler::Beyond;

use super::photo_pyramid::{Crop, PhotoPyramid};
use crate::network::{Network, NetworkError};

/// Texels of the network's input along a side, as it was trained.
const RESOLUTION: usize = 128;

/// Cells along a side of a grid, and anchors in each cell.
const GRIDS: [(usize, usize); 2] = [(16, 2), (8, 6)];

const ANCHORS: usize = 896;

/// Values for each anchor: a box and six keypoints.
const VALUES: usize = 16;

/// Boxes that share more than this part of their union show the same face.
const SAME_FACE: f64 = 0.3;

/// A face in a crop both sides of which have length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Detection {
    /// `0.0..=1.0`
    pub(super) score: f64,
    pub(super) center: [f64; 2],
    pub(super) size: [f64; 2],
    /// The right eye (on the left of the picture), the left eye, the nose, the mouth, the right and
    /// the left ear.
    pub(super) keypoints: [[f64; 2]; 6],
}

/// Checks that a network is a detector of this kind.
pub(super) fn check(network: &Network) -> Result<(), NetworkError> {
    network.check_lengths(RESOLUTION * RESOLUTION * 3, [ANCHORS, ANCHORS * VALUES])
}

/// The faces in a crop with at least a score, the best first.
pub(super) fn detect(
    network: &Network,
    picture: &PhotoPyramid<'_>,
    crop: &Crop,
    least_score: f64,
) -> Vec<Detection> {
    let colors = picture.crop(crop, RESOLUTION, Beyond::Zero);
    let input: Vec<f32> = colors.as_flattened().iter().map(|value| value * 2.0 - 1.0).collect();
    // The network was checked when it was loaded.
    let Ok(mut outputs) = network.run(&input) else { return Vec::new() };
    outputs.sort_unstable_by_key(Vec::len);
    let [scores, values] = &outputs[..] else { return Vec::new() };
    merge(decode(scores, values, least_score))
}

/// The centres of the cells that anchors belong to.
fn anchors() -> impl Iterator<Item = [f64; 2]> {
    GRIDS.into_iter().flat_map(|(side, each)| {
        (0..side * side * each).map(move |index| {
            let cell = index / each;
            [cell % side, cell / side].map(|at| (at as f64 + 0.5) / side as f64)
        })
    })
}

fn decode(scores: &[f32], values: &[f32], least_score: f64) -> Vec<Detection> {
    let (values, _) = values.as_chunks::<VALUES>();
    let decoded = scores.iter().zip(values).zip(anchors()).map(|((&score, values), anchor)| {
        let pair = |index: usize| {
            [0, 1].map(|axis| f64::from(values[2 * index + axis]) / RESOLUTION as f64)
        };
        let placed = |index: usize| {
            let offset = pair(index);
            [anchor[0] + offset[0], anchor[1] + offset[1]]
        };
        Detection {
            score: logistic(score),
            center: placed(0),
            size: pair(1),
            keypoints: std::array::from_fn(|index| placed(index + 2)),
        }
    });
    decoded.filter(|found| found.score >= least_score).collect()
}

/// `1 / (1 + e^-x)`
pub(super) fn logistic(value: f32) -> f64 {
    1.0 / (1.0 + (-f64::from(value)).exp())
}

/// One detection for each face: the best and all that overlap it, averaged by their scores.
fn merge(mut found: Vec<Detection>) -> Vec<Detection> {
    found.sort_by(|a, b| b.score.total_cmp(&a.score));
    let mut merged = Vec::new();
    while let Some(&best) = found.first() {
        let (same, others): (Vec<_>, Vec<_>) =
            found.iter().partition(|other| overlap(&best, other) > SAME_FACE);
        // A degenerate box does not even overlap itself.
        found = if same.is_empty() { found.split_off(1) } else { others };
        if same.is_empty() {
            continue;
        }
        let sum: f64 = same.iter().map(|found| found.score).sum();
        let mean = |point: &dyn Fn(&Detection) -> [f64; 2]| {
            [0, 1].map(|axis| {
                same.iter().map(|found| found.score * point(found)[axis]).sum::<f64>() / sum
            })
        };
        merged.push(Detection {
            score: best.score,
            center: mean(&|found| found.center),
            size: mean(&|found| found.size),
            keypoints: std::array::from_fn(|index| mean(&|found| found.keypoints[index])),
        });
    }
    merged
}

/// The intersection of two boxes as a part of their union.
pub(super) fn overlap(a: &Detection, b: &Detection) -> f64 {
    let shared = [0, 1].map(|axis| {
        let low = (a.center[axis] - a.size[axis] / 2.0).max(b.center[axis] - b.size[axis] / 2.0);
        let high = (a.center[axis] + a.size[axis] / 2.0).min(b.center[axis] + b.size[axis] / 2.0);
        (high - low).max(0.0)
    });
    let intersection = shared[0] * shared[1];
    let union = a.size[0] * a.size[1] + b.size[0] * b.size[1] - intersection;
    if union > 0.0 { intersection / union } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, side: f64, score: f64) -> Detection {
        Detection { score, center: [x, 0.5], size: [side; 2], keypoints: [[x, 0.5]; 6] }
    }

    #[test]
    fn anchors_are_the_cells_of_both_grids() {
        let anchors: Vec<_> = anchors().collect();
        assert_eq!(anchors.len(), ANCHORS);
        assert_eq!(anchors[0], [1.0 / 32.0; 2]);
        assert_eq!(anchors[1], anchors[0]);
        assert_eq!(anchors[2], [3.0 / 32.0, 1.0 / 32.0]);
        assert_eq!(anchors[32], [1.0 / 32.0, 3.0 / 32.0]);
        assert_eq!(anchors[512], [1.0 / 16.0; 2]);
        assert_eq!(anchors[895], [15.0 / 16.0; 2]);
    }

    #[test]
    fn values_are_relative_to_anchors_in_texels() {
        let (mut scores, mut values) = (vec![-9.0; ANCHORS], vec![0.0; ANCHORS * VALUES]);
        scores[2] = 2.0;
        let wanted: Vec<f32> = (0..16).map(|value| value as f32).collect();
        values[2 * VALUES..3 * VALUES].copy_from_slice(&wanted);
        let found = decode(&scores, &values, 0.5);
        let [found] = found[..] else { panic!("{found:?}") };
        assert!((found.score - 0.880_797).abs() < 1e-6);
        assert_eq!(found.center, [12.0 / 128.0, 5.0 / 128.0]);
        assert_eq!(found.size, [2.0 / 128.0, 3.0 / 128.0]);
        assert_eq!(found.keypoints[5], [(12.0 + 14.0) / 128.0, (4.0 + 15.0) / 128.0]);
    }

    #[test]
    fn overlapping_boxes_are_one_face() {
        let merged = merge(vec![at(0.2, 0.2, 0.6), at(0.8, 0.2, 0.7), at(0.22, 0.2, 0.9)]);
        assert_eq!(merged.len(), 2);
        assert_eq!((merged[0].score, merged[1].score), (0.9, 0.7));
        assert!((merged[0].center[0] - (0.2 * 0.6 + 0.22 * 0.9) / 1.5).abs() < 1e-12);
        assert!((merged[1].center[0] - 0.8).abs() < 1e-12);
        assert_eq!(merge(vec![at(0.2, 0.0, 0.6), at(0.2, f64::NAN, 0.6)]), []);
    }
}
