//! When which part of which foot stands on the ground.
//!
//! A heel or ball of the foot stands where it is low and slow; two limits each, so that it does not
//! flicker. The ground itself is where most slow feet near the lowest of them are: recordings are some
//! centimetres off, feet sink into it and soles are shod.

use glam::Vec3;

use super::soles::{Contact, Soles};
use crate::rig::{Pose, RigError, Skeleton};

/// Heel and ball of both feet in each frame.
pub(super) type Halves = [[Contact; 2]; 2];

/// A half of a foot comes to stand below this height and speed, and stands until it is above both of
/// the second: in metres above the ground, and metres a second.
const LANDS: (f32, f32) = (0.04, 0.3);
const LEAVES: (f32, f32) = (0.07, 0.6);
/// The height of the ground is told by feet slower than this, in metres a second.
const SLOW: f32 = 0.15;
/// The window in which most of them are, and how far above the lowest feet it may be, in metres.
const WINDOW_M: f32 = 0.03;
const SEARCH_M: f32 = 0.15;
/// Over which time speeds are measured, in seconds.
const SPEED_S: f32 = 0.07;

/// What stands in a frame: heel and ball of the left and the right foot.
pub(super) type Standing = [[bool; 2]; 2];

/// Where heels and balls are in all frames.
pub(super) fn halves(
    skeleton: &Skeleton,
    soles: &Soles,
    poses: &[Pose],
) -> Result<Vec<Halves>, RigError> {
    let frame = |pose: &Pose| {
        let motions = skeleton.motions(pose)?;
        Ok([soles.feet[0].contacts(&motions), soles.feet[1].contacts(&motions)])
    };
    poses.iter().map(frame).collect()
}

/// The height of the ground on which somebody walks; nothing where no foot is ever slow.
pub(super) fn ground(times: &[f32], frames: &[Halves]) -> Option<f32> {
    let mut heights: Vec<f32> = Vec::new();
    for foot in 0..2 {
        for half in 0..2 {
            let track = Track { times, frames, foot, half };
            let slow = (0..frames.len()).filter(|&frame| track.speed(frame) < SLOW);
            heights.extend(slow.map(|frame| track.at(frame).height));
        }
    }
    heights.sort_by(f32::total_cmp);
    let count =
        |from: usize| heights.partition_point(|&height| height < heights[from] + WINDOW_M) - from;
    // Some frames are errors: what is lowest is where a twentieth of all slow feet are.
    let lowest = (0..heights.len()).find(|&from| count(from) * 20 >= heights.len());
    let lowest = heights[lowest?];
    let near = heights.partition_point(|&height| height < lowest + SEARCH_M);
    // The first of the fullest windows.
    let best = (0..near).rev().max_by_key(|&from| count(from))?;
    Some(heights[best + count(best) / 2])
}

/// Which halves stand in each frame.
///
/// - `ground`: its height.
pub(super) fn standing(times: &[f32], frames: &[Halves], ground: f32) -> Vec<Standing> {
    let mut standing = vec![[[false; 2]; 2]; frames.len()];
    for foot in 0..2 {
        for half in 0..2 {
            let track = Track { times, frames, foot, half };
            let is_within = |frame: usize, (height, speed): (f32, f32)| {
                track.at(frame).height - ground < height && track.speed(frame) < speed
            };
            let mut stands = false;
            for frame in 0..frames.len() {
                stands = is_within(frame, if stands { LEAVES } else { LANDS });
                standing[frame][foot][half] = stands;
            }
            // The same backwards: who leaves lands in reversed time, and frames in between belong to it.
            stands = false;
            for frame in (0..frames.len()).rev() {
                stands = is_within(frame, if stands { LEAVES } else { LANDS });
                standing[frame][foot][half] |= stands;
            }
        }
    }
    standing
}

/// A half of a foot over time.
struct Track<'a> {
    times: &'a [f32],
    frames: &'a [Halves],
    foot: usize,
    half: usize,
}

impl Track<'_> {
    fn at(&self, frame: usize) -> Contact {
        self.frames[frame][self.foot][self.half]
    }

    /// How fast it moves around a frame, in metres a second: the slower of before and after, so that
    /// the first and last frame of a step count as standing.
    fn speed(&self, frame: usize) -> f32 {
        let speed = |other: usize| -> f32 {
            let seconds = (self.times[other] - self.times[frame]).abs();
            let way: Vec3 = self.at(other).place - self.at(frame).place;
            if seconds > 0.0 { way.length() / seconds } else { 0.0 }
        };
        let time = self.times[frame];
        // The frames beside it at least, where they are farther apart.
        let before = self.times.partition_point(|&found| found < time - SPEED_S);
        let before = before.min(frame.saturating_sub(1));
        let after = self.times.partition_point(|&found| found <= time + SPEED_S);
        let after = after.saturating_sub(1).max(frame + 1).min(self.times.len() - 1);
        match (before < frame, after > frame) {
            (true, true) => speed(before).min(speed(after)),
            (true, false) => speed(before),
            (false, true) => speed(after),
            (false, false) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feet on a ground at 0.05: the left one stands for half a second and steps, the right one stands.
    fn steps() -> (Vec<f32>, Vec<Halves>) {
        let times: Vec<f32> = (0..30).map(|frame| frame as f32 / 30.0).collect();
        let frame = |&time: &f32| {
            let step = (time - 0.5).max(0.0);
            let contact = |x, z, height: f32| Contact { height, place: Vec3::new(x, height, z) };
            let left = |z: f32| contact(0.1, z + 3.0 * step, 0.05 + step.min(1.0 - step) * 0.6);
            let right = |z: f32| contact(-0.1, z, 0.052);
            [[left(-0.1), left(0.1)], [right(-0.1), right(0.1)]]
        };
        let frames = times.iter().map(frame).collect();
        (times, frames)
    }

    #[test]
    fn the_ground_is_where_slow_feet_are() {
        let (times, mut frames) = steps();
        let found = ground(&times, &frames).unwrap();
        assert!((found - 0.05).abs() < 0.005, "{found}");
        // One frame that is far off changes nothing.
        for half in &mut frames[7][0] {
            half.height = -1.0;
        }
        let found = ground(&times, &frames).unwrap();
        assert!((found - 0.05).abs() < 0.005, "{found}");
    }

    #[test]
    fn feet_stand_while_they_are_low_and_slow() {
        let (times, frames) = steps();
        let standing = standing(&times, &frames, 0.05);
        assert!(standing.iter().all(|feet| feet[1] == [true; 2]));
        assert!(standing[..15].iter().all(|feet| feet[0] == [true; 2]));
        assert!(standing[18..].iter().all(|feet| feet[0] == [false; 2]));
    }
}
