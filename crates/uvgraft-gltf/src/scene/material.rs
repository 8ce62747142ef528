//! Materials: the part of glTF's material model that is rendered.

/// A surface material.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Base colour, linear RGBA; multiplies the texture.
    pub color: [f32; 4],
    /// Base colour texture.
    pub texture: Option<TextureUse>,
    /// Emitted light, linear; multiplied by its texture. May exceed 1.
    pub emissive: [f32; 3],
    /// Texture of the emitted light.
    pub emissive_texture: Option<TextureUse>,
    /// Normal map in tangent space: X along U, Y against V, Z out of the surface, -1 to 1 stored as
    /// 0 to 1.
    pub normal: Option<ScaledTexture>,
    /// Ambient occlusion, in the red channel: the share of the sky that is visible.
    pub occlusion: Option<ScaledTexture>,
    /// Specular highlights, for files in the specular-glossiness model.
    pub gloss: Option<SpecularGloss>,
    /// Alpha mode.
    pub alpha: AlphaMode,
    /// Whether back faces are visible.
    pub double_sided: bool,
    /// Whether it ignores lighting.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            color: [1.0; 4],
            texture: None,
            emissive: [0.0; 3],
            emissive_texture: None,
            normal: None,
            occlusion: None,
            gloss: None,
            alpha: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

/// A data texture with a strength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaledTexture {
    /// The texture.
    pub texture: TextureUse,
    /// Scale of a normal's X and Y, or strength of the occlusion.
    pub scale: f32,
}

/// Specular reflection of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecularGloss {
    /// Specular colour at normal incidence, linear; diffuse reflection is reduced by as much.
    pub specular: [f32; 3],
    /// From 0, rough, to 1, a mirror.
    pub glossiness: f32,
    /// Multiplies both: specular colour in RGB, glossiness in alpha.
    pub texture: Option<TextureUse>,
}

/// A texture with its sampler settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureUse {
    /// Index among the scene's textures.
    pub index: usize,
    /// Wrap modes along U and V.
    pub wrap: [Wrap; 2],
    /// Whether magnification uses nearest-neighbour filtering.
    pub nearest: bool,
    /// Index of the vertices' texture coordinates: 0 for `PosedPrimitive::uv`, others for
    /// `PosedPrimitive::more_uv`.
    pub coordinates: usize,
}

/// Wrap mode of a texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Repeats.
    #[default]
    Repeat,
    /// Repeats, mirrored every other time.
    Mirror,
    /// Clamps to the colour at the edge.
    Clamp,
}

/// Alpha mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored.
    Opaque,
    /// The surface is cut out where alpha is below this value.
    Mask(f32),
    /// Alpha blending.
    Blend,
}
