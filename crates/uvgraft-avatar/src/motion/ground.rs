//! Footskate cleanup: where the feet of a recording stand, the feet of the body that plays it stand
//! too, whatever the lengths of its legs and the shape of its soles.
//!
//! Contacts are detected on a reference: the performer if that person's shape is known, or else the
//! body itself. The body is shifted vertically by one offset for the whole clip, the median of what
//! its standing feet need; then inverse kinematics brings each standing foot to the ground and
//! holds it where it came down. Between steps a foot's correction fades from one to the next, and
//! where a leg is too short the hips sink, smoothly.
//!
//! Based on: Kovar et al., "Footskate Cleanup for Motion Capture Editing", 2002.

use glam::Vec3;
use uvgraft::statistics::median;

use super::contact::{self, Halves, Standing};
use super::legs::{Leg, LegPose, world};
use super::soles::Soles;
use crate::rig::{Clip, RigError, Skeleton};

/// The body whose feet determine the contacts and the height of the ground.
pub(super) struct Reference<'a> {
    pub skeleton: &'a Skeleton,
    pub soles: &'a Soles,
    /// The same frames as in the clip to be corrected.
    pub clip: &'a Clip,
}

/// The corrections made to a clip.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Grounding {
    /// Height of the ground in the recording, in metres; `None` if no foot ever stands.
    pub ground_m: Option<f32>,
    /// Number of frames in which a foot stands.
    pub planted: usize,
    /// Largest displacement of a foot, in metres.
    pub max_shift_m: f32,
    /// Largest distance by which the hips sank so that a leg could reach, in metres.
    pub sunk_m: f32,
}

/// Time over which a foot's correction fades out where no other step is near, in seconds.
const FADE_S: f32 = 0.35;
/// Half the smoothing window of the hips' height, in seconds.
const SINK_S: f32 = 0.15;
/// Corrections below this are skipped, in metres.
const NONE_M: f32 = 1e-5;
/// Upper limit of the sinking, as a fraction of the leg's length: anything beyond is
/// not a matter of reach.
const MAX_SINK: f32 = 0.25;

/// A clip that is being corrected.
struct Cleanup<'a> {
    skeleton: &'a Skeleton,
    soles: &'a Soles,
    clip: &'a mut Clip,
    standing: Vec<Standing>,
}

/// Corrects a clip so that its feet stand on y = 0.
///
/// - `in_place`: the recording lacks the body's position, so its height follows from the lower foot
///   in each frame, and feet may slide.
pub(super) fn put_on_ground(
    clip: &mut Clip,
    skeleton: &Skeleton,
    soles: &Soles,
    reference: Option<&Reference<'_>>,
    in_place: bool,
) -> Result<Grounding, RigError> {
    let own = contact::halves(skeleton, soles, &clip.poses)?;
    if in_place {
        let low: Vec<f32> = own.iter().map(lowest).collect();
        let even = smoothed(&clip.times, &low, SINK_S, Smooth::Mean);
        for (pose, low) in clip.poses.iter_mut().zip(even) {
            pose.translation[1] -= low;
        }
        let standing = vec![[[false; 2]; 2]; clip.poses.len()];
        let mut cleanup = Cleanup { skeleton, soles, clip, standing };
        let mut grounding = Grounding::default();
        cleanup.correct(&mut grounding)?;
        return Ok(grounding);
    }
    let halves = match reference {
        Some(other) => contact::halves(other.skeleton, other.soles, &other.clip.poses)?,
        None => own.clone(),
    };
    let found = contact::ground(&clip.times, &halves);
    let (standing, lift) = match found {
        Some(ground) => {
            let standing = contact::standing(&clip.times, &halves, ground);
            (standing.clone(), lift(&own, &standing))
        }
        None => (vec![[[false; 2]; 2]; own.len()], None),
    };
    // If no foot ever stands, the lowest point of all frames goes to the ground.
    let lift = lift.unwrap_or_else(|| -own.iter().map(lowest).fold(f32::MAX, f32::min));
    for pose in &mut clip.poses {
        pose.translation[1] += lift;
    }
    let is_planted = |feet: &&Standing| feet.iter().flatten().any(|&half| half);
    let planted = standing.iter().filter(is_planted).count();
    let mut cleanup = Cleanup { skeleton, soles, clip, standing };
    let mut grounding = Grounding { ground_m: found, planted, ..Grounding::default() };
    cleanup.correct(&mut grounding)?;
    Ok(grounding)
}

