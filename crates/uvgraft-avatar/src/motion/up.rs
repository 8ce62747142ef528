//! Detects which axis of a recording points up.
//!
//! AMASS has Z up; what other tools make of it, or estimate from video, often has Y up. People
//! stand most of the time, so the direction from feet to head shows the axis. For people who lie
//! all the time the ground does: along the up axis, their lowest joint is near 0.

use glam::{Quat, Vec3};

use super::Motion;
use crate::body::JointEntry;

/// The axis of a recording that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpAxis {
    /// As in glTF.
    Y,
    /// As in AMASS.
    Z,
}

uvgraft::choices!(UpAxis {
    Y => "y", "Y up";
    Z => "z", "Z up";
});

/// The result of the detection.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Guess {
    pub up: UpAxis,
    /// The motion is unambiguous.
    pub is_certain: bool,
}

/// Number of frames to sample.
const FRAMES: usize = 200;
/// Minimum mean uprightness to decide by it, the cosine between the spine and the axis:
/// 1 for a body that always stands.
const UPRIGHT: f32 = 0.4;
/// Minimum difference in uprightness between the two axes.
const AHEAD: f32 = 0.25;
/// Maximum distance from 0 of the lowest joint of a body on the ground, in metres.
const NEAR_M: f32 = 0.2;

impl UpAxis {
    /// The rotation from the axes of the recording to Y up.
    pub(super) fn upright(self) -> Quat {
        match self {
            Self::Y => Quat::IDENTITY,
            Self::Z => Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2),
        }
    }

    /// Detects the up axis of a motion.
    pub(super) fn guess(motion: &Motion) -> Guess {
        let step = motion.frames().div_ceil(FRAMES).max(1);
        let frames: Vec<usize> = (0..motion.frames()).step_by(step).collect();
        let (mut along, mut lowest) = (Vec3::ZERO, Vec3::splat(f32::MAX));
        for &frame in &frames {
            let joints = joint_positions(motion, frame);
            if let Some(body) = spine(motion.joints(), &joints) {
                along += body / frames.len() as f32;
            }
            lowest = joints.iter().fold(lowest, |low, joint| low.min(*joint));
        }
        let upright = along.z - along.y;
        if along.y.max(along.z) > UPRIGHT && upright.abs() > AHEAD {
            let stands_on = |height: f32| motion.is_still() || height.abs() < NEAR_M;
            // A body lying along an axis looks as if it stood along it. The other axis is up if
            // only there the lowest joint is near the ground.
            let (first, other) =
                if upright > 0.0 { (lowest.z, lowest.y) } else { (lowest.y, lowest.z) };
            let lies = !stands_on(first) && stands_on(other);
            return Guess {
                up: if (upright > 0.0) == lies { UpAxis::Y } else { UpAxis::Z },
                is_certain: true,
            };
        }
        let on_ground = [lowest.y, lowest.z].map(|height| height.abs() < NEAR_M);
        let up = if on_ground == [true, false] { UpAxis::Y } else { UpAxis::Z };
        Guess { up, is_certain: on_ground[0] != on_ground[1] && !motion.is_still() }
    }
}

/// Unit vector from the midpoint of the ankles to the neck.
fn spine(joints: &[JointEntry], places: &[Vec3]) -> Option<Vec3> {
    let place = |name: &str| {
        let joint = joints.iter().position(|entry| entry.0 == name)?;
        Some(places[joint])
    };
    let feet = (place("left_ankle")? + place("right_ankle")?) / 2.0;
    (place("neck")? - feet).try_normalize()
}

/// Joint positions of the family's mean body in a frame, in the axes of the recording.
fn joint_positions(motion: &Motion, frame: usize) -> Vec<Vec3> {
    let mut world: Vec<(Quat, Vec3)> = Vec::with_capacity(MEAN_JOINTS.len());
    let entries = motion.joints().iter().zip(MEAN_JOINTS).zip(motion.turns(frame));
    for ((&(_, parent, _), rest), &turn) in entries {
        let turn = Quat::from_scaled_axis(turn.into());
        let rest = Vec3::from(rest);
        world.push(match parent {
            None => (turn, rest + Vec3::from(motion.translation(frame))),
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

/// Rest positions of the 22 joints that all bodies begin with, accurate to a few centimetres, in
/// metres, Y up: enough to tell heads from feet.
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

    /// A motion of a few frames in which only the root moves, made with Y up and then
    /// rotated by `axes`.
    fn motion(turn: Quat, height: f32, axes: Quat, has_translations: bool) -> Motion {
        const FRAMES: usize = 5;
        let mut arrays = NamedArrays::new();
        let (mut poses, mut places) = (vec![0.0; FRAMES * 66], Vec::new());
        for frame in 0..FRAMES {
            let root = axes * Quat::from_rotation_y(0.3 * frame as f32) * turn;
            poses[frame * 66..][..3].copy_from_slice(&root.to_scaled_axis().to_array());
            // The body rotates about its pelvis.
            let pelvis = Vec3::from(MEAN_JOINTS[0]);
            let place = axes * Vec3::new(3.0 + frame as f32 * 0.1, height, 2.0) - pelvis;
            places.extend(place.to_array());
        }
        arrays.insert("poses", NumericArray::new_f32(vec![FRAMES, 66], poses).unwrap());
        if has_translations {
            arrays.insert("trans", NumericArray::new_f32(vec![FRAMES, 3], places).unwrap());
        }
        arrays.insert("mocap_framerate", NumericArray::new_f64(vec![], vec![30.0]).unwrap());
        Motion::from_arrays(&arrays).unwrap()
    }

    #[test]
    fn standing_and_lying_people_show_which_axis_is_up() {
        for (axes, up) in [(Quat::IDENTITY, UpAxis::Y), (UpAxis::Z.upright().inverse(), UpAxis::Z)]
        {
            for has_translations in [true, false] {
                let guess = UpAxis::guess(&motion(Quat::IDENTITY, 0.9, axes, has_translations));
                assert_eq!(guess, Guess { up, is_certain: true });
            }
            // On the back and on the belly, 15 cm above the ground. On the side, the
            // arms of the T-pose would be below it.
            for turn in [Quat::from_rotation_x(-1.5), Quat::from_rotation_x(1.5)] {
                let guess = UpAxis::guess(&motion(turn, 0.15, axes, true));
                assert_eq!(guess, Guess { up, is_certain: true }, "{turn}");
            }
        }
        // Without translations, a lying body whose head points along neither axis is ambiguous.
        let lying = motion(Quat::from_rotation_x(-1.5), 0.15, Quat::IDENTITY, false);
        assert!(!UpAxis::guess(&lying).is_certain);
    }
}
