//! An animated full-body avatar, from the texture of a head or from photographs.
//!
//! [`AvatarRequest::make`] goes through these steps:
//!
//! 1. `plan`: the request is checked before any large file is read.
//! 2. `ingredients`: the pair, the rigged body with its animations, and what photographs show.
//! 3. `face_transfer`: the face on the body's texture, while the body gets its shape and a mouth is fitted.
//! 4. `assembled`: eyes, mouth, the head's own layout and other maps.
//! 5. `finish`: fewer triangles, levels of detail, and the files.

mod assembled;
mod betas;
mod body;
mod expressions;
mod face;
mod face_transfer;
mod features;
mod finish;
mod ingredients;
mod layout;
mod levels;
mod likeness;
mod map_transfer;
mod maps;
mod materials;
mod metadata;
mod motions;
mod named_expressions;
mod pair;
mod plan;
mod request;
mod summary;
mod thumbnail;

use uvgraft::Texture;
use uvgraft_pipeline::{Observer, Result};

use self::assembled::Assembled;
pub use self::betas::Betas;
use self::ingredients::Ingredients;
pub use self::materials::MapRole;
use self::plan::Plan;
pub use self::plan::level_file;
pub use self::request::{
    AvatarRequest, Body, EyeStyle, LevelOptions, LevelStorage, MaterialOptions, Metadata,
    MotionOptions, MouthStyle, TextureLayout, TextureOptions,
};
use crate::report::Report;

/// An avatar: files in memory, and what there is to say about it.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct AvatarFiles {
    /// The GLB or VRM file.
    pub file: Vec<u8>,
    /// Files of coarser levels of detail; see [`level_file`] for their names.
    pub levels: Vec<Vec<u8>>,
    /// The region and its weights on both layouts, if [`AvatarRequest::preview`] asks for it.
    pub preview: Option<Texture>,
    /// The detected labels of the face, if the blending asks for them.
    pub labels: Option<Texture>,
    /// Its figures.
    pub report: Report,
}

impl AvatarRequest {
    /// Makes the avatar.
    ///
    /// - `observer`: receives notes and warnings, which name the file that they are about. It may cancel
    ///   the work between its steps, none of which takes more than some seconds.
    ///
    /// # Errors
    /// As bad input for options that contradict each other, for files that cannot be read or do not go
    /// together, and for a body that the format cannot hold.
    pub fn make(&self, observer: &dyn Observer) -> Result<AvatarFiles> {
        let plan = Plan::new(self)?;
        Plan::warn(self, observer);
        let ingredients = Ingredients::gather(self, &plan, observer)?;
        observer.begin("laying the face onto the body")?;
        let assembled = Assembled::new(self, &plan, ingredients, observer)?;
        observer.begin("writing the avatar")?;
        assembled.finish(self, plan, observer)
    }
}
