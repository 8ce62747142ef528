//! The 468 landmarks of one face.
//!
//! The network sees the face upright in 192 × 192 texels. The first crop comes from the detector; the
//! landmarks found in it make a better one, in which they are found again.
//!
//! # Source
//! Kartynnik et al., "Real-time Facial Surface Geometry from Monocular Video on Mobile GPUs", 2019, and
//! the graph `face_landmark` of MediaPipe for the margins of crops.

use uvgraft_io::face_networks::LANDMARKS;

use super::FoundFace;
use super::detector::logistic;
use super::picture::{Crop, Outside, Picture};
use super::regions::{LEFT_EYE_OUTER, RIGHT_EYE_OUTER};
use crate::network::{Network, NetworkError};

/// Texels of the network's input along a side.
const RESOLUTION: usize = 192;

/// Side of a crop, in sides of the box around a face.
const MARGIN: f64 = 1.5;

/// Checks that a network is one for landmarks.
pub(super) fn check(network: &Network) -> Result<(), NetworkError> {
    network.check_lengths(RESOLUTION * RESOLUTION * 3, [1, LANDMARKS * 3])
}

/// Landmarks in pixels, and the score of their crop.
pub(super) fn find(
    network: &Network,
    picture: &Picture<'_>,
    face: &FoundFace,
) -> (Vec<[f64; 3]>, f64) {
    let first = in_crop(network, picture, &first_crop(face));
    in_crop(network, picture, &crop_around(&first.0))
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

fn in_crop(network: &Network, picture: &Picture<'_>, crop: &Crop) -> (Vec<[f64; 3]>, f64) {
    let colors = picture.crop(crop, RESOLUTION, Outside::Nearest);
    // The network was checked when it was loaded.
    let mut outputs = network.run(colors.as_flattened()).unwrap_or_default();
    outputs.sort_unstable_by_key(Vec::len);
    let [score, points] = &outputs[..] else { return (vec![[0.0; 3]; LANDMARKS], 0.0) };
    let texels = RESOLUTION as f64;
    let placed = |point: &[f32; 3]| {
        let [x, y, z] = point.map(|value| f64::from(value) / texels);
        let [x, y] = crop.position([x, y]);
        [x, y, z * crop.side]
    };
    (points.as_chunks::<3>().0.iter().map(placed).collect(), logistic(score[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

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
