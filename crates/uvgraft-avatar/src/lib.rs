//! The example that uvgraft demonstrates itself on: a synthetic head, a synthetic body that contains
//! the same head, their painted textures, and an offline renderer to look at them.
//!
//! Everything is computed, nothing is read from files, and every run gives the same result.

mod arms;
mod bake;
mod body_shape;
mod clothes;
mod complexion;
mod depth;
mod face;
mod features;
pub mod figure;
mod hair;
mod head;
mod head_shape;
mod layout;
mod mipmap;
mod noise;
pub mod render;
mod sdf;
mod shade;
mod surface;
mod vector;
mod wardrobe;

pub use face::paint_head;
pub use figure::Figure;
pub use wardrobe::{paint_body, paint_body_in_tone};
