//! How far points of trunk, neck, arms and legs follow which joints.
//!
//! The shares are functions of the place alone, one for the whole space around the figure as it is
//! modelled: skin, and cloth over it, and parts that overlap move together, and no border between
//! parts can tear. Each joint takes over across a band around it that is as wide as the limb. Only
//! the root of a sleeve, which the shirt hides, hangs back, or it would come out under a raised arm.

use glam::{Vec3, vec3};
use uvgraft::easing::{mix, smoothstep};
use uvgraft_avatar::rig::HumanBone;

use super::joints::{ELBOW, HIP, KNEE, LEFT, Limbs, RIGHT};
use super::{Shares, head};
use crate::arms::WRIST;
use crate::body_shape::{ARM, SHOULDER};
use crate::surface::PartKind;
use crate::symmetry::Symmetry as _;

/// The shares of a point on trunk, neck, arms or trousers. World space in centimetres.
pub(crate) fn shares(kind: PartKind, p: Vec3) -> Shares {
    let mut shares = Shares::default();
    let (own, other) = if p.x < 0.0 { (RIGHT, LEFT) } else { (LEFT, RIGHT) };
    let q = p.folded();
    let rest = head::neck(&mut shares, p, 1.0);
    let rest = arm(&mut shares, &own, kind, q, rest);
    let rest = legs(&mut shares, &own, &other, q, rest);
    spine(&mut shares, p.y, rest);
    shares
}

/// Takes the arm's part of `whole`; `q` is on the left. Returns what remains.
fn arm(shares: &mut Shares, own: &Limbs, kind: PartKind, q: Vec3, whole: f32) -> f32 {
    let along = (q - SHOULDER).dot(ARM);
    // Far out on the arm, so that a raised one leaves the flank and the collar where they are.
    let raised = smoothstep(-4.0, 11.0, outwards(q));
    let raised = match kind {
        PartKind::Sleeve => raised * mix(0.5, 1.0, smoothstep(-3.5, 6.0, along)),
        _ => raised,
    };
    let bent = bend(ELBOW - 10.5, ELBOW + 10.5, along);
    let turned = smoothstep(WRIST - 5.5, WRIST + 4.5, along);
    let arm = whole * raised;
    shares.add(own.upper_arm, arm * (1.0 - bent));
    shares.add(own.lower_arm, arm * bent * (1.0 - turned));
    shares.add(own.hand, arm * bent * turned);
    // The collar bone carries the top of the shoulder, and in front and behind what hangs on it.
    let rest = whole - arm;
    let shoulder = smoothstep(3.0, 13.5, q.x) * smoothstep(126.0, 139.0, q.y);
    shares.add(own.shoulder, rest * shoulder);
    rest * (1.0 - shoulder)
}

/// How far a point is on the arm's side of the shoulder: above the armpit of an upright plane, and
/// below it of the one midway between arm and trunk.
fn outwards(q: Vec3) -> f32 {
    const ARMPIT: Vec3 = vec3(14.9, 133.5, 0.0);
    const ABOVE: Vec3 = vec3(0.995, 0.1, 0.0);
    const BELOW: Vec3 = vec3(0.91, 0.42, 0.0);
    const BLEND: f32 = 3.0;
    let (above, below) = ((q - ARMPIT).dot(ABOVE), (q - ARMPIT).dot(BELOW));
    let overlap = (BLEND - (above - below).abs()).max(0.0) / BLEND;
    above.min(below) - overlap * overlap * BLEND * 0.25
}

/// Takes the legs' part of `whole`; `q` is on the left. Returns what remains.
fn legs(shares: &mut Shares, own: &Limbs, other: &Limbs, q: Vec3, whole: f32) -> f32 {
    // Legs begin at the crotch in the middle and at the hip bone outside.
    let middle = mix(81.0, HIP.y - 0.5, smoothstep(0.0, 11.0, q.x));
    // The band is so wide that trousers stay inside the shirt on somebody who sits.
    let legs = whole * smoothstep(middle + 12.0, middle - 12.0, q.y);
    // Both have the crotch in common; the thighs below it have not.
    let shared = mix(0.3, 5.0, smoothstep(75.0, 84.0, q.y));
    let side = smoothstep(-shared, shared, q.x);
    let bent = bend(KNEE.y + 14.0, KNEE.y - 14.0, q.y);
    // The hem lies on the shoe.
    let foot = 0.55 * smoothstep(14.0, 3.5, q.y);
    for (limbs, leg) in [(own, legs * side), (other, legs * (1.0 - side))] {
        shares.add(limbs.upper_leg, leg * (1.0 - bent));
        shares.add(limbs.lower_leg, leg * bent * (1.0 - foot));
        shares.add(limbs.foot, leg * bent * foot);
    }
    whole - legs
}

/// From 0 to 1 at nearly even speed: rings around a knee or an elbow turn by equal angles, so that no
/// two of them make a corner of the outline.
fn bend(from: f32, to: f32, x: f32) -> f32 {
    let even = ((x - from) / (to - from)).clamp(0.0, 1.0);
    mix(even, smoothstep(from, to, x), 0.35)
}

fn spine(shares: &mut Shares, y: f32, whole: f32) {
    let mut below = whole;
    let bones = [HumanBone::Hips, HumanBone::Spine, HumanBone::Chest, HumanBone::UpperChest];
    for (k, band) in [(94.0, 109.0), (107.0, 120.0), (119.0, 133.0)].into_iter().enumerate() {
        let above = below * smoothstep(band.0, band.1, y);
        shares.add(bones[k], below - above);
        below = above;
    }
    shares.add(bones[3], below);
}
