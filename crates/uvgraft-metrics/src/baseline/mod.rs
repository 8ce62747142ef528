//! What textures were carried with before, written anew to compare with. Nothing else uses it.

pub mod affine;
pub mod grid;
mod median;
