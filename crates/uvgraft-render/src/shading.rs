//! How surfaces reflect light.

/// How a surface reflects light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shading {
    /// Diffuse, with hardly a highlight.
    #[default]
    Matt,
    /// Broad highlights; light wraps around into the shade, red most.
    Skin,
    /// Small, bright highlights.
    Eye,
    /// Highlights of the hair's own colour.
    Hair,
    /// Faint, broad highlights.
    Leather,
}

impl Shading {
    /// The shading of a name, in lower case: `matt`, `skin`, `eye`, `hair` or `leather`.
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

    /// Strength and sharpness of highlights.
    pub(crate) fn gloss(self) -> (f32, f32) {
        match self {
            Self::Matt => (0.015, 8.0),
            Self::Skin => (0.085, 22.0),
            Self::Eye => (0.9, 220.0),
            Self::Hair => (0.15, 20.0),
            Self::Leather => (0.08, 30.0),
        }
    }

    /// How far light creeps around into the shade, for red, green and blue: skin glows red there.
    pub(crate) fn wrap(self) -> [f32; 3] {
        match self {
            Self::Skin => [0.42, 0.22, 0.16],
            Self::Eye => [0.4, 0.4, 0.4],
            _ => [0.12, 0.12, 0.12],
        }
    }
}

/// Highlights that a file describes, as Blinn and Phong do.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Glint {
    pub color: [f32; 3],
    sharpness: f32,
}

impl Glint {
    /// - `color`: linear, of light that is mirrored straight on.
    /// - `glossiness`: from 0 to 1; the roughness is what is missing to 1, squared.
    pub fn new(color: [f32; 3], glossiness: f32) -> Self {
        let roughness = (1.0 - glossiness.clamp(0.0, 1.0)).powi(2);
        // Where both have the same width; mirrors show lights that have some size.
        let sharpness = 2.0 / (roughness * roughness).max(1e-3) - 2.0;
        Self { color: color.map(|value| value.clamp(0.0, 1.0)), sharpness: sharpness.max(1.0) }
    }

    /// What is left of light for the surface's own colour.
    pub fn rest(&self) -> f32 {
        1.0 - self.color.iter().fold(0.0, |most: f32, &value| most.max(value))
    }

    /// The part of a light that is mirrored to where the half-way vector is seen from.
    pub fn peak(&self, facing_half: f32) -> f32 {
        (self.sharpness + 2.0) / 8.0 * facing_half.max(0.0).powf(self.sharpness)
    }
}

/// A surface's own colour, and what it mirrors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Paint {
    pub shading: Shading,
    pub albedo: [f32; 3],
    /// In place of the shading's highlights.
    pub glint: Option<Glint>,
}
