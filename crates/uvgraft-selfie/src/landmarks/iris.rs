//! The iris and the lids of one eye.
//!
//! The network sees a right eye in 64 × 64 texels; left eyes are mirrored for it.
//!
//! # Source
//! Ablavatski et al., "Real-time Pupil Tracking from Monocular Video for Digital Puppetry", 2020, and
//! the graph `iris_landmark` of MediaPipe for the margins of crops.

use uvgraft::sampler::Beyond;

use super::photo_pyramid::{Crop, PhotoPyramid};
use crate::network::{Network, NetworkError};

/// Texels of the network's input along a side, as it was trained.
const RESOLUTION: usize = 64;

/// Side of a crop, in distances between the corners of the eye.
const MARGIN: f64 = 2.3;

/// Points of the lids, and then of their surroundings, that the network gives.
const CONTOUR: usize = 71;

/// Points along the edges of both lids.
const LIDS: usize = 16;

/// Landmarks at the corners of the right and the left eye, the left one in the picture first.
const CORNERS: [[usize; 2]; 2] = [[33, 133], [362, 263]];

/// One eye.
#[derive(Debug, Clone, PartialEq)]
pub struct Iris {
    /// Centre of the iris, in pixels.
    pub center: [f64; 2],
    /// Radius of the iris, in pixels.
    pub radius: f64,
    /// Four points of the iris's outline, in pixels: two across and two along the eye.
    pub outline: [[f64; 2]; 4],
    /// The edges of the lids, in pixels, as a closed curve that starts at the outer corner and runs
    /// along the lower lid to the inner corner and back along the upper one; as
    /// [`super::regions::RIGHT_EYE`] does, but more exact than those landmarks.
    pub lids: Vec<[f64; 2]>,
}

/// Checks that a network is one for irises.
pub(super) fn check(network: &Network) -> Result<(), NetworkError> {
    network.check_lengths(RESOLUTION * RESOLUTION * 3, [5 * 3, CONTOUR * 3])
}

/// The right eye (on the left of the picture) and the left one.
pub(super) fn find(
    network: &Network,
    picture: &PhotoPyramid<'_>,
    points: &[[f64; 3]],
) -> [Iris; 2] {
    [false, true].map(|is_left| {
        let [from, to] = CORNERS[usize::from(is_left)].map(|index| points[index]);
        let [x, y] = [to[0] - from[0], to[1] - from[1]];
        let crop = Crop {
            center: [f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])],
            side: MARGIN * x.hypot(y),
            angle: y.atan2(x),
        };
        in_crop(network, picture, &crop, is_left)
    })
}

fn in_crop(network: &Network, picture: &PhotoPyramid<'_>, crop: &Crop, is_mirrored: bool) -> Iris {
    let mut colors = picture.crop(crop, RESOLUTION, Beyond::Edge);
    if is_mirrored {
        colors.chunks_exact_mut(RESOLUTION).for_each(<[_]>::reverse);
    }
    // The network was checked when it was loaded.
    let mut outputs = network.run(colors.as_flattened()).unwrap_or_default();
    outputs.sort_unstable_by_key(Vec::len);
    let placed = |point: &[f32; 3]| {
        let [x, y] = [0, 1].map(|axis| f64::from(point[axis]) / RESOLUTION as f64);
        crop.position([if is_mirrored { 1.0 - x } else { x }, y])
    };
    let points = |output: usize| -> Vec<[f64; 2]> {
        let values = outputs.get(output).map_or(&[][..], |values| values.as_chunks::<3>().0);
        values.iter().map(placed).collect()
    };
    let (iris, contour) = (points(0), points(1));
    let (Some(&[center, a, b, c, d]), Some(&contour)) =
        (iris.first_chunk::<5>(), contour.first_chunk::<LIDS>())
    else {
        return Iris { center: crop.center, radius: 0.0, outline: [crop.center; 4], lids: vec![] };
    };
    let outline = [a, b, c, d];
    let distances = outline.map(|point| (point[0] - center[0]).hypot(point[1] - center[1]));
    // The lower lid from corner to corner comes first, then the upper one without the corners.
    let (lower, upper) = contour.split_at(9);
    let lids = lower.iter().chain(upper.iter().rev()).copied().collect();
    Iris { center, radius: distances.iter().sum::<f64>() / 4.0, outline, lids }
}
