//! What normal maps follow.

/// Which way the green channel of a normal map counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "lowercase"))]
pub enum NormalY {
    /// Bright green leans to the top of the image ("+Y"): OpenGL, glTF, Blender, Unity.
    #[default]
    OpenGl,
    /// Bright green leans to the bottom of the image ("−Y"): DirectX, Unreal.
    DirectX,
}

/// What normal maps follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[non_exhaustive]
pub struct NormalOptions {
    /// Of the map that normals come from.
    pub source: NormalY,
    /// Of the map that they go to.
    pub target: NormalY,
}

impl NormalOptions {
    /// From a map that follows one to a map that follows the other.
    pub const fn new(source: NormalY, target: NormalY) -> Self {
        Self { source, target }
    }
}
