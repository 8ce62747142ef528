//! MakeHuman's base stands with lowered, bent arms; SMPL-X rests with straight, horizontal ones.
//!
//! Bones of the arms and fingers are turned to the side by linear blend skinning. The turns are
//! those of the template, so that what they do to vertices and joints is linear, and can be
//! applied to the components of a shape space too.

use glam::{Mat3, Quat, Vec3};

use crate::joints::{self, COUNT, ELBOWS, HANDS, SHOULDERS, WRISTS};

/// Share of the spread of the fingers that is kept: those of SMPL-X's flat hand are nearly
/// parallel.
const SPREAD: f32 = 0.5;

/// Vertices and joints; or offsets of them.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Points {
    pub(crate) vertices: Vec<[f32; 3]>,
    pub(crate) joints: Vec<[f32; 3]>,
}

/// Skinning weights of vertices: joints and weights that sum to 1.
pub(crate) type Weights = Vec<Vec<(usize, f32)>>;

/// The turn of each joint in the world.
pub(crate) struct TPose(Vec<Mat3>);

impl TPose {
    /// - `joints`: of the template.
    /// - `tips`: of the index, middle, little and ring finger of both hands.
    pub(crate) fn new(joints: &[[f32; 3]], tips: &[[Vec3; 4]; 2]) -> Self {
        let mut turns = vec![Quat::IDENTITY; COUNT];
        for (side, tips) in tips.iter().enumerate() {
            let at = |joint: usize| Vec3::from(joints[joint]);
            let [shoulder, elbow, wrist, hand] =
                [SHOULDERS, ELBOWS, WRISTS, HANDS].map(|joint| joint[side]);
            let outward = if side == 0 { Vec3::X } else { Vec3::NEG_X };
            let straight = |turn: Quat, from: Vec3, to: Vec3| {
                Quat::from_rotation_arc((turn * (to - from)).normalize(), outward) * turn
            };
            let upper = straight(Quat::IDENTITY, at(shoulder), at(elbow));
            let lower = straight(upper, at(elbow), at(wrist));
            // Palms face down, where the index finger is in front of the little one. The forearm
            // takes half of the twist.
            let [middle, little] = [hand + 3, hand + 6];
            let flat = straight(lower, at(wrist), at(middle));
            let across = flat * (at(hand) - at(little));
            let twist = |share: f32| Quat::from_rotation_x(share * f32::atan2(across.y, across.z));
            turns[shoulder] = upper;
            turns[elbow] = twist(0.5) * lower;
            turns[wrist] = twist(1.0) * flat;
            let palm = turns[wrist];
            turns[hand..hand + 15].fill(palm);
            for (finger, &tip) in tips.iter().enumerate() {
                let first = hand + 3 * finger;
                let ends = [at(first), at(first + 1), at(first + 2), tip];
                let along = palm * (ends[1] - ends[0]);
                let flat = Vec3::new(along.x, 0.0, SPREAD * along.z).normalize();
                let mut turn = palm;
                for (bone, ends) in ends.windows(2).enumerate() {
                    let now = (turn * (ends[1] - ends[0])).normalize();
                    turn = Quat::from_rotation_arc(now, flat) * turn;
                    turns[first + bone] = turn;
                }
            }
        }
        Self(turns.into_iter().map(|turn| Mat3::from_quat(turn.normalize())).collect())
    }

