//! CIELAB under D65, so that mean colours are perceptual rather than means of stored values.
//!
//! Apart from `uvgraft::color`, by exact constants and with an inverse: what is judged must not be
//! measured by its own mistakes.

use uvgraft::color::{linear_from_srgb, srgb_from_linear};

use super::Color;

const WHITE: [f64; 3] = [0.950_47, 1.0, 1.088_83];
const XYZ_FROM_RGB: [[f64; 3]; 3] = [
    [0.412_456_4, 0.357_576_1, 0.180_437_5],
    [0.212_672_9, 0.715_152_2, 0.072_175_0],
    [0.019_333_9, 0.119_192_0, 0.950_304_1],
];
const RGB_FROM_XYZ: [[f64; 3]; 3] = [
    [3.240_454_2, -1.537_138_5, -0.498_531_4],
    [-0.969_266_0, 1.876_010_8, 0.041_556_0],
    [0.055_643_4, -0.204_025_9, 1.057_225_2],
];
const DELTA: f64 = 6.0 / 29.0;

/// CIELAB of an sRGB colour; `L` from 0 to 100.
pub fn lab_from_srgb(color: Color) -> [f64; 3] {
    let rgb = color.map(|value| f64::from(linear_from_srgb(value)));
    let f = |row: usize| {
        let value = dot(XYZ_FROM_RGB[row], rgb) / WHITE[row];
        if value > DELTA.powi(3) {
            value.cbrt()
        } else {
            value / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = [f(0), f(1), f(2)];
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn srgb_from_lab([l, a, b]: [f64; 3]) -> Color {
    let y = (l + 16.0) / 116.0;
    let f = [y + a / 500.0, y, y - b / 200.0];
    let xyz = [0, 1, 2].map(|k| {
        let t = f[k];
        let value = if t > DELTA { t.powi(3) } else { 3.0 * DELTA * DELTA * (t - 4.0 / 29.0) };
        value * WHITE[k]
    });
    RGB_FROM_XYZ.map(|row| srgb_from_linear(dot(row, xyz) as f32))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The mean in CIELAB, as sRGB; `None` if there are no colours.
pub fn mean_color(colors: impl IntoIterator<Item = Color>) -> Option<Color> {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for color in colors {
        let lab = lab_from_srgb(color);
        sum = [0, 1, 2].map(|k| sum[k] + lab[k]);
        count += 1.0;
    }
    (count > 0.0).then(|| srgb_from_lab(sum.map(|value| value / count)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_colors_and_back() {
        let close = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 0.02);
        assert!(close(lab_from_srgb([1.0; 3]), [100.0, 0.0, 0.0]));
        assert!(close(lab_from_srgb([1.0, 0.0, 0.0]), [53.24, 80.09, 67.20]));
        for color in [[0.8, 0.6, 0.5], [0.1, 0.02, 0.9], [0.01, 0.0, 0.002]] {
            let back = srgb_from_lab(lab_from_srgb(color));
            assert!((0..3).all(|k| (back[k] - color[k]).abs() < 1e-4), "{back:?}");
        }
        // Halfway between black and white in lightness.
        let grey = mean_color([[0.0; 3], [1.0; 3]]).expect("two colours");
        assert!((lab_from_srgb(grey)[0] - 50.0).abs() < 1e-3);
        assert_eq!(mean_color([]), None);
    }
}