fn lowest(halves: &Halves) -> f32 {
    halves.iter().flatten().map(|half| half.height).fold(f32::MAX, f32::min)
}

/// The vertical shift that brings the median standing foot to the ground; `None` if none stands.
fn lift(own: &[Halves], standing: &[Standing]) -> Option<f32> {
    let mut heights = Vec::new();
    for (halves, stands) in own.iter().zip(standing) {
        for (foot, stands) in halves.iter().zip(stands) {
            if stands.contains(&true) {
                heights.push(foot[0].height.min(foot[1].height));
            }
        }
    }
    median(heights).map(|height| -height)
}

impl Cleanup<'_> {
    fn correct(&mut self, grounding: &mut Grounding) -> Result<(), RigError> {
        let frames = contact::halves(self.skeleton, self.soles, &self.clip.poses)?;
        let mut moves = [self.moves(&frames, 0), self.moves(&frames, 1)];
        let legs = Leg::both(self.skeleton);
        let Some(legs) = legs else {
            // Without leg chains there is no inverse kinematics; at least nothing sinks
            // into the ground.
            for (frame, pose) in self.clip.poses.iter_mut().enumerate() {
                pose.translation[1] += moves.iter().map(|moves| moves[frame].y).fold(0.0, f32::max);
            }
            return Ok(());
        };
        self.keep_above(&frames, &mut moves);
        let sunk = self.sink(&legs, &moves, grounding);
        for frame in 0..self.clip.poses.len() {
            for (leg, moves) in legs.iter().zip(&moves) {
                let pose = &mut self.clip.poses[frame];
                // The foot keeps its position while the hips sink.
                let by = moves[frame] + Vec3::new(0.0, sunk[frame], 0.0);
                if by.length() < NONE_M {
                    continue;
                }
                grounding.max_shift_m = grounding.max_shift_m.max(moves[frame].length());
                let placed = leg.placed(self.skeleton, &world(self.skeleton, pose));
                leg.reach(&placed, placed.ankle + by, pose);
            }
        }
        Ok(())
    }

    /// The displacement that a foot needs in each frame: a standing foot is put on the ground and
    /// held at the anchors where its heel and ball came down.
    ///
    /// A part that comes down while the other one is held gets its anchor at its corrected
    /// position, so a foot rolls from heel to ball without a jump.
    fn moves(&self, frames: &[Halves], foot: usize) -> Vec<Vec3> {
        let mut moves = vec![None; frames.len()];
        let mut anchors: [Option<Vec3>; 2] = [None; 2];
        for (frame, halves) in frames.iter().enumerate() {
            let (halves, stands) = (&halves[foot], self.standing[frame][foot]);
            let held = |anchors: &[Option<Vec3>; 2]| {
                let off = anchors.iter().zip(halves).zip(stands).filter(|&(_, stands)| stands);
                let off: Vec<Vec3> =
                    off.filter_map(|((anchor, half), _)| Some((*anchor)? - half.point)).collect();
                off.iter().sum::<Vec3>() / off.len().max(1) as f32
            };
            // Anchors of parts that still stand are kept; parts that come down now are
            // anchored after correction.
            for (anchor, stands) in anchors.iter_mut().zip(stands) {
                if !stands {
                    *anchor = None;
                }
            }
            let by = held(&anchors);
            for ((anchor, half), stands) in anchors.iter_mut().zip(halves).zip(stands) {
                if stands && anchor.is_none() {
                    *anchor = Some(half.point + by);
                }
            }
            if stands.contains(&true) {
                let by = held(&anchors);
                let height = halves[0].height.min(halves[1].height);
                moves[frame] = Some(Vec3::new(by.x, -height, by.z));
            }
        }
        faded(&self.clip.times, &moves)
    }

    /// Raises feet that would sink into the ground.
    fn keep_above(&self, frames: &[Halves], moves: &mut [Vec<Vec3>; 2]) {
        for (foot, moves) in moves.iter_mut().enumerate() {
            for (by, halves) in moves.iter_mut().zip(frames) {
                let height = halves[foot][0].height.min(halves[foot][1].height);
                by.y = by.y.max(-height);
            }
        }
    }

    /// Lowers the hips where a standing foot is out of reach, and returns by how much
    /// in each frame.
    fn sink(
        &mut self,
        legs: &[Leg; 2],
        moves: &[Vec<Vec3>; 2],
        grounding: &mut Grounding,
    ) -> Vec<f32> {
        let mut needed = vec![0.0_f32; self.clip.poses.len()];
        for (frame, pose) in self.clip.poses.iter().enumerate() {
            let joints = world(self.skeleton, pose);
            for ((leg, moves), stands) in legs.iter().zip(moves).zip(self.standing[frame]) {
                if stands.contains(&true) {
                    let placed = leg.placed(self.skeleton, &joints);
                    let length = leg.length_m(self.skeleton);
                    needed[frame] = needed[frame].max(too_high(&placed, moves[frame], length));
                }
            }
        }
        let even = smoothed(&self.clip.times, &needed, SINK_S, Smooth::Above);
        for (pose, &sunk) in self.clip.poses.iter_mut().zip(&even) {
            pose.translation[1] -= sunk;
            grounding.sunk_m = grounding.sunk_m.max(sunk);
        }
        even
    }
}

