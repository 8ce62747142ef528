//! Texture colours in the form that metrics compare.

use uvgraft::color::Encoding;
use uvgraft::texture::{Channels, Depth, Size, Texels, Texture};

use super::MetricError;

/// The colours of a texture as a display shows them: RGB with the sRGB transfer function, 1.0 for
/// white, composited over black where the texture is not opaque. Grey becomes three equal values,
/// and data is treated as if it were colour.
#[derive(Debug, Clone)]
pub struct Colors {
    size: Size,
    values: Vec<f32>,
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
        let has_alpha = texture.channels().has_alpha() && texture.encoding() != Encoding::Data;
        let channels = if has_alpha { Channels::Rgba } else { Channels::Rgb };
        let Texels::F32(mut values) = texture.converted(channels, Depth::F32).into_texels() else {
            unreachable!("converted to floats")
        };
        if has_alpha {
            values = values
                .chunks_exact(4)
                .flat_map(|texel| [0, 1, 2].map(|channel| texel[channel] * texel[3]))
                .collect();
        }
        if let Some(index) = values.iter().position(|value| !value.is_finite()) {
            let texel = (index / 3) as u32;
            return Err(MetricError::NotFinite { x: texel % size.width, y: texel / size.width });
        }
        Ok(Self { size, values })
    }

    /// Width and height.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The values, row-major, three per texel.
    pub fn values(&self) -> &[f32] {
        &self.values
    }
}
