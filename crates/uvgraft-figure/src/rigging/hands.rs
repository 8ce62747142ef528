//! How far points of hands and fingers follow which joints.

use glam::Vec3;
use uvgraft::easing::{bell, smoothstep};

use super::Shares;
use super::joints::{LEFT, Limbs, RIGHT};
use crate::arms::{beside_finger, finger_bends, in_arm, on_finger};
use crate::symmetry::Symmetry as _;

/// Half-widths of the bands around a finger's joints, in lengths of the finger.
const BANDS: [f32; 3] = [0.09, 0.09, 0.08];

/// The shares of a point on a finger, 0 for the thumb.
pub(crate) fn finger(number: u8, p: Vec3) -> Shares {
    let own = if p.x < 0.0 { RIGHT } else { LEFT };
    let (t, ..) = on_finger(number, p.folded());
    let number = usize::from(number);
    let mut shares = Shares::default();
    let mut outer = 1.0;
    let mut inner_bone = own.hand;
    for (k, (at, band)) in finger_bends(number).into_iter().zip(BANDS).enumerate() {
        let beyond = outer * smoothstep(at - band, at + band, t);
        shares.add(inner_bone, outer - beyond);
        (outer, inner_bone) = (beyond, own.fingers[number][k]);
    }
    shares.add(inner_bone, outer);
    shares
}

/// Gives fingers their part of the palm's shares: the ball of the thumb follows the thumb, and the
/// knuckles follow what is beyond them.
pub(crate) fn palm(shares: &mut Shares, p: Vec3) {
    let own: Limbs = if p.x < 0.0 { RIGHT } else { LEFT };
    let q = p.folded();
    let place = in_arm(q);
    let (off, t) = beside_finger(0, 0.1, 0.5, q);
    let thumb = 0.85 * smoothstep(3.1, 1.1, off) * smoothstep(0.0, 0.7, t);
    let thumb = thumb * smoothstep(54.0, 58.0, place.x);
    shares.pass(own.hand, own.fingers[0][0], thumb);
    let ends = 0.6 * smoothstep(61.8, 66.2, place.x);
    if ends > 0.0 {
        let near = [1, 2, 3, 4].map(|number| bell(beside_finger(number, 0.1, 0.4, q).0, 1.3));
        let sum: f32 = near.iter().sum::<f32>().max(1e-6);
        let hand = shares.of(own.hand);
        for (number, near) in (1..).zip(near) {
            let share = hand * ends * near / sum;
            shares.add(own.fingers[number][0], share);
            shares.add(own.hand, -share);
        }
    }
}
