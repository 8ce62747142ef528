//! The material of a triangle, evaluated at a point.

use glam::{Vec3, vec3};
use uvgraft_gltf::scene::{Material, ScaledTexture, SpecularGloss, TextureUse, Wrap};

use super::mipmap::{Footprint, Mipmap};
use super::shading::{Glint, Shading};

/// A material, ready to draw.
#[derive(Debug, Clone)]
pub(crate) struct Surface {
    pub shading: Shading,
    /// Its texture indices refer to mipmaps.
    pub material: Material,
}

/// What a texture's values mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    Color,
    Data,
}

/// The mipmaps that surfaces need: texture indices, once for each role in which a texture is used.
#[derive(Debug, Default)]
pub(crate) struct Needed(pub Vec<(usize, Role)>);

impl Needed {
    fn insert(&mut self, texture: TextureUse, role: Role, textures: usize) -> Option<TextureUse> {
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
    /// - `textures`: number of textures; references to others are dropped.
    pub fn new(material: &Material, textures: usize, needed: &mut Needed) -> Self {
        let mut color = |texture: Option<TextureUse>| {
            texture.and_then(|texture| needed.insert(texture, Role::Color, textures))
        };
        let (texture, emissive_texture) =
            (color(material.texture), color(material.emissive_texture));
        let gloss =
            material.gloss.map(|gloss| SpecularGloss { texture: color(gloss.texture), ..gloss });
        let mut data = |scaled: Option<ScaledTexture>| {
            let ScaledTexture { texture, scale } = scaled?;
            let texture = needed.insert(texture, Role::Data, textures)?;
            Some(ScaledTexture { texture, scale })
        };
        let (normal, occlusion) = (data(material.normal), data(material.occlusion));
        let material =
            Material { texture, emissive_texture, normal, occlusion, gloss, ..material.clone() };
        Self { shading: Shading::Matt, material }
    }

    /// A surface with one texture, visible from both sides.
    pub fn of_part(shading: Shading) -> Self {
        let texture =
            TextureUse { index: 0, wrap: [Wrap::Clamp; 2], nearest: false, coordinates: 0 };
        let texture = Some(texture);
        Self { shading, material: Material { texture, double_sided: true, ..Material::default() } }
    }

    /// Linear colour and alpha over the texture's footprint.
    pub fn albedo(&self, lookup: &Lookup<'_>) -> [f32; 4] {
        match self.material.texture {
            None => self.material.color,
            Some(texture) => {
                let sampled = lookup.sample(texture);
                [0, 1, 2, 3].map(|k| sampled[k] * self.material.color[k])
            }
        }
    }

    /// Emitted light, linear.
    pub fn glow(&self, lookup: &Lookup<'_>) -> [f32; 3] {
        match self.material.emissive_texture {
            Some(texture) if self.material.emissive != [0.0; 3] => {
                let sampled = lookup.sample(texture);
                [0, 1, 2].map(|k| sampled[k] * self.material.emissive[k])
            }
            _ => self.material.emissive,
        }
    }

    /// The normal map's value in tangent space; `None` without a normal map.
    pub fn bump(&self, lookup: &Lookup<'_>) -> Option<Vec3> {
        let ScaledTexture { texture, scale } = self.material.normal?;
        let [x, y, z, _] = lookup.sample(texture).map(|value| 2.0 * value - 1.0);
        Some(vec3(x * scale, y * scale, z))
    }

    /// The fraction of the sky that is visible from here, from the file's occlusion map.
    pub fn openness(&self, lookup: &Lookup<'_>) -> f32 {
        match self.material.occlusion {
            None => 1.0,
            Some(ScaledTexture { texture, scale }) => {
                1.0 + scale.clamp(0.0, 1.0) * (lookup.sample(texture)[0] - 1.0)
            }
        }
    }

    /// Highlights from the file's specular colour and glossiness; `None` if it has none.
    pub fn glint(&self, lookup: &Lookup<'_>) -> Option<Glint> {
        let gloss = self.material.gloss?;
        let [r, g, b, a] = gloss.texture.map_or([1.0; 4], |texture| lookup.sample(texture));
        let [red, green, blue] = gloss.specular;
        Some(Glint::new([red * r, green * g, blue * b], gloss.glossiness * a))
    }
}

/// How a surface's textures are sampled.
pub(crate) struct Lookup<'a> {
    pub mipmaps: &'a [Mipmap],
    /// The footprint in a set of texture coordinates, by its index.
    pub footprint: &'a dyn Fn(usize) -> Footprint,
}

impl Lookup<'_> {
    fn sample(&self, texture: TextureUse) -> [f32; 4] {
        self.mipmaps[texture.index].sample(&(self.footprint)(texture.coordinates), &texture)
    }
}
