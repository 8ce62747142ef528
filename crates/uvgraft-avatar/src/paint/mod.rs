//! Procedural texture painting: colours of single texels, textures painted by functions of the point
//! in space, and repeatable noise.

pub mod bake;
pub mod noise;
pub mod texel;
