//! The figure's joints: VRM's bones, placed by the same constants that shape the figure.

use glam::{Vec3, vec3};
use uvgraft_avatar::rig::{HumanBone, Joint};

use crate::arms::{self, WRIST};
use crate::body_shape::{ARM, SHOULDER};
use crate::head_shape::{EYE, EYE_LEVEL};
use crate::symmetry::Symmetry as _;

/// The bones that come in pairs, on one side.
pub(crate) struct Limbs {
    /// 1 on the left (+X), -1 on the right.
    pub sign: f32,
    pub eye: HumanBone,
    pub upper_leg: HumanBone,
    pub lower_leg: HumanBone,
    pub foot: HumanBone,
    pub toes: HumanBone,
    pub shoulder: HumanBone,
    pub upper_arm: HumanBone,
    pub lower_arm: HumanBone,
    pub hand: HumanBone,
    /// From the thumb to the little finger, each from the hand outwards.
    pub fingers: [[HumanBone; 3]; 5],
}

pub(crate) const LEFT: Limbs = Limbs {
    sign: 1.0,
    eye: HumanBone::LeftEye,
    upper_leg: HumanBone::LeftUpperLeg,
    lower_leg: HumanBone::LeftLowerLeg,
    foot: HumanBone::LeftFoot,
    toes: HumanBone::LeftToes,
    shoulder: HumanBone::LeftShoulder,
    upper_arm: HumanBone::LeftUpperArm,
    lower_arm: HumanBone::LeftLowerArm,
    hand: HumanBone::LeftHand,
    fingers: [
        [HumanBone::LeftThumbMetacarpal, HumanBone::LeftThumbProximal, HumanBone::LeftThumbDistal],
        [
            HumanBone::LeftIndexProximal,
            HumanBone::LeftIndexIntermediate,
            HumanBone::LeftIndexDistal,
        ],
        [
            HumanBone::LeftMiddleProximal,
            HumanBone::LeftMiddleIntermediate,
            HumanBone::LeftMiddleDistal,
        ],
        [HumanBone::LeftRingProximal, HumanBone::LeftRingIntermediate, HumanBone::LeftRingDistal],
        [
            HumanBone::LeftLittleProximal,
            HumanBone::LeftLittleIntermediate,
            HumanBone::LeftLittleDistal,
        ],
    ],
};

pub(crate) const RIGHT: Limbs = Limbs {
    sign: -1.0,
    eye: HumanBone::RightEye,
    upper_leg: HumanBone::RightUpperLeg,
    lower_leg: HumanBone::RightLowerLeg,
    foot: HumanBone::RightFoot,
    toes: HumanBone::RightToes,
    shoulder: HumanBone::RightShoulder,
    upper_arm: HumanBone::RightUpperArm,
    lower_arm: HumanBone::RightLowerArm,
    hand: HumanBone::RightHand,
    fingers: [
        [
            HumanBone::RightThumbMetacarpal,
            HumanBone::RightThumbProximal,
            HumanBone::RightThumbDistal,
        ],
        [
            HumanBone::RightIndexProximal,
            HumanBone::RightIndexIntermediate,
            HumanBone::RightIndexDistal,
        ],
        [
            HumanBone::RightMiddleProximal,
            HumanBone::RightMiddleIntermediate,
            HumanBone::RightMiddleDistal,
        ],
        [
            HumanBone::RightRingProximal,
            HumanBone::RightRingIntermediate,
            HumanBone::RightRingDistal,
        ],
        [
            HumanBone::RightLittleProximal,
            HumanBone::RightLittleIntermediate,
            HumanBone::RightLittleDistal,
        ],
    ],
};

/// The joints of the left leg.
pub(crate) const HIP: Vec3 = vec3(8.6, 90.0, -0.8);
pub(crate) const KNEE: Vec3 = vec3(9.1, 50.0, 0.3);
pub(crate) const ANKLE: Vec3 = vec3(9.9, 8.6, -3.0);
/// Joint of the toes, in the ball of the foot.
pub(crate) const BALL: Vec3 = vec3(11.6, 2.2, 8.4);
/// Distance of the elbow from the shoulder.
pub(crate) const ELBOW: f32 = 27.0;
/// The hinge of the jaw, in head space.
pub(crate) const JAW: Vec3 = vec3(0.0, -2.0, 0.6);
/// The uppermost joint of the neck, in head space.
pub(crate) const NAPE: Vec3 = vec3(0.0, -6.5, -2.4);

/// The joints of the figure as modelled, in metres: one for each of [`HumanBone::ALL`], in that
/// order.
pub(crate) fn joints() -> Vec<Joint> {
    let head = |p: Vec3| p + vec3(0.0, EYE_LEVEL, 0.0);
    let mut table: Vec<(HumanBone, Option<HumanBone>, Vec3)> = vec![
        (HumanBone::Hips, None, vec3(0.0, 94.0, -1.0)),
        (HumanBone::Spine, Some(HumanBone::Hips), vec3(0.0, 102.0, -1.8)),
        (HumanBone::Chest, Some(HumanBone::Spine), vec3(0.0, 113.5, -2.8)),
        (HumanBone::UpperChest, Some(HumanBone::Chest), vec3(0.0, 126.0, -3.4)),
        (HumanBone::Neck, Some(HumanBone::UpperChest), vec3(0.0, 146.5, -4.2)),
        (HumanBone::Head, Some(HumanBone::Neck), head(NAPE)),
        (HumanBone::Jaw, Some(HumanBone::Head), head(JAW)),
    ];
    for limbs in [LEFT, RIGHT] {
        let mut add = |bone, parent, p: Vec3| {
            table.push((bone, Some(parent), if limbs.sign < 0.0 { p.mirrored() } else { p }));
        };
        add(limbs.eye, HumanBone::Head, head(EYE));
        add(limbs.upper_leg, HumanBone::Hips, HIP);
        add(limbs.lower_leg, limbs.upper_leg, KNEE);
        add(limbs.foot, limbs.lower_leg, ANKLE);
        add(limbs.toes, limbs.foot, BALL);
        add(limbs.shoulder, HumanBone::UpperChest, vec3(2.4, 141.5, -1.2));
        add(limbs.upper_arm, limbs.shoulder, SHOULDER);
        add(limbs.lower_arm, limbs.upper_arm, SHOULDER + ARM * ELBOW);
        add(limbs.hand, limbs.lower_arm, SHOULDER + ARM * WRIST);
        for (number, bones) in limbs.fingers.into_iter().enumerate() {
            let [first, second, third, _] = arms::finger_joints(number);
            add(bones[0], limbs.hand, first);
            add(bones[1], bones[0], second);
            add(bones[2], bones[1], third);
        }
    }
    table.sort_by_key(|&(bone, ..)| bone);
    let joint = |&(bone, parent, position): &(HumanBone, Option<HumanBone>, Vec3)| Joint {
        name: bone.name().to_owned(),
        parent: parent.map(|parent| parent as usize),
        position: (position * 0.01).into(),
        human: Some(bone),
    };
    table.iter().map(joint).collect()
}
