//! Reading and writing colours of single texels, for any bit depth, channel count and encoding.

use uvgraft::color::{linear_from_srgb, luma};
use uvgraft::easing::mix;
use uvgraft::{Encoding, TexelsMut, Texture, Value};

/// Gamma-encoded sRGB values, 1.0 for white.
pub type Color = [f32; 3];

/// Linear interpolation between two colours.
pub fn blend(a: Color, b: Color, t: f32) -> Color {
    std::array::from_fn(|k| mix(a[k], b[k], t))
}

/// The colour of a texel in sRGB, for any channels and encoding.
pub fn srgb(texture: &Texture, x: u32, y: u32) -> Color {
    let colors = if texture.channels().count() >= 3 { 3 } else { 1 };
    std::array::from_fn(|channel| {
        let value = texture.get(x, y, channel.min(colors - 1));
        match texture.encoding() {
            Encoding::Linear => uvgraft::color::srgb_from_linear(value),
            Encoding::Srgb | Encoding::Data => value,
        }
    })
}

/// Sets the colour of a texel and makes it opaque.
pub fn put(texture: &mut Texture, x: u32, y: u32, color: Color) {
    let (channels, encoding) = (texture.channels().count(), texture.encoding());
    let first = (y as usize * texture.size().width as usize + x as usize) * channels;
    let texel = first..first + channels;
    match texture.texels_mut() {
        TexelsMut::U8(texels) => write(&mut texels[texel], color, encoding),
        TexelsMut::U16(texels) => write(&mut texels[texel], color, encoding),
        TexelsMut::F32(texels) => write(&mut texels[texel], color, encoding),
    }
}

/// Writes a colour to the channels of a texel and makes it opaque.
fn write<T: Value>(texel: &mut [T], color: Color, encoding: Encoding) {
    let color = match encoding {
        Encoding::Linear => color.map(linear_from_srgb),
        Encoding::Srgb | Encoding::Data => color,
    };
    let grey = luma(color);
    match texel {
        [grey_texel] => *grey_texel = T::from_unit(grey),
        [grey_texel, alpha] => {
            *grey_texel = T::from_unit(grey);
            *alpha = T::ONE;
        }
        colors => {
            let values = color.into_iter().chain([1.0]);
            colors.iter_mut().zip(values).for_each(|(texel, value)| *texel = T::from_unit(value));
        }
    }
}
