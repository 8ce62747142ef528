//! Reflection models of surfaces.

/// How a surface reflects light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shading {
    /// Diffuse, with almost no highlight.
    #[default]
    Matt,
    /// Broad highlights; light wraps around into the shade, red the most.
    Skin,
    /// Small, bright highlights.
    Eye,
    /// Highlights in the hair's own colour.
    Hair,
    /// Faint, broad highlights.
    Leather,
}

impl Shading {
    /// The shading with a lower-case name: `matt`, `skin`, `eye`, `hair` or `leather`.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "matt" => Self::Matt,
            "skin" => Self::Skin,
            "eye" => Self::Eye,
            "hair" => Self::Hair,
            "leather" => Self::Leather,
            _ => return None,
        })
    }

    /// Strength and exponent of highlights.
    pub(crate) fn gloss(self) -> (f32, f32) {
        match self {
            Self::Matt => (0.015, 8.0),
            Self::Skin => (0.085, 22.0),
            Self::Eye => (0.9, 220.0),
            Self::Hair => (0.15, 20.0),
            Self::Leather => (0.08, 30.0),
        }
    }

    /// How far diffuse light wraps around into the shade, in red, green and blue: skin
    /// glows red there.
    pub(crate) fn wrap(self) -> [f32; 3] {
        match self {
            Self::Skin => [0.42, 0.22, 0.16],
            Self::Eye => [0.4, 0.4, 0.4],
            _ => [0.12, 0.12, 0.12],
        }
    }
}

/// Specular highlights from a file's material, as a Blinn-Phong lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Glint {
    pub color: [f32; 3],
    sharpness: f32,
}

impl Glint {
    /// - `color`: linear specular colour at normal incidence.
    /// - `glossiness`: from 0 to 1; the roughness is `(1 - glossiness)^2`.
    pub fn new(color: [f32; 3], glossiness: f32) -> Self {
        let roughness = (1.0 - glossiness.clamp(0.0, 1.0)).powi(2);
        // `2 / roughness^2 - 2` gives the lobe the width of a microfacet lobe of that roughness.
        // The roughness has a lower limit, since even a mirror shows lights of a finite size.
        let sharpness = 2.0 / (roughness * roughness).max(1e-3) - 2.0;
        Self { color: color.map(|value| value.clamp(0.0, 1.0)), sharpness: sharpness.max(1.0) }
    }

    pub fn sharpness(&self) -> f32 {
        self.sharpness
    }

    /// The fraction of light left for diffuse reflection.
    pub fn rest(&self) -> f32 {
        1.0 - self.color.iter().fold(0.0, |most: f32, &value| most.max(value))
    }

    /// Reflected fraction of a light, for the cosine between normal and half-way vector; normalised
    /// by `(sharpness + 2) / 8`.
    pub fn peak(&self, facing_half: f32) -> f32 {
        (self.sharpness + 2.0) / 8.0 * facing_half.max(0.0).powf(self.sharpness)
    }
}

/// The diffuse colour of a surface and its highlights.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paint {
    pub shading: Shading,
    pub albedo: [f32; 3],
    /// Replaces the highlights of `shading`.
    pub glint: Option<Glint>,
}
