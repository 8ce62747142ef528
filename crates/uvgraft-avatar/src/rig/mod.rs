//! A rig: a skeleton of joints, skinning weights, morph targets and animation clips.
//!
//! At rest all joints are aligned with the world axes, so a joint's local rotation at rest is the
//! identity and inverse bind matrices are translations. Positions are in metres, Y up, facing +Z;
//! the person's left is +X. Rotations are unit quaternions `[x, y, z, w]`.

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
pub(crate) use skeleton::posed_joints;
pub use skeleton::{Joint, Skeleton};
pub use skin::{MAX_INFLUENCES, Pruning, Skin};

/// Why a rig was refused.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigError {
    /// There are no joints, or too many for 16-bit indices.
    #[error("must have 1 to 65,535 joints, got {found}")]
    JointCount {
        /// Number of joints.
        found: usize,
    },
    /// A joint other than the first has no parent, or one that does not precede it.
    #[error("the parent of joint {joint} (`{name}`) must come before it")]
    Parent {
        /// The joint's index.
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
    /// Two joints stand for the same bone.
    #[error("two joints for the bone `{bone}`")]
    Bone {
        /// VRM's name of the bone.
        bone: &'static str,
    },
    /// A value is not finite, or a rotation is not of unit length.
    #[error("{what} must be finite")]
    NotFinite {
        /// What it belongs to.
        what: String,
    },
    /// The lengths of two lists disagree.
    #[error("must have {wanted} {what}, got {found}")]
    Count {
        /// What the list holds.
        what: &'static str,
        /// Its length.
        found: usize,
        /// The required length.
        wanted: usize,
    },
    /// A vertex has no weights, or weights that are negative.
    #[error("vertex {vertex} {problem}")]
    Weights {
        /// The vertex's index.
        vertex: usize,
        /// What is wrong with its weights.
        problem: &'static str,
    },
    /// The times of a clip are not increasing, or there are none.
    #[error("clip `{clip}`: {problem}")]
    Clip {
        /// Its name.
        clip: String,
        /// What is wrong.
        problem: &'static str,
    },
}
