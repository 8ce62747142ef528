//! A greeting: the right hand rises and waves.

use std::f32::consts::TAU;

use uvgraft::easing::smoothstep;
use uvgraft_avatar::rig::{HumanBone, Pose, Skeleton};

use super::posture::{Posture, degrees};
use crate::rigging::joints::RIGHT;

pub(super) const SECONDS: f32 = 3.6;
/// Swings per second.
const SWINGS: f32 = 2.2;

pub(super) fn pose(skeleton: &Skeleton, seconds: f32) -> Pose {
    let mut posture = Posture::standing(skeleton);
    super::breathe(&mut posture, seconds / SECONDS);
    // The upper arm moves first; forearm and hand follow.
    let up = |late: f32| {
        smoothstep(0.1 + late, 0.85 + late, seconds) * smoothstep(3.5 - late, 2.7 - late, seconds)
    };
    let (arm, forearm, hand) = (up(0.0), up(0.08), up(0.16));
    let swing = (TAU * SWINGS * (seconds - 0.9)).sin() * up(0.25);
    let follow = (TAU * SWINGS * (seconds - 0.98)).sin() * up(0.25);
    let s = RIGHT.sign;

    posture.towards(RIGHT.shoulder, degrees([0.0, 0.0, s * 9.0]), arm);
    let raised = degrees([0.0, s * -24.0, 0.0])
        * degrees([0.0, 0.0, s * -10.0])
        * degrees([-82.0 - 5.0 * swing, 0.0, 0.0]);
    posture.towards(RIGHT.upper_arm, raised, arm);
    posture.towards(RIGHT.lower_arm, degrees([0.0, s * (-84.0 + 17.0 * swing), 0.0]), forearm);
    posture.towards(RIGHT.hand, degrees([0.0, s * (8.0 + 12.0 * follow), s * 6.0]), hand);
    posture.curl(&RIGHT, 1.0 - 0.65 * hand);

    // The weight shifts to the other leg, and the head tilts towards the hand.
    posture.move_hips([2.6 * arm, -0.5 * arm, 0.0]);
    posture.turn(HumanBone::Hips, [0.0, -3.0 * arm, 1.6 * arm]);
    posture.turn(HumanBone::Spine, [0.0, -arm, 1.2 * arm]);
    posture.turn(HumanBone::Chest, [0.0, 0.0, 1.4 * arm + 0.4 * swing]);
    posture.turn(HumanBone::UpperChest, [0.0, 2.0 * arm, 0.0]);
    posture.turn(HumanBone::Neck, [0.0, 2.0 * hand, -3.0 * hand]);
    posture.turn(HumanBone::Head, [3.0 * hand, 2.0 * hand, -5.0 * hand - 0.8 * follow]);
    posture.plant_both();
    posture.pose
}
