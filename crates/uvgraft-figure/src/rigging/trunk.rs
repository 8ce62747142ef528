//! Skin weights of trunk, neck, arms and legs.
//!
//! The weights are functions of the position alone, defined in the whole space around the modelled
//! figure: skin, cloth over it and overlapping parts move together, and no boundary between parts
//! can tear. Each joint blends in across a band as wide as the limb. The one exception is the root
//! of a sleeve, which the shirt hides: it follows less, or it would come out under a raised arm.

use glam::{Vec3, vec3};
use uvgraft::easing::{mix, smoothstep};
use uvgraft_avatar::rig::HumanBone;

use super::joints::{ELBOW, HIP, KNEE, LEFT, Limbs, RIGHT};
use super::{Weights, head};
use crate::arms::WRIST;
use crate::body_shape::{ARM, SHOULDER};
use crate::surface::PartKind;
use crate::symmetry::Symmetry as _;

/// The weights of a point on trunk, neck, arms or trousers, in world space, in centimetres.
pub(crate) fn weights(kind: PartKind, p: Vec3) -> Weights {
    let mut weights = Weights::default();
    let (own, other) = if p.x < 0.0 { (RIGHT, LEFT) } else { (LEFT, RIGHT) };
    let q = p.folded();
    let rest = head::neck(&mut weights, p, 1.0);
    let rest = arm(&mut weights, &own, kind, q, rest);
    let rest = legs(&mut weights, &own, &other, q, rest);
    spine(&mut weights, p.y, rest);
    weights
}

/// Adds the arm's part of `whole`; `q` is on the left. Returns the remainder.
fn arm(weights: &mut Weights, own: &Limbs, kind: PartKind, q: Vec3, whole: f32) -> f32 {
    let along = (q - SHOULDER).dot(ARM);
    // Starts far out on the arm, so that a raised arm leaves the flank and the collar in place.
    let raised = smoothstep(-4.0, 11.0, outwards(q));
    let raised = match kind {
        PartKind::Sleeve => raised * mix(0.5, 1.0, smoothstep(-3.5, 6.0, along)),
        _ => raised,
    };
    let bent = bend(ELBOW - 10.5, ELBOW + 10.5, along);
    let turned = smoothstep(WRIST - 5.5, WRIST + 4.5, along);
    let arm = whole * raised;
    weights.add(own.upper_arm, arm * (1.0 - bent));
    weights.add(own.lower_arm, arm * bent * (1.0 - turned));
    weights.add(own.hand, arm * bent * turned);
    // The collar bone carries the top of the shoulder and the cloth hanging from it in
    // front and behind.
    let rest = whole - arm;
    let shoulder = smoothstep(3.0, 13.5, q.x) * smoothstep(126.0, 139.0, q.y);
    weights.add(own.shoulder, rest * shoulder);
    rest * (1.0 - shoulder)
}

/// Signed distance towards the arm's side of the shoulder: above the armpit from a nearly vertical
/// plane, below it from the plane midway between arm and trunk, with a smooth minimum between them.
fn outwards(q: Vec3) -> f32 {
    const ARMPIT: Vec3 = vec3(14.9, 133.5, 0.0);
    const ABOVE: Vec3 = vec3(0.995, 0.1, 0.0);
    const BELOW: Vec3 = vec3(0.91, 0.42, 0.0);
    const BLEND: f32 = 3.0;
    let (above, below) = ((q - ARMPIT).dot(ABOVE), (q - ARMPIT).dot(BELOW));
    let overlap = (BLEND - (above - below).abs()).max(0.0) / BLEND;
    above.min(below) - overlap * overlap * BLEND * 0.25
}

/// Adds the legs' part of `whole`; `q` is on the left. Returns the remainder.
fn legs(weights: &mut Weights, own: &Limbs, other: &Limbs, q: Vec3, whole: f32) -> f32 {
    // Legs begin at the crotch on the inside and at the hip bone on the outside.
    let middle = mix(81.0, HIP.y - 0.5, smoothstep(0.0, 11.0, q.x));
    // The band is wide enough that trousers stay inside the shirt in a seated pose.
    let legs = whole * smoothstep(middle + 12.0, middle - 12.0, q.y);
    // Both legs share the crotch, but not the thighs below it.
    let shared = mix(0.3, 5.0, smoothstep(75.0, 84.0, q.y));
    let side = smoothstep(-shared, shared, q.x);
    let bent = bend(KNEE.y + 14.0, KNEE.y - 14.0, q.y);
    // The hem rests on the shoe.
    let foot = 0.55 * smoothstep(14.0, 3.5, q.y);
    for (limbs, leg) in [(own, legs * side), (other, legs * (1.0 - side))] {
        weights.add(limbs.upper_leg, leg * (1.0 - bent));
        weights.add(limbs.lower_leg, leg * bent * (1.0 - foot));
        weights.add(limbs.foot, leg * bent * foot);
    }
    whole - legs
}

/// From 0 to 1 at nearly constant speed: rings around a knee or an elbow rotate by equal angles, so
/// that the outline has no corner.
fn bend(from: f32, to: f32, x: f32) -> f32 {
    let even = ((x - from) / (to - from)).clamp(0.0, 1.0);
    mix(even, smoothstep(from, to, x), 0.35)
}

fn spine(weights: &mut Weights, y: f32, whole: f32) {
    let mut below = whole;
    let bones = [HumanBone::Hips, HumanBone::Spine, HumanBone::Chest, HumanBone::UpperChest];
    for (k, band) in [(94.0, 109.0), (107.0, 120.0), (119.0, 133.0)].into_iter().enumerate() {
        let above = below * smoothstep(band.0, band.1, y);
        weights.add(bones[k], below - above);
        below = above;
    }
    weights.add(bones[3], below);
}
