//! The material of a triangle, evaluated at a point.

use glam::{Vec3, vec3};
use uvgraft_gltf::scene::{Material, ScaledTexture, SpecularGloss, TextureUse, Wrap};

use super::mipmap::Mipmap;
use super::point::Point;
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
pub(crate) struct NeededMipmaps(pub Vec<(usize, Role)>);

impl NeededMipmaps {
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
    pub fn new(material: &Material, textures: usize, needed: &mut NeededMipmaps) -> Self {
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

    /// Whether all textures are magnified at a footprint.
    pub fn is_smooth(&self, lookup: &Lookup<'_>) -> bool {
        let material = &self.material;
        let scaled = [material.normal, material.occlusion].map(|map| map.map(|map| map.texture));
        let colors = [material.texture, material.emissive_texture];
        let gloss = material.gloss.and_then(|gloss| gloss.texture);
        let mut textures = colors.into_iter().chain(scaled).chain([gloss]).flatten();
        textures.all(|texture| lookup.is_small(texture))
    }

    /// The exponent of its highlights, or more.
    pub fn sharpness(&self) -> f32 {
        self.material.gloss.map_or_else(
            || self.shading.gloss().1,
            |gloss| Glint::new([0.0; 3], gloss.glossiness).sharpness(),
        )
    }

    /// Linear colour and alpha over the texture's footprint, multiplied by the vertices' colours.
    pub fn color(&self, lookup: &Lookup<'_>) -> [f32; 4] {
        lookup.point.tinted(self.albedo(lookup))
    }

    fn albedo(&self, lookup: &Lookup<'_>) -> [f32; 4] {
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

    /// The file's specular colour and glossiness; `None` if it has none.
    pub fn gloss(&self, lookup: &Lookup<'_>) -> Option<[f32; 4]> {
        let gloss = self.material.gloss?;
        let [r, g, b, a] = gloss.texture.map_or([1.0; 4], |texture| lookup.sample(texture));
        let [red, green, blue] = gloss.specular;
        Some([red * r, green * g, blue * b, gloss.glossiness * a])
    }
}

/// How a surface's textures are sampled.
pub(crate) struct Lookup<'a> {
    pub mipmaps: &'a [Mipmap],
    pub point: &'a Point<'a>,
}

impl Lookup<'_> {
    fn sample(&self, texture: TextureUse) -> [f32; 4] {
        self.mipmaps[texture.index].sample(&self.point.footprint(texture.coordinates), &texture)
    }

    /// Whether the footprint is within a texel or two of a texture, so that one interpolated value
    /// stands for all of it.
    fn is_small(&self, texture: TextureUse) -> bool {
        let footprint = self.point.footprint(texture.coordinates);
        !texture.nearest && self.mipmaps[texture.index].is_magnified(&footprint)
    }
}
