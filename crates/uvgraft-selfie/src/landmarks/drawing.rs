//! Tells drawings from photographs, which the networks cannot do.

use uvgraft::sampler::Beyond;

use super::FoundFace;
use super::photo_pyramid::{Crop, PhotoPyramid};

/// Texels along a side in which a face is looked at.
const RESOLUTION: usize = 96;

/// Neighbours that differ by less have the same colour: half a level of 8 bits.
const SAME: f32 = 0.5 / 255.0;

/// Axes of the ellipse that is looked at, in sides of the face's box. Origin not recorded.
const ELLIPSE: [f64; 2] = [0.4, 0.45];

/// The part of a face in which neighbouring texels have the same colour. Skin in photographs has shading
/// and noise everywhere; drawings are filled with single colours.
pub(super) fn flat_part(picture: &PhotoPyramid<'_>, face: &FoundFace) -> f64 {
    let crop = Crop { center: face.center, side: face.size(), angle: face.eye_angle() };
    let colors = picture.crop(&crop, RESOLUTION, Beyond::Edge);
    let (mut flat, mut all) = (0, 0);
    for row in 0..RESOLUTION - 1 {
        for column in 0..RESOLUTION - 1 {
            let [v, u] = [row, column].map(|at| (at as f64 + 1.0) / RESOLUTION as f64 - 0.5);
            if (u / ELLIPSE[0]).powi(2) + (v / ELLIPSE[1]).powi(2) > 1.0 {
                continue;
            }
            let index = row * RESOLUTION + column;
            let is_same = |other: usize| {
                (0..3).all(|channel| (colors[other][channel] - colors[index][channel]).abs() < SAME)
            };
            all += 1;
            flat += usize::from(is_same(index + 1) && is_same(index + RESOLUTION));
        }
    }
    f64::from(u32::try_from(flat).unwrap_or(u32::MAX)) / f64::from(all)
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Encoding, Size, Texels, Texture};

    use super::*;

    #[test]
    fn areas_of_one_color_are_flat_and_shading_is_not() {
        let part = |value: &dyn Fn(u32, u32) -> f32| {
            let texels = (0..200 * 200).map(|index| value(index % 200, index / 200)).collect();
            let (channels, encoding) = (Channels::Grey, Encoding::Srgb);
            let texture = Texture::new(Size::square(200), channels, encoding, Texels::F32(texels));
            let texture = texture.unwrap();
            let face = FoundFace {
                score: 1.0,
                center: [100.0; 2],
                box_size: [120.0; 2],
                angle: 0.0,
                keypoints: [[0.0; 2]; 6],
            };
            flat_part(&PhotoPyramid::new(&texture), &face)
        };
        assert_eq!(part(&|_, _| 0.7), 1.0);
        assert_eq!(part(&|x, y| (x + y) as f32 / 400.0), 0.0);
        let half = part(&|x, _| if x < 100 { 0.7 } else { x as f32 / 200.0 });
        assert!((half - 0.5).abs() < 0.03, "{half}");
    }
}
