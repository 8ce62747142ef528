//! Painting textures by formula: colours of single texels, and repeatable noise.

pub mod noise;
pub mod texel;
