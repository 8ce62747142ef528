//! A rig: joints that move, which vertices follow them how far, shapes that are mixed in, and clips
//! that play.
//!
//! At rest all joints are aligned with the world, so a joint's local rotation at rest is the
//! identity, and inverse bind matrices are translations. Positions are in metres, Y up, facing +Z;
//! the person's left is +X. Rotations are quaternions `[x, y, z, w]` of unit length.

mod clip;
mod human;
mod morph;
mod pose;
mod skeleton;
mod skin;

pub use clip::Clip;
pub use human::HumanBone;
pub use morph::{Expression, ExpressionPreset, Morph};
pub use pose::{Pose, Rigid};
pub use skeleton::{Joint, Skeleton};
pub use skin::{MOST_INFLUENCES, Pruning, Skin};

/// Why a rig was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// No joint at all, or more than 16 bits count.
    #[error("must have 1 to 65,535 joints, got {found}")]
    JointCount {
        /// How many.
        found: usize,
    },
    /// A joint that is not the first has no parent, or one that comes after it.
    #[error("the parent of joint {joint} (`{name}`) must come before it")]
    Parent {
        /// Which, counted from 0.
        joint: usize,
        /// Its name.
        name: String,
    },
    /// Two joints with the same name.
    #[error("duplicate joint name `{name}`")]
    JointName {
        /// The name.
        name: String,
    },
    /// Two joints are the same bone of a human.
    #[error("two joints for the bone `{bone}`")]
    Bone {
        /// VRM's name of the bone.
        bone: &'static str,
    },
    /// A value that is no finite number, or a rotation without length.
    #[error("{what} must be finite")]
    NotFinite {
        /// What it belongs to.
        what: String,
    },
    /// Lists whose lengths must agree do not.
    #[error("must have {wanted} {what}, got {found}")]
    Count {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many there must be.
        wanted: usize,
    },
    /// A vertex that follows nothing, or weights that are negative.
    #[error("vertex {vertex} {problem}")]
    Weights {
        /// Which, counted from 0.
        vertex: usize,
        /// What is wrong with its weights.
        problem: &'static str,
    },
    /// The times of a clip do not rise, or there are none.
    #[error("clip `{clip}`: {problem}")]
    Clip {
        /// Its name.
        clip: String,
        /// What is wrong.
        problem: &'static str,
    },
}
