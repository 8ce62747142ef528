//! Skin weights of neck, head and jaw.

use glam::{Vec3, vec3};
use uvgraft::easing::{mix, smoothstep};
use uvgraft_avatar::rig::HumanBone;

use super::Weights;
use super::joints::JAW;
use crate::head_shape::{EYE_LEVEL, LIP_WIDTH, lip_line, neck_axis};

/// Adds the weights of neck and head for a point of the skin, or of a collar around it, in world
/// space; `whole` is the weight to distribute. Returns the remainder for the trunk.
pub(crate) fn neck(weights: &mut Weights, p: Vec3, whole: f32) -> f32 {
    let p = p - vec3(0.0, EYE_LEVEL, 0.0);
    // Height above a plane through throat and nape that rises towards the back, like the base of
    // the skull.
    let height = p.y + 0.3 * p.z + 9.0;
    let off = p - neck_axis(p.y);
    // Shoulders at the same height are far from the axis.
    let beside = smoothstep(11.0, 6.0, (off.x * off.x + off.z * off.z).sqrt());
    let neck =
        whole * smoothstep(-9.0, -3.0, height) * mix(beside, 1.0, smoothstep(-4.0, -2.0, height));
    let head = neck * smoothstep(-5.0, 0.2, height);
    weights.add(HumanBone::Neck, neck - head);
    weights.add(HumanBone::Head, head);
    whole - neck
}

/// Weight of the jaw, as opposed to the skull, at a point of the face's skin in head space. `lip`
/// tells apart upper and lower lip, which touch; see [`Figure::lips`](super::Figure::lips).
pub(crate) fn jaw(p: Vec3, lip: Option<f32>) -> f32 {
    let x = p.x.abs();
    let (dy, dz) = (p.y - JAW.y, p.z - JAW.z);
    // Upper limit: within the mouth the line between the lips, lateral to it a band that widens.
    let split = if lip.is_some() || (x < LIP_WIDTH && dz > 0.0) {
        let t = x / LIP_WIDTH;
        let height = p.y - lip_line(x);
        let middle = lip.map_or(1.0 - t * t, f32::abs).max(0.0).powf(0.7);
        let apart = if lip == Some(0.0) {
            0.0
        } else {
            mix(middle, 1.0, smoothstep(0.0, 2.0, height.abs()))
        };
        if is_lower(p, lip) { apart } else { -apart }
    } else {
        // The line from the corner of the mouth to the hinge.
        let corner = lip_line(LIP_WIDTH);
        let t = ((x - LIP_WIDTH) / 4.0).clamp(0.0, 1.0);
        let line = mix(corner, -3.5, t * t);
        let band = mix(2.0, 3.5, t);
        let off = (line - p.y) / band;
        2.0 * smoothstep(-1.0, 1.0, off) - 1.0
    };
    let opened = 0.5 + 0.5 * split;
    // Lower limit, at the throat: the line from the angle of the jaw to the chin.
    let edge = mix(-7.5, -10.8, ((p.z - 0.5) / 6.5).clamp(0.0, 1.0));
    let above_throat = smoothstep(3.2, 0.0, edge - p.y);
    // Rear limit, in front of the ears.
    let in_front = smoothstep(-1.0, 3.5, dz) * smoothstep(-0.2, -4.0, dy);
    opened * above_throat * in_front
}

/// Whether a point of the skin is below the line between the lips; see [`jaw`].
pub(crate) fn is_lower(p: Vec3, lip: Option<f32>) -> bool {
    let below = p.y < lip_line(p.x.clamp(-LIP_WIDTH, LIP_WIDTH));
    lip.map_or(below, |along| along > 0.0)
}
