//! Samples a texture's colour the way a renderer without mipmaps does.

use uvgraft::color::{Encoding, srgb_from_linear};
use uvgraft::texture::{Channels, Texture};

/// The sample at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Sample {
    /// A colour: sRGB, 1.0 at full intensity, whatever its alpha.
    Color([f32; 3]),
    /// All texels are transparent.
    Clear,
    /// A value is NaN or infinite.
    NotFinite,
}

/// The colour at a point, filtered bilinearly from the four texels around it.
///
/// - `uv`: finite; points outside the texture get the colour of its nearest edge.
///
/// Values are filtered as sRGB, weighted by alpha. Apart from the core's `bilinear`: texels of weight 0 may
/// hold anything, even NaN, and sums are in double precision, so that what is measured does not depend
/// on how it was made.
pub(super) fn sample(texture: &Texture, uv: [f64; 2]) -> Sample {
    let size = texture.size();
    let axis = |coordinate: f64, count: u32| {
        let last = f64::from(count - 1);
        let at = (coordinate * f64::from(count) - 0.5).clamp(0.0, last);
        let low = at.floor();
        ([low as u32, (low as u32 + 1).min(count - 1)], at - low)
    };
    let (columns, right) = axis(uv[0], size.width);
    let (rows, down) = axis(uv[1], size.height);
    let mut color = [0.0; 3];
    let mut total = 0.0;
    for (row, across) in rows.into_iter().zip([1.0 - down, down]) {
        for (column, along) in columns.into_iter().zip([1.0 - right, right]) {
            let weight = along * across;
            if weight > 0.0 {
                let (rgb, alpha) = texel(texture, column, row);
                let weight = weight * f64::from(alpha);
                // A fully transparent texel may hold anything, even NaN.
                if weight != 0.0 {
                    (0..3).for_each(|k| color[k] += weight * f64::from(rgb[k]));
                    total += weight;
                }
            }
        }
    }
    let color = color.map(|value| (value / total) as f32);
    if total == 0.0 {
        Sample::Clear
    } else if color.iter().all(|value| value.is_finite()) {
        Sample::Color(color)
    } else {
        Sample::NotFinite
    }
}

/// A texel's sRGB values and its alpha.
pub(super) fn texel(texture: &Texture, x: u32, y: u32) -> ([f32; 3], f32) {
    let channels = texture.channels();
    let get = |channel: usize| texture.get(x, y, channel);
    let rgb = if channels.has_color() { [get(0), get(1), get(2)] } else { [get(0); 3] };
    let rgb = match texture.encoding() {
        Encoding::Linear => rgb.map(srgb_from_linear),
        Encoding::Srgb | Encoding::Data => rgb,
    };
    let alpha = match channels {
        Channels::Grey | Channels::Rgb => 1.0,
        // Float textures may hold any value as alpha; below 0 a texel is invisible.
        Channels::GreyAlpha => get(1).max(0.0),
        Channels::Rgba => get(3).max(0.0),
    };
    (rgb, alpha)
}

#[cfg(test)]
mod tests {
    use uvgraft::texture::{Size, Texels};

    use super::*;

    fn texture(channels: Channels, encoding: Encoding, values: &[f32]) -> Texture {
        let size = Size::new(2, (values.len() / channels.count() / 2) as u32);
        Texture::new(size, channels, encoding, Texels::F32(values.to_vec())).unwrap()
    }

    #[test]
    fn centres_lie_at_one_half() {
        let grey = texture(Channels::Grey, Encoding::Srgb, &[0.0, 1.0, 0.5, 0.5]);
        let at = |u: f64, v: f64| sample(&grey, [u, v]);
        assert_eq!(at(0.25, 0.25), Sample::Color([0.0; 3]));
        assert_eq!(at(0.75, 0.25), Sample::Color([1.0; 3]));
        assert_eq!(at(0.375, 0.25), Sample::Color([0.25; 3]));
        assert_eq!(at(0.75, 0.5), Sample::Color([0.75; 3]));
        for (outside, inside) in [([-3.0, 0.25], [0.0, 0.25]), ([1e300, 0.5], [1.0, 0.5])] {
            assert_eq!(sample(&grey, outside), sample(&grey, inside));
        }
    }

    #[test]
    fn alpha_is_a_weight_and_may_be_zero() {
        let values = [1.0, 0.5, 0.0, 1.0, f32::NAN, 0.0, f32::NAN, 0.0];
        let texture = texture(Channels::GreyAlpha, Encoding::Srgb, &values);
        assert_eq!(sample(&texture, [0.5, 0.25]), Sample::Color([1.0 / 3.0; 3]));
        assert_eq!(sample(&texture, [0.5, 0.5]), Sample::Color([1.0 / 3.0; 3]));
        assert_eq!(sample(&texture, [0.5, 0.9]), Sample::Clear);
    }

    #[test]
    fn linear_light_is_encoded_before_it_is_filtered() {
        let values = [0.0, 0.214_041_14, 0.0, 1.0, f32::NAN, f32::INFINITY];
        let texture = texture(Channels::Rgb, Encoding::Linear, &[values, values].concat());
        let Sample::Color([r, g, b]) = sample(&texture, [0.25, 0.5]) else { panic!("a colour") };
        assert!(r == 0.0 && (g - 0.5).abs() < 1e-6 && b == 0.0);
        assert_eq!(sample(&texture, [0.75, 0.5]), Sample::NotFinite);
    }
}
