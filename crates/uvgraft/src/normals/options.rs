//! Conventions of normal maps.

/// The direction of a normal map's green channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum NormalY {
    /// Bright green points to the top of the image ("+Y"): OpenGL, glTF, Blender, Unity.
    #[default]
    OpenGl,
    /// Bright green points to the bottom of the image ("−Y"): DirectX, Unreal.
    DirectX,
}

uvgraft_surface::choices!(NormalY {
    OpenGl => "opengl", "Y up, as in OpenGL, glTF, Unity and Blender";
    DirectX => "directx", "Y down, as in DirectX and Unreal";
});
#[cfg(feature = "serde")]
uvgraft_surface::serialize_by_name!(NormalY);

/// The conventions of the source and target normal maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[non_exhaustive]
pub struct NormalOptions {
    /// Convention of the map that normals are read from.
    pub source: NormalY,
    /// Convention of the map that is written.
    pub target: NormalY,
}

impl NormalOptions {
    /// Converts from the convention `source` to `target`.
    pub const fn new(source: NormalY, target: NormalY) -> Self {
        Self { source, target }
    }
}
