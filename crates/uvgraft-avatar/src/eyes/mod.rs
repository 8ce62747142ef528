//! Eyes: separate islands where both share one, and painted eyes in place of captured ones.
//!
//! Some layouts map both eyes to one disc. A texture from a layout with two islands
//! then loses one of the eyes, and shadows of lids and highlights that a capture baked
//! into the other one show up in both. [`SeparatedEyes`] gives one of the eyes a separate
//! island before a texture is transferred, so that each eye comes from its own region
//! of the source; [`clean`] paints sclera, iris and pupil over the capture.

mod clean;
pub mod eyeball;
mod gaze;
mod iris;
mod separate;
mod texels;

pub use self::clean::{CleanedEyes, EyeColors, clean, clean_head};
pub use self::iris::Iris;
pub use self::separate::{SeparatedEyes, SeparationError};
