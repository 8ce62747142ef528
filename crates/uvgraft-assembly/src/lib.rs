//! Avatars, head textures from photographs, renders and viewer pages, each as a request.
//!
//! | request | result |
//! |---|---|
//! | [`AvatarRequest`] | an animated avatar and its coarser levels: GLB or VRM files in memory |
//! | [`SelfieRequest`] | the texture and the shape of a head, and cameras, from photographs |
//! | [`RenderRequest`] | pictures of a GLB, VRM or glTF file, or of a mesh with a texture |
//! | [`ViewRequest`] | a page that shows such a file or mesh in the browser |
//!
//! A request states what is read, as paths or as bytes in memory ([`Input`]), and how. It is checked
//! before anything large is read. Its result is in memory: the caller decides what becomes a file. An
//! [`Observer`] receives notes and warnings and may cancel the work; a [`Failure`] states whose fault
//! it is. Messages name a request's parameters in backticks: `` `size` ``.
//!
//! ```no_run
//! use uvgraft_assembly::{AvatarRequest, Body};
//!
//! let mut request = AvatarRequest::new(Body::Figure, "me.glb");
//! request.photos = vec!["me.jpg".into()];
//! let avatar = request.make(&())?;
//! println!("{}", avatar.report);
//! std::fs::write("me.glb", &avatar.file)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate prints nothing and reads no clock. Threads belong to the caller, as everywhere in
//! uvgraft, and results do not depend on them.

#![forbid(unsafe_code)]

pub mod avatar;
pub mod drawing;
mod existing;
pub mod mesh_file;
pub mod pair_picture;
pub mod pairing;
pub mod recognition;
pub mod render;
pub mod report;
mod scene_memory;
pub mod selfie;
mod shown;
pub mod skin;
pub mod view;
pub mod weights;

pub use uvgraft_files::input::Input;
pub use uvgraft_pipeline::{Failure, Fault, Observer, Result};

pub use self::avatar::{AvatarFiles, AvatarRequest, Body};
pub use self::render::RenderRequest;
pub use self::report::Report;
pub use self::selfie::{FittedSelfie, SelfieRequest};
pub use self::view::ViewRequest;
