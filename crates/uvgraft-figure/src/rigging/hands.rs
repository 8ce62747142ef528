//! Skin weights of hands and fingers.

use glam::Vec3;
use uvgraft::easing::{bell, smoothstep};

use super::Weights;
use super::joints::{LEFT, Limbs, RIGHT};
use crate::arms::{axis_distance, finger_bends, in_arm, on_finger};
use crate::symmetry::Symmetry as _;

/// Half-widths of the blend bands around a finger's joints, in finger lengths.
const BANDS: [f32; 3] = [0.09, 0.09, 0.08];

/// The weights of a point on a finger; finger 0 is the thumb.
pub(crate) fn finger(number: u8, p: Vec3) -> Weights {
    let own = if p.x < 0.0 { RIGHT } else { LEFT };
    let (t, ..) = on_finger(number, p.folded());
    let number = usize::from(number);
    let mut weights = Weights::default();
    let mut outer = 1.0;
    let mut inner_bone = own.hand;
    for (k, (at, band)) in finger_bends(number).into_iter().zip(BANDS).enumerate() {
        let beyond = outer * smoothstep(at - band, at + band, t);
        weights.add(inner_bone, outer - beyond);
        (outer, inner_bone) = (beyond, own.fingers[number][k]);
    }
    weights.add(inner_bone, outer);
    weights
}

/// Passes part of the palm's weights to the fingers: the ball of the thumb follows the thumb, and
/// the knuckles follow the fingers beyond them.
pub(crate) fn palm(weights: &mut Weights, p: Vec3) {
    let own: Limbs = if p.x < 0.0 { RIGHT } else { LEFT };
    let q = p.folded();
    let local = in_arm(q);
    let (off, t) = axis_distance(0, 0.1, 0.5, q);
    let thumb = 0.85 * smoothstep(3.1, 1.1, off) * smoothstep(0.0, 0.7, t);
    let thumb = thumb * smoothstep(54.0, 58.0, local.x);
    weights.pass(own.hand, own.fingers[0][0], thumb);
    let ends = 0.6 * smoothstep(61.8, 66.2, local.x);
    if ends > 0.0 {
        let near = [1, 2, 3, 4].map(|number| bell(axis_distance(number, 0.1, 0.4, q).0, 1.3));
        let sum: f32 = near.iter().sum::<f32>().max(1e-6);
        let hand = weights.of(own.hand);
        for (number, near) in (1..).zip(near) {
            let weight = hand * ends * near / sum;
            weights.add(own.fingers[number][0], weight);
            weights.add(own.hand, -weight);
        }
    }
}
