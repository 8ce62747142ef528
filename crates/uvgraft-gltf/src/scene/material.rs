//! What surfaces look like: the part of glTF's materials that is drawn.

/// How a surface looks: the part of glTF's materials that is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name.
    pub name: String,
    /// Linear colour and opacity; multiplies the texture.
    pub color: [f32; 4],
    /// What is spread over the surface.
    pub texture: Option<TextureUse>,
    /// Linear light that it gives off by itself, which its texture is multiplied with. May be above 1.
    pub emissive: [f32; 3],
    /// Where it gives off light, and of which colour.
    pub emissive_texture: Option<TextureUse>,
    /// Normals in tangent space: X along U, Y against V, Z out of the surface, each -1 to 1 as 0 to 1.
    pub normal: Option<Scaled>,
    /// How much of the sky reaches the surface, in the red channel.
    pub occlusion: Option<Scaled>,
    /// Highlights, where the file tells them by colour and sharpness.
    pub gloss: Option<Gloss>,
    /// What opacity means.
    pub alpha: Alpha,
    /// Whether it is seen from behind too.
    pub double_sided: bool,
    /// Whether it has its colour whatever the light.
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
            alpha: Alpha::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

/// A texture of numbers, and how much of it counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaled {
    /// The texture.
    pub texture: TextureUse,
    /// Multiplies a normal's X and Y, or is the share of an occlusion.
    pub scale: f32,
}

/// How a surface mirrors light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gloss {
    /// Linear colour of what is mirrored straight on; what it takes is missing from the surface's own.
    pub specular: [f32; 3],
    /// From 0, rough, to 1, a mirror.
    pub glossiness: f32,
    /// Multiplies both: the colour and, as opacity, the glossiness.
    pub texture: Option<TextureUse>,
}

/// A texture and how it goes on beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureUse {
    /// Its number among the scene's textures.
    pub index: usize,
    /// To the sides, and up and down.
    pub wrap: [Wrap; 2],
    /// Whether enlarged texels are squares.
    pub nearest: bool,
    /// Which of the vertices' texture coordinates: 0 for `Drawn::uv`, others for `Drawn::more_uv`.
    pub coordinates: usize,
}

/// How a texture goes on beyond its edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// From its start again.
    #[default]
    Repeat,
    /// Back and forth.
    Mirror,
    /// With the colour at the edge.
    Clamp,
}

/// What opacity means.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Alpha {
    /// Nothing.
    Opaque,
    /// There is no surface where it is below this.
    Mask(f32),
    /// The share of what is seen.
    Blend,
}
