//! Gaze directions, as expressions.

use glam::{Quat, Vec3};

use crate::Avatar;
use crate::rig::{Expression, ExpressionPreset as Preset, HumanBone, Morph};

/// Rotation of the eyes in the full expression, in degrees.
const UP_DEG: f32 = 20.0;
const ACROSS_DEG: f32 = 25.0;

/// Adds the expressions `lookUp`, `lookDown`, `lookLeft` and `lookRight` to an avatar whose eyes
/// are bones, with morphs that rotate the vertices attached to these bones alone. Left is the
/// person's own left. Avatars without eyes remain unchanged.
pub fn add_gaze(avatar: &mut Avatar) {
    let eyes = [HumanBone::LeftEye, HumanBone::RightEye];
    let joints: Vec<usize> = eyes.iter().filter_map(|&eye| avatar.skeleton.human(eye)).collect();
    let follows = |vertex: usize| match avatar.skin.of(vertex) {
        [(first, weight), ..] if *weight > 0.99 => {
            joints.iter().copied().find(|&joint| joint == usize::from(*first))
        }
        _ => None,
    };
    let balls: Vec<(u32, usize)> = (0..avatar.skin.vertices())
        .filter_map(|vertex| Some((vertex as u32, follows(vertex)?)))
        .collect();
    if joints.len() < eyes.len() || balls.is_empty() {
        return;
    }
    for (preset, axis, degrees) in [
        (Preset::LookUp, Vec3::NEG_X, UP_DEG),
        (Preset::LookDown, Vec3::X, UP_DEG),
        (Preset::LookLeft, Vec3::Y, ACROSS_DEG),
        (Preset::LookRight, Vec3::NEG_Y, ACROSS_DEG),
    ] {
        if avatar.expressions.iter().any(|expression| expression.preset == Some(preset)) {
            continue;
        }
        let turn = Quat::from_axis_angle(axis, degrees.to_radians());
        let offset = |&(vertex, joint): &(u32, usize)| {
            let center = Vec3::from(avatar.skeleton.joints()[joint].position);
            let from = Vec3::from(avatar.mesh.positions()[vertex as usize]) - center;
            (vertex, (turn * from - from).to_array())
        };
        let offsets = balls.iter().map(offset).collect();
        avatar.expressions.push(Expression::preset(preset, vec![(avatar.morphs.len(), 1.0)]));
        avatar.morphs.push(Morph { name: preset.name().to_owned(), offsets });
    }
}
