//! The T-pose: arms straight out to the sides.

use glam::{Quat, Vec3};

use crate::rig::{HumanBone, Pose, Skeleton};

/// Bones of arms that are less than this off count as straight: bodies scanned in T-pose hang their arms
/// by some degrees. In radians.
const TOLERANCE: f32 = 0.2;

/// The left arm's bones, each with the one at its end; then the right's.
const ARMS: [[(HumanBone, HumanBone); 3]; 2] = {
    use HumanBone as Bone;
    [
        [
            (Bone::LeftUpperArm, Bone::LeftLowerArm),
            (Bone::LeftLowerArm, Bone::LeftHand),
            (Bone::LeftHand, Bone::LeftMiddleProximal),
        ],
        [
            (Bone::RightUpperArm, Bone::RightLowerArm),
            (Bone::RightLowerArm, Bone::RightHand),
            (Bone::RightHand, Bone::RightMiddleProximal),
        ],
    ]
};

/// The pose that takes a skeleton's rest to a T-pose, by turning arms the shortest way; `None` if it
/// is in one, give or take 11°, or has no arms. Legs stay as they are.
pub fn t_pose(skeleton: &Skeleton) -> Option<Pose> {
    let joints = skeleton.joints();
    // How far bones are from where they should point, in the world.
    let mut turns = vec![None; joints.len()];
    let mut is_one = true;
    for (arm, side) in ARMS.iter().zip([Vec3::X, Vec3::NEG_X]) {
        for &(bone, end) in arm {
            let (Some(bone), Some(end)) = (skeleton.human(bone), skeleton.human(end)) else {
                continue;
            };
            let along = Vec3::from(joints[end].position) - Vec3::from(joints[bone].position);
            let Some(along) = along.try_normalize() else { continue };
            is_one &= along.angle_between(side) < TOLERANCE;
            turns[bone] = Some(Quat::from_rotation_arc(along, side));
        }
    }
    if is_one {
        return None;
    }
    let mut pose = Pose::rest(joints.len());
    let mut world = vec![Quat::IDENTITY; joints.len()];
    for (index, joint) in joints.iter().enumerate() {
        let above = joint.parent.map_or(Quat::IDENTITY, |parent| world[parent]);
        world[index] = turns[index].unwrap_or(above);
        pose.rotations[index] = (above.inverse() * world[index]).normalize().into();
    }
    Some(pose)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rig::Joint;

    fn left_arm(elbow: [f32; 3], hand: [f32; 3]) -> Skeleton {
        let joint = |name: &str, parent, position, human| Joint {
            name: name.to_owned(),
            parent,
            position,
            human,
        };
        Skeleton::new(vec![
            joint("root", None, [0.0; 3], None),
            joint("a", Some(0), [0.2, 1.4, 0.0], Some(HumanBone::LeftUpperArm)),
            joint("b", Some(1), elbow, Some(HumanBone::LeftLowerArm)),
            joint("c", Some(2), hand, Some(HumanBone::LeftHand)),
        ])
        .unwrap()
    }

    #[test]
    fn bent_arms_become_straight() {
        // Down to the elbow at 45°, then forwards.
        let skeleton = left_arm([0.4, 1.2, 0.0], [0.4, 1.2, 0.3]);
        let motions = skeleton.motions(&t_pose(&skeleton).unwrap()).unwrap();
        let length = 0.08_f32.sqrt();
        for (joint, wanted) in [(2, [0.2 + length, 1.4, 0.0]), (3, [0.5 + length, 1.4, 0.0])] {
            let found = motions[joint].point(skeleton.joints()[joint].position);
            assert!(Vec3::from(found).abs_diff_eq(wanted.into(), 1e-6), "{found:?}");
        }
    }

    #[test]
    fn a_t_pose_is_left_alone() {
        assert_eq!(t_pose(&left_arm([0.5, 1.38, 0.0], [0.8, 1.38, 0.01])), None);
    }
}
