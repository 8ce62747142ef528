//! Methods that find corresponding triangles of two meshes.
//!
//! Each takes the two meshes and its own extra input, and ends in [`Piece`]s; later stages don't
//! depend on the method. Other crates add methods through
//! [`Pair::from_pieces`](crate::Pair::from_pieces).
//!
//! | method | extra input |
//! |---|---|
//! | `vertex_map` | the target vertex of each source vertex |
//! | [`split_vertices`] | the same, numbered before a tool split or added vertices |
//! | [`table`] | for each vertex of one mesh, a point on the other |
//! | [`faces`] | none: both meshes have the same faces |
//! | [`topology`] | none: one mesh's connectivity is part of the other's |
//! | [`surface`] | none: the target is registered to the source |
//!
//! [`find()`] tries the last three in this order. The other files are what methods share: `places`
//! finds vertices at one position, `fans` retriangulates polygons, `twins` matches triangles at the
//! same points, and [`similarity`] aligns corresponding points.
//!
//! [`Piece`]: crate::Piece

pub mod faces;
mod fans;
mod find;
mod places;
pub mod similarity;
pub mod split_vertices;
pub mod surface;
pub mod table;
pub mod topology;
mod twins;
mod vertex_map;

pub use find::{By, Correspondence, FindError, FindOptions, Method, MethodFailure, Refused, find};
pub use vertex_map::LinkError;
