//! Procedural motions of the figure.

mod amass;
mod legs;
mod posture;
mod walk;
mod wave;

use std::f32::consts::TAU;

use uvgraft_avatar::rig::{Clip, HumanBone, Pose, Skeleton};

use self::posture::Posture;
use super::rigging::joints::{LEFT, RIGHT};
pub use amass::{AmassArrays, as_amass};

/// Frame rate of all clips, in frames per second.
const RATE: f32 = 30.0;

/// The clips `idle`, `wave` and `walk` for the figure's skeleton in T-pose; each loops.
pub(crate) fn clips(skeleton: &Skeleton) -> Vec<Clip> {
    vec![
        clip("idle", 4.0, |seconds| idle(skeleton, seconds)),
        clip("wave", wave::SECONDS, |seconds| wave::pose(skeleton, seconds)),
        clip("walk", walk::SECONDS, |seconds| walk::pose(skeleton, seconds)),
    ]
}

/// A looping clip: its last pose repeats the first.
fn clip(name: &str, seconds: f32, pose: impl Fn(f32) -> Pose) -> Clip {
    let frames = (seconds * RATE).round() as usize;
    let mut poses: Vec<Pose> = (0..frames).map(|frame| pose(frame as f32 / RATE)).collect();
    poses.push(poses[0].clone());
    let times = (0..=frames).map(|frame| frame as f32 / RATE).collect();
    Clip { name: name.to_owned(), times, poses }
}

/// Standing and breathing.
fn idle(skeleton: &Skeleton, seconds: f32) -> Pose {
    let mut posture = Posture::standing(skeleton);
    breathe(&mut posture, seconds / 4.0);
    posture.plant_both();
    posture.pose
}

/// Breathing and a slow sway; `phase` is in breaths.
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

#[cfg(test)]
mod tests {
    use glam::{Quat, Vec3};

    use super::*;
    use crate::Figure;
    use crate::surface::PartKind;
    use uvgraft_avatar::Avatar;

    /// Position of a bone's joint in a pose.
    fn place(avatar: &Avatar, pose: &Pose, bone: HumanBone) -> Vec3 {
        let motion = avatar.skeleton.motions(pose).unwrap()[bone as usize];
        motion.point(avatar.skeleton.joints()[bone as usize].position).into()
    }

    #[test]
    fn clips_end_as_they_begin_and_never_jump() {
        let avatar = Figure::new().avatar();
        let names: Vec<&str> = avatar.clips.iter().map(|clip| clip.name.as_str()).collect();
        assert_eq!(names, ["idle", "wave", "walk"]);
        for clip in &avatar.clips {
            assert_eq!(clip.poses.first(), clip.poses.last(), "{}", clip.name);
            for (frame, pair) in clip.poses.windows(2).enumerate() {
                for (joint, (a, b)) in pair[0].rotations.iter().zip(&pair[1].rotations).enumerate()
                {
                    let turn =
                        Quat::from_array(*a).angle_between(Quat::from_array(*b)).to_degrees();
                    // 600 degrees per second; the wrist of a waving hand stays well below.
                    let bone = HumanBone::ALL[joint].name();
                    assert!(turn < 20.0, "{} {frame}: {bone} turns {turn} deg", clip.name);
                }
            }
        }
    }

    #[test]
    fn standing_feet_do_not_move() {
        let avatar = Figure::new().avatar();
        for clip in &avatar.clips[..2] {
            for pose in &clip.poses {
                for bone in [LEFT.foot, RIGHT.foot, LEFT.toes, RIGHT.toes] {
                    let rest = Vec3::from(avatar.skeleton.joints()[bone as usize].position);
                    let moved = place(&avatar, pose, bone).distance(rest);
                    assert!(moved < 1e-3, "{}: {} moves {moved} m", clip.name, bone.name());
                }
            }
        }
    }

    #[test]
    fn waving_raises_the_right_hand_over_the_shoulder() {
        let avatar = Figure::new().avatar();
        let middle = &avatar.clips[1].poses[54];
        let hand = place(&avatar, middle, RIGHT.hand);
        assert!(hand.y > place(&avatar, middle, RIGHT.shoulder).y + 0.1 && hand.x < -0.3, "{hand}");
        assert!(place(&avatar, middle, LEFT.hand).y < 1.05);
    }

    #[test]
    fn walking_feet_stay_on_the_ground_and_move_with_it() {
        let figure = Figure::new();
        let avatar = figure.avatar();
        let parts = figure.parts_of_vertices();
        let clip = &avatar.clips[2];
        for (k, pose) in clip.poses.iter().enumerate() {
            let posed = avatar.posed(pose, &[]).unwrap();
            let lowest = |sign: f32| {
                let shoes = posed.iter().zip(&parts).zip(avatar.mesh.positions());
                let own = shoes.filter(|((_, part), rest)| {
                    part.kind == PartKind::Shoe && rest[0] * sign > 0.0
                });
                own.map(|((p, _), _)| p[1]).fold(f32::INFINITY, f32::min)
            };
            let phase = k as f32 / (clip.poses.len() - 1) as f32;
            for (limbs, own) in [(LEFT, phase), (RIGHT, (phase + 0.5).fract())] {
                let low = lowest(limbs.sign);
                assert!(low > -0.012, "frame {k}: {} is {low} m high", limbs.foot.name());
                if own < walk::STANCE - 0.02 {
                    assert!(low < 0.012, "frame {k}: {} is {low} m high", limbs.foot.name());
                }
            }
        }
        // The left foot is flat from frame 4 to 12 and moves backwards with the ground.
        for frame in 5..12 {
            let z = |frame: usize| place(&avatar, &clip.poses[frame], LEFT.toes).z;
            let step = z(frame) - z(frame + 1);
            let wanted = walk::STRIDE / (walk::SECONDS * RATE);
            assert!((step - wanted).abs() < 2e-3, "frame {frame}: {step} for {wanted}");
        }
    }
}
