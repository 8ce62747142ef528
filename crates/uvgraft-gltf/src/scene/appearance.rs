//! Reads materials and their textures.

use uvgraft::Texture;

use super::accessor::Accessors;
use super::asset::Asset;
use super::budget::Demand;
use super::document::{self, TextureInfo};
use super::error::SceneError;
use super::images::Images;
use super::material::{AlphaMode, Material, ScaledTexture, SpecularGloss, TextureUse};

/// The UV set of a texture, and the transform applied to it.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct UvSource {
    pub set: u32,
    transform: Option<document::TextureTransform>,
}

impl UvSource {
    /// Where the textures of a material that use a UV set find their coordinates: the first of them
    /// decides, the base colour before all others. Without any, coordinates are as stored.
    ///
    /// Quantised files store coordinates as integers, which only this transform brings back into
    /// the texture.
    pub fn of_set(
        material: &document::Material,
        set: u32,
        place: &str,
    ) -> Result<Self, SceneError> {
        let older = material.extensions.specular_glossiness.as_ref();
        let textures = [
            older.and_then(|older| older.diffuse_texture.as_ref()),
            material.pbr_metallic_roughness.base_color_texture.as_ref(),
            material.normal_texture.as_ref(),
            material.emissive_texture.as_ref(),
            material.occlusion_texture.as_ref(),
        ];
        for info in textures.into_iter().flatten() {
            let source = Self::of(info, place)?;
            if source.set == set {
                return Ok(source);
            }
        }
        Ok(Self { set, transform: None })
    }

    /// The different sources of all textures of a material, at least one; those that cannot be read are left
    /// out.
    pub fn of_all(material: &document::Material) -> Vec<Self> {
        let older = material.extensions.specular_glossiness.as_ref();
        let textures = [
            base_color_texture(material),
            material.emissive_texture.as_ref(),
            material.normal_texture.as_ref(),
            material.occlusion_texture.as_ref(),
            older.and_then(|older| older.specular_glossiness_texture.as_ref()),
        ];
        let mut sources = Vec::new();
        for info in textures.into_iter().flatten() {
            if let Ok(source) = Self::of(info, "")
                && !sources.contains(&source)
            {
                sources.push(source);
            }
        }
        if sources.is_empty() { vec![Self::default()] } else { sources }
    }

    /// Where the base colour of a material finds its coordinates; the first set without a texture.
    pub fn of_base_color(material: &document::Material, place: &str) -> Result<Self, SceneError> {
        let info = base_color_texture(material);
        info.map_or_else(|| Ok(Self::default()), |info| Self::of(info, place))
    }

    /// Equal for equal transforms.
    pub fn transform_bits(&self) -> Option<[u32; 5]> {
        let transform = self.transform?;
        let ([dx, dy], [sx, sy]) = (transform.offset, transform.scale.unwrap_or([1.0; 2]));
        Some([dx, dy, sx, sy, transform.rotation].map(f32::to_bits))
    }

    fn of(info: &TextureInfo, place: &str) -> Result<Self, SceneError> {
        let transform = info.extensions.transform;
        if let Some(transform) = transform {
            let [a, b] = transform.offset;
            let [c, d] = transform.scale.unwrap_or([1.0; 2]);
            if ![a, b, c, d, transform.rotation].iter().all(|value| value.is_finite()) {
                let reason = "texture transform must be finite";
                return Err(SceneError::content(place, reason));
            }
        }
        let set = transform.and_then(|transform| transform.tex_coord).unwrap_or(info.tex_coord);
        Ok(Self { set, transform })
    }

    /// # Source
    /// Khronos, "KHR_texture_transform": scale, then rotation, then offset.
    pub fn transform(&self, uv: &mut [[f32; 2]]) {
        let Some(transform) = self.transform else { return };
        let (sin, cos) = transform.rotation.sin_cos();
        let ([sx, sy], [dx, dy]) = (transform.scale.unwrap_or([1.0; 2]), transform.offset);
        for uv in uv {
            let (u, v) = (uv[0] * sx, uv[1] * sy);
            *uv = [cos * u + sin * v + dx, cos * v - sin * u + dy];
        }
    }
}

/// The texture of a material's base colour, in the older workflow of materials the diffuse one.
pub(super) fn base_color_texture(material: &document::Material) -> Option<&TextureInfo> {
    match &material.extensions.specular_glossiness {
        Some(older) => older.diffuse_texture.as_ref(),
        None => material.pbr_metallic_roughness.base_color_texture.as_ref(),
    }
}

/// All materials, and one more at the end for primitives without a material.
pub(super) struct Appearance {
    pub materials: Vec<Material>,
    /// UV sources of each material, at least one; [`TextureUse::coordinates`] indexes them.
    pub uv_sources: Vec<Vec<UvSource>>,
    pub textures: Vec<Texture>,
}

pub(super) fn appearance<'c>(
    asset: &Asset<'c>,
    accessors: &Accessors<'c>,
    demand: Demand,
) -> Result<Appearance, SceneError> {
    let mut images = Images::new(demand);
    let (mut materials, mut uv_sources) = (Vec::new(), Vec::new());
    for (index, material) in asset.document.materials.iter().enumerate() {
        let place = format!("material {index}");
        let mut textures =
            MaterialTextures { asset, accessors, images: &mut images, place, sources: vec![] };
        materials.push(read(material, &mut textures)?);
        let mut sources = textures.sources;
        sources.resize_with(sources.len().max(1), UvSource::default);
        uv_sources.push(sources);
    }
    materials.push(Material::default());
    uv_sources.push(vec![UvSource::default()]);
    images.demand().check()?;
    Ok(Appearance { materials, uv_sources, textures: images.decode()? })
}

