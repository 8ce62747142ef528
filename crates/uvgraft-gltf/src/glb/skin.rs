//! Joints and weights of vertices, at most four each, and the error of pruning the rest.

use glam::{Mat3, Quat, Vec3};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{MAX_INFLUENCES, Pose, Pruning, RigError, Rigid, Skin};

use super::buffer::Buffer;
use super::json::{self, ARRAY_BUFFER, UNSIGNED_BYTE, UNSIGNED_SHORT};
use super::vertices::Vertices;

/// Steps per unit that weights are rounded to: an `f32` below 1 represents every step exactly.
const STEPS: f32 = (1 << 23) as f32;

/// Upper limit of clip frames evaluated for the pruning error.
const MAX_FRAMES: usize = 24;

/// Appends joints and weights of vertices; returns the indices of their accessors.
///
/// Weights are floats: a few bytes more than normalised integers, but the file then
/// animates exactly like the avatar.
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
        // Unused slots are joint 0 with weight 0, as the specification requires.
        let mut own = [(0, 0.0); MAX_INFLUENCES];
        for (own, &influence) in own.iter_mut().zip(influences) {
            *own = influence;
        }
        // Multiples of 2⁻²³ add up without rounding in any order; the largest weight, which comes
        // first, takes the remainder of 1.
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
    let joints = buffer.vec4s(&numbers, component_type, vertices.count(), ARRAY_BUFFER);
    (joints, buffer.floats(&weights, Some(ARRAY_BUFFER), false))
}

/// Appends the joints as a skin. Nodes have the indices of joints. The mesh is bound to the
/// avatar's rest pose, regardless of the pose of the nodes. Joints are axis-aligned there, so each
/// inverse bind matrix is a translation.
pub(super) fn write_joints(avatar: &Avatar, buffer: &mut Buffer) -> json::Skin {
    let inverse_bind = |joint: &uvgraft_avatar::rig::Joint| {
        // Negating could yield -0.0.
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

/// Displacement of vertices by pruning, compared with the full skin, in metres: the maximum, and
/// the mean over all vertices and poses. Poses are frames of the clips or, if there are none, all
/// joints bent by 30° about each axis.
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

/// Evenly spaced frames of all clips, or bends if there are no clips.
fn poses(avatar: &Avatar) -> Vec<Pose> {
    let frames: Vec<&Pose> = avatar.clips.iter().flat_map(|clip| &clip.poses).collect();
    if frames.is_empty() {
        return bends(avatar.skeleton.joints().len(), 30.0_f32.to_radians());
    }
    let step = frames.len().div_ceil(MAX_FRAMES);
    frames.into_iter().step_by(step).cloned().collect()
}

/// Poses with all joints rotated about X, about Y, about Z.
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
