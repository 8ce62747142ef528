//! The material of an avatar, and its images as the files they will be.

use super::picture::Picture;

/// How surfaces are lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub enum Style {
    /// By glTF's physically based model, which all readers have.
    #[default]
    Pbr,
    /// As drawings are, by `VRMC_materials_mtoon` 1.0; for readers without it as [`Style::Pbr`].
    MToon,
    /// Not at all: plain colours, by `KHR_materials_unlit`.
    Unlit,
}

/// A material. Each one costs a draw call, and platforms rank avatars by how many they have.
#[derive(Debug, Clone)]
pub struct AvatarMaterial {
    /// What the material is called.
    pub name: String,
    /// Base colour, sRGB. Its opacity is not shown.
    pub color: Picture,
    /// Normal map in tangent space with green up ("OpenGL"); with it the file has tangents.
    pub normal: Option<Picture>,
    /// Roughness in green and metalness in blue, as glTF has it; the factors are multiplied in.
    pub roughness: Option<Picture>,
    /// Ambient occlusion in red; it may be the same picture as `roughness`, which is then stored once.
    pub occlusion: Option<Picture>,
    /// What shines by itself, sRGB.
    pub emissive: Option<Picture>,
    /// `0.0..=1.0`, 1 for what does not shine.
    pub roughness_factor: f32,
    /// `0.0..=1.0`, 0 for what is no metal.
    pub metallic_factor: f32,
    /// Show the backs of triangles too.
    pub double_sided: bool,
    /// How it is lit.
    pub style: Style,
    /// Its triangles are in the way of who looks out of the avatar's eyes: VRM files hide them then.
    pub is_head: bool,
}

impl AvatarMaterial {
    /// Skin and cloth under a texture: no metal, rather rough.
    pub fn new(color: Picture) -> Self {
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
            style: Style::default(),
            is_head: false,
        }
    }

    /// Whether its vertices have tangents: where there is a normal map. Shaders of MToon refuse them (three-vrm 3), and
    /// readers of such files make their own, as glTF has it.
    pub(super) fn has_tangents(&self) -> bool {
        self.normal.is_some() && self.style != Style::MToon
    }

    /// All images, each once, in the order in which they are stored.
    pub fn pictures(&self) -> impl Iterator<Item = &Picture> {
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