fn read(
    material: &document::Material,
    textures: &mut MaterialTextures<'_, '_>,
) -> Result<Material, SceneError> {
    let (pbr, extensions) = (&material.pbr_metallic_roughness, &material.extensions);
    let older = extensions.specular_glossiness.as_ref();
    let color = older.map_or(pbr.base_color_factor, |older| older.diffuse_factor);
    let color = color.unwrap_or([1.0; 4]);
    let strength = extensions.emissive_strength.as_ref().and_then(|info| info.emissive_strength);
    let strength = strength.unwrap_or(1.0);
    let emissive = material.emissive_factor.unwrap_or_default().map(|value| value * strength);
    let cutoff = material.alpha_cutoff.unwrap_or(0.5);
    textures.finite(&[&color[..], &emissive, &[cutoff]].concat())?;
    // The base colour texture is read first, so its UV source has index 0.
    let texture = textures.used(base_color_texture(material), false)?;
    Ok(Material {
        name: material.name.clone().unwrap_or_default(),
        color,
        texture,
        emissive,
        emissive_texture: textures.used(material.emissive_texture.as_ref(), false)?,
        normal: textures.scaled(material.normal_texture.as_ref(), |info| info.scale)?,
        occlusion: textures.scaled(material.occlusion_texture.as_ref(), |info| info.strength)?,
        gloss: older.map(|older| gloss(older, textures)).transpose()?,
        alpha: alpha(material, cutoff, &textures.place)?,
        double_sided: material.double_sided,
        unlit: extensions.unlit.is_some(),
    })
}

fn gloss(
    older: &document::SpecularGlossiness,
    textures: &mut MaterialTextures<'_, '_>,
) -> Result<SpecularGloss, SceneError> {
    let specular = older.specular_factor.unwrap_or([1.0; 3]);
    let glossiness = older.glossiness_factor.unwrap_or(1.0);
    textures.finite(&[&specular[..], &[glossiness]].concat())?;
    let texture = textures.used(older.specular_glossiness_texture.as_ref(), false)?;
    Ok(SpecularGloss { specular, glossiness, texture })
}

fn alpha(material: &document::Material, cutoff: f32, place: &str) -> Result<AlphaMode, SceneError> {
    Ok(match material.alpha_mode.as_deref() {
        None | Some("OPAQUE") => AlphaMode::Opaque,
        Some("MASK") => AlphaMode::Mask(cutoff),
        Some("BLEND") => AlphaMode::Blend,
        Some(other) => {
            let reason = format!("alpha mode must be OPAQUE, MASK or BLEND, got {other:?}");
            return Err(SceneError::content(place, reason));
        }
    })
}

/// The textures of one material.
struct MaterialTextures<'a, 'c> {
    asset: &'a Asset<'c>,
    accessors: &'a Accessors<'c>,
    images: &'a mut Images<'c>,
    place: String,
    sources: Vec<UvSource>,
}

impl MaterialTextures<'_, '_> {
    /// - `is_data`: whether the texture has numbers instead of colours.
    fn used(
        &mut self,
        info: Option<&TextureInfo>,
        is_data: bool,
    ) -> Result<Option<TextureUse>, SceneError> {
        let Some(info) = info else { return Ok(None) };
        let texture = (info.index, is_data);
        let found = self.images.use_of(texture, &self.place, self.asset, self.accessors)?;
        let Some(found) = found else { return Ok(None) };
        let source = UvSource::of(info, &self.place)?;
        let known = self.sources.iter().position(|known| *known == source);
        let coordinates = known.unwrap_or_else(|| {
            self.sources.push(source);
            self.sources.len() - 1
        });
        Ok(Some(TextureUse { coordinates, ..found }))
    }

    fn scaled(
        &mut self,
        info: Option<&TextureInfo>,
        scale: impl Fn(&TextureInfo) -> Option<f32>,
    ) -> Result<Option<ScaledTexture>, SceneError> {
        let scale = info.and_then(scale).unwrap_or(1.0);
        self.finite(&[scale])?;
        Ok(self.used(info, true)?.map(|texture| ScaledTexture { texture, scale }))
    }

    fn finite(&self, values: &[f32]) -> Result<(), SceneError> {
        if values.iter().all(|value| value.is_finite()) {
            return Ok(());
        }
        let reason = "factors must be finite";
        Err(SceneError::content(self.place.as_str(), reason))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_is_scaled_then_turned_then_moved() {
        let transform = document::TextureTransform {
            offset: [0.1, 0.2],
            rotation: std::f32::consts::FRAC_PI_2,
            scale: Some([2.0, 3.0]),
            tex_coord: None,
        };
        let mut uv = [[0.25, 0.5]];
        UvSource { set: 0, transform: Some(transform) }.transform(&mut uv);
        // (0.5, 1.5) rotated by 90° is (1.5, -0.5).
        assert!((uv[0][0] - 1.6).abs() < 1e-6 && (uv[0][1] + 0.3).abs() < 1e-6, "{uv:?}");
    }
}
