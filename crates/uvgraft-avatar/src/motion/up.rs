//! Which axis of a recording points up.
//!
//! AMASS has Z up; what other tools make of it, and what is estimated from video, often Y. People mostly
//! stand, so the way from feet to head tells, and where they lie all the time, what they lie on does:
//! along the axis that points up their lowest joint is near 0.

use glam::{Quat, Vec3};

use super::Motion;
use crate::body::JointEntry;

/// The axis of a recording that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Up {
    /// As in glTF.
    Y,
    /// As in AMASS.
    Z,
}

/// What was found out about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Guess {
    pub up: Up,
    /// The motion leaves no doubt.
    pub is_certain: bool,
}

/// As many frames of a motion are looked at.
const FRAMES: usize = 200;
/// Bodies that are upright on average by less are not by which to tell: 1 is always.
const UPRIGHT: f32 = 0.4;
/// How far one axis must be ahead of the other.
const AHEAD: f32 = 0.25;
/// As far from 0 a lowest joint is on the ground, in metres.
const NEAR_M: f32 = 0.2;

impl Up {
    /// What turns such a recording upright.
    pub(super) fn upright(self) -> Quat {
        match self {
            Self::Y => Quat::IDENTITY,
            Self::Z => Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
        }
    }

    /// From the motion: the axis along which bodies stand.
    pub(super) fn guess(motion: &Motion) -> Guess {
        let step = motion.frames().div_ceil(FRAMES).max(1);
        let frames: Vec<usize> = (0..motion.frames()).step_by(step).collect();
        let (mut along, mut lowest) = (Vec3::ZERO, Vec3::splat(f32::MAX));
        for &frame in &frames {
            let joints = places(motion, frame);
            if let Some(body) = spine(motion.joints(), &joints) {
                along += body / frames.len() as f32;
            }
            lowest = joints.iter().fold(lowest, |low, joint| low.min(*joint));
        }
        let upright = along.z - along.y;
        if along.y.max(along.z) > UPRIGHT && upright.abs() > AHEAD {
            let stands_on = |height: f32| motion.is_still() || height.abs() < NEAR_M;
            // A body that lies along one axis looks as if it stood along it. What it lies on is low.
            let (first, other) =
                if upright > 0.0 { (lowest.z, lowest.y) } else { (lowest.y, lowest.z) };
            let lies = !stands_on(first) && stands_on(other);
            return Guess {
                up: if (upright > 0.0) == lies { Up::Y } else { Up::Z },
                is_certain: true,
            };
        }
        let on_ground = [lowest.y, lowest.z].map(|height| height.abs() < NEAR_M);
        let up = if on_ground == [true, false] { Up::Y } else { Up::Z };
        Guess { up, is_certain: on_ground[0] != on_ground[1] && !motion.is_still() }
    }
}

/// From the middle of the feet to the neck, of length 1.
fn spine(joints: &[JointEntry], places: &[Vec3]) -> Option<Vec3> {
    let place = |name: &str| {
        let joint = joints.iter().position(|entry| entry.0 == name)?;
        Some(places[joint])
    };
    let feet = (place("left_ankle")? + place("right_ankle")?) / 2.0;
    (place("neck")? - feet).try_normalize()
}

/// Where joints of the family's mean body are in a frame, in the recording's own axes.
fn places(motion: &Motion, frame: usize) -> Vec<Vec3> {
    let mut world: Vec<(Quat, Vec3)> = Vec::with_capacity(MEAN_JOINTS.len());
    let entries = motion.joints().iter().zip(MEAN_JOINTS).zip(motion.turns(frame));
    for ((&(_, parent, _), rest), &turn) in entries {
        let turn = Quat::from_scaled_axis(turn.into());
        let rest = Vec3::from(rest);
        world.push(match parent {
            None => (turn, rest + Vec3::from(motion.place(frame))),
            Some(parent) => {
                let (turned, place) = world[parent];
                (
                    (turned * turn).normalize(),
                    place + turned * (rest - Vec3::from(MEAN_JOINTS[parent])),
                )
            }
        });
    }
    world.into_iter().map(|(_, place)| place).collect()
}

/// Where the 22 joints are that all bodies begin with, to some centimetres, in metres, Y up: enough to
/// tell heads from feet.
const MEAN_JOINTS: [[f32; 3]; 22] = [
    [0.0, -0.23, 0.03],
    [0.07, -0.32, 0.02],
    [-0.07, -0.32, 0.02],
    [0.0, -0.11, 0.0],
    [0.1, -0.7, 0.01],
    [-0.1, -0.7, 0.01],
    [0.0, 0.03, 0.01],
    [0.09, -1.1, -0.03],
    [-0.09, -1.1, -0.03],
    [0.0, 0.08, 0.02],
    [0.12, -1.16, 0.09],
    [-0.12, -1.16, 0.09],
    [0.0, 0.29, -0.01],
    [0.08, 0.2, -0.01],
    [-0.08, 0.2, -0.01],
    [0.0, 0.37, 0.03],
    [0.18, 0.23, -0.02],
    [-0.18, 0.23, -0.02],
    [0.43, 0.22, -0.04],
    [-0.43, 0.22, -0.04],
    [0.69, 0.22, -0.05],
    [-0.69, 0.22, -0.05],
];

#[cfg(test)]
mod tests {
    use uvgraft_io::arrays::{NamedArrays, NumericArray};

    use super::*;

    /// A motion of a few frames in which the root alone is turned and moved, with Y up, then turned.
    fn motion(turn: Quat, height: f32, axes: Quat, has_places: bool) -> Motion {
        const FRAMES: usize = 5;
        let mut arrays = NamedArrays::new();
        let (mut poses, mut places) = (vec![0.0; FRAMES * 66], Vec::new());
        for frame in 0..FRAMES {
            let root = axes * Quat::from_rotation_y(0.3 * frame as f32) * turn;
            poses[frame * 66..][..3].copy_from_slice(&root.to_scaled_axis().to_array());
            // The body turns about its pelvis.
            let pelvis = Vec3::from(MEAN_JOINTS[0]);
            let place = axes * Vec3::new(3.0 + frame as f32 * 0.1, height, 2.0) - pelvis;
            places.extend(place.to_array());
        }
        arrays.insert("poses", NumericArray::new_f32(vec![FRAMES, 66], poses).unwrap());
        if has_places {
            arrays.insert("trans", NumericArray::new_f32(vec![FRAMES, 3], places).unwrap());
        }
        arrays.insert("mocap_framerate", NumericArray::new_f64(vec![], vec![30.0]).unwrap());
        Motion::from_arrays(&arrays).unwrap()
    }

    #[test]
    fn standing_and_lying_people_tell_which_axis_is_up() {
        for (axes, up) in [(Quat::IDENTITY, Up::Y), (Up::Z.upright().inverse(), Up::Z)] {
            for has_places in [true, false] {
                let guess = Up::guess(&motion(Quat::IDENTITY, 0.9, axes, has_places));
                assert_eq!(guess, Guess { up, is_certain: true });
            }
            // On the back and on the belly, 15 cm above the ground. On the side, arms in T-pose would be below it.
            for turn in [Quat::from_rotation_x(-1.5), Quat::from_rotation_x(1.5)] {
                let guess = Up::guess(&motion(turn, 0.15, axes, true));
                assert_eq!(guess, Guess { up, is_certain: true }, "{turn}");
            }
        }
        // Without places nobody can tell how somebody lies whose head is not up along either axis.
        let lying = motion(Quat::from_rotation_x(-1.5), 0.15, Quat::IDENTITY, false);
        assert!(!Up::guess(&lying).is_certain);
    }
}
