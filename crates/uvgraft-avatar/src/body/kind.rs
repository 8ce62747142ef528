//! The members of the SMPL family, their joints, and the humanoid bones that these stand for.

use crate::rig::HumanBone;

/// A member of the SMPL family.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BodyKind {
    /// A body; each hand is a single joint.
    Smpl,
    /// A body with fingers.
    SmplH,
    /// A body with fingers, a jaw and eyes.
    SmplX,
    /// A head.
    Flame,
}

/// A joint's name, the index of its parent, and its bone.
pub(crate) type JointEntry = (&'static str, Option<usize>, Option<HumanBone>);

impl BodyKind {
    /// All members.
    pub const ALL: [Self; 4] = [Self::Smpl, Self::SmplH, Self::SmplX, Self::Flame];

    /// Its usual name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Smpl => "SMPL",
            Self::SmplH => "SMPL-H",
            Self::SmplX => "SMPL-X",
            Self::Flame => "FLAME",
        }
    }

    /// Number of joints.
    pub const fn joint_count(self) -> usize {
        match self {
            Self::Smpl => 24,
            Self::SmplH => 52,
            Self::SmplX => 55,
            Self::Flame => 5,
        }
    }

    /// Number of vertices of the published model; models of other meshes have other counts.
    pub const fn vertex_count(self) -> usize {
        match self {
            Self::Smpl | Self::SmplH => 6890,
            Self::SmplX => 10_475,
            Self::Flame => 5023,
        }
    }

    /// Number of pose features of its correctives: nine for each joint except the root.
    pub(crate) const fn features(self) -> usize {
        9 * (self.joint_count() - 1)
    }

    /// Whether two kinds share a shape space: SMPL-H is built on SMPL's bodies.
    pub fn shares_shapes_with(self, other: Self) -> bool {
        let of_smpl = |kind| matches!(kind, Self::Smpl | Self::SmplH);
        self == other || of_smpl(self) && of_smpl(other)
    }

    /// The kind with this number of joints.
    pub fn with_joints(count: usize) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.joint_count() == count)
    }

    /// Index of the first of the 15 joints of the left hand and of the right hand.
    pub(crate) const fn fingers(self) -> Option<[usize; 2]> {
        match self {
            Self::SmplH => Some([22, 37]),
            Self::SmplX => Some([25, 40]),
            Self::Smpl | Self::Flame => None,
        }
    }

    /// Index of the jaw's joint.
    pub(crate) const fn jaw(self) -> Option<usize> {
        match self {
            Self::SmplX => Some(22),
            Self::Flame => Some(2),
            Self::Smpl | Self::SmplH => None,
        }
    }

    /// Its joints, in the order of model files.
    ///
    /// # Source
    /// The names are those of the Python package `smplx` (`joint_names.py`). It has no
    /// names for FLAME's joints, which are named after its pose parameters here. SMPL's
    /// hand joints correspond to no VRM bone. FLAME's root rotates about the base of
    /// the neck and its `neck` about the base of the skull.
    pub(crate) fn joints(self) -> Vec<JointEntry> {
        let mut joints = match self {
            Self::Flame => FLAME.to_vec(),
            _ => BODY.to_vec(),
        };
        match self {
            Self::Smpl => joints.extend_from_slice(&HAND_ENDS),
            Self::SmplX => joints.extend_from_slice(&FACE),
            Self::SmplH | Self::Flame => {}
        }
        if self.fingers().is_some() {
            for (side, wrist) in [(LEFT_FINGERS, LEFT_WRIST), (RIGHT_FINGERS, RIGHT_WRIST)] {
                for finger in side.as_chunks::<3>().0 {
                    let first = joints.len();
                    for (place, &(name, bone)) in finger.iter().enumerate() {
                        let parent = if place == 0 { wrist } else { first + place - 1 };
                        joints.push((name, Some(parent), Some(bone)));
                    }
                }
            }
        }
        joints
    }
}

const LEFT_WRIST: usize = 20;
const RIGHT_WRIST: usize = 21;

/// The joints that all bodies share, before any others.
pub(crate) const BODY: [JointEntry; 22] = [
    ("pelvis", None, Some(HumanBone::Hips)),
    ("left_hip", Some(0), Some(HumanBone::LeftUpperLeg)),
    ("right_hip", Some(0), Some(HumanBone::RightUpperLeg)),
    ("spine1", Some(0), Some(HumanBone::Spine)),
    ("left_knee", Some(1), Some(HumanBone::LeftLowerLeg)),
    ("right_knee", Some(2), Some(HumanBone::RightLowerLeg)),
    ("spine2", Some(3), Some(HumanBone::Chest)),
    ("left_ankle", Some(4), Some(HumanBone::LeftFoot)),
    ("right_ankle", Some(5), Some(HumanBone::RightFoot)),
    ("spine3", Some(6), Some(HumanBone::UpperChest)),
    ("left_foot", Some(7), Some(HumanBone::LeftToes)),
    ("right_foot", Some(8), Some(HumanBone::RightToes)),
    ("neck", Some(9), Some(HumanBone::Neck)),
    ("left_collar", Some(9), Some(HumanBone::LeftShoulder)),
    ("right_collar", Some(9), Some(HumanBone::RightShoulder)),
    ("head", Some(12), Some(HumanBone::Head)),
    ("left_shoulder", Some(13), Some(HumanBone::LeftUpperArm)),
    ("right_shoulder", Some(14), Some(HumanBone::RightUpperArm)),
    ("left_elbow", Some(16), Some(HumanBone::LeftLowerArm)),
    ("right_elbow", Some(17), Some(HumanBone::RightLowerArm)),
    ("left_wrist", Some(18), Some(HumanBone::LeftHand)),
    ("right_wrist", Some(19), Some(HumanBone::RightHand)),
];

