//! Which joint of a skeleton turns like which of a motion.
//!
//! At rest the bodies of the SMPL family stand in a T and their joints are aligned with the world, so a
//! rotation means the same on any skeleton that is at rest like that: joints are found by the bones that
//! they are. Where a skeleton has no joint for one of the motion's, its rotation is handed on to what hangs
//! on it. Arms that hang lower at rest are lifted first, by the shortest rotation that takes them to where
//! the family's are.

use glam::{Quat, Vec3};

use super::super::resample::Frame;
use super::super::{Motion, MotionError};
use crate::rig::{HumanBone, Skeleton};

/// Without these no motion of a body makes sense.
const NEEDED: [HumanBone; 4] =
    [HumanBone::Hips, HumanBone::Spine, HumanBone::LeftUpperLeg, HumanBone::RightUpperLeg];
/// Arms that are turned less against the family's are taken as they are.
const LEAST_ARM_DEG: f32 = 15.0;
/// How one of the skeleton's joints is turned.
#[derive(Debug, Clone, Copy)]
pub(super) enum Turn {
    Still,
    /// Like a joint of the motion.
    Same(usize),
    /// As a joint of the motion is in the world, seen from what another one is; between two lifted
    /// rests.
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

    /// For each joint of the skeleton the motion's: the same bone, or the same name where neither is
    /// a bone.
    pub(super) fn sources(&self, skeleton: &Skeleton) -> Vec<Option<usize>> {
        let source = |joint: &crate::rig::Joint| {
            self.joints().iter().position(|&(name, _, bone)| match joint.human {
                Some(human) => bone == Some(human),
                None => bone.is_none() && name == joint.name,
            })
        };
        skeleton.joints().iter().map(source).collect()
    }

    /// Whether a skeleton is at rest as the motion's body is: all joints of a body have its names.
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

/// For each joint the rotation from its rest to one with arms as the family has them.
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
        // Hands and fingers are lifted as the forearm is.
        lifts[joint] = joints[joint].parent.map_or(Quat::IDENTITY, |parent| lifts[parent]);
        let Some(&(_, end, outwards)) =
            arms.iter().find(|&&(bone, _, _)| joints[joint].human == Some(bone))
        else {
            continue;
        };
        let Some(end) = skeleton.human(end) else { continue };
        let along = Vec3::from(joints[end].position) - Vec3::from(joints[joint].position);
        if let Some(along) = along.try_normalize() {
            let lower = along.angle_between(outwards).to_degrees() > LEAST_ARM_DEG;
            // The motion's joint turns what points outwards; this one first brings its arm there.
            lifts[joint] =
                if lower { Quat::from_rotation_arc(along, outwards) } else { Quat::IDENTITY };
        }
    }
    lifts
}
