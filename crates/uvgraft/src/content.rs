//! What textures hold: colours, data or normals.

use crate::normals::NormalOptions;

/// What the values of textures mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[non_exhaustive]
pub enum Content {
    /// Colours in the textures' encodings, and alpha.
    #[default]
    Color,
    /// Data, such as roughness or masks: values are never converted, and no channel is alpha.
    Data,
    /// Tangent-space normals: data that is rotated into the frames of the target's layout.
    Normals(NormalOptions),
}
