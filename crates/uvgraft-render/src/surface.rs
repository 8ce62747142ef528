//! What a triangle's material comes to in a picture.

use glam::{Vec3, vec3};
use uvgraft_gltf::scene::{Alpha, Gloss, Material, Scaled, TextureUse, Wrap};

use super::mipmap::{Footprint, Mipmap};
use super::shading::{Glint, Shading};

/// A material whose textures are named by the numbers of their mipmaps.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    pub shading: Shading,
    /// Linear, with opacity.
    pub color: [f32; 4],
    pub texture: Option<TextureUse>,
    pub emissive: [f32; 3],
    pub emissive_texture: Option<TextureUse>,
    pub normal: Option<Scaled>,
    pub occlusion: Option<Scaled>,
    pub gloss: Option<Gloss>,
    pub alpha: Alpha,
    pub double_sided: bool,
    pub unlit: bool,
}

/// What a texture's values are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Color,
    Data,
}

/// The mipmaps that surfaces need: textures by their numbers, each for what it is used as.
#[derive(Debug, Default)]
pub(crate) struct Needed(pub Vec<(usize, Role)>);

impl Needed {
    fn number(&mut self, texture: TextureUse, role: Role, textures: usize) -> Option<TextureUse> {
        let key = (texture.index, role);
        let known = self.0.iter().position(|&known| known == key);
        let index = known.unwrap_or(self.0.len());
        if known.is_none() && texture.index < textures {
            self.0.push(key);
        }
        (texture.index < textures).then_some(TextureUse { index, ..texture })
    }
}

impl Surface {
    /// - `textures`: how many there are; others are left out.
    pub fn new(material: &Material, textures: usize, needed: &mut Needed) -> Self {
        let mut color = |texture: Option<TextureUse>| {
            texture.and_then(|texture| needed.number(texture, Role::Color, textures))
        };
        let (texture, emissive_texture) =
            (color(material.texture), color(material.emissive_texture));
        let gloss = material.gloss.map(|gloss| Gloss { texture: color(gloss.texture), ..gloss });
        let mut data = |scaled: Option<Scaled>| {
            let Scaled { texture, scale } = scaled?;
            let texture = needed.number(texture, Role::Data, textures)?;
            Some(Scaled { texture, scale })
        };
        Self {
            shading: Shading::Matt,
            color: material.color,
            texture,
            emissive: material.emissive,
            emissive_texture,
            normal: data(material.normal),
            occlusion: data(material.occlusion),
            gloss,
            alpha: material.alpha,
            double_sided: material.double_sided,
            unlit: material.unlit,
        }
    }

    /// A part of a mesh with one texture, seen from both sides.
    pub fn of_part(shading: Shading) -> Self {
        Self {
            shading,
            color: [1.0; 4],
            texture: Some(TextureUse {
                index: 0,
                wrap: [Wrap::Clamp; 2],
                nearest: false,
                coordinates: 0,
            }),
            emissive: [0.0; 3],
            emissive_texture: None,
            normal: None,
            occlusion: None,
            gloss: None,
            alpha: Alpha::Opaque,
            double_sided: true,
            unlit: false,
        }
    }

    /// Linear colour and opacity around a place of the texture.
    pub fn albedo(&self, lookup: &Lookup<'_>) -> [f32; 4] {
        match self.texture {
            None => self.color,
            Some(texture) => {
                let sampled = lookup.sample(texture);
                [0, 1, 2, 3].map(|k| sampled[k] * self.color[k])
            }
        }
    }

    /// Linear light that it gives off.
    pub fn glow(&self, lookup: &Lookup<'_>) -> [f32; 3] {
        match self.emissive_texture {
            Some(texture) if self.emissive != [0.0; 3] => {
                let sampled = lookup.sample(texture);
                [0, 1, 2].map(|k| sampled[k] * self.emissive[k])
            }
            _ => self.emissive,
        }
    }

    /// The normal in tangent space; `None` where there is no map.
    pub fn bump(&self, lookup: &Lookup<'_>) -> Option<Vec3> {
        let Scaled { texture, scale } = self.normal?;
        let [x, y, z, _] = lookup.sample(texture).map(|value| 2.0 * value - 1.0);
        Some(vec3(x * scale, y * scale, z))
    }

    /// The share of the sky that the file says is seen from here.
    pub fn openness(&self, lookup: &Lookup<'_>) -> f32 {
        match self.occlusion {
            None => 1.0,
            Some(Scaled { texture, scale }) => {
                1.0 + scale.clamp(0.0, 1.0) * (lookup.sample(texture)[0] - 1.0)
            }
        }
    }

    /// Highlights by colour and sharpness, where the file tells them.
    pub fn glint(&self, lookup: &Lookup<'_>) -> Option<Glint> {
        let gloss = self.gloss?;
        let [r, g, b, a] = gloss.texture.map_or([1.0; 4], |texture| lookup.sample(texture));
        let [red, green, blue] = gloss.specular;
        Some(Glint::new([red * r, green * g, blue * b], gloss.glossiness * a))
    }
}

/// Where a surface's textures are looked up.
pub(crate) struct Lookup<'a> {
    pub mipmaps: &'a [Mipmap],
    /// By the number of texture coordinates.
    pub footprint: &'a dyn Fn(usize) -> Footprint,
}

impl Lookup<'_> {
    fn sample(&self, texture: TextureUse) -> [f32; 4] {
        self.mipmaps[texture.index].sample(&(self.footprint)(texture.coordinates), &texture)
    }
}
