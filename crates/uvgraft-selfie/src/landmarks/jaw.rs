//! Tells textures of heads from photographs, which the networks cannot do: in a photograph the head
//! has an outline, in a texture the skin of the jaw goes on to the neck and the ears.

use uvgraft::sampler::Beyond;

use super::photo_pyramid::{Crop, PhotoPyramid};
use super::regions::{CHIN, LEFT_SIDE, RIGHT_SIDE};

/// Landmarks on the edge of the jaw beside the chin, on the left and on the right of a picture: below
/// hair and ears, above shoulders.
const BESIDE_CHIN: [(usize, i32); 2] = [(150, -1), (379, 1)];

/// Pixels along a side of the crop that is looked at.
const RESOLUTION: i32 = 160;
/// Its side, in widths of the face. Origin not recorded.
const SIDE: f64 = 2.2;
/// From how far inside the edge to how far outside it colours are compared, in pixels of the crop: 0.08
/// and 0.36 widths of the face.
const RANGE: std::ops::RangeInclusive<i32> = -6..=26;
/// Distance between compared colours, in pixels of the crop: shading is not as sharp as an outline.
const STEP: usize = 4;
/// Brightness below which noise is not taken for an outline. Origin not recorded.
const DARK: f32 = 0.05;

/// The smaller of the largest changes of colour on the way outwards from the jaw on both sides, as a
/// share of the brightness of the skin; infinite if the jaw is at the edge of the picture.
pub(super) fn outline(picture: &PhotoPyramid<'_>, points: &[[f64; 3]]) -> f64 {
    let at = |landmark: usize| [points[landmark][0], points[landmark][1]];
    let [right, left, chin] = [RIGHT_SIDE, LEFT_SIDE, CHIN].map(at);
    let across = [left[0] - right[0], left[1] - right[1]];
    let center = [0, 1].map(|k| (left[k] + right[k] + 2.0 * chin[k]) / 4.0);
    let side = SIDE * across[0].hypot(across[1]);
    let crop = Crop { center, side, angle: across[1].atan2(across[0]) };
    let colors = picture.crop(&crop, RESOLUTION as usize, Beyond::Edge);
    let steps = BESIDE_CHIN
        .map(|(landmark, outwards)| largest_step(picture, &crop, &colors, at(landmark), outwards));
    f64::from(steps[0].max(steps[1]))
}

/// The largest change of colour on a row of a crop.
fn largest_step(
    picture: &PhotoPyramid<'_>,
    crop: &Crop,
    colors: &[[f32; 3]],
    from: [f64; 2],
    outwards: i32,
) -> f32 {
    let (sin, cos) = crop.angle.sin_cos();
    let [dx, dy] = [0, 1].map(|k| (from[k] - crop.center[k]) / crop.side);
    let index = |part: f64| ((part + 0.5) * f64::from(RESOLUTION)).floor() as i32;
    let (column, row) = (index(cos * dx + sin * dy), index(cos * dy - sin * dx));
    let size = picture.size();
    // The mean of three rows, which is less noisy.
    let color = |along: i32| {
        let column = column + outwards * along;
        let mut sum = [0.0_f32; 3];
        for row in row - 1..=row + 1 {
            let is_inside = |at: i32| (0..RESOLUTION).contains(&at);
            let place = [column, row].map(|at| (f64::from(at) + 0.5) / f64::from(RESOLUTION));
            let place = crop.position(place);
            let is_shown = (0..2).all(|k| (0.0..size[k]).contains(&place[k]));
            if !(is_inside(column) && is_inside(row) && is_shown) {
                return None;
            }
            let texel = colors[(row * RESOLUTION + column) as usize];
            (0..3).for_each(|channel| sum[channel] += texel[channel] / 3.0);
        }
        Some(sum)
    };
    let Some(path) = RANGE.map(color).collect::<Option<Vec<_>>>() else { return f32::INFINITY };
    let change = |(a, b): (&[f32; 3], &[f32; 3])| {
        (0..3).map(|channel| (a[channel] - b[channel]).abs()).fold(0.0, f32::max)
    };
    let largest = path.iter().zip(&path[STEP..]).map(change).fold(0.0, f32::max);
    largest / path[0].iter().copied().fold(DARK, f32::max)
}

#[cfg(test)]
mod tests {
    use uvgraft::{Channels, Encoding, Size, Texels, Texture};

    use super::*;

    /// A picture of 400 × 400 texels, and a face 120 wide in the middle that leans by `angle`.
    fn outline_of(angle: f64, center: f64, color: &dyn Fn([f64; 2]) -> f32) -> f64 {
        let (sin, cos) = f64::sin_cos(angle);
        let texels = (0..400 * 400)
            .map(|index| {
                let [x, y] = [index % 400, index / 400].map(|at| f64::from(at) + 0.5 - center);
                color([cos * x + sin * y, cos * y - sin * x])
            })
            .collect();
        let size = Size::square(400);
        let texture = Texture::new(size, Channels::Grey, Encoding::Srgb, Texels::F32(texels));
        let texture = texture.unwrap();
        let mut points = vec![[0.0; 3]; 468];
        for (landmark, [x, y]) in [
            (RIGHT_SIDE, [-60.0, -20.0]),
            (LEFT_SIDE, [60.0, -20.0]),
            (CHIN, [0.0, 70.0]),
            (150, [-35.0, 55.0]),
            (379, [35.0, 55.0]),
        ] {
            points[landmark] = [center + cos * x - sin * y, center + cos * y + sin * x, 0.0];
        }
        outline(&PhotoPyramid::new(&texture), &points)
    }

    #[test]
    fn heads_have_an_outline_and_textures_do_not() {
        let head = |[x, y]: [f64; 2]| x.hypot(y) < 66.0;
        for angle in [0.0, 0.4, -1.5, 3.0] {
            for wall in [0.3, 0.95] {
                let found = outline_of(angle, 200.0, &|at| if head(at) { 0.7 } else { wall });
                assert!(found > 0.2, "{angle} {wall}: {found}");
            }
            // Shading alone.
            let found = outline_of(angle, 200.0, &|[x, _]| 0.7 - 0.001 * x.abs() as f32);
            assert!(found < 0.02, "{found}");
            // An outline on one side, as of a face that is turned.
            let found =
                outline_of(angle, 200.0, &|at| if head(at) || at[0] < 0.0 { 0.7 } else { 0.2 });
            assert!(found > 0.3, "{found}");
        }
        // Darker pictures have the same outline.
        let dark = outline_of(0.0, 200.0, &|at| if head(at) { 0.14 } else { 0.06 });
        assert!(dark > 0.3, "{dark}");
    }

    #[test]
    fn jaws_at_the_edge_are_unknown() {
        assert_eq!(outline_of(0.0, 60.0, &|_| 0.7), f64::INFINITY);
    }
}
