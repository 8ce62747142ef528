//! The texture and the shape of a head, from photographs of a face.

mod cameras;
mod frames;
mod made;
mod networks;
mod photo;
mod request;
mod sheet;
mod summary;
mod tracked;
mod window;

pub(crate) use self::frames::Frames;
pub(crate) use self::made::GivenHead;
pub use self::made::MadeSelfie;
pub use self::request::{FocalLength, Head, Networks, PhotoOptions, SelfieRequest};
