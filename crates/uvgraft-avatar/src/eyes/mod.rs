//! Eyes: an island of its own for each where both share one, and clean ones drawn in place of captured ones.
//!
//! Some layouts show both eyes on one disc. A face whose layout has two loses one of them there, and whatever a
//! capture baked into it, lids' shadows and lights, is seen in both. [`Parted`] gives one of the eyes an island of
//! its own before a texture is carried over, so that each comes from where it is in the source; [`clean`] draws
//! sclera, iris and pupil over what was captured.

mod clean;
pub mod eyeball;
mod gaze;
mod iris;
mod parted;
mod texels;

pub use self::clean::{Cleaned, clean};
pub use self::iris::Iris;
pub use self::parted::{Parted, PartedError};
