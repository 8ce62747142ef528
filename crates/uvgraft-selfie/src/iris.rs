//! The colours of the eyes in a photograph.

use uvgraft::Texture;
use uvgraft::color::luma;
use uvgraft::statistics::{median_color, order_statistic};
use uvgraft_avatar::eyes::EyeColors;

use crate::outline::{FaceOutlines, Outline};

/// Radius of an iris, in distances between the eyes: 5.9 of 63 mm.
const RADIUS: f64 = 0.093;

/// Between the pupil and the dark ring at the edge, in radii. Origin not recorded.
const RING: [f64; 2] = [0.42, 0.85];

/// Fewest pixels of the ring.
const FEWEST: usize = 8;

/// The mean colours of both eyes as a photograph shows them; `None` if they are closed, too small, or
/// the irises hardly darker than the white.
///
/// - `unit_px`: the distance between the eyes in the photograph, in pixels.
pub(crate) fn eye_colors(
    photo: &Texture,
    outlines: &FaceOutlines,
    unit_px: f64,
) -> Option<EyeColors> {
    let found: Vec<EyeColors> =
        outlines.eyes.iter().filter_map(|eye| of_eye(photo, eye, unit_px)).collect();
    let count = found.len() as f32;
    let mean = |of: &dyn Fn(&EyeColors) -> f32| found.iter().map(of).sum::<f32>() / count;
    (!found.is_empty()).then(|| EyeColors {
        iris: std::array::from_fn(|k| mean(&|eye| eye.iris[k])),
        white: mean(&|eye| eye.white),
    })
}

fn of_eye(photo: &Texture, eye: &Outline, unit_px: f64) -> Option<EyeColors> {
    /// Pixels nearer to the lids are lashes or their shadow. 0.8 mm where eyes are 63 mm apart.
    const INSIDE: f64 = 0.012;
    let pixels: Vec<([f64; 2], [f32; 3])> = eye
        .pixels(photo.size())
        .filter(|&at| eye.depth(at, 1.0) > INSIDE * unit_px)
        .map(|at| (at, color(photo, at)))
        .collect();
    if pixels.len() < 2 * FEWEST {
        return None;
    }
    let dark = order_statistic(pixels.iter().map(|pixel| luma(pixel.1)), |count| count / 5)?;
    let darkest = || pixels.iter().filter(|pixel| luma(pixel.1) <= dark).map(|pixel| pixel.0);
    let count = darkest().count() as f64;
    let center: [f64; 2] =
        std::array::from_fn(|axis| darkest().map(|at| at[axis]).sum::<f64>() / count);
    let radius = RADIUS * unit_px;
    let within = |[from, to]: [f64; 2]| {
        pixels
            .iter()
            .filter(|(at, _)| {
                let distance = (at[0] - center[0]).hypot(at[1] - center[1]) / radius;
                (from..to).contains(&distance)
            })
            .map(|pixel| pixel.1)
            .collect::<Vec<_>>()
    };
    let mut ring = within(RING);
    if ring.len() < FEWEST {
        return None;
    }
    // Highlights are lighter than the iris, the pupil is darker.
    ring.sort_by(|a, b| luma(*a).total_cmp(&luma(*b)));
    let ring = &ring[ring.len() / 5..ring.len() - ring.len() / 4];
    let iris = median_color(ring.iter().copied())?;
    let around = within([1.2, 2.2]).into_iter().map(luma);
    // The lightest are highlights, the darker ones lashes and the lids' shadows.
    let white = order_statistic(around, |count| count * 9 / 10).unwrap_or(1.0);
    (luma(iris) < 0.85 * white).then_some(EyeColors { iris, white })
}

fn color(photo: &Texture, [x, y]: [f64; 2]) -> [f32; 3] {
    let channel = |k: usize| if photo.channels().has_color() { k } else { 0 };
    let value = |k: usize| photo.get(x as u32, y as u32, channel(k));
    let is_linear = photo.encoding() == uvgraft::Encoding::Linear;
    std::array::from_fn(|k| {
        if is_linear { uvgraft::color::srgb_from_linear(value(k)) } else { value(k) }
    })
}
