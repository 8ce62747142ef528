//! Point samples of a texture, bilinear.
//!
//! Transfers have kernels of their own in [`resample`](crate::resample), which sample along runs.

use crate::color::{Encoding, linear_from_srgb, luma, srgb_from_linear};
use crate::texture::{Size, Texture};

/// What samples read beyond the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beyond {
    /// The nearest texel.
    Edge,
    /// Zeros.
    Zero,
}

/// The bilinear mean of the four texels around a position; NaN if a coordinate is NaN.
///
/// - `at_px`: column and row; the centre of the first texel is at 0.5, 0.5.
/// - `texel`: the values at a column and row, each less than the side of `size`.
#[inline]
pub fn bilinear<const N: usize>(
    size: Size,
    at_px: [f64; 2],
    beyond: Beyond,
    texel: impl Fn(u32, u32) -> [f32; N],
) -> [f32; N] {
    let axis = |at: f64, side: u32| {
        // Farther away from the edge nothing changes, and integers would overflow.
        let at = (at - 0.5).clamp(-2.0, f64::from(side) + 1.0);
        // `f64::floor` is a call where the baseline target has no instruction for it.
        let towards_zero = at as i64;
        let first = towards_zero - i64::from(towards_zero as f64 > at);
        (first, (at - first as f64) as f32)
    };
    let ((left, fx), (top, fy)) = (axis(at_px[0], size.width), axis(at_px[1], size.height));
    let at = |x: i64, y: i64| {
        let [column, row] =
            [(x, size.width), (y, size.height)].map(|(at, side)| at.clamp(0, i64::from(side) - 1));
        if beyond == Beyond::Zero && [column, row] != [x, y] {
            return [0.0; N];
        }
        texel(column as u32, row as u32)
    };
    let (a, b) = (at(left, top), at(left + 1, top));
    let (c, d) = (at(left, top + 1), at(left + 1, top + 1));
    std::array::from_fn(|k| {
        let above = a[k] + (b[k] - a[k]) * fx;
        let below = c[k] + (d[k] - c[k]) * fx;
        above + (below - above) * fy
    })
}

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
    ///
    /// As products with weights rather than the differences of [`bilinear`]: those lose what is next to
    /// a texel of 1e30, or overflow, and masks and captures in floats have such texels.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_centres_and_beyond_edges() {
        let size = Size::new(3, 2);
        let at = |x: f64, y: f64, beyond| {
            bilinear(size, [x, y], beyond, |x, y| [x as f32 + 10.0 * y as f32])[0]
        };
        assert_eq!(at(0.5, 0.5, Beyond::Edge), 0.0);
        assert_eq!(at(1.75, 0.75, Beyond::Edge), 1.25 + 2.5);
        assert_eq!([-7.0, 1e300].map(|x| at(x, 1.5, Beyond::Edge)), [10.0, 12.0]);
        assert_eq!([-7.0, 1e300].map(|x| at(x, 1.5, Beyond::Zero)), [0.0, 0.0]);
        // At the very edge, half is beyond.
        assert_eq!(at(3.0, 1.5, Beyond::Zero), 6.0);
        assert!(at(f64::NAN, 1.5, Beyond::Edge).is_nan());
    }
}
