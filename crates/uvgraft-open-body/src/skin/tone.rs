//! Tones of skin, from very light to very dark, and how they vary over the body.

use glam::Vec3;
use uvgraft::color::luma;
use uvgraft_avatar::paint::noise::{fractal, noise};
use uvgraft_avatar::paint::texel::{Color, blend};

use super::scaled;

/// Tones in equal steps from 0 to 1, in sRGB.
const TONES: [Color; 7] = [
    [0.945, 0.800, 0.725],
    [0.900, 0.725, 0.625],
    [0.830, 0.630, 0.510],
    [0.715, 0.510, 0.390],
    [0.555, 0.375, 0.275],
    [0.390, 0.255, 0.190],
    [0.245, 0.160, 0.125],
];

/// The colour of skin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinTone(Color);

impl SkinTone {
    /// A tone on a scale from very light, 0, to very dark, 1; values beyond are clamped.
    pub fn on_scale(value: f32) -> Self {
        let place = value.clamp(0.0, 1.0) * (TONES.len() - 1) as f32;
        let lower = (place as usize).min(TONES.len() - 2);
        Self(blend(TONES[lower], TONES[lower + 1], place - lower as f32))
    }

    /// Any mean colour, in sRGB.
    pub const fn from_color(color: [f32; 3]) -> Self {
        Self(color)
    }

    /// The mean colour, in sRGB.
    pub const fn color(&self) -> [f32; 3] {
        self.0
    }

    /// The colour of skin with much blood under it, such as lips.
    pub(super) fn blood(&self) -> Color {
        let [red, green, blue] = self.0;
        [red * 0.93, green * 0.68, blue * 0.68]
    }

    /// Skin at a point: its tone varies over centimetres, blotches are redder, and pores are a few
    /// tenths of a millimetre wide.
    ///
    /// - `place`: in centimetres.
    /// - `flush`: share of blood, as on cheeks.
    pub(super) fn at(&self, place: Vec3, flush: f32) -> Color {
        let tone = fractal(place * 0.22, 2, 121);
        let blotches = fractal(place * 1.3, 3, 131);
        let pores = noise(place * 15.0, 141);
        let grain = noise(place * 33.0, 142);
        // The eye sees the same steps better on dark skin.
        let contrast = 0.6 + 0.4 * luma(self.0);
        let share = flush + 0.10 + 0.10 * tone + 0.12 * blotches;
        let color = blend(self.0, self.blood(), share.clamp(0.0, 1.0));
        scaled(color, 1.0 + contrast * (0.035 * tone + 0.022 * pores.min(0.3) + 0.014 * grain))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tones_go_from_light_to_dark() {
        let steps: Vec<f32> =
            (0..=20).map(|step| luma(SkinTone::on_scale(step as f32 / 20.0).color())).collect();
        assert!(steps.windows(2).all(|pair| pair[0] > pair[1]), "{steps:?}");
        assert_eq!(SkinTone::on_scale(-1.0).color(), TONES[0]);
        assert_eq!(SkinTone::on_scale(2.0).color(), TONES[6]);
    }
}
