//! Recorded motions, and how they are brought onto bodies.

mod amass;
mod contact;
mod ground;
mod legs;
mod resample;
mod retarget;
mod soles;
mod up;

use uvgraft_io::arrays::ArraysError;

use crate::rig::RigError;
pub use amass::Motion;
pub use ground::Grounding;
pub use retarget::{ClipOptions, Ground, Person, Retarget};
pub use retarget::{MEAN_LEG_M, MEAN_PELVIS};
pub use soles::Soles;
pub use up::Up;

/// Why a motion was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// An array that a motion needs is not there, or was not read.
    #[error("not a motion: {0}")]
    Arrays(#[from] ArraysError),
    /// None of several arrays is there, of which a motion needs one.
    #[error("not a motion: must have {wanted}, got {found}")]
    Missing {
        /// Their names.
        wanted: &'static str,
        /// The names that there are.
        found: String,
    },
    /// An array has another shape than a motion's.
    #[error("`{key}` must have shape {wanted}, got {found:?}")]
    Shape {
        /// Its name.
        key: &'static str,
        /// The lengths of its axes.
        found: Vec<usize>,
        /// What they must be.
        wanted: String,
    },
    /// A value is NaN or infinite.
    #[error("`{key}` must be finite, got {found} in frame {frame}, value {column}")]
    NotFinite {
        /// The array's name.
        key: &'static str,
        /// Which frame, counted from 0.
        frame: usize,
        /// Which value of the frame, counted from 0.
        column: usize,
        /// What was found.
        found: f32,
    },
    /// A frame rate that no recording has.
    #[error("the frame rate must be more than 0 and at most {most} frames per second, got {found}")]
    Rate {
        /// What was found.
        found: f64,
        /// The most that is accepted.
        most: f64,
    },
    /// More frames than are accepted.
    #[error("must have 1 to {most} frames, got {found}")]
    Frames {
        /// How many.
        found: usize,
        /// The most that are accepted.
        most: usize,
    },
    /// A part of the motion that has no frames, or a length that is none.
    #[error("no frames from {start_s} s for {seconds} s in a motion of {length_s:.2} s")]
    Part {
        /// Where the part starts.
        start_s: f64,
        /// How long it is.
        seconds: f64,
        /// How long the motion is.
        length_s: f64,
    },
    /// A body that cannot move as people do.
    #[error(
        "the skeleton of a motion of {joints} joints must have {missing}, got `{root}` and \
         {others} more joints"
    )]
    OtherSkeleton {
        /// The joints of the motion.
        joints: usize,
        /// The skeleton's first joint.
        root: String,
        /// How many more it has.
        others: usize,
        /// VRM's names of the bones that are missing.
        missing: String,
    },
    /// The clip does not fit the skeleton.
    #[error("{0}")]
    Rig(#[from] RigError),
}
