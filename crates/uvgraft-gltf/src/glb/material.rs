//! Materials of an avatar, with their images as encoded files.

use super::embedded_image::EmbeddedImage;

/// Lighting model of a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum ShadingModel {
    /// glTF's physically based model, supported by all readers.
    #[default]
    Pbr,
    /// Toon shading by `VRMC_materials_mtoon` 1.0; readers without it fall back to
    /// [`ShadingModel::Pbr`].
    MToon,
    /// Unlit: plain colours, by `KHR_materials_unlit`.
    Unlit,
}

uvgraft::choices!(ShadingModel {
    Pbr => "pbr", "Physically based, supported everywhere";
    MToon => "mtoon", "Toon shading (MToon 1.0, .vrm only); readers without support use pbr";
    Unlit => "unlit", "No lighting, for textures with baked light";
});

/// A material. Each one costs a draw call, and platforms rank avatars by their number.
#[derive(Debug, Clone)]
pub struct AvatarMaterial {
    /// Name of the material.
    pub name: String,
    /// Base colour, sRGB. Its alpha is ignored.
    pub color: EmbeddedImage,
    /// Normal map in tangent space with green up ("OpenGL"); with it, tangents are written.
    pub normal: Option<EmbeddedImage>,
    /// Roughness in green and metalness in blue, as in glTF; multiplied by the factors.
    pub roughness: Option<EmbeddedImage>,
    /// Ambient occlusion in red; if it is the same image as `roughness`, it is stored once.
    pub occlusion: Option<EmbeddedImage>,
    /// Emitted light, sRGB.
    pub emissive: Option<EmbeddedImage>,
    /// `0.0..=1.0`, 1 for fully rough.
    pub roughness_factor: f32,
    /// `0.0..=1.0`, 0 for non-metals.
    pub metallic_factor: f32,
    /// Whether back faces are visible.
    pub double_sided: bool,
    /// Lighting model.
    pub style: ShadingModel,
    /// Whether its triangles block the view from the avatar's eyes: VRM files hide them in first
    /// person.
    pub is_head: bool,
}

impl AvatarMaterial {
    /// A default for skin and cloth with a texture: not metallic, rather rough.
    pub fn new(color: EmbeddedImage) -> Self {
        Self {
            name: "body".to_owned(),
            color,
            normal: None,
            roughness: None,
            occlusion: None,
            emissive: None,
            roughness_factor: 0.7,
            metallic_factor: 0.0,
            double_sided: false,
            style: ShadingModel::default(),
            is_head: false,
        }
    }

    /// Whether its vertices have tangents: with a normal map, but not with MToon, whose shaders
    /// reject them (three-vrm 3); readers then compute tangents, as glTF specifies.
    pub(super) fn has_tangents(&self) -> bool {
        self.normal.is_some() && self.style != ShadingModel::MToon
    }

    /// All images, each once, in storage order.
    pub fn pictures(&self) -> impl Iterator<Item = &EmbeddedImage> {
        let occlusion = self.occlusion.as_ref().filter(|_| self.occlusion != self.roughness);
        let data = [self.normal.as_ref(), self.roughness.as_ref(), occlusion];
        [Some(&self.color), self.emissive.as_ref()].into_iter().chain(data).flatten()
    }
}

impl AsRef<[Self]> for AvatarMaterial {
    fn as_ref(&self) -> &[Self] {
        std::slice::from_ref(self)
    }
}
