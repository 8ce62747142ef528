//! How a texture that is laid over another becomes one with it, on the mesh rather than in the image.
//!
//! The border of what is transferred runs over the surface and crosses UV islands as it likes, so
//! distances and corrections of colour live at the points of the mesh and are interpolated over its
//! triangles.

mod geodesic;
mod harmonic;
mod painted;
mod sample;
mod selection;

pub use selection::{Ground, Growth, RegionError, Selection, Side};
