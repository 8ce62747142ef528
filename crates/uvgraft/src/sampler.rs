//! Point samples of a texture.

use crate::color::{Encoding, linear_from_srgb, luma, srgb_from_linear};
use crate::texture::{Size, Texture};

/// Samples a texture bilinearly; beyond its edge the edge texels repeat.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sampler<'a> {
    texture: &'a Texture,
}

impl<'a> Sampler<'a> {
    pub fn new(texture: &'a Texture) -> Self {
        Self { texture }
    }

    /// Red, green, blue and alpha in the texture's encoding; full scale is 1.0. Colours
    /// are weighted by alpha during interpolation, so that transparent texels do not
    /// bleed into the result.
    pub fn rgba(self, uv: [f64; 2]) -> [f32; 4] {
        let Size { width, height } = self.texture.size();
        let taps = |coordinate: f64, side: u32| {
            let at = (coordinate * f64::from(side) - 0.5).clamp(0.0, f64::from(side - 1));
            let first = at as u32;
            (first, (first + 1).min(side - 1), (at - f64::from(first)) as f32)
        };
        let (left, right, s) = taps(uv[0], width);
        let (top, bottom, t) = taps(uv[1], height);
        let mut sum = [0.0; 4];
        for (x, y, weight) in [
            (left, top, (1.0 - s) * (1.0 - t)),
            (right, top, s * (1.0 - t)),
            (left, bottom, (1.0 - s) * t),
            (right, bottom, s * t),
        ] {
            let [r, g, b, alpha] = self.texel(x, y);
            for (sum, value) in sum.iter_mut().zip([r * alpha, g * alpha, b * alpha, alpha]) {
                *sum += value * weight;
            }
        }
        let [r, g, b, alpha] = sum;
        if alpha > 0.0 { [r / alpha, g / alpha, b / alpha, alpha] } else { [0.0; 4] }
    }

    /// As [`Sampler::rgba`], with the colours converted from the texture's encoding to `encoding`.
    pub fn rgba_as(self, uv: [f64; 2], encoding: Encoding) -> [f32; 4] {
        let [r, g, b, alpha] = self.rgba(uv);
        let convert: fn(f32) -> f32 = match (self.texture.encoding(), encoding) {
            (Encoding::Srgb, Encoding::Linear) => linear_from_srgb,
            (Encoding::Linear, Encoding::Srgb) => srgb_from_linear,
            _ => |value| value,
        };
        [convert(r), convert(g), convert(b), alpha]
    }

    /// Luma of the colours as stored, times alpha.
    pub fn brightness(self, uv: [f64; 2]) -> f32 {
        let [r, g, b, alpha] = self.rgba(uv);
        luma([r, g, b]) * alpha
    }

    fn texel(self, x: u32, y: u32) -> [f32; 4] {
        let channels = self.texture.channels();
        let value = |channel| self.texture.get(x, y, channel);
        let [r, g, b] = if channels.has_color() { [0, 1, 2].map(value) } else { [value(0); 3] };
        let alpha = if channels.has_alpha() { value(channels.count() - 1) } else { 1.0 };
        [r, g, b, alpha]
    }
}
