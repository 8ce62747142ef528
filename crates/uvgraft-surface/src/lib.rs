//! Meshes, what lies where on them, and which triangles of two meshes are the same piece of surface.
//!
//! A [`Mesh`] is a surface with a UV layout. Two meshes and the [`Piece`]s of their triangles that
//! correspond form a [`Pair`], whatever method of [`correspond`] found them. The crate `uvgraft`
//! transfers textures by pairs; it re-exports what is needed for that.
//!
//! The crate does no file access and knows nothing of colours. With the feature `threads` (default),
//! work is shared by the caller's rayon pool; results do not depend on the number of threads. See
//! [`threads`].

pub mod anatomy;
pub mod bits;
pub mod choice;
pub mod connectivity;
pub mod correspond;
pub mod deform;
pub mod directions;
pub mod disjoint;
pub mod easing;
pub mod edges;
pub mod islands;
pub mod known;
pub mod listing;
pub mod mesh;
pub mod pair;
pub mod piece;
pub mod raster;
pub mod rotation;
pub mod size;
pub mod source_layout;
pub mod sparse;
pub mod statistics;
pub mod surface;
pub mod surface_field;
pub mod surface_index;
pub mod tangents;
pub mod threads;
pub mod tile;
pub mod tile_atlas;
mod triangle_tree;

pub use anatomy::{Anatomy, AnatomyError, Area, HeadFrame, Landmark};
pub use choice::Choice;
pub use connectivity::Fingerprint;
pub use correspond::LinkError;
pub use known::{Recognition, recognise};
pub use mesh::{Corner, Mesh, MeshError, MeshPart};
pub use pair::{Direction, Pair, PairError, Side};
pub use piece::{Extent, Piece, PieceError, Weights};
pub use size::Size;
pub use source_layout::SourceLayout;
pub use tangents::{TangentFrame, TangentFrames};
pub use tile::{Tile, TileError};
pub use tile_atlas::{TileAtlas, TileAtlasError};
