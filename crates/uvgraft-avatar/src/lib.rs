//! Full-body avatars, and the example that uvgraft demonstrates itself on: a synthetic head, a
//! synthetic body that contains the same head, their painted textures, and an offline renderer to
//! look at them.

pub mod figure;
pub mod film;
mod noise;
mod normals;
pub mod render;
pub mod scene;
mod vector;

pub use figure::{Figure, paint_body, paint_body_in_tone, paint_head};
