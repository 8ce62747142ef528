//! The 468 landmarks of one face.
//!
//! The network sees the face upright in 192 × 192 texels. The first crop comes from the detector; the
//! landmarks found in it make a better one, in which they are found again. Where they are to be
//! measured by, the mean over several crops is steadier.
//!
//! # Source
//! Kartynnik et al., "Real-time Facial Surface Geometry from Monocular Video on Mobile GPUs", 2019, and
//! the graph `face_landmark` of MediaPipe for the margins of crops.

use crate::face_networks::LANDMARKS;
use uvgraft::sampler::Beyond;
use uvgraft::threads;

use super::FoundFace;
use super::detector::logistic;
use super::photo_pyramid::{Crop, PhotoPyramid};
use super::regions::{LEFT_EYE_OUTER, RIGHT_EYE_OUTER};
use crate::network::{Network, NetworkError};

/// Texels of the network's input along a side, as it was trained.
const RESOLUTION: usize = 192;

/// Side of a crop, in sides of the box around a face.
const MARGIN: f64 = 1.5;

/// How crops differ from that around the landmarks: moved, as shares of its side; scaled; and turned,
/// in radians. Twice as many change nothing.
const JITTER: [[f64; 4]; 5] = [
    [0.0, 0.0, 1.0, 0.0],
    [0.02, 0.02, 0.95, 0.05],
    [-0.02, 0.02, 1.05, -0.05],
    [0.02, -0.02, 1.1, 0.03],
    [-0.02, -0.02, 0.9, -0.03],
];

/// Checks that a network is one for landmarks.
pub(super) fn check(network: &Network) -> Result<(), NetworkError> {
    network.check_lengths(RESOLUTION * RESOLUTION * 3, [1, LANDMARKS * 3])
}

/// Landmarks in pixels, and the score of their crop.
pub(super) fn find(
    network: &Network,
    picture: &PhotoPyramid<'_>,
    face: &FoundFace,
) -> (Vec<[f64; 3]>, f64) {
    let first = in_crop(network, picture, &first_crop(face), None);
    in_crop(network, picture, &crop_around(&first.0), None)
}

/// Landmarks as the mean of those found in several crops, half of them mirrored: a single crop is off
/// by a pixel of the network's input, and to one side.
///
/// - `points`: as [`find`] finds them.
/// - `mirror_partners`: for each landmark, that of the other side of the face.
pub(super) fn averaged(
    network: &Network,
    picture: &PhotoPyramid<'_>,
    points: &[[f64; 3]],
    mirror_partners: &[usize],
) -> Vec<[f64; 3]> {
    let middle = crop_around(points);
    let crops: Vec<(Crop, bool)> = JITTER
        .into_iter()
        .flat_map(|[x, y, scale, turn]| {
            let center = middle.position([0.5 + x, 0.5 + y]);
            let crop = Crop { center, side: middle.side * scale, angle: middle.angle + turn };
            [(crop, false), (crop, true)]
        })
        .collect();
    let found = threads::map_indices(crops.len(), |index| {
        let (crop, is_mirrored) = &crops[index];
        in_crop(network, picture, crop, is_mirrored.then_some(mirror_partners)).0
    });
    let count = found.len() as f64;
    (0..points.len())
        .map(|at| std::array::from_fn(|k| found.iter().map(|p| p[at][k]).sum::<f64>() / count))
        .collect()
}

fn first_crop(face: &FoundFace) -> Crop {
    Crop { center: face.center, side: face.size(), angle: face.eye_angle() }.scaled(MARGIN)
}

