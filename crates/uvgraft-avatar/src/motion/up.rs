//! Detects which axis of a recording points up.
//!
//! AMASS has Z up; what other tools make of it, or estimate from video, often has Y up, or Y down
//! in the axes of a camera. People stand most of the time, so the direction from feet to head shows
//! the axis. For people who lie all the time the ground does: along the up axis, their lowest joint
//! is near 0. So it does for people who stand on their hands.

use glam::{Quat, Vec3};
use uvgraft::statistics::median_color;

use super::Motion;
use crate::body::JointEntry;
use crate::rig::posed_joints;

/// The axis of a recording that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum UpAxis {
    /// As in glTF.
    Y,
    /// As in AMASS.
    Z,
    /// Y points down, as in the axes of a camera.
    MinusY,
    /// Z points down.
    MinusZ,
}

uvgraft::choices!(UpAxis {
    Y => "y", "Y up";
    Z => "z", "Z up";
    MinusY => "-y", "Y down, as in the axes of a camera";
    MinusZ => "-z", "Z down";
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
/// How far below 0 the lowest joint of a body that lies on the ground may be, in metres. Less than
/// above, because joints are inside of the body; a body that stands with its pelvis at the origin has
/// its wrists and heels about 5 cm behind it.
const LIES_BELOW_M: f32 = 0.04;

impl UpAxis {
    /// The rotation from the axes of the recording to Y up.
    pub(super) fn upright(self) -> Quat {
        use std::f32::consts::{FRAC_PI_2, PI};
        match self {
            Self::Y => Quat::IDENTITY,
            Self::Z => Quat::from_rotation_x(-FRAC_PI_2),
            Self::MinusY => Quat::from_rotation_x(PI),
            Self::MinusZ => Quat::from_rotation_x(FRAC_PI_2),
        }
    }

    /// Detects the up axis of a motion.
    pub(super) fn guess(motion: &Motion) -> Guess {
        Posture::of(motion).up()
    }
}

/// How a body is oriented in the axes of its recording.
pub(super) struct Posture {
    /// Mean direction from feet to head.
    spine: Vec3,
    /// The lowest joint along each axis, median over frames.
    lowest: Vec3,
    /// Share of frames in which both wrists are lower than the head, by axis.
    on_hands: Vec3,
    is_still: bool,
}

impl Posture {
    pub(super) fn of(motion: &Motion) -> Self {
        let step = motion.frames().div_ceil(FRAMES).max(1);
        let frames: Vec<usize> = (0..motion.frames()).step_by(step).collect();
        let share = 1.0 / frames.len() as f32;
        let (mut along, mut on_hands, mut lowest) = (Vec3::ZERO, Vec3::ZERO, Vec::new());
        for &frame in &frames {
            let joints = joint_positions(motion, frame);
            if let Some(body) = spine(motion.joints(), &joints) {
                along += body * share;
            }
            let place = |name| place(motion.joints(), &joints, name);
            if let (Some(head), Some(left), Some(right)) =
                (place("head"), place("left_wrist"), place("right_wrist"))
            {
                let is_lower = left.max(right).cmplt(head);
                on_hands += Vec3::select(is_lower, Vec3::splat(share), Vec3::ZERO);
            }
            lowest.push(joints.into_iter().fold(Vec3::MAX, Vec3::min));
        }
        let lowest = median_color(lowest.iter().map(Vec3::to_array)).map_or(Vec3::ZERO, Vec3::from);
        Self { spine: along, lowest, on_hands, is_still: motion.is_still() }
    }

    /// The mean cosine between the spine and an axis: -1 for a body upside down.
    pub(super) fn uprightness(&self, up: UpAxis) -> f32 {
        (up.upright() * self.spine).y
    }

    fn up(&self) -> Guess {
        let Self { spine, lowest, is_still, .. } = *self;
        let certain = |up| Guess { up, is_certain: true };
        let upright = spine.z - spine.y;
        if spine.y.max(spine.z) > UPRIGHT && upright.abs() > AHEAD {
            let (first, other) =
                if upright > 0.0 { (UpAxis::Z, UpAxis::Y) } else { (UpAxis::Y, UpAxis::Z) };
            // A body lying along an axis looks as if it stood along it. The other axis is up if
            // only there the lowest joint is near the ground.
            let stands = is_still || along(first, lowest).abs() < NEAR_M;
            return certain(if !stands && self.lies_on(other) { other } else { first });
        }
        let (down, other) =
            if spine.y < spine.z { (UpAxis::Y, UpAxis::Z) } else { (UpAxis::Z, UpAxis::Y) };
        let upside_down = -along(down, spine);
        if upside_down > UPRIGHT && upside_down - along(other, spine).abs() > AHEAD {
            if !is_still && self.lies_on(other) {
                return certain(other);
            }
            // A body that stands on its hands looks as if the axis pointed down.
            let is_on_hands = along(down, self.on_hands) > 0.5;
            if !is_still && is_on_hands && along(down, lowest).abs() < NEAR_M {
                return certain(down);
            }
            // Cameras have Y down; hardly anything has Z down, so that a body without positions rather
            // lies on its back.
            return match down {
                UpAxis::Y => Guess { up: UpAxis::MinusY, is_certain: !(is_still && is_on_hands) },
                _ if is_still => Guess { up: UpAxis::Y, is_certain: false },
                _ => certain(UpAxis::MinusZ),
            };
        }
        let on_ground = [lowest.y, lowest.z].map(|height| height.abs() < NEAR_M);
        let up = if on_ground == [true, false] { UpAxis::Y } else { UpAxis::Z };
        Guess { up, is_certain: on_ground[0] != on_ground[1] && !is_still }
    }

    /// Whether the body is as near to the ground as one that lies on it.
    fn lies_on(&self, up: UpAxis) -> bool {
        self.is_still || (-LIES_BELOW_M..NEAR_M).contains(&along(up, self.lowest))
    }

    /// Whether the body stands on its hands for most of the time.
    pub(super) fn is_on_hands(&self, up: UpAxis) -> bool {
        let is_down = matches!(up, UpAxis::MinusY | UpAxis::MinusZ);
        !is_down && along(up, self.on_hands) > 0.5
    }
}

/// The value of Y or Z.
fn along(up: UpAxis, values: Vec3) -> f32 {
    match up {
        UpAxis::Y | UpAxis::MinusY => values.y,
        UpAxis::Z | UpAxis::MinusZ => values.z,
    }
}

fn place(joints: &[JointEntry], places: &[Vec3], name: &str) -> Option<Vec3> {
    let joint = joints.iter().position(|entry| entry.0 == name)?;
    places.get(joint).copied()
}

/// Unit vector from the midpoint of the ankles to the neck.
fn spine(joints: &[JointEntry], places: &[Vec3]) -> Option<Vec3> {
    let place = |name| place(joints, places, name);
    let feet = (place("left_ankle")? + place("right_ankle")?) / 2.0;
    (place("neck")? - feet).try_normalize()
}

/// Joint positions of the family's mean body in a frame, in the axes of the recording.
fn joint_positions(motion: &Motion, frame: usize) -> Vec<Vec3> {
    let entries = motion.joints().iter().zip(MEAN_JOINTS).zip(motion.turns(frame));
    let joints = entries.map(|((&(_, parent, _), rest), &turn)| {
        (parent, rest.into(), Quat::from_scaled_axis(turn.into()))
    });
    let world = posed_joints(joints, motion.translation(frame).into());
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

    #[test]
    fn people_upside_down_show_that_the_axis_points_down() {
        let guess =
            |turn, height, axes, is_placed| UpAxis::guess(&motion(turn, height, axes, is_placed));
        for up in [UpAxis::MinusY, UpAxis::MinusZ] {
            let axes = up.upright().inverse();
            // Below, at and above the height of a camera, and without positions.
            for height in [-0.6, 0.3, 1.2] {
                let found = guess(Quat::IDENTITY, height, axes, true);
                assert_eq!(found, Guess { up, is_certain: true }, "{height}");
            }
        }
        let found = guess(Quat::IDENTITY, 0.0, UpAxis::MinusY.upright().inverse(), false);
        assert_eq!(found, Guess { up: UpAxis::MinusY, is_certain: true });
        // On the back along Y, on a ground of Z up.
        let axes = UpAxis::Z.upright().inverse();
        let lying = Quat::from_rotation_x(-1.5);
        let mut found = guess(lying, 0.15, axes, true);
        assert_eq!(found, Guess { up: UpAxis::Z, is_certain: true });
        found = guess(lying, 0.15, Quat::from_rotation_z(3.0) * axes, true);
        assert_eq!(found, Guess { up: UpAxis::Z, is_certain: true });
    }

    #[test]
    fn people_on_their_hands_are_not_upside_down() {
        // Arms raised beside the head: hands are 47 cm above the shoulders.
        let raised = |up: UpAxis, height: f32, place: [f32; 3]| {
            let mut poses = vec![0.0; 3 * 66];
            let axes = up.upright().inverse();
            let root = axes * Quat::from_rotation_x(3.1);
            for row in poses.chunks_mut(66) {
                row[..3].copy_from_slice(&root.to_scaled_axis().to_array());
                row[16 * 3 + 2] = 1.5;
                row[17 * 3 + 2] = -1.5;
            }
            let at = axes * Vec3::new(place[0], height, place[2]) - Vec3::from(MEAN_JOINTS[0]);
            let mut arrays = NamedArrays::new();
            arrays.insert("poses", NumericArray::new_f32(vec![3, 66], poses).unwrap());
            let places = [at; 3].map(|at| at.to_array()).concat();
            arrays.insert("trans", NumericArray::new_f32(vec![3, 3], places).unwrap());
            Motion::with_rate(&arrays, Some(30.0)).unwrap()
        };
        // Hands are about 1 m above the pelvis of a body that stands.
        for up in [UpAxis::Y, UpAxis::Z] {
            let motion = raised(up, 0.95, [3.0, 0.0, 2.0]);
            assert_eq!(UpAxis::guess(&motion), Guess { up, is_certain: true });
            assert_eq!(motion.doubts(up), []);
        }
    }

    #[test]
    fn bodies_that_stand_with_the_pelvis_at_the_origin_do_not_lie() {
        // Standing, with positions relative to the start, hardly moving.
        let mut arrays = NamedArrays::new();
        let places = (0..5).flat_map(|frame| [0.002 * frame as f32, 0.0, 0.001]).collect();
        arrays.insert("poses", NumericArray::new_f32(vec![5, 66], vec![0.0; 330]).unwrap());
        arrays.insert("trans", NumericArray::new_f32(vec![5, 3], places).unwrap());
        let motion = Motion::with_rate(&arrays, Some(30.0)).unwrap();
        assert_eq!(UpAxis::guess(&motion), Guess { up: UpAxis::Y, is_certain: true });
    }
}
