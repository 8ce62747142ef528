//! Methods that find corresponding triangles of two meshes.
//!
//! One method per file. Each takes the two meshes and its own extra input and returns [`Piece`]s;
//! later stages don't depend on the method. [`find()`] tries those that need no extra
//! input in turn. Other crates add methods through [`Pair::from_pieces`](crate::Pair::from_pieces).
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
