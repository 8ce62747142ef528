//! Maps the joint rotations of a motion to those of a skeleton.
//!
//! At rest the bodies of the SMPL family stand in a T-pose with their joints aligned with the
//! world, so a rotation has the same effect on every skeleton with that rest pose, and joints are
//! matched by the bones they stand for. If a skeleton lacks one of the motion's joints, its
//! rotation is passed on to its descendants. Arms that hang lower at rest are lifted first, by the
//! shortest rotation to the direction of the family's arms.

use glam::{Quat, Vec3};

use super::super::resample::Frame;
use super::super::{Motion, MotionError};
use crate::rig::{HumanBone, Skeleton};

/// Bones without which a human motion makes no sense.
const NEEDED: [HumanBone; 4] =
    [HumanBone::Hips, HumanBone::Spine, HumanBone::LeftUpperLeg, HumanBone::RightUpperLeg];
/// Arms whose rest direction differs less than this from the family's are not lifted.
const MIN_ARM_DEG: f32 = 15.0;
/// Where a joint of the skeleton takes its rotation from.
#[derive(Debug, Clone, Copy)]
pub(super) enum Turn {
    Still,
    /// The local rotation of a joint of the motion.
    Same(usize),
    /// The world rotation of a joint of the motion, relative to that of another one,
    /// with both rest poses lifted.
    Between {
        above: Option<usize>,
        source: usize,
        lift_above: Quat,
        lift: Quat,
    },
}

impl Motion {
    pub(super) fn check_bones(&self, skeleton: &Skeleton) -> Result<(), MotionError> {
        let missing: Vec<&str> = NEEDED
            .iter()
            .filter(|&&bone| skeleton.human(bone).is_none())
            .map(|bone| bone.name())
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        Err(MotionError::OtherSkeleton {
            joints: self.joints().len(),
            root: skeleton.joints()[0].name.clone(),
            others: skeleton.joints().len() - 1,
            missing: missing.join(", "),
        })
    }

    /// For each joint of the skeleton the joint of the motion: the one with the same bone, or with
    /// the same name if neither is a bone.
    pub(super) fn sources(&self, skeleton: &Skeleton) -> Vec<Option<usize>> {
        let source = |joint: &crate::rig::Joint| {
            self.joints().iter().position(|&(name, _, bone)| match joint.human {
                Some(human) => bone == Some(human),
                None => bone.is_none() && name == joint.name,
            })
        };
        skeleton.joints().iter().map(source).collect()
    }

    /// Whether a skeleton has the family's rest pose: it has all joints of a body by their names.
    pub(super) fn is_of_family(&self, skeleton: &Skeleton) -> bool {
        crate::body::BODY.iter().all(|&(name, _, _)| skeleton.find(name).is_some())
    }

    pub(super) fn plan(
        &self,
        skeleton: &Skeleton,
        sources: &[Option<usize>],
        lifts: &[Quat],
    ) -> Vec<Turn> {
        let joints = skeleton.joints();
        let turn = |joint: usize| {
            let Some(source) = sources[joint] else { return Turn::Still };
            let ancestors = std::iter::successors(joints[joint].parent, |&at| joints[at].parent);
            let above = ancestors.filter_map(|at| sources[at]).next();
            let lift = lifts[joint];
            let lift_above = joints[joint].parent.map_or(Quat::IDENTITY, |parent| lifts[parent]);
            let direct = self.joints()[source].1 == above;
            if direct && lift == Quat::IDENTITY && lift_above == Quat::IDENTITY {
                Turn::Same(source)
            } else {
                Turn::Between { above, source, lift_above, lift }
            }
        };
        (0..joints.len()).map(turn).collect()
    }

    pub(super) fn rotations(&self, frame: &Frame, turns: &[Turn]) -> Vec<[f32; 4]> {
        let mut world: Vec<Quat> = Vec::with_capacity(frame.turns.len());
        for (&turn, &(_, parent, _)) in frame.turns.iter().zip(self.joints()) {
            world.push(parent.map_or(turn, |parent| (world[parent] * turn).normalize()));
        }
        let rotation = |turn: &Turn| match *turn {
            Turn::Still => Quat::IDENTITY,
            Turn::Same(source) => frame.turns[source],
            Turn::Between { above, source, lift_above, lift } => {
                let above = above.map_or(Quat::IDENTITY, |above| world[above]) * lift_above;
                (above.inverse() * world[source] * lift).normalize()
            }
        };
        turns.iter().map(|turn| rotation(turn).into()).collect()
    }
}

/// For each joint the world rotation that brings arms from their rest direction to the family's.
pub(super) fn lifts(skeleton: &Skeleton, family: bool) -> Vec<Quat> {
    use HumanBone::{
        LeftHand, LeftLowerArm, LeftUpperArm, RightHand, RightLowerArm, RightUpperArm,
    };
    let joints = skeleton.joints();
    let mut lifts = vec![Quat::IDENTITY; joints.len()];
    if family {
        return lifts;
    }
    let arms = [
        (LeftUpperArm, LeftLowerArm, Vec3::X),
        (LeftLowerArm, LeftHand, Vec3::X),
        (RightUpperArm, RightLowerArm, Vec3::NEG_X),
        (RightLowerArm, RightHand, Vec3::NEG_X),
    ];
    for joint in 0..joints.len() {
        // Hands and fingers are lifted with the forearm.
        lifts[joint] = joints[joint].parent.map_or(Quat::IDENTITY, |parent| lifts[parent]);
        let Some(&(_, end, outwards)) =
            arms.iter().find(|&&(bone, _, _)| joints[joint].human == Some(bone))
        else {
            continue;
        };
        let Some(end) = skeleton.human(end) else { continue };
        let along = Vec3::from(joints[end].position) - Vec3::from(joints[joint].position);
        if let Some(along) = along.try_normalize() {
            let lower = along.angle_between(outwards).to_degrees() > MIN_ARM_DEG;
            // The motion's joint rotates an arm that points outwards, so the arm is
            // brought there first.
            lifts[joint] =
                if lower { Quat::from_rotation_arc(along, outwards) } else { Quat::IDENTITY };
        }
    }
    lifts
}
