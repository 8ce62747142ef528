//! Conversions between channels, depths and encodings of textures.

use uvgraft_surface::threads::for_each_chunk;

use crate::color::{Encoding, linear_from_srgb, luma, srgb_from_linear};
use crate::texture::{Channels, Depth, Texels, TexelsMut, Texture, Value};

/// Values converted per work item.
const CHUNK: usize = 1 << 16;

impl Texture {
    /// Converts the texture to other channels and another depth.
    ///
    /// Grey is replicated to RGB, and missing alpha becomes 1. Colour is reduced to grey by
    /// Rec. 709 weights on the encoded values, and surplus alpha is dropped. Fewer bits round to
    /// nearest; integers clamp to `0.0..=1.0`.
    #[must_use]
    pub fn converted(self, channels: Channels, depth: Depth) -> Self {
        if self.channels() == channels && self.depth() == depth {
            return self;
        }
        let (size, encoding, from) = (self.size(), self.encoding(), self.channels());
        let texels = match (self.into_texels(), depth) {
            (Texels::U8(values), Depth::U8) => Texels::U8(convert(&values, from, channels)),
            (Texels::U8(values), Depth::U16) => Texels::U16(convert(&values, from, channels)),
            (Texels::U8(values), Depth::F32) => Texels::F32(convert(&values, from, channels)),
            (Texels::U16(values), Depth::U8) => Texels::U8(convert(&values, from, channels)),
            (Texels::U16(values), Depth::U16) => Texels::U16(convert(&values, from, channels)),
            (Texels::U16(values), Depth::F32) => Texels::F32(convert(&values, from, channels)),
            (Texels::F32(values), Depth::U8) => Texels::U8(convert(&values, from, channels)),
            (Texels::F32(values), Depth::U16) => Texels::U16(convert(&values, from, channels)),
            (Texels::F32(values), Depth::F32) => Texels::F32(convert(&values, from, channels)),
        };
        Self::new(size, channels, encoding, texels).expect("as many texels as before")
    }

    /// Converts the colours to another transfer function. From or to [`Encoding::Data`] the
    /// texture is only relabelled. Colours are converted as 32-bit floats, and the result
    /// stays in that depth.
    #[must_use]
    pub fn encoded_as(self, encoding: Encoding) -> Self {
        let transfer: fn(f32) -> f32 = match (self.encoding(), encoding) {
            (Encoding::Srgb, Encoding::Linear) => linear_from_srgb,
            (Encoding::Linear, Encoding::Srgb) => srgb_from_linear,
            _ => return self.with_encoding(encoding),
        };
        let channels = self.channels();
        let mut texture = self.converted(channels, Depth::F32).with_encoding(encoding);
        if let TexelsMut::F32(values) = texture.texels_mut() {
            let count = channels.count();
            let colors = count - usize::from(channels.has_alpha());
            for_each_chunk(values, CHUNK / count * count, |_, values| {
                for texel in values.chunks_exact_mut(count) {
                    for value in &mut texel[..colors] {
                        *value = transfer(*value);
                    }
                }
            });
        }
        texture
    }
}

/// Converts channels and depth in one pass over the texels, in parallel chunks.
fn convert<A: Value, B: Value>(values: &[A], from: Channels, to: Channels) -> Vec<B> {
    let (from_count, to_count) = (from.count(), to.count());
    let mut out = vec![B::default(); values.len() / from_count * to_count];
    // 8 to 16 bits multiplies by 257, and back divides by it: both exact in 32-bit floats.
    let scale = B::ONE.to_level() / A::ONE.to_level();
    let value = |value: A| B::from_level(value.to_level() * scale);
    let texels = CHUNK / 4;
    for_each_chunk(&mut out, texels * to_count, |chunk, out| {
        let values = &values[chunk * texels * from_count..];
        for (texel, out) in values.chunks_exact(from_count).zip(out.chunks_exact_mut(to_count)) {
            match (from.has_color(), to.has_color()) {
                (true, true) => {
                    for (out, &texel) in out.iter_mut().zip(&texel[..3]) {
                        *out = value(texel);
                    }
                }
                (false, true) => out[..3].fill(value(texel[0])),
                (false, false) => out[0] = value(texel[0]),
                (true, false) => {
                    let levels = [0, 1, 2].map(|channel| texel[channel].to_level());
                    out[0] = B::from_level(luma(levels) * scale);
                }
            }
            if to.has_alpha() {
                out[to_count - 1] =
                    if from.has_alpha() { value(texel[from_count - 1]) } else { B::ONE };
            }
        }
    });
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texture::Size;

    fn texture(channels: Channels, values: Vec<u8>) -> Texture {
        let size = Size::new((values.len() / channels.count()) as u32, 1);
        Texture::new(size, channels, Encoding::Srgb, Texels::U8(values)).unwrap()
    }

    #[test]
    fn fills_in_what_is_missing() {
        let grey = texture(Channels::Grey, vec![7, 9]);
        let rgba = grey.clone().converted(Channels::Rgba, Depth::U8);
        assert_eq!(*rgba.texels(), Texels::U8(vec![7, 7, 7, 255, 9, 9, 9, 255]));
        assert_eq!(rgba.converted(Channels::Grey, Depth::U8), grey);
        let both = texture(Channels::GreyAlpha, vec![7, 100]).converted(Channels::Rgba, Depth::U8);
        assert_eq!(*both.texels(), Texels::U8(vec![7, 7, 7, 100]));
    }

    #[test]
    fn widening_and_back_is_exact() {
        let all = texture(Channels::Grey, (0..=255).collect());
        for depth in [Depth::U16, Depth::F32] {
            let more = all.clone().converted(Channels::Grey, depth);
            assert_eq!(more.get(255, 0, 0), 1.0);
            assert_eq!(more.converted(Channels::Grey, Depth::U8), all);
        }
        let wide = all.clone().converted(Channels::Grey, Depth::U16);
        let Texels::U16(values) = wide.texels() else { panic!() };
        assert_eq!(values[1], 257);
        let linear = all.clone().encoded_as(Encoding::Linear).encoded_as(Encoding::Srgb);
        assert_eq!(linear.converted(Channels::Grey, Depth::U8), all);
    }

    #[test]
    fn alpha_and_data_have_no_transfer_function() {
        let linear = texture(Channels::GreyAlpha, vec![128, 128]).encoded_as(Encoding::Linear);
        assert!((linear.get(0, 0, 0) - 0.2158).abs() < 1e-3);
        assert_eq!(linear.get(0, 0, 1), 128.0 / 255.0);
        let data = texture(Channels::Grey, vec![128]).with_encoding(Encoding::Data);
        assert_eq!(*data.encoded_as(Encoding::Linear).texels(), Texels::U8(vec![128]));
    }
}
