//! Carries textures between meshes with different UV layouts.

pub mod color;
mod convert;
pub mod correspond;
pub mod filter;
pub mod islands;
pub mod map;
pub mod mesh;
pub mod pad;
pub mod pair;
pub mod raster;
pub mod resample;
pub mod texture;
mod threads;
pub mod transfer;

pub use color::Encoding;
pub use correspond::{Link, LinkError};
pub use filter::Filter;
pub use map::{MapOptions, SamplingMap};
pub use mesh::{Corner, Mesh, MeshError, Part};
pub use pair::{Direction, Pair, PairError};
pub use texture::{Channels, Depth, Size, Texels, Texture, TextureError, Value};
pub use transfer::{Transfer, TransferError, TransferOptions};
