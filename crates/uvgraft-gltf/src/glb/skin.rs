//! Joints and weights of the vertices, at most four each, and what leaving out the rest costs.

use glam::{Mat3, Quat, Vec3};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{MOST_INFLUENCES, Pose, Pruning, RigError, Rigid, Skin};

use super::buffer::Buffer;
use super::json::{self, ARRAY_BUFFER, UNSIGNED_BYTE, UNSIGNED_SHORT};
use super::vertices::Vertices;

/// The steps that weights are rounded to: floats below 1 hold all of them.
const STEPS: f32 = (1 << 23) as f32;

/// Frames of all clips that are looked at for the error of pruning.
const MOST_FRAMES: usize = 24;

/// Appends joints and weights of vertices; returns their accessors.
///
/// Weights are floats: they are a few bytes more than integers, but the file then moves exactly like the
/// avatar.
pub(super) fn write(
    skin: &Skin,
    joints: usize,
    vertices: &Vertices,
    buffer: &mut Buffer,
) -> (usize, usize) {
    let (mut numbers, mut weights) = (Vec::new(), Vec::with_capacity(vertices.count()));
    let narrow = joints <= usize::from(u8::MAX) + 1;
    for &vertex in &vertices.from {
        let influences = skin.of(vertex as usize);
        // What stays unused is joint 0 with weight 0, as the specification asks.
        let mut own = [(0, 0.0); MOST_INFLUENCES];
        for (own, &influence) in own.iter_mut().zip(influences) {
            *own = influence;
        }
        // Multiples of 2⁻²³ sum without rounding, in whichever order; the largest, which comes first,
        // takes what is left of 1.
        for (_, weight) in &mut own[1..] {
            *weight = (*weight * STEPS).round() / STEPS;
        }
        own[0].1 = 1.0 - own[1..].iter().map(|&(_, weight)| weight).sum::<f32>();
        for own in own.iter_mut().filter(|(_, weight)| *weight == 0.0) {
            own.0 = 0;
        }
        for (joint, _) in own {
            if narrow {
                numbers.push(joint as u8);
            } else {
                numbers.extend(joint.to_le_bytes());
            }
        }
        weights.push(own.map(|(_, weight)| weight));
    }
    let component_type = if narrow { UNSIGNED_BYTE } else { UNSIGNED_SHORT };
    let joints = buffer.fours(&numbers, component_type, vertices.count(), ARRAY_BUFFER);
    (joints, buffer.floats(&weights, Some(ARRAY_BUFFER), false))
}

/// Appends the joints as a skin. Nodes have the numbers of joints. The mesh is bound to the avatar's
/// rest, wherever the nodes stand: all joints are aligned with the world there, so what takes vertices to
/// a joint is a translation.
pub(super) fn write_joints(avatar: &Avatar, buffer: &mut Buffer) -> json::Skin {
    let inverse_bind = |joint: &uvgraft_avatar::rig::Joint| {
        // The product with -1 could make a zero negative.
        let [x, y, z] = joint.position.map(|value| 0.0 - value);
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0]
    };
    let joints = avatar.skeleton.joints();
    let matrices: Vec<[f32; 16]> = joints.iter().map(inverse_bind).collect();
    json::Skin {
        name: "skin".to_owned(),
        inverse_bind_matrices: buffer.floats(&matrices, None, false),
        skeleton: 0,
        joints: (0..joints.len()).collect(),
    }
}

/// How far vertices are from where the whole skin would take them, in metres: at most, and on average
/// over all vertices and poses. Poses are frames of the clips, or all joints bent by 30° around each
/// axis where there are none.
pub(super) fn error(
    avatar: &Avatar,
    pruned: &Skin,
    pruning: &Pruning,
) -> Result<(f32, f32), RigError> {
    if pruning.vertices == 0 {
        return Ok((0.0, 0.0));
    }
    let changed: Vec<usize> = (0..pruned.vertices())
        .filter(|&vertex| pruned.of(vertex).len() < avatar.skin.of(vertex).len())
        .collect();
    let poses = poses(avatar);
    let (mut most, mut sum) = (0.0_f32, 0.0_f64);
    for pose in &poses {
        let motions = avatar.skeleton.motions(pose)?;
        let matrices: Vec<(Mat3, Vec3)> = motions.iter().map(matrix).collect();
        for &vertex in &changed {
            let position = Vec3::from(avatar.mesh.positions()[vertex]);
            let place = |skin: &Skin| {
                skin.of(vertex).iter().fold(Vec3::ZERO, |sum, &(joint, weight)| {
                    let (turn, shift) = matrices[usize::from(joint)];
                    sum + weight * (turn * position + shift)
                })
            };
            let error = place(pruned).distance(place(&avatar.skin));
            most = most.max(error);
            sum += f64::from(error);
        }
    }
    Ok((most, (sum / (poses.len() * pruned.vertices()) as f64) as f32))
}

fn matrix(motion: &Rigid) -> (Mat3, Vec3) {
    (Mat3::from_quat(Quat::from_array(motion.rotation)), Vec3::from(motion.translation))
}

/// Frames at even steps through all clips, or bends.
fn poses(avatar: &Avatar) -> Vec<Pose> {
    let frames: Vec<&Pose> = avatar.clips.iter().flat_map(|clip| &clip.poses).collect();
    if frames.is_empty() {
        return bends(avatar.skeleton.joints().len(), 30.0_f32.to_radians());
    }
    let step = frames.len().div_ceil(MOST_FRAMES);
    frames.into_iter().step_by(step).cloned().collect()
}

/// All joints turned around X, around Y, around Z.
///
/// - `angle`: in radians.
pub(crate) fn bends(joints: usize, angle: f32) -> Vec<Pose> {
    let bend = |axis: usize| {
        let mut turn = [0.0; 3];
        turn[axis] = angle;
        Pose::from_axis_angles([0.0; 3], &vec![turn; joints])
    };
    (0..3).map(bend).collect()
}
