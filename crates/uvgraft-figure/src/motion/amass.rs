//! Exports a clip of the figure in the form of AMASS: rotations of SMPL-H's joints, Z up.

use glam::{Quat, Vec3};
use uvgraft_avatar::motion::{MEAN_LEG_M, MEAN_PELVIS};
use uvgraft_avatar::rig::{Clip, HumanBone, Skeleton};

/// The arrays of an AMASS motion file.
#[derive(Debug, Clone, PartialEq)]
pub struct AmassArrays {
    /// `poses`, `[frames, 156]`: a rotation vector in radians for each of SMPL-H's 52 joints.
    pub poses: Vec<f32>,
    /// `trans`, `[frames, 3]`: translation of the body, in metres.
    pub trans: Vec<f32>,
    /// `mocap_framerate`: frames per second.
    pub mocap_framerate: f32,
    /// Number of frames.
    pub frames: usize,
}

macro_rules! hand {
    ($($bone:ident)*) => { [$(HumanBone::$bone),*] };
}

/// SMPL-H's joints without the fingers, in SMPL-H's order.
///
/// # Source
/// `smplx` (Python package), `joint_names.py`.
const SMPL_H: [HumanBone; 22] = [
    HumanBone::Hips,
    HumanBone::LeftUpperLeg,
    HumanBone::RightUpperLeg,
    HumanBone::Spine,
    HumanBone::LeftLowerLeg,
    HumanBone::RightLowerLeg,
    HumanBone::Chest,
    HumanBone::LeftFoot,
    HumanBone::RightFoot,
    HumanBone::UpperChest,
    HumanBone::LeftToes,
    HumanBone::RightToes,
    HumanBone::Neck,
    HumanBone::LeftShoulder,
    HumanBone::RightShoulder,
    HumanBone::Head,
    HumanBone::LeftUpperArm,
    HumanBone::RightUpperArm,
    HumanBone::LeftLowerArm,
    HumanBone::RightLowerArm,
    HumanBone::LeftHand,
    HumanBone::RightHand,
];

/// The joints that follow, for both hands: index, middle, little and ring finger, and thumb.
const HANDS: [[HumanBone; 15]; 2] = [
    hand!(LeftIndexProximal LeftIndexIntermediate LeftIndexDistal
        LeftMiddleProximal LeftMiddleIntermediate LeftMiddleDistal
        LeftLittleProximal LeftLittleIntermediate LeftLittleDistal
        LeftRingProximal LeftRingIntermediate LeftRingDistal
        LeftThumbMetacarpal LeftThumbProximal LeftThumbDistal),
    hand!(RightIndexProximal RightIndexIntermediate RightIndexDistal
        RightMiddleProximal RightMiddleIntermediate RightMiddleDistal
        RightLittleProximal RightLittleIntermediate RightLittleDistal
        RightRingProximal RightRingIntermediate RightRingDistal
        RightThumbMetacarpal RightThumbProximal RightThumbDistal),
];

/// Converts a clip to AMASS arrays, as if SMPL-H's mean body had moved: translations are scaled by
/// the ratio of leg lengths.
///
/// `skeleton` must have all VRM bones except eyes and jaw, aligned with the world in T-pose;
/// missing bones stay at rest. The clip's frames must be evenly spaced. If a clip loops, its last
/// frame repeats the first.
pub fn as_amass(skeleton: &Skeleton, clip: &Clip) -> AmassArrays {
    // From Y up, facing +Z, to Z up, facing -Y.
    let tilted = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let position =
        |bone| skeleton.human(bone).map(|joint| Vec3::from(skeleton.joints()[joint].position));
    let hips = position(HumanBone::Hips).unwrap_or_default();
    let leg = [HumanBone::LeftUpperLeg, HumanBone::LeftLowerLeg, HumanBone::LeftFoot].map(position);
    let scale = match leg {
        [Some(hip), Some(knee), Some(ankle)] => {
            MEAN_LEG_M / (hip.distance(knee) + knee.distance(ankle)).max(1e-3)
        }
        _ => 1.0,
    };
    let joints: Vec<Option<usize>> =
        SMPL_H.iter().chain(HANDS.iter().flatten()).map(|&bone| skeleton.human(bone)).collect();
    let frames = clip.poses.len();
    let mut arrays = AmassArrays {
        poses: Vec::with_capacity(frames * 3 * joints.len()),
        trans: Vec::with_capacity(frames * 3),
        mocap_framerate: (frames.max(2) - 1) as f32 / clip.seconds().max(1e-3),
        frames,
    };
    for pose in &clip.poses {
        for (number, joint) in joints.iter().enumerate() {
            let local =
                joint.map_or(Quat::IDENTITY, |joint| Quat::from_array(pose.rotations[joint]));
            let turn = if number == 0 { tilted * local } else { local };
            arrays.poses.extend(shortest(turn).to_scaled_axis().to_array());
        }
        let moved = tilted * ((hips + Vec3::from(pose.translation)) * scale) - MEAN_PELVIS;
        arrays.trans.extend(moved.to_array());
    }
    arrays
}

/// The same rotation, by at most half a turn.
fn shortest(rotation: Quat) -> Quat {
    if rotation.w < 0.0 { -rotation } else { rotation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Figure;

    #[test]
    fn rotations_stand_where_smpl_h_has_them() {
        let avatar = Figure::new().avatar();
        let clip = &avatar.clips[1];
        let arrays = as_amass(&avatar.skeleton, clip);
        assert_eq!((arrays.frames, arrays.poses.len()), (109, 109 * 156));
        assert_eq!(arrays.trans.len(), 109 * 3);
        assert!((arrays.mocap_framerate - 30.0).abs() < 1e-3);
        let frame = &arrays.poses[50 * 156..51 * 156];
        let turn = |joint: usize| {
            Quat::from_scaled_axis(Vec3::new(
                frame[3 * joint],
                frame[3 * joint + 1],
                frame[3 * joint + 2],
            ))
        };
        let pose = &clip.poses[50];
        for (joint, bone) in [
            (19, HumanBone::RightLowerArm),
            (15, HumanBone::Head),
            (22, HumanBone::LeftIndexProximal),
            (28, HumanBone::LeftLittleProximal),
            (51, HumanBone::RightThumbDistal),
        ] {
            let wanted = Quat::from_array(pose.rotations[bone as usize]);
            assert!(turn(joint).angle_between(wanted) < 2e-3, "{}", bone.name());
        }
        // Upright is a quarter turn about X if Z is up.
        let up = turn(0) * Vec3::Y;
        assert!(up.z > 0.99, "{up}");
        // The mean body's hips are 0.9 m high, lower than the figure's.
        let height = arrays.trans[2] + MEAN_PELVIS.z;
        assert!((0.85..0.95).contains(&height), "{height}");
    }
}
