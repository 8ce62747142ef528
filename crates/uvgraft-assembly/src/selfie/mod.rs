//! The texture and the shape of a head, from photographs of a face.

mod cameras;
mod fitted;
mod frames;
mod networks;
mod photo;
mod request;
mod sheet;
mod summary;
mod tracked;
mod window;

pub use self::fitted::FittedSelfie;
pub(crate) use self::fitted::GivenHead;
pub(crate) use self::frames::Frames;
pub use self::request::{FocalLength, Head, Networks, PhotoOptions, SelfieRequest};
