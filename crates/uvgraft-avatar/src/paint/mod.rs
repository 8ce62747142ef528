//! Painting textures by formula: colours of single texels, repeatable noise, and easing curves.

pub mod easing;
pub mod noise;
pub mod texel;
