//! Detects ground contact: which part of which foot stands, and when.
//!
//! The heel or ball of a foot stands while it is low and slow, with hysteresis in both
//! against flickering. The height of the ground is where most slow feet are, near the
//! lowest of them; it is not 0, because recordings are some centimetres off, feet sink
//! into the ground and people wear shoes.

use glam::Vec3;

use super::soles::{Contact, Soles};
use crate::rig::{Pose, RigError, Skeleton};

/// Heel and ball of both feet in a frame.
pub(super) type Halves = [[Contact; 2]; 2];

/// Limits of height above the ground, in metres, and of speed, in metres a second. Half
/// a foot starts to stand once it is below both limits of `LANDS`, and stops once it
/// exceeds either limit of `LEAVES`.
const LANDS: (f32, f32) = (0.04, 0.3);
const LEAVES: (f32, f32) = (0.07, 0.6);
/// Feet slower than this determine the height of the ground, in metres a second.
const SLOW: f32 = 0.15;
/// Size of the window that must hold most of their heights, and how far above the lowest feet it
/// may begin, in metres.
const WINDOW_M: f32 = 0.03;
const SEARCH_M: f32 = 0.15;
/// Interval over which speeds are measured, in seconds.
const SPEED_S: f32 = 0.07;

/// Which parts stand in a frame: heel and ball of the left and the right foot.
pub(super) type Standing = [[bool; 2]; 2];

/// The heels and balls of both feet in all poses.
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

/// Estimates the height of the ground as the median of the fullest window of slow heights; `None`
/// if no foot is ever slow.
///
/// A plain minimum would follow bad frames, so the search begins at the lowest height
/// that is supported by a twentieth of the samples. It ends `SEARCH_M` above it, so
/// that feet on something higher don't count.
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
    // Outliers: the lowest height must have at least a twentieth of all samples in its window.
    let lowest = (0..heights.len()).find(|&from| count(from) * 20 >= heights.len());
    let lowest = heights[lowest?];
    let near = heights.partition_point(|&height| height < lowest + SEARCH_M);
    // The lowest one among the fullest windows.
    let best = (0..near).rev().max_by_key(|&from| count(from))?;
    Some(heights[best + count(best) / 2])
}

/// Which parts of the feet stand in each frame.
///
/// - `ground`: height of the ground.
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
            // The same backwards in time: take-off is then a landing, and the frames in
            // between become standing too.
            stands = false;
            for frame in (0..frames.len()).rev() {
                stands = is_within(frame, if stands { LEAVES } else { LANDS });
                standing[frame][foot][half] |= stands;
            }
        }
    }
    standing
}

/// Half a foot over time.
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

    /// Speed around a frame, in metres a second: the lower of the speeds before and after it, so
    /// that the first and last frames of a step count as standing.
    fn speed(&self, frame: usize) -> f32 {
        let speed = |other: usize| -> f32 {
            let seconds = (self.times[other] - self.times[frame]).abs();
            let step: Vec3 = self.at(other).point - self.at(frame).point;
            if seconds > 0.0 { step.length() / seconds } else { 0.0 }
        };
        let time = self.times[frame];
        // At least the adjacent frames, even if they are farther away in time.
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

    /// Feet on a ground at 0.05: the left one stands for half a second and then steps,
    /// the right one stands.
    fn steps() -> (Vec<f32>, Vec<Halves>) {
        let times: Vec<f32> = (0..30).map(|frame| frame as f32 / 30.0).collect();
        let frame = |&time: &f32| {
            let step = (time - 0.5).max(0.0);
            let contact = |x, z, height: f32| Contact { height, point: Vec3::new(x, height, z) };
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
        // A single outlier frame has no effect.
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
