//! Walking in place: the ground moves backwards under the figure.

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use uvgraft::easing::{mix, smoothstep};
use uvgraft_avatar::rig::{HumanBone, Pose, Skeleton};

use super::posture::{Posture, degrees};
use crate::curve::curve;
use crate::rigging::joints::{LEFT, Limbs, RIGHT};

/// Duration of a cycle of two steps.
pub(super) const SECONDS: f32 = 1.2;
/// Distance that the ground moves in a cycle, in metres.
pub(super) const STRIDE: f32 = 1.12;
/// The fraction of the cycle in which a foot is on the ground.
pub(super) const STANCE: f32 = 0.62;
/// Where a foot lands, in front of its rest position, in metres.
const REACH: f32 = 0.36;

pub(super) fn pose(skeleton: &Skeleton, seconds: f32) -> Pose {
    let phase = seconds / SECONDS;
    let mut posture = Posture::standing(skeleton);
    // The left heel lands at 0. The hips are lowest then, and highest as the legs pass each other.
    let step = TAU * phase;
    let twice = 2.0 * step;
    posture.move_hips([1.6 * (step - 0.5).sin(), -3.5 - 1.4 * (twice - 0.5).cos(), 0.0]);
    let yaw = 5.0 * (step + 0.2).cos();
    let roll = 2.2 * (step - 0.5).sin();
    posture.turn(HumanBone::Hips, [2.0, -yaw, roll]);
    posture.turn(HumanBone::Spine, [1.0, 0.9 * yaw, -0.7 * roll]);
    posture.turn(HumanBone::Chest, [0.5, 0.7 * yaw, -0.4 * roll]);
    posture.turn(HumanBone::UpperChest, [0.0, 0.4 * yaw, 0.0]);
    posture.turn(HumanBone::Neck, [-1.5, -0.5 * yaw, 0.0]);
    posture.turn(HumanBone::Head, [-2.0 + 0.8 * twice.cos(), -0.5 * yaw, 0.1 * roll]);
    for limbs in [LEFT, RIGHT] {
        let own = if limbs.sign > 0.0 { phase } else { phase + 0.5 }.fract();
        // Arms swing opposite to the legs; elbows bend as they come forward.
        let swing = -(TAU * own - 0.25).cos();
        let late = -(TAU * own - 0.75).cos();
        posture.hang(&limbs, 3.0 + 21.0 * swing, 24.0 + 13.0 * late);
        step_foot(&mut posture, &limbs, own);
    }
    posture.pose
}

/// Places a foot at a `phase` of its cycle, which begins as its heel lands.
fn step_foot(posture: &mut Posture<'_>, limbs: &Limbs, phase: f32) {
    let rest = |bone| Vec3::from(posture.skeleton.joints()[bone as usize].position);
    let ankle = rest(limbs.foot);
    let ball = rest(limbs.toes);
    let heel = Vec3::new(ankle.x, 0.0, ankle.z - 0.045);
    let target = if phase < STANCE {
        on_ground(phase, ankle, heel, ball)
    } else {
        // A cubic Hermite curve from lift-off to landing, with the ground's speed at both ends, so
        // that the foot's velocity is continuous.
        let (from, to) = (on_ground(STANCE, ankle, heel, ball), on_ground(0.0, ankle, heel, ball));
        let length = 1.0 - STANCE;
        let t = (phase - STANCE) / length;
        let speed = Vec3::NEG_Z * STRIDE * length;
        let (t2, t3) = (t * t, t * t * t);
        let lift = 0.05 * (std::f32::consts::PI * t.powf(0.75)).sin().powi(2);
        from * (2.0 * t3 - 3.0 * t2 + 1.0)
            + to * (3.0 * t2 - 2.0 * t3)
            + speed * (t3 - 2.0 * t2 + t)
            + speed * (t3 - t2)
            + Vec3::Y * lift
    };
    // Walking feet are closer to the centre line than standing ones.
    let inwards = Vec3::new(-0.022 * limbs.sign, 0.0, 0.0);
    let foot = degrees([pitch(phase), 0.0, 0.0]);
    posture.plant(limbs, target + inwards, foot);
    // Toes stay on the ground as the heel rises.
    let toes = if phase < STANCE {
        pitch(phase).max(0.0)
    } else {
        mix(pitch(STANCE), 0.0, smoothstep(STANCE, STANCE + 0.18, phase))
    };
    posture.set(limbs.toes, Quat::from_rotation_x(-toes.to_radians()));
}

/// Pitch of the foot in degrees: positive with the heel raised, negative with the toes raised.
fn pitch(phase: f32) -> f32 {
    const TURNS: [(f32, f32); 9] = [
        (0.0, -17.0),
        (0.1, 0.0),
        (0.25, 0.0),
        (0.38, 2.0),
        (0.5, 16.0),
        (STANCE, 42.0),
        (0.74, 36.0),
        (0.9, -12.0),
        (1.0, -17.0),
    ];
    curve(&TURNS, phase)
}

/// Ankle position of a foot on the ground that rolls over heel and ball.
fn on_ground(phase: f32, ankle: Vec3, heel: Vec3, ball: Vec3) -> Vec3 {
    let pitch = pitch(phase);
    let pivot = if pitch < 0.0 { heel } else { ball };
    let rolled = pivot + degrees([pitch, 0.0, 0.0]) * (ankle - pivot);
    rolled + Vec3::Z * (REACH - STRIDE * phase)
}