    /// Applies the turns; linear in `points`.
    pub(crate) fn apply(&self, points: &Points, weights: &Weights) -> Points {
        let at = |joint: usize| Vec3::from(points.joints[joint]);
        let mut moved: Vec<Vec3> = Vec::with_capacity(COUNT);
        for joint in 0..points.joints.len() {
            moved.push(match joints::parent(joint) {
                None => at(joint),
                Some(parent) => moved[parent] + self.0[parent] * (at(joint) - at(parent)),
            });
        }
        let pose = |(place, weights): (&[f32; 3], &Vec<(usize, f32)>)| {
            let place = Vec3::from(*place);
            let parts = weights.iter().map(|&(joint, weight)| {
                weight * (moved[joint] + self.0[joint] * (place - at(joint)))
            });
            parts.sum::<Vec3>().into()
        };
        let vertices = points.vertices.iter().zip(weights).map(pose).collect();
        Points { vertices, joints: moved.into_iter().map(Into::into).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Joints with arms that hang down and forward, and fingers that are bent.
    fn hanging() -> (Vec<[f32; 3]>, [[Vec3; 4]; 2]) {
        let mut places = vec![[0.0; 3]; COUNT];
        let mut tips = [[Vec3::ZERO; 4]; 2];
        for (side, sign) in [1.0, -1.0].into_iter().enumerate() {
            places[SHOULDERS[side]] = [sign * 0.2, 0.5, 0.0];
            places[ELBOWS[side]] = [sign * 0.4, 0.3, 0.0];
            places[WRISTS[side]] = [sign * 0.5, 0.2, 0.2];
            for finger in 0..5 {
                let z = [0.06, 0.02, -0.06, -0.02, 0.1][finger];
                for bone in 0..4 {
                    let along = 0.08 + 0.03 * bone as f32;
                    let (x, y) = (0.5 + 0.7 * along, 0.2 - along - 0.01 * (bone * bone) as f32);
                    let place = [sign * x, y, 0.2 + along * 0.4 + z];
                    if bone < 3 {
                        places[HANDS[side] + 3 * finger + bone] = place;
                    } else if finger < 4 {
                        tips[side][finger] = place.into();
                    }
                }
            }
        }
        (places, tips)
    }

    #[test]
    fn arms_and_fingers_are_straight_and_lengths_kept() {
        let (places, tips) = hanging();
        let pose = TPose::new(&places, &tips);
        let none = Points { vertices: Vec::new(), joints: places.clone() };
        let found = pose.apply(&none, &Vec::new()).joints;
        let at = |joint: usize| Vec3::from(found[joint]);
        for side in 0..2 {
            let outward = if side == 0 { Vec3::X } else { Vec3::NEG_X };
            let [shoulder, elbow, wrist, hand] =
                [SHOULDERS, ELBOWS, WRISTS, HANDS].map(|joint| joint[side]);
            for (from, to) in [(shoulder, elbow), (elbow, wrist), (wrist, hand + 3)] {
                let direction = (at(to) - at(from)).normalize();
                assert!(direction.abs_diff_eq(outward, 1e-4), "{from} {direction}");
                let before = Vec3::from(places[to]).distance(places[from].into());
                assert!((before - at(to).distance(at(from))).abs() < 1e-5);
            }
            assert!((at(hand).y - at(hand + 6).y).abs() < 1e-4, "palm down");
            assert!(at(hand).z > at(hand + 6).z, "index finger in front");
            for bone in [hand, hand + 1, hand + 9] {
                assert!((at(bone + 1) - at(bone)).y.abs() < 1e-4);
            }
        }
    }

    #[test]
    fn offsets_are_posed_like_differences() {
        let (places, tips) = hanging();
        let pose = TPose::new(&places, &tips);
        let weights: Weights =
            (0..COUNT - 1).map(|joint| vec![(joint, 0.25), (joint + 1, 0.75)]).collect();
        let shape = |seed: f32| Points {
            vertices: (0..COUNT - 1).map(|at| [at as f32 * 0.01, seed, 0.02]).collect(),
            joints: places.iter().map(|&[x, y, z]| [x * seed, y, z + seed]).collect(),
        };
        let [one, two] = [shape(1.0), shape(1.3)];
        let minus = |a: &[[f32; 3]], b: &[[f32; 3]]| -> Vec<[f32; 3]> {
            a.iter().zip(b).map(|(a, b)| (Vec3::from(*a) - Vec3::from(*b)).into()).collect()
        };
        let offsets = Points {
            vertices: minus(&two.vertices, &one.vertices),
            joints: minus(&two.joints, &one.joints),
        };
        let [one, two, offsets] = [one, two, offsets].map(|points| pose.apply(&points, &weights));
        for (found, wanted) in offsets.vertices.iter().zip(minus(&two.vertices, &one.vertices)) {
            assert!(Vec3::from(*found).abs_diff_eq(wanted.into(), 1e-5));
        }
    }
}
