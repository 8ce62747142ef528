//! What the colours of an EXR become: linear values of the primaries of sRGB.

use ::exr::math::Vec2;
use ::exr::meta::attribute;
use uvgraft::texture::Channels;

use crate::image::color_space::{Chromaticities, applied};

/// The colour space of a file, and how its channels hold colours.
pub(super) struct Colors {
    pub(super) primaries: Chromaticities,
    /// Whether the channels are RY, Y and BY instead of R, G and B.
    pub(super) is_luminance_chroma: bool,
}

/// The declared primaries. Those that span no colour space are ignored, as viewers ignore them: programs
/// exist that write zeros.
pub(super) fn primaries(declared: Option<attribute::Chromaticities>) -> Chromaticities {
    let pair = |Vec2(x, y): Vec2<f32>| [x, y].map(f64::from);
    declared
        .map(|declared| Chromaticities {
            red: pair(declared.red),
            green: pair(declared.green),
            blue: pair(declared.blue),
            white: pair(declared.white),
        })
        .filter(|primaries| primaries.to_srgb().is_ok())
        .unwrap_or(Chromaticities::SRGB)
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
        if let (true, Ok(Some(matrix))) = (converts, self.primaries.to_srgb()) {
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
        let colors = Colors { primaries, is_luminance_chroma: true };
        colors.apply(&mut values, Channels::Rgba, true);
        for (found, wanted) in values.iter().zip([0.8, 0.4, 0.1, 0.5]) {
            assert!((found - wanted).abs() < 1e-6, "{values:?}");
        }
    }

    #[test]
    fn colours_outside_of_the_gamut_become_negative() {
        let primaries = Chromaticities { red: [0.708, 0.292], ..Chromaticities::SRGB };
        let colors = Colors { primaries, is_luminance_chroma: false };
        let mut values = [1.0, 0.0, 0.0];
        colors.apply(&mut values, Channels::Rgb, true);
        assert!(values[1] < 0.0 && values[2] < 0.0, "{values:?}");
        let mut stored = [1.0, 0.0, 0.0];
        colors.apply(&mut stored, Channels::Rgb, false);
        assert_eq!(stored, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn nonsense_is_ignored() {
        let zero = Vec2(0.0, 0.0);
        let zeros = attribute::Chromaticities { red: zero, green: zero, blue: zero, white: zero };
        assert_eq!(primaries(Some(zeros)), Chromaticities::SRGB);
    }
}