const HAND_ENDS: [JointEntry; 2] =
    [("left_hand", Some(LEFT_WRIST), None), ("right_hand", Some(RIGHT_WRIST), None)];

const FACE: [JointEntry; 3] = [
    ("jaw", Some(15), Some(HumanBone::Jaw)),
    ("left_eye_smplhf", Some(15), Some(HumanBone::LeftEye)),
    ("right_eye_smplhf", Some(15), Some(HumanBone::RightEye)),
];

const FLAME: [JointEntry; 5] = [
    ("global", None, Some(HumanBone::Neck)),
    ("neck", Some(0), Some(HumanBone::Head)),
    ("jaw", Some(1), Some(HumanBone::Jaw)),
    ("left_eye", Some(1), Some(HumanBone::LeftEye)),
    ("right_eye", Some(1), Some(HumanBone::RightEye)),
];

const LEFT_FINGERS: [(&str, HumanBone); 15] = [
    ("left_index1", HumanBone::LeftIndexProximal),
    ("left_index2", HumanBone::LeftIndexIntermediate),
    ("left_index3", HumanBone::LeftIndexDistal),
    ("left_middle1", HumanBone::LeftMiddleProximal),
    ("left_middle2", HumanBone::LeftMiddleIntermediate),
    ("left_middle3", HumanBone::LeftMiddleDistal),
    ("left_pinky1", HumanBone::LeftLittleProximal),
    ("left_pinky2", HumanBone::LeftLittleIntermediate),
    ("left_pinky3", HumanBone::LeftLittleDistal),
    ("left_ring1", HumanBone::LeftRingProximal),
    ("left_ring2", HumanBone::LeftRingIntermediate),
    ("left_ring3", HumanBone::LeftRingDistal),
    ("left_thumb1", HumanBone::LeftThumbMetacarpal),
    ("left_thumb2", HumanBone::LeftThumbProximal),
    ("left_thumb3", HumanBone::LeftThumbDistal),
];

const RIGHT_FINGERS: [(&str, HumanBone); 15] = [
    ("right_index1", HumanBone::RightIndexProximal),
    ("right_index2", HumanBone::RightIndexIntermediate),
    ("right_index3", HumanBone::RightIndexDistal),
    ("right_middle1", HumanBone::RightMiddleProximal),
    ("right_middle2", HumanBone::RightMiddleIntermediate),
    ("right_middle3", HumanBone::RightMiddleDistal),
    ("right_pinky1", HumanBone::RightLittleProximal),
    ("right_pinky2", HumanBone::RightLittleIntermediate),
    ("right_pinky3", HumanBone::RightLittleDistal),
    ("right_ring1", HumanBone::RightRingProximal),
    ("right_ring2", HumanBone::RightRingIntermediate),
    ("right_ring3", HumanBone::RightRingDistal),
    ("right_thumb1", HumanBone::RightThumbMetacarpal),
    ("right_thumb2", HumanBone::RightThumbProximal),
    ("right_thumb3", HumanBone::RightThumbDistal),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joint_counts_match_the_files() {
        for kind in BodyKind::ALL {
            let joints = kind.joints();
            assert_eq!(joints.len(), kind.joint_count(), "{}", kind.name());
            for (joint, (name, parent, _)) in joints.iter().enumerate() {
                assert_eq!(parent.is_none(), joint == 0, "{name}");
                assert!(parent.is_none_or(|parent| parent < joint), "{name}");
            }
            assert_eq!(BodyKind::with_joints(joints.len()), Some(kind));
        }
    }

    #[test]
    fn finger_and_jaw_indices_match_the_joint_names() {
        let named = |kind: BodyKind, joint: usize| kind.joints()[joint].0;
        for kind in [BodyKind::SmplH, BodyKind::SmplX] {
            let [left, right] = kind.fingers().unwrap();
            assert_eq!((named(kind, left), named(kind, left + 14)), ("left_index1", "left_thumb3"));
            assert_eq!(
                (named(kind, right), named(kind, right + 14)),
                ("right_index1", "right_thumb3")
            );
            assert_eq!(kind.joints()[right].1, Some(RIGHT_WRIST));
            assert_eq!(kind.joints()[right + 2].1, Some(right + 1));
        }
        for kind in [BodyKind::SmplX, BodyKind::Flame] {
            assert_eq!(named(kind, kind.jaw().unwrap()), "jaw");
        }
        assert_eq!(named(BodyKind::Smpl, LEFT_WRIST), "left_wrist");
    }
}
