//! Material maps: their roles, and how each role is processed.

use uvgraft::{Content, Depth, Encoding, Filter, NormalOptions, TexelFormat};
use uvgraft_image::{DeclaredSpace, Format};

use crate::failure::{Failure, Result};

/// What the values of a texture mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[non_exhaustive]
pub enum Values {
    /// The surface's base colour, which takes part in tone matching.
    #[default]
    Albedo,
    /// Another colour.
    Color,
    /// Data, which is never colour-managed and has no alpha.
    Data,
    /// Tangent-space normals.
    Normals,
    /// Data that is processed as floats if the output format supports them.
    Displacement,
}

/// The role of a material map, and what its values mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Role {
    name: &'static str,
    values: Values,
}

const ROLES: [(&str, Values); 27] = [
    ("albedo", Values::Albedo),
    ("base-color", Values::Albedo),
    ("color", Values::Albedo),
    ("diffuse", Values::Albedo),
    ("emissive", Values::Color),
    ("sheen-color", Values::Color),
    ("specular-color", Values::Color),
    ("subsurface-color", Values::Color),
    ("alpha", Values::Data),
    ("ao", Values::Data),
    ("cavity", Values::Data),
    ("clearcoat", Values::Data),
    ("curvature", Values::Data),
    ("data", Values::Data),
    ("gloss", Values::Data),
    ("mask", Values::Data),
    ("metallic", Values::Data),
    ("occlusion", Values::Data),
    ("opacity", Values::Data),
    ("orm", Values::Data),
    ("roughness", Values::Data),
    ("specular", Values::Data),
    ("subsurface", Values::Data),
    ("thickness", Values::Data),
    ("normal", Values::Normals),
    ("displacement", Values::Displacement),
    ("height", Values::Displacement),
];

impl Role {
    /// Finds a role by its name.
    ///
    /// # Errors
    /// For an unknown name, with the known ones.
    pub fn named(name: &str) -> Result<Self> {
        let found = ROLES.iter().find(|(known, _)| *known == name);
        found.map(|&(name, values)| Self { name, values }).ok_or_else(|| {
            let names: Vec<&str> = ROLES.iter().map(|(name, _)| *name).collect();
            Failure::option(format!("`map` {name}: role must be one of {}", names.join(", ")))
        })
    }

    /// Its name, such as `roughness`; outputs are named after it.
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// What its values mean.
    pub const fn values(self) -> Values {
        self.values
    }
}

impl Values {
    pub(crate) fn is_data(self) -> bool {
        !matches!(self, Self::Albedo | Self::Color)
    }

    pub(crate) fn is_toned(self) -> bool {
        self == Self::Albedo
    }

    /// The content type for a graft.
    pub(crate) fn content(self, normals: NormalOptions) -> Content {
        match self {
            Self::Albedo | Self::Color => Content::Color,
            Self::Data | Self::Displacement => Content::Data,
            Self::Normals => Content::Normals(normals),
        }
    }

    /// Colour of the default base, 1.0 for full intensity.
    pub(crate) fn default_base(self) -> [f32; 4] {
        match self {
            Self::Normals => [0.5, 0.5, 1.0, 1.0],
            // Data has no alpha channel, so the base cannot be transparent.
            Self::Data | Self::Displacement => [0.0, 0.0, 0.0, 1.0],
            Self::Albedo | Self::Color => [0.0; 4],
        }
    }

    /// The default interpolation filter.
    pub(crate) fn filter(self) -> Filter {
        // Overshoot would produce values that no texel has.
        if self.is_data() { Filter::Bilinear } else { Filter::default() }
    }

    /// The format with the encoding that the values imply.
    pub(crate) fn reinterpret(self, format: TexelFormat) -> TexelFormat {
        if self.is_data() { TexelFormat { encoding: Encoding::Data, ..format } } else { format }
    }

    /// Whether colour spaces that files declare are converted.
    pub(crate) fn space(self) -> DeclaredSpace {
        if self.is_data() { DeclaredSpace::Ignored } else { DeclaredSpace::Honoured }
    }

    /// The bit depth used for processing a texture that is written in the given format.
    pub(crate) fn depth(self, found: Depth, format: Option<Format>) -> Depth {
        let holds_floats = format.is_some_and(|format| format.codec().holds(Depth::F32));
        if self == Self::Displacement && holds_floats { Depth::F32 } else { found }
    }
}
