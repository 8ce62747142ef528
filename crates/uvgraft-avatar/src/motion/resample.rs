//! Frames of a motion at other times.

use glam::{Quat, Vec3};

use super::{ClipOptions, Motion, MotionError};
use crate::rig::{Clip, Pose};

/// A frame of a motion: Z up, a rotation for each of the motion's joints.
pub(super) struct Frame {
    pub(super) time_s: f32,
    pub(super) turns: Vec<Quat>,
    pub(super) place: Vec3,
}

/// Frames closer to one of the motion's than this part of a frame are that frame.
const SAME: f64 = 1e-4;

/// How many frames of a part, and how many a second.
fn part(motion: &Motion, options: &ClipOptions<'_>) -> Result<(usize, f64), MotionError> {
    let length_s = motion.seconds();
    let start_s = options.start_s;
    let seconds = options.seconds.unwrap_or(f64::INFINITY);
    let asked = options.fps.unwrap_or(motion.rate());
    if asked.is_nan() || asked <= 0.0 {
        return Err(MotionError::Rate { found: asked, most: motion.rate() });
    }
    let rate = asked.min(motion.rate());
    if !(0.0..=length_s).contains(&start_s) || seconds.is_nan() || seconds < 0.0 {
        return Err(MotionError::Part { start_s, seconds, length_s });
    }
    let available_s = seconds.min(length_s - start_s);
    Ok(((available_s * rate + SAME).floor() as usize + 1, rate))
}

/// The times of the part that is asked for, from 0, in seconds.
pub(super) fn times(motion: &Motion, options: &ClipOptions<'_>) -> Result<Vec<f32>, MotionError> {
    let (count, rate) = part(motion, options)?;
    Ok((0..count).map(|index| (index as f64 / rate) as f32).collect())
}

/// A clip at other times within its own: rotations along the shortest arc between frames.
pub(super) fn at_times(clip: &Clip, times: Vec<f32>) -> Clip {
    // Times are sums of 32-bit floats.
    const SAME_S: f32 = 1e-4;
    let last = clip.times.len() - 1;
    let pose = |&time: &f32| {
        let after = clip.times.partition_point(|&found| found < time - SAME_S).min(last);
        let step = clip.times[after] - time;
        if after == 0 || step < SAME_S {
            return clip.poses[after].clone();
        }
        let (a, b) = (&clip.poses[after - 1], &clip.poses[after]);
        let part = 1.0 - step / (clip.times[after] - clip.times[after - 1]);
        let turn = |(&a, &b): (&[f32; 4], &[f32; 4])| {
            Quat::from_array(a).slerp(Quat::from_array(b), part).normalize().into()
        };
        let place = Vec3::from(a.translation).lerp(b.translation.into(), part);
        let rotations = a.rotations.iter().zip(&b.rotations).map(turn).collect();
        Pose { translation: place.into(), rotations }
    };
    let poses = times.iter().map(pose).collect();
    Clip { name: clip.name.clone(), times, poses }
}

/// The part of a motion that is asked for, from time 0: rotations along the shortest arc between
/// frames, at most as many frames a second as the motion has.
pub(super) fn frames(
    motion: &Motion,
    options: &ClipOptions<'_>,
) -> Result<Vec<Frame>, MotionError> {
    let (count, rate) = part(motion, options)?;
    let start_s = options.start_s;
    let last = motion.frames() - 1;
    let frame = |index: usize| {
        let at = (start_s + index as f64 / rate) * motion.rate();
        let near = at.round();
        let (before, part) = if (at - near).abs() < SAME {
            (near as usize, 0.0)
        } else {
            (at as usize, (at - at.floor()) as f32)
        };
        let before = before.min(last);
        let quat = |&turn: &[f32; 3]| Quat::from_scaled_axis(turn.into());
        let mut turns: Vec<Quat> = motion.turns(before).iter().map(quat).collect();
        let mut place = Vec3::from(motion.place(before));
        if part > 0.0 && before < last {
            for (turn, next) in turns.iter_mut().zip(motion.turns(before + 1)) {
                *turn = turn.slerp(quat(next), part);
            }
            place = place.lerp(motion.place(before + 1).into(), part);
        }
        Frame { time_s: (index as f64 / rate) as f32, turns, place }
    };
    Ok((0..count).map(frame).collect())
}

#[cfg(test)]
mod tests {
    use uvgraft_io::arrays::{NamedArrays, NumericArray};

