//! Perceptual colour difference: CIEDE2000.

use palette::color_difference::Ciede2000;
use palette::white_point::D65;
use palette::{FromColor, Lab, Srgb};

/// The colour difference ΔE₀₀ between two colours.
///
/// - `a`, `b`: red, green and blue with the sRGB transfer function, 1.0 for full intensity. Values
///   outside `0.0..=1.0` are clamped, as a display does.
///
/// 0 for equal colours; about 1 is the smallest difference visible side by side, about 2.3 is
/// noticed at a glance, black against white is 100. NaN gives NaN.
///
/// # Source
/// CIE 142-2001 with all weights 1, of CIELAB under D65 (2°), computed by the crate `palette`.
pub fn delta_e(a: [f32; 3], b: [f32; 3]) -> f64 {
    if a == b {
        // Early out for the commonest case: texel pairs along the seams of flat-coloured textures.
        return 0.0;
    }
    lab(a).difference(lab(b))
}

fn lab(srgb: [f32; 3]) -> Lab<D65, f64> {
    let [red, green, blue] = srgb.map(|value| f64::from(value.clamp(0.0, 1.0)));
    Lab::from_color(Srgb::new(red, green, blue))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twelve of the test pairs in Sharma, Wu and Dalal, "The CIEDE2000 color-difference formula:
    /// implementation notes, supplementary test data, and mathematical observations" (2005), where
    /// they are given to four decimals.
    #[test]
    fn agrees_with_published_pairs() {
        let pairs: &[([f64; 3], [f64; 3], f64)] = &[
            ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
            ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
            ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
            ([50.0, 2.49, -0.001], [50.0, -2.49, 0.0009], 7.1792),
            ([50.0, -0.001, 2.49], [50.0, 0.0009, -2.49], 4.8045),
            ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
            ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
            ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
            ([50.0, 2.5, 0.0], [50.0, 3.2592, 0.335], 1.0000),
            ([60.2574, -34.0099, 36.2677], [60.4626, -34.1751, 39.4387], 1.2644),
            ([90.9257, -0.5406, -0.9208], [88.6381, -0.8985, -0.7239], 1.5381),
            ([2.0776, 0.0795, -1.1350], [0.9033, -0.0636, -0.5514], 0.9082),
        ];
        for &(a, b, wanted) in pairs {
            let [a, b] = [a, b].map(|[l, x, y]| Lab::<D65, f64>::new(l, x, y));
            for found in [a.difference(b), b.difference(a)] {
                assert!((found - wanted).abs() < 5.1e-5, "{a:?} {b:?}: {found}, wanted {wanted}");
            }
        }
    }

    /// CIELAB of the sRGB primaries under D65, as commonly tabulated to two decimals.
    #[test]
    fn srgb_white_point_is_d65() {
        let colors: &[([f32; 3], [f64; 3])] = &[
            ([1.0, 1.0, 1.0], [100.0, 0.0, 0.0]),
            ([1.0, 0.0, 0.0], [53.24, 80.09, 67.20]),
            ([0.0, 1.0, 0.0], [87.73, -86.18, 83.18]),
            ([0.0, 0.0, 1.0], [32.30, 79.19, -107.86]),
        ];
        for &(srgb, wanted) in colors {
            let Lab { l, a, b, .. } = lab(srgb);
            for (found, wanted) in [l, a, b].into_iter().zip(wanted) {
                // Published sRGB matrices differ in precision, from four decimals upwards.
                assert!((found - wanted).abs() < 0.02, "{srgb:?}: {l} {a} {b}");
            }
        }
        assert!((delta_e([0.0; 3], [1.0; 3]) - 100.0).abs() < 1e-3);
    }

    #[test]
    fn out_of_gamut_values_are_clamped() {
        assert_eq!(delta_e([2.0, 0.5, -1.0], [1.0, 0.5, 0.0]), 0.0);
        assert_eq!(delta_e([f32::INFINITY, 0.0, 0.0], [1.0, 0.0, 0.0]), 0.0);
        assert!(delta_e([f32::NAN, 0.0, 0.0], [1.0, 0.0, 0.0]).is_nan());
        assert_eq!(delta_e([0.25, 0.5, 0.75], [0.25, 0.5, 0.75]), 0.0);
    }
}
