//! What faces show, measured on the mesh, and expressions solved by it.
//!
//! [`Face::find`] finds lids, lips, corners of the mouth and brows of any head by geometry, and
//! [`Face::measure`] says how far lids and lips are open and where the rest is. [`solve`] finds mixes of whatever
//! moves a face (components of expression, a jaw, eyelids) that do what VRM's expressions are named after.

mod costs;
mod features;
mod gaze;
mod measures;
mod movement;
mod quadratic;
mod solve;
mod surface;
mod targets;

use uvgraft::anatomy::AnatomyError;

pub use self::features::Face;
pub use self::gaze::add_gaze;
pub use self::measures::Measures;
pub use self::movement::Movement;
pub use self::solve::{Shortfall, Solved, solve};

/// Why a face could not be measured.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FaceError {
    /// There is no head.
    #[error("{0}")]
    Anatomy(#[from] AnatomyError),
    /// A part of the face is not there, or hidden.
    #[error("the face has no {part}")]
    Part {
        /// Which.
        part: &'static str,
    },
}
