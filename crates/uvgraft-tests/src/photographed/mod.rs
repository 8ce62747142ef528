//! Synthetic photographs of heads whose texture, pose, camera and light are known, and measures of
//! what is made of them.
//!
//! The renderer is independent of the one under test: a depth buffer with nine samples per pixel,
//! bilinear lookup and light in linear space.

mod camera;
mod judge;
mod reconstruction;
mod shot;
mod subject;
mod visible;

pub use camera::Pinhole;
pub use judge::{Found, Judgement, error_map, landmark_error_mm, pose_error_degrees};
pub use reconstruction::{Reconstruction, landmarks, networks, prepared, views};
pub use shot::{Light, Photograph, Shot};
pub use subject::{Content, Subject};