    use super::*;

    /// Frame `k` turns the root by `k` tenths about x and moves it by `k` along y, 120 times a second.
    fn motion(frames: usize) -> Motion {
        let mut arrays = NamedArrays::new();
        let table = |columns: usize, step: f32, column: usize| {
            let mut values = vec![0.0; frames * columns];
            for (frame, row) in values.chunks_mut(columns).enumerate() {
                row[column] = frame as f32 * step;
            }
            NumericArray::new_f32(vec![frames, columns], values).unwrap()
        };
        arrays.insert("poses", table(66, 0.1, 0));
        arrays.insert("trans", table(3, 1.0, 1));
        arrays.insert("mocap_framerate", NumericArray::new_f64(vec![], vec![120.0]).unwrap());
        Motion::from_arrays(&arrays).unwrap()
    }

    /// Which frame each is, by its place and by its turn.
    fn numbers(motion: &Motion, options: &ClipOptions<'_>) -> Vec<f32> {
        let frames = frames(motion, options).unwrap();
        for frame in &frames {
            let angle = frame.turns[0].to_scaled_axis().x;
            assert!((angle - frame.place.y * 0.1).abs() < 1e-5, "{angle} {}", frame.place.y);
        }
        frames.iter().map(|frame| frame.place.y).collect()
    }

    #[test]
    fn frames_are_kept_dropped_or_mixed() {
        let motion = motion(13);
        let all = ClipOptions { fps: None, ..ClipOptions::default() };
        assert_eq!(numbers(&motion, &all), (0..13).map(|k| k as f32).collect::<Vec<_>>());
        let few = ClipOptions { fps: Some(30.0), ..all };
        assert_eq!(numbers(&motion, &few), [0.0, 4.0, 8.0, 12.0]);
        let times: Vec<f32> =
            frames(&motion, &few).unwrap().iter().map(|frame| frame.time_s).collect();
        assert!((times[3] - 0.1).abs() < 1e-6 && times[0] == 0.0);
        let mixed = numbers(&motion, &ClipOptions { fps: Some(50.0), ..all });
        let wanted = [0.0, 2.4, 4.8, 7.2, 9.6, 12.0];
        assert!(mixed.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4), "{mixed:?}");
        // No more frames than were recorded.
        assert_eq!(numbers(&motion, &ClipOptions { fps: Some(1000.0), ..all }).len(), 13);
        let part = ClipOptions { start_s: 0.05, seconds: Some(0.034), fps: Some(60.0), ..all };
        assert_eq!(numbers(&motion, &part), [6.0, 8.0, 10.0]);
    }

    #[test]
    fn clips_are_mixed_between_their_frames() {
        let pose = |x: f32| Pose {
            translation: [x, 0.0, 0.0],
            rotations: vec![Quat::from_rotation_x(0.1 * x).into()],
        };
        let times = (0..5).map(|frame| frame as f32 / 120.0).collect();
        let poses: Vec<Pose> = (0..5).map(|frame| pose(frame as f32)).collect();
        let clip = Clip { name: "c".to_owned(), times, poses };
        let few = at_times(&clip, vec![0.0, 2.0 / 120.0, 3.25 / 120.0, 4.0 / 120.0]);
        assert_eq!([&few.poses[0], &few.poses[1]], [&clip.poses[0], &clip.poses[2]]);
        assert_eq!(few.poses[3], clip.poses[4]);
        let mixed = &few.poses[2];
        assert!((mixed.translation[0] - 3.25).abs() < 1e-3, "{mixed:?}");
        let angle = Quat::from_array(mixed.rotations[0]).to_scaled_axis().x;
        assert!((angle - 0.325).abs() < 1e-4, "{angle}");
    }

    #[test]
    fn parts_and_rates_that_are_none_are_refused() {
        let motion = motion(13);
        let base = ClipOptions::default();
        for (start_s, seconds) in [(0.2, None), (-0.1, None), (f64::NAN, None), (0.0, Some(-1.0))] {
            let options = ClipOptions { start_s, seconds, ..base };
            assert!(matches!(frames(&motion, &options), Err(MotionError::Part { .. })));
        }
        for fps in [0.0, -30.0, f64::NAN] {
            let options = ClipOptions { fps: Some(fps), ..base };
            assert!(matches!(frames(&motion, &options), Err(MotionError::Rate { .. })));
        }
    }
}
