//! Full-body avatars, and the example that uvgraft demonstrates itself on: a synthetic head, a
//! synthetic body that contains the same head, their painted textures, and an offline renderer to
//! look at them.
//!
//! With the feature `threads` (default) work is done on the caller's rayon pool, as
//! [`uvgraft::threads`] says; results are the same without it.

pub mod atlas;
mod avatar;
pub mod body;
pub mod eyes;
pub mod face;
pub mod figure;
pub mod film;
pub mod glb;
pub mod motion;
pub mod mouth;
mod noise;
mod normals;
mod portrait;
pub mod preset;
mod ray;
pub mod render;
pub mod rig;
pub mod scene;
mod texel;
mod vector;

pub use avatar::Avatar;
pub use figure::{Figure, paint_body, paint_body_in_tone, paint_head};
pub use portrait::{PortraitError, portrait};
