//! What a triangle's material comes to in a picture.

use super::mipmap::{Footprint, Mipmap};
use super::shade::Finish;
use crate::scene::{Alpha, Material, TextureUse, Wrap};

#[derive(Debug, Clone)]
pub(crate) struct Surface {
    pub finish: Finish,
    /// Linear, with opacity.
    pub color: [f32; 4],
    pub texture: Option<TextureUse>,
    pub alpha: Alpha,
    pub double_sided: bool,
    pub unlit: bool,
}

impl Surface {
    pub fn new(material: &Material, textures: usize) -> Self {
        Self {
            finish: Finish::named(&material.name),
            color: material.color,
            texture: material.texture.filter(|texture| texture.index < textures),
            alpha: material.alpha,
            double_sided: material.double_sided,
            unlit: material.unlit,
        }
    }

    /// A part of a mesh with one texture, seen from both sides.
    pub fn of_part(material: &str) -> Self {
        Self {
            finish: Finish::named(material),
            color: [1.0; 4],
            texture: Some(TextureUse { index: 0, wrap: [Wrap::Clamp; 2], nearest: false }),
            alpha: Alpha::Opaque,
            double_sided: true,
            unlit: false,
        }
    }

    /// Linear colour and opacity around a place of the texture.
    pub fn albedo(&self, mipmaps: &[Mipmap], footprint: &Footprint) -> [f32; 4] {
        match self.texture {
            None => self.color,
            Some(texture) => {
                let sampled = mipmaps[texture.index].sample(footprint, &texture);
                [0, 1, 2, 3].map(|k| sampled[k] * self.color[k])
            }
        }
    }
}
