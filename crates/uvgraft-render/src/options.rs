//! How pictures are made.

/// How a picture is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderOptions {
    /// Whether there is light at all. Without it every surface has the plain colour of its texture,
    /// and there are no shadows.
    pub lit: bool,
    /// What is behind everything.
    pub background: Background,
    /// Height of a floor that takes shadows, if there is one; seen from above only.
    pub floor: Option<f32>,
    /// Samples along each side of a pixel: 2, or 4 for smoother edges.
    pub samples: u32,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { lit: true, background: Background::Studio, floor: None, samples: 4 }
    }
}

/// What is behind everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Background {
    /// A neutral backdrop that is brighter in the middle.
    Studio,
    /// One colour, sRGB.
    Plain([u8; 3]),
    /// Nothing: the picture has opacity. A floor's shadow is black that one sees through.
    Transparent,
}
