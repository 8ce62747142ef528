//! Measurements of faces, and expressions solved from them.
//!
//! [`Face::find`] locates the lids, lips, corners of the mouth and brows of any head by geometry,
//! and [`Face::measure`] measures how far lids and lips are open and where the other features are.
//! [`solve`] finds the combinations of whatever moves a face (expression components, a jaw,
//! eyelids) that make VRM's expressions. [`transfer`] transfers named expressions from another head.

mod costs;
mod features;
mod gaze;
mod measures;
mod movement;
mod named;
mod quadratic;
mod solve;
mod surface;
mod targets;
pub mod transfer;

use uvgraft::anatomy::AnatomyError;

pub use self::features::Face;
pub use self::gaze::add_gaze;
pub use self::measures::Measures;
pub use self::movement::BlendBasis;
pub use self::named::{AddedExpressions, add_named};
pub use self::solve::{Solved, UnmetTarget, solve};

/// Why a face could not be measured.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceError {
    /// There is no head.
    #[error("{0}")]
    Anatomy(#[from] AnatomyError),
    /// A part of the face is missing or hidden.
    #[error("the face has no {part}")]
    Part {
        /// The part.
        part: &'static str,
    },
}
