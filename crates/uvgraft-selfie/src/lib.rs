//! From photographs of a face to the texture and the shape of a head.
//!
//! [`network`] runs small neural networks, which [`tflite`] reads from files of [`face_networks`], and [`landmarks`] finds faces and their 468 landmarks
//! with two of them. [`Head`] knows where these landmarks are on a mesh, [`Fit`] finds cameras and
//! shape from them.

#![forbid(unsafe_code)]

mod average_pose;
pub mod camera;
mod color_model;
mod completion;
mod components;
pub mod depth_map;
mod drawing;
mod expression;
pub mod face_networks;
mod fit;
mod fusion;
mod head;
mod head_landmarks;
mod iris;
pub mod landmarks;
mod layout_texels;
pub mod light;
mod likeness;
mod mirror;
mod model_space;
pub mod network;
mod normals;
mod outline;
mod pixels;
mod projection;
mod raster;
mod segmentation;
mod texture;
pub mod tflite;
mod tracked;

pub use self::camera::Camera;
pub use self::fit::{Fit, FittedPhoto, PhotoLandmarks};
pub use self::head::{Head, HeadError, LandmarkDetector};
pub use self::head_landmarks::{HeadLandmark, HeadLandmarkError};
pub use self::light::Relight;
pub use self::likeness::{Likeness, LikenessError};
pub use self::model_space::ModelSpace;
pub use self::pixels::Pixels;
pub use self::projection::{Projection, ProjectionError};
pub use self::texture::{SelfieError, SelfieTexture, TextureOptions, textured};
pub use self::tracked::TrackedPhoto;