/// The upright square around landmarks, with a margin.
fn crop_around(points: &[[f64; 3]]) -> Crop {
    let (right, left) = (points[RIGHT_EYE_OUTER], points[LEFT_EYE_OUTER]);
    let angle = (left[1] - right[1]).atan2(left[0] - right[0]);
    let (sin, cos) = angle.sin_cos();
    // In axes along and across the face, so that the box does not depend on how it is turned.
    let along = |point: &[f64; 3]| cos * point[0] + sin * point[1];
    let across = |point: &[f64; 3]| cos * point[1] - sin * point[0];
    let range = |values: &dyn Fn(&[f64; 3]) -> f64| {
        points.iter().map(values).fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
            [low.min(value), high.max(value)]
        })
    };
    let [[left, right], [top, bottom]] = [range(&along), range(&across)];
    let (x, y) = ((left + right) / 2.0, (top + bottom) / 2.0);
    let center = [cos * x - sin * y, sin * x + cos * y];
    Crop { center, side: MARGIN * (right - left).max(bottom - top), angle }
}

/// Landmarks in a crop, in pixels of the photograph, and their score.
///
/// - `mirror_partners`: if the network is to see it mirrored: for each landmark, that of the other side.
fn in_crop(
    network: &Network,
    picture: &PhotoPyramid<'_>,
    crop: &Crop,
    mirror_partners: Option<&[usize]>,
) -> (Vec<[f64; 3]>, f64) {
    let mut colors = picture.crop(crop, RESOLUTION, Beyond::Edge);
    if mirror_partners.is_some() {
        colors.chunks_exact_mut(RESOLUTION).for_each(<[_]>::reverse);
    }
    // The network was checked when it was loaded.
    let mut outputs = network.run(colors.as_flattened()).unwrap_or_default();
    outputs.sort_unstable_by_key(Vec::len);
    let [score, points] = &outputs[..] else { return (vec![[0.0; 3]; LANDMARKS], 0.0) };
    let texels = RESOLUTION as f64;
    let points = points.as_chunks::<3>().0;
    let placed = |index: usize| {
        let [x, y, z] = points
            [mirror_partners.map_or(index, |mirror_partners| mirror_partners[index])]
        .map(|value| f64::from(value) / texels);
        let x = if mirror_partners.is_some() { 1.0 - x } else { x };
        let [x, y] = crop.position([x, y]);
        [x, y, z * crop.side]
    };
    ((0..points.len()).map(placed).collect(), logistic(score[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_spread_evenly() {
        for axis in [0, 1] {
            let mean: f64 = JITTER.iter().map(|of| of[axis]).sum();
            assert!(mean.abs() < 1e-12);
        }
        let [scale, turn] =
            [2, 3].map(|k| JITTER.iter().map(|of| of[k]).sum::<f64>() / JITTER.len() as f64);
        assert!((scale - 1.0).abs() < 0.01 && turn.abs() < 0.01);
    }

    #[test]
    fn the_crop_turns_with_the_face() {
        let upright: Vec<[f64; 3]> = (0..LANDMARKS)
            .map(|index| match index {
                RIGHT_EYE_OUTER => [-30.0, -20.0, 0.0],
                LEFT_EYE_OUTER => [30.0, -20.0, 0.0],
                _ => [(index % 7) as f64 * 10.0 - 20.0, (index % 5) as f64 * 20.0 - 40.0, 0.0],
            })
            .collect();
        let crop = crop_around(&upright);
        assert_eq!(crop, Crop { center: [5.0, 0.0], side: 120.0, angle: 0.0 });
        let turned: Vec<[f64; 3]> = upright
            .iter()
            .map(|&[x, y, z]| {
                let place = Crop { center: [500.0, 300.0], side: 2.0, angle: 2.2 };
                let [x, y] = place.position([x + 0.5, y + 0.5]);
                [x, y, z]
            })
            .collect();
        let crop = crop_around(&turned);
        assert!((crop.angle - 2.2).abs() < 1e-12);
        assert!((crop.side - 240.0).abs() < 1e-9);
        let wanted = [500.0 + 10.0 * 2.2_f64.cos(), 300.0 + 10.0 * 2.2_f64.sin()];
        assert!((0..2).all(|axis| (crop.center[axis] - wanted[axis]).abs() < 1e-9), "{crop:?}");
    }
}
