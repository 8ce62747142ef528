//! The colour of irises in a texture.

use uvgraft::color::{lab, lab_distance, luma};
use uvgraft::statistics::{median_color, order_statistic};

use super::gaze::Gaze;
use crate::paint::texel::Color;

/// Minimum number of texels for a colour.
const FEWEST: usize = 12;

/// Colour differences (ΔE of CIE 1976): minimum between an iris and the white around it, below
/// which the capture is too blurred to use, and minimum between two eyes that differ on purpose,
/// rounded up from the effect of the lids' shadows.
const CLEAR: f32 = 9.0;
const DIFFERENT: f32 = 22.0;

/// The most common colour, for captures that show none.
const BROWN: Color = [0.33, 0.21, 0.13];

/// The iris of an eye.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iris {
    /// Its colour, sRGB, 1.0 for white.
    pub color: [f32; 3],
    /// Whether the texture shows its colour; otherwise it is brown.
    pub is_found: bool,
}

/// Texels of one eye: distance from the gaze axis in iris radii, and colour in sRGB.
pub(super) type Samples = Vec<(f32, Color)>;

pub(super) fn sample(gaze: &Gaze, point: glam::Vec3, color: Color) -> (f32, Color) {
    (gaze.around(point).0, color)
}

/// The colours of the irises: one for both eyes unless they clearly differ.
pub(super) fn irises(eyes: &[Samples]) -> Vec<Iris> {
    let found: Vec<Option<Color>> = eyes.iter().map(color).collect();
    let known: Vec<Color> = found.iter().flatten().copied().collect();
    let brown = Iris { color: BROWN, is_found: false };
    match *known {
        [] => vec![brown; eyes.len()],
        [a, b] if difference(a, b) > DIFFERENT => found
            .iter()
            .map(|color| color.map_or(brown, |color| Iris { color, is_found: true }))
            .collect(),
        _ => {
            let mean = std::array::from_fn(|k| {
                known.iter().map(|c| c[k]).sum::<f32>() / known.len() as f32
            });
            vec![Iris { color: mean, is_found: true }; eyes.len()]
        }
    }
}

/// The median of a ring inside the iris, leaving out the brightest texels, which are
/// highlights, and the darkest, which are the edge of the pupil and lashes. `None` if
/// the ring does not contrast with the white.
fn color(samples: &Samples) -> Option<Color> {
    let ring = |from: f32, to: f32| -> Vec<Color> {
        let within = samples.iter().filter(|(distance, _)| (from..to).contains(distance));
        within.map(|&(_, color)| color).collect()
    };
    let (mut iris, mut white) = (ring(0.45, 0.85), ring(1.15, 1.6));
    if iris.len() < FEWEST || white.len() < FEWEST {
        return None;
    }
    for colors in [&mut iris, &mut white] {
        colors.sort_by(|&a, &b| luma(a).total_cmp(&luma(b)));
    }
    let iris = median_color(iris[iris.len() / 8..iris.len() - iris.len() / 4].iter().copied())?;
    let white = median_color(white[white.len() / 4..].iter().copied())?;
    (difference(iris, white) > CLEAR && luma(iris) < luma(white)).then_some(iris)
}

/// Luma of the white of the eyes in a texture: captures have lighting baked in, and a painted
/// sclera must not glow in a dark one. It is the upper quartile of the lighter eye, which leaves
/// out lashes and the lids' shadows; `None` if too little is visible.
pub(super) fn white(eyes: &[Samples]) -> Option<f32> {
    let of = |samples: &Samples| {
        let ring = samples.iter().filter(|(distance, _)| (1.15..1.8).contains(distance));
        let lumas: Vec<f32> = ring.map(|&(_, color)| luma(color)).collect();
        (lumas.len() >= FEWEST).then(|| order_statistic(lumas, |count| count * 3 / 4))?
    };
    eyes.iter().filter_map(of).reduce(f32::max)
}

/// CIE 1976 colour difference.
fn difference(a: Color, b: Color) -> f32 {
    lab_distance(lab(a), lab(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Color = [0.85, 0.82, 0.8];

    /// A ring of colour around a pupil, with highlights on a tenth of it.
    fn eye(color: Color) -> Samples {
        let at = |k: usize| {
            let distance = k as f32 / 500.0;
            let color = match distance {
                _ if k.is_multiple_of(10) => [1.0; 3],
                d if d < 0.4 => [0.03; 3],
                d if d < 1.0 => color,
                _ => WHITE,
            };
            (distance, color)
        };
        (0..900).map(at).collect()
    }

    #[test]
    fn the_colour_is_measured_between_pupil_and_highlights() {
        let green = [0.35, 0.45, 0.3];
        let found = irises(&[eye(green), eye(green)]);
        assert!(
            found.iter().all(|iris| iris.is_found && difference(iris.color, green) < 1.0),
            "{found:?}"
        );
    }

    #[test]
    fn eyes_share_a_colour_unless_they_clearly_differ() {
        let (blue, bluer, brown) = ([0.35, 0.45, 0.6], [0.33, 0.44, 0.62], [0.35, 0.22, 0.12]);
        let found = irises(&[eye(blue), eye(bluer)]);
        assert_eq!(found[0], found[1]);
        let found = irises(&[eye(blue), eye(brown)]);
        assert!(difference(found[0].color, blue) < 1.0 && difference(found[1].color, brown) < 1.0);
    }

    #[test]
    fn cloudy_eyes_are_brown_unless_the_other_one_is_clear() {
        let cloudy = [0.83, 0.8, 0.79];
        assert!(irises(&[eye(cloudy), eye(cloudy)]).iter().all(|iris| !iris.is_found));
        let green = [0.35, 0.45, 0.3];
        let found = irises(&[eye(cloudy), eye(green)]);
        assert!(found[0].is_found && found[0] == found[1]);
        assert!(!irises(&[Vec::new()])[0].is_found);
    }
}
