//! How two meshes are found to correspond.
//!
//! One method a file. Each looks at two meshes and whatever it goes by, and ends in [`Piece`]s; nothing after
//! it asks which method it was. Methods of other crates do the same through
//! [`Pair::from_pieces`](crate::Pair::from_pieces).
//!
//! [`Piece`]: crate::Piece

pub(crate) mod vertex_map;

pub use vertex_map::LinkError;
