//! Rendering options.

/// How a picture is rendered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Whether the scene is lit. Unlit, every surface has the plain colour of its texture and there
    /// are no shadows.
    pub lit: bool,
    /// The background.
    pub background: Background,
    /// Height of a floor that receives shadows, if there is one; visible only from above.
    pub floor: Option<f32>,
    /// Samples along each side of a pixel: 2, or 4 for smoother edges.
    pub samples: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { lit: true, background: Background::Studio, floor: None, samples: 4 }
    }
}

/// What is behind the scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// A neutral backdrop, brighter at the centre.
    Studio,
    /// One colour, sRGB.
    Plain([u8; 3]),
    /// Nothing: the picture has an alpha channel. A floor's shadow is translucent black.
    Transparent,
}
