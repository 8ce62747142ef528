//! Methods that find corresponding triangles of two meshes.
//!
//! One method per file. Each takes the two meshes and its own extra input and returns [`Piece`]s;
//! later stages don't depend on the method. Other crates add methods through
//! [`Pair::from_pieces`](crate::Pair::from_pieces).
//!
//! [`Piece`]: crate::Piece

pub mod table;
pub(crate) mod vertex_map;

pub use vertex_map::LinkError;
