//! Texture colours in the form that metrics compare.

use std::borrow::Cow;
use std::ops::Range;

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};

use super::MetricError;

/// The colours of a texture as a display shows them: RGB with the sRGB transfer function, 1.0 for
/// white, composited over black where the texture is not opaque. Grey becomes three equal values,
/// and data is treated as if it were colour.
///
/// Opaque textures of 8 bits stay as they are, a quarter or a twelfth of what floats take.
#[derive(Debug, Clone)]
pub struct Colors {
    size: Size,
    stored: Stored,
}

#[derive(Debug, Clone)]
enum Stored {
    /// One level of 255 per texel.
    Grey(Vec<u8>),
    /// Three levels of 255 per texel.
    Rgb(Vec<u8>),
    /// Three values per texel.
    Floats(Vec<f32>),
}

impl Colors {
    /// The colours of a texture.
    ///
    /// # Errors
    /// [`MetricError::NotFinite`] if a float texture holds a NaN or an infinity.
    pub fn new(texture: Texture) -> Result<Self, MetricError> {
        let size = texture.size();
        let texture = match texture.encoding() {
            Encoding::Linear => texture.encoded_as(Encoding::Srgb),
            Encoding::Srgb | Encoding::Data => texture,
        };
        if texture.depth() == Depth::U8 && !texture.channels().has_alpha() {
            let is_grey = texture.channels() == Channels::Grey;
            let Texels::U8(levels) = texture.into_texels() else { unreachable!("8 bits") };
            let stored = if is_grey { Stored::Grey(levels) } else { Stored::Rgb(levels) };
            return Ok(Self { size, stored });
        }
        let has_alpha = texture.channels().has_alpha() && texture.encoding() != Encoding::Data;
        let channels = if has_alpha { Channels::Rgba } else { Channels::Rgb };
        let Texels::F32(mut values) = texture.converted(channels, Depth::F32).into_texels() else {
            unreachable!("converted to floats")
        };
        if has_alpha {
            over_black(&mut values);
        }
        let colors = Self { size, stored: Stored::Floats(values) };
        match colors.position(|value| !value.is_finite()) {
            Some((x, y)) => Err(MetricError::NotFinite { x, y }),
            None => Ok(colors),
        }
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The values of texels, three each, of the rows one after the other.
    pub fn values(&self, texels: Range<usize>) -> Cow<'_, [f32]> {
        // As textures are converted to floats.
        let value = |&level: &u8| f32::from(level) * (1.0 / 255.0);
        match &self.stored {
            Stored::Floats(values) => values[in_threes(texels)].into(),
            Stored::Rgb(levels) => levels[in_threes(texels)].iter().map(value).collect(),
            Stored::Grey(levels) => levels[texels].iter().map(value).flat_map(|v| [v; 3]).collect(),
        }
    }

    /// Column and row of the first texel with a value that cannot be one of 8 bits, and meets a condition.
    pub(crate) fn position(&self, condition: impl Fn(&f32) -> bool) -> Option<(u32, u32)> {
        let Stored::Floats(values) = &self.stored else { return None };
        let texel = values.iter().position(condition)? as u32 / 3;
        Some((texel % self.size.width, texel / self.size.width))
    }

    /// As [`values`](Self::values), as levels of 255, if the texture has 8 bits.
    #[cfg(any(feature = "ssimulacra2", feature = "flip"))]
    pub(crate) fn levels(&self, texels: Range<usize>) -> Option<Cow<'_, [u8]>> {
        match &self.stored {
            Stored::Floats(_) => None,
            Stored::Rgb(levels) => Some(levels[in_threes(texels)].into()),
            Stored::Grey(levels) => Some(levels[texels].iter().flat_map(|&v| [v; 3]).collect()),
        }
    }
}

/// The range of three values for each texel.
const fn in_threes(texels: Range<usize>) -> Range<usize> {
    texels.start * 3..texels.end * 3
}

/// Turns RGBA into RGB in place.
fn over_black(values: &mut Vec<f32>) {
    let texels = values.len() / 4;
    for texel in 0..texels {
        let alpha = values[texel * 4 + 3];
        for channel in 0..3 {
            values[texel * 3 + channel] = values[texel * 4 + channel] * alpha;
        }
    }
    values.truncate(texels * 3);
    values.shrink_to_fit();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_the_values_that_floats_have() {
        let levels: Vec<u8> = (0..=255).collect();
        for channels in [Channels::Grey, Channels::Rgb] {
            let size = Size::new(256 / channels.count() as u32, 1);
            let levels = levels[..size.texels() * channels.count()].to_vec();
            let texture = Texture::new(size, channels, Encoding::Srgb, Texels::U8(levels)).unwrap();
            let floats = texture.clone().converted(Channels::Rgb, Depth::F32);
            let [small, large] = [texture, floats].map(|texture| Colors::new(texture).unwrap());
            let all = 0..size.texels();
            assert_eq!(small.values(all.clone()), large.values(all.clone()));
            #[cfg(any(feature = "ssimulacra2", feature = "flip"))]
            assert!(small.levels(all.clone()).is_some() && large.levels(all.clone()).is_none());
        }
    }

    #[test]
    fn transparent_texels_are_over_black() {
        let texels = Texels::F32(vec![1.0, 0.5, 0.25, 0.5, 0.25, 1.0, 0.75, 0.0]);
        let texture = Texture::new(Size::new(2, 1), Channels::Rgba, Encoding::Srgb, texels);
        let colors = Colors::new(texture.unwrap()).unwrap();
        assert_eq!(*colors.values(0..2), [0.5, 0.25, 0.125, 0.0, 0.0, 0.0]);
        assert_eq!(*colors.values(1..2), [0.0; 3]);
    }
}
