//! What the colours of an EXR become: linear values of the primaries of sRGB.

use ::exr::math::Vec2;
use ::exr::meta::attribute;
use uvgraft::texture::Channels;

use crate::color_space::{Chromaticities, D65, applied};

/// The colour space of a file, and how its channels hold colours.
pub(super) struct Colors {
    pub(super) primaries: Chromaticities,
    /// CIE 1931 x and y of what is neutral.
    pub(super) neutral: [f64; 2],
    /// Whether the channels are RY, Y and BY instead of R, G and B.
    pub(super) is_luminance_chroma: bool,
}

/// - `declared`: the attribute `chromaticities`.
pub(super) fn primaries(declared: Option<attribute::Chromaticities>) -> Chromaticities {
    let pair = |Vec2(x, y): Vec2<f32>| [x, y].map(f64::from);
    Chromaticities::declared(declared.map(|it| [it.red, it.green, it.blue, it.white].map(pair)))
}

/// What is neutral: what the file says, or else its white. The values of XYZ are those of colours,
/// though, and their formal white, of equal energy, is no colour of a picture.
///
/// - `adopted`: the attribute `adoptedNeutral`.
pub(super) fn neutral(primaries: &Chromaticities, adopted: Option<Vec2<f32>>) -> [f64; 2] {
    /// Files round to 3 digits at least.
    const SAME: f64 = 1e-3;
    let Chromaticities { red, green, blue, white } = *primaries;
    let distances = [red, green, blue].into_iter().zip([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]);
    let is_xyz = distances.flat_map(|(a, b)| [a[0] - b[0], a[1] - b[1]]).all(|it| it.abs() < SAME);
    let stated = adopted.map(|Vec2(x, y)| [x, y].map(f64::from));
    let is_sound = |neutral: &[f64; 2]| primaries.to_srgb_from(*neutral).is_ok();
    stated.filter(is_sound).unwrap_or(if is_xyz { D65 } else { white })
}

impl Colors {
    /// Converts texels to R, G and B of the primaries of sRGB.
    ///
    /// - `values`: colours multiplied by alpha, or not: all of this is linear.
    /// - `converts`: whether primaries are converted.
    pub(super) fn apply(&self, values: &mut [f32], channels: Channels, converts: bool) {
        if !channels.has_color() {
            return;
        }
        if let (true, Ok(luminances)) = (self.is_luminance_chroma, self.primaries.luminances()) {
            each(values, channels, |chroma| from_chroma(chroma, luminances));
        }
        if let (true, Ok(Some(matrix))) = (converts, self.primaries.to_srgb_from(self.neutral)) {
            // Colours outside of the gamut get negative values, which floats hold.
            each(values, channels, |color| applied(&matrix, color));
        }
    }
}

/// From RY, Y and BY, where RY is (R − Y) / Y.
///
/// Source: "Technical Introduction to OpenEXR", luminance/chroma images.
fn from_chroma([ry, y, by]: [f64; 3], [red, green, blue]: [f64; 3]) -> [f64; 3] {
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    [r, (y - r * red - b * blue) / green, b]
}

fn each(values: &mut [f32], channels: Channels, convert: impl Fn([f64; 3]) -> [f64; 3]) {
    for texel in values.chunks_exact_mut(channels.count()) {
        if let [r, g, b, ..] = texel {
            let converted = convert([*r, *g, *b].map(f64::from));
            [*r, *g, *b] = converted.map(|value| value as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminance_and_chroma_give_the_colour_back() {
        let primaries = Chromaticities::SRGB;
        let [red, green, blue] = primaries.luminances().unwrap();
        let (r, g, b) = (0.8, 0.4, 0.1);
        let y = r * red + g * green + b * blue;
        let mut values = [(r - y) / y, y, (b - y) / y, 0.5].map(|value| value as f32);
        let colors = Colors { primaries, neutral: D65, is_luminance_chroma: true };
        colors.apply(&mut values, Channels::Rgba, true);
        for (found, wanted) in values.iter().zip([0.8, 0.4, 0.1, 0.5]) {
            assert!((found - wanted).abs() < 1e-6, "{values:?}");
        }
    }

    #[test]
    fn colours_outside_of_the_gamut_become_negative() {
        let primaries = Chromaticities { red: [0.708, 0.292], ..Chromaticities::SRGB };
        let colors = Colors { primaries, neutral: D65, is_luminance_chroma: false };
        let mut values = [1.0, 0.0, 0.0];
        colors.apply(&mut values, Channels::Rgb, true);
        assert!(values[1] < 0.0 && values[2] < 0.0, "{values:?}");
        let mut stored = [1.0, 0.0, 0.0];
        colors.apply(&mut stored, Channels::Rgb, false);
        assert_eq!(stored, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn what_is_neutral() {
        let p3 = Chromaticities { white: [0.314, 0.351], ..Chromaticities::SRGB };
        assert_eq!(neutral(&p3, None), p3.white);
        assert_eq!(neutral(&p3, Some(Vec2(0.25, 0.5))), [0.25, 0.5]);
        assert_eq!(neutral(&p3, Some(Vec2(0.0, 0.0))), p3.white);
        let white = [1.0 / 3.0; 2];
        let xyz = Chromaticities { red: [1.0, 0.0], green: [0.0, 1.0], blue: [0.0, 0.0], white };
        assert_eq!(neutral(&xyz, None), D65);
    }

    #[test]
    fn nonsense_is_ignored() {
        let zero = Vec2(0.0, 0.0);
        let zeros = attribute::Chromaticities { red: zero, green: zero, blue: zero, white: zero };
        assert_eq!(primaries(Some(zeros)), Chromaticities::SRGB);
    }
}