/// The height by which a hip is too high for its leg to reach the foot's target: with the
/// horizontal distance h to the target and the reach r, the hip may be √(r² - h²) above it.
fn too_high(placed: &LegPose, by: Vec3, length_m: f32) -> f32 {
    let to = placed.ankle + by;
    // No leg has to be straighter than in the recording.
    let reach = (length_m * 0.999).max(placed.ankle.distance(placed.hip).min(length_m));
    let aside = Vec3::new(to.x - placed.hip.x, 0.0, to.z - placed.hip.z).length();
    let most = to.y + (reach * reach - aside * aside).max(0.0).sqrt();
    (placed.hip.y - most).clamp(0.0, MAX_SINK * length_m)
}

/// Fills the gaps between the given corrections: short gaps are interpolated with smoothstep, in
/// longer ones both neighbours fade to zero.
fn faded(times: &[f32], given: &[Option<Vec3>]) -> Vec<Vec3> {
    let smooth = |part: f32| {
        let part = part.clamp(0.0, 1.0);
        part * part * (3.0 - 2.0 * part)
    };
    let mut before: Vec<Option<usize>> = Vec::with_capacity(given.len());
    for frame in 0..given.len() {
        let last = before.last().copied().flatten();
        before.push(if given[frame].is_some() { Some(frame) } else { last });
    }
    let mut after = None;
    let mut moves = vec![Vec3::ZERO; given.len()];
    for frame in (0..given.len()).rev() {
        if given[frame].is_some() {
            after = Some(frame);
        }
        let end = |at: Option<usize>| at.and_then(|at| Some((times[at], given[at]?)));
        moves[frame] = match (end(before[frame]), end(after)) {
            (Some((from, a)), Some((to, b))) if to - from < 2.0 * FADE_S => {
                let part = if to > from { (times[frame] - from) / (to - from) } else { 0.0 };
                a.lerp(b, smooth(part))
            }
            (a, b) => {
                let near = |end: Option<(f32, Vec3)>| {
                    end.map_or(Vec3::ZERO, |(time, by)| {
                        by * (1.0 - smooth((times[frame] - time).abs() / FADE_S))
                    })
                };
                near(a) + near(b)
            }
        };
    }
    moves
}

/// How a curve is smoothed.
#[derive(Clone, Copy, PartialEq)]
enum Smooth {
    /// Moving average.
    Mean,
    /// Smooth upper bound: no value exceeds the result.
    Above,
}

/// Smooths a curve.
///
/// - `seconds`: half the width of the window.
fn smoothed(times: &[f32], values: &[f32], seconds: f32, smooth: Smooth) -> Vec<f32> {
    let window = |frame: usize| {
        let from = times.partition_point(|&time| time < times[frame] - seconds);
        let to = times.partition_point(|&time| time <= times[frame] + seconds);
        from..to
    };
    let most = |frame: usize| values[window(frame)].iter().copied().fold(f32::MIN, f32::max);
    let high: Vec<f32> = match smooth {
        Smooth::Mean => values.to_vec(),
        Smooth::Above => (0..values.len()).map(most).collect(),
    };
    // The mean of moving maxima over the same window is at least as high as the value itself.
    let mean = |frame: usize| {
        let window = window(frame);
        high[window.clone()].iter().sum::<f32>() / window.len() as f32
    };
    (0..values.len()).map(mean).collect()
}
