//! Carries textures between meshes with different UV layouts.

pub mod color;
pub mod mesh;
pub mod raster;
pub mod texture;

pub use color::Encoding;
pub use mesh::{Corner, Mesh, MeshError, Part};
pub use texture::{Channels, Depth, Size, Texels, Texture, TextureError, Value};
