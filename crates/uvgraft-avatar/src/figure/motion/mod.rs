//! Motions of the figure, made by formula.

mod amass;
mod legs;
mod posture;
mod walk;
mod wave;

pub use amass::{AmassArrays, as_amass};

use std::f32::consts::TAU;

use self::posture::Posture;
use super::rigging::joints::{LEFT, RIGHT};
use crate::rig::{Clip, HumanBone, Pose, Skeleton};

/// Frames a second of all clips.
const RATE: f32 = 30.0;

/// The clips `idle`, `wave` and `walk` of the figure's skeleton in T-pose; each ends as it begins.
pub(crate) fn clips(skeleton: &Skeleton) -> Vec<Clip> {
    vec![
        clip("idle", 4.0, |seconds| idle(skeleton, seconds)),
        clip("wave", wave::SECONDS, |seconds| wave::pose(skeleton, seconds)),
        clip("walk", walk::SECONDS, |seconds| walk::pose(skeleton, seconds)),
    ]
}

/// A clip that loops: its last pose is its first one.
fn clip(name: &str, seconds: f32, pose: impl Fn(f32) -> Pose) -> Clip {
    let frames = (seconds * RATE).round() as usize;
    let mut poses: Vec<Pose> = (0..frames).map(|frame| pose(frame as f32 / RATE)).collect();
    poses.push(poses[0].clone());
    let times = (0..=frames).map(|frame| frame as f32 / RATE).collect();
    Clip { name: name.to_owned(), times, poses }
}

/// Stands and breathes.
fn idle(skeleton: &Skeleton, seconds: f32) -> Pose {
    let mut posture = Posture::standing(skeleton);
    breathe(&mut posture, seconds / 4.0);
    posture.plant_both();
    posture.pose
}

/// Breath and a slow sway; `phase` counts breaths.
fn breathe(posture: &mut Posture<'_>, phase: f32) {
    let breath = 0.5 - 0.5 * (TAU * phase).cos();
    let sway = (TAU * phase).sin();
    posture.move_hips([0.4 * sway, -0.25 * breath, 0.0]);
    posture.turn(HumanBone::Spine, [0.5 * breath, 0.0, -0.3 * sway]);
    posture.turn(HumanBone::UpperChest, [-1.6 * breath, 0.0, 0.0]);
    posture.turn(HumanBone::Neck, [0.8 * breath, 0.0, 0.0]);
    posture.turn(HumanBone::Head, [0.3 * breath, 0.8 * sway, 0.3 * sway]);
    for limbs in [LEFT, RIGHT] {
        posture.turn(limbs.shoulder, [0.0, 0.0, limbs.sign * 1.4 * breath]);
        posture.turn(limbs.upper_arm, [0.0, 0.0, limbs.sign * -0.8 * breath]);
    }
}
