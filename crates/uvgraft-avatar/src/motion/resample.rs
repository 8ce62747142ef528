//! Resampling of motions and clips at other times.

use glam::{Quat, Vec3};

use super::{ClipOptions, Motion, MotionError};
use crate::rig::{Clip, Pose};

/// A frame of a motion: a rotation for each of the motion's joints and the body's translation, in
/// the axes of the recording.
pub(super) struct Frame {
    pub(super) time_s: f32,
    pub(super) turns: Vec<Quat>,
    pub(super) translation: Vec3,
}

/// Times closer than this to a frame of the motion, in frames, use that frame unchanged.
const SAME: f64 = 1e-4;

/// The number of frames in the requested part, and their rate in frames a second.
fn count_and_rate(motion: &Motion, options: &ClipOptions<'_>) -> Result<(usize, f64), MotionError> {
    let length_s = motion.seconds();
    let start_s = options.start_s;
    let seconds = options.seconds.unwrap_or(f64::INFINITY);
    let requested = options.fps.unwrap_or(motion.rate());
    if requested.is_nan() || requested <= 0.0 {
        return Err(MotionError::Rate { found: requested, most: motion.rate() });
    }
    let rate = requested.min(motion.rate());
    if !(0.0..=length_s).contains(&start_s) || seconds.is_nan() || seconds < 0.0 {
        return Err(MotionError::Part { start_s, seconds, length_s });
    }
    let available_s = seconds.min(length_s - start_s);
    Ok(((available_s * rate + SAME).floor() as usize + 1, rate))
}

/// The times of the requested part, from 0, in seconds.
pub(super) fn times(motion: &Motion, options: &ClipOptions<'_>) -> Result<Vec<f32>, MotionError> {
    let (count, rate) = count_and_rate(motion, options)?;
    Ok((0..count).map(|index| (index as f64 / rate) as f32).collect())
}

/// Resamples a clip at times within its own range: rotations take the shortest arc between frames.
pub(super) fn at_times(clip: &Clip, times: Vec<f32>) -> Clip {
    // Tolerance of times, which are accumulated in 32-bit floats.
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
        let shift = Vec3::from(a.translation).lerp(b.translation.into(), part);
        let rotations = a.rotations.iter().zip(&b.rotations).map(turn).collect();
        Pose { translation: shift.into(), rotations }
    };
    let poses = times.iter().map(pose).collect();
    Clip { name: clip.name.clone(), times, poses }
}

/// Extracts the requested part of a motion, starting at time 0. Rotations take the shortest arc
/// between frames; the frame rate is at most that of the motion.
pub(super) fn frames(
    motion: &Motion,
    options: &ClipOptions<'_>,
) -> Result<Vec<Frame>, MotionError> {
    let (count, rate) = count_and_rate(motion, options)?;
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
        let mut translation = Vec3::from(motion.translation(before));
        if part > 0.0 && before < last {
            for (turn, next) in turns.iter_mut().zip(motion.turns(before + 1)) {
                *turn = turn.slerp(quat(next), part);
            }
            translation = translation.lerp(motion.translation(before + 1).into(), part);
        }
        Frame { time_s: (index as f64 / rate) as f32, turns, translation }
    };
    Ok((0..count).map(frame).collect())
}

#[cfg(test)]
mod tests {
    use uvgraft_io::arrays::{NamedArrays, NumericArray};

    use super::*;

    /// Frame `k` rotates the root by `k` tenths about x and moves it by `k` along y, at
    /// 120 frames a second.
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

    /// The possibly fractional index of each frame, from both its translation and its rotation.
    fn indices(motion: &Motion, options: &ClipOptions<'_>) -> Vec<f32> {
        let frames = frames(motion, options).unwrap();
        for frame in &frames {
            let angle = frame.turns[0].to_scaled_axis().x;
            assert!(
                (angle - frame.translation.y * 0.1).abs() < 1e-5,
                "{angle} {}",
                frame.translation.y
            );
        }
        frames.iter().map(|frame| frame.translation.y).collect()
    }

    #[test]
    fn frames_are_kept_dropped_or_interpolated() {
        let motion = motion(13);
        let all = ClipOptions { fps: None, ..ClipOptions::default() };
        assert_eq!(indices(&motion, &all), (0..13).map(|k| k as f32).collect::<Vec<_>>());
        let few = ClipOptions { fps: Some(30.0), ..all };
        assert_eq!(indices(&motion, &few), [0.0, 4.0, 8.0, 12.0]);
        let times: Vec<f32> =
            frames(&motion, &few).unwrap().iter().map(|frame| frame.time_s).collect();
        assert!((times[3] - 0.1).abs() < 1e-6 && times[0] == 0.0);
        let mixed = indices(&motion, &ClipOptions { fps: Some(50.0), ..all });
        let wanted = [0.0, 2.4, 4.8, 7.2, 9.6, 12.0];
        assert!(mixed.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-4), "{mixed:?}");
        // No more frames than were recorded.
        assert_eq!(indices(&motion, &ClipOptions { fps: Some(1000.0), ..all }).len(), 13);
        let part = ClipOptions { start_s: 0.05, seconds: Some(0.034), fps: Some(60.0), ..all };
        assert_eq!(indices(&motion, &part), [6.0, 8.0, 10.0]);
    }

    #[test]
    fn clips_are_interpolated_between_frames() {
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
    fn invalid_parts_and_rates_are_refused() {
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
