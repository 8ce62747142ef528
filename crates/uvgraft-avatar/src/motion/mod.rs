//! Recorded motions, and their retargeting to other bodies.

mod amass;
mod contact;
mod ground;
mod legs;
mod plausible;
mod resample;
mod retarget;
mod soles;
mod up;

use uvgraft_io::arrays::ArraysError;

use crate::rig::RigError;
pub use amass::Motion;
pub use ground::Grounding;
pub use plausible::Doubt;
pub use retarget::{ClipOptions, GroundMode, Performer, Retarget};
pub use retarget::{MEAN_LEG_M, MEAN_PELVIS};
pub use soles::Soles;
pub use up::UpAxis;

/// Why a motion was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MotionError {
    /// An array that a motion needs is missing, or was not read.
    #[error("not a motion: {0}")]
    Arrays(#[from] ArraysError),
    /// A motion needs one of several arrays, and none of them is present.
    #[error("not a motion: must have {wanted}, got {found}")]
    Missing {
        /// Their names.
        wanted: &'static str,
        /// The names that are present.
        found: String,
    },
    /// The file states no frame rate.
    #[error("no frame rate: must have one of {wanted}, got {found}")]
    NoRate {
        /// The names that it may have.
        wanted: String,
        /// The names that are present.
        found: String,
    },
    /// Rotations are far beyond a full turn.
    #[error(
        "rotations must be in radians, got {found:.1} for `{joint}` in frame {frame}, as in degrees"
    )]
    Degrees {
        /// The length of a rotation vector.
        found: f32,
        /// The frame's index.
        frame: usize,
        /// The joint's name.
        joint: &'static str,
    },
    /// An array has the wrong shape for a motion.
    #[error("`{key}` must have shape {wanted}, got {found:?}")]
    Shape {
        /// Its name.
        key: &'static str,
        /// The lengths of its axes.
        found: Vec<usize>,
        /// The required shape.
        wanted: String,
    },
    /// A value is NaN or infinite.
    #[error("`{key}` must be finite, got {found} in frame {frame}, value {column}")]
    NotFinite {
        /// The array's name.
        key: &'static str,
        /// The frame's index.
        frame: usize,
        /// Index of the value within the frame.
        column: usize,
        /// The value.
        found: f32,
    },
    /// A value is beyond anything that a body does.
    #[error("`{key}` must be from -{most} to {most}, got {found} in frame {frame}, value {column}")]
    TooLarge {
        /// The array's name.
        key: &'static str,
        /// The frame's index.
        frame: usize,
        /// Index of the value within the frame.
        column: usize,
        /// The value.
        found: f32,
        /// Upper limit of its magnitude.
        most: f32,
    },
    /// The frame rate is out of range.
    #[error("the frame rate must be more than 0 and at most {most} frames per second, got {found}")]
    Rate {
        /// The rate.
        found: f64,
        /// Upper limit.
        most: f64,
    },
    /// No frames, or more than are accepted.
    #[error("must have 1 to {most} frames, got {found}")]
    Frames {
        /// Number of frames.
        found: usize,
        /// Upper limit.
        most: usize,
    },
    /// The requested part of the motion has no frames, or its length is invalid.
    #[error("no frames from {start_s} s for {seconds} s in a motion of {length_s:.2} s")]
    Part {
        /// Start of the part.
        start_s: f64,
        /// Requested length of the part.
        seconds: f64,
        /// Length of the motion.
        length_s: f64,
    },
    /// The skeleton lacks bones that a human motion needs.
    #[error(
        "the skeleton of a motion of {joints} joints must have {missing}, got `{root}` and \
         {others} more joints"
    )]
    OtherSkeleton {
        /// Number of joints of the motion.
        joints: usize,
        /// Name of the skeleton's first joint.
        root: String,
        /// Number of its other joints.
        others: usize,
        /// VRM's names of the bones that are missing.
        missing: String,
    },
    /// The clip does not fit the skeleton.
    #[error("{0}")]
    Rig(#[from] RigError),
}
