//! Procedural texture painting: colours of single texels, and repeatable noise.

pub mod noise;
pub mod texel;
