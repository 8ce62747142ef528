//! Clips as animations: a rotation channel for each joint that rotates, and a translation
//! channel for the root if it moves.

use glam::{Quat, Vec3};
use uvgraft_avatar::rig::{Clip, Pose, Skeleton};

use super::buffer::{Buffer, Track};
use super::json::{Animation, AnimationSampler, Channel, ChannelTarget};

/// Tolerance within which a joint's values are constant: rounding errors of rotations are about
/// 1e-7.
const STILL: f32 = 1e-6;

/// Appends a clip as an animation.
///
/// Joints that stay at their nodes' transform get no channel. Joints that are constant but
/// different from it get two keys, at the ends of the clip; all others get a key at every frame.
/// All tracks share one buffer view, and the two time tracks (every frame, both ends) are
/// written only if a channel uses them.
///
/// - `stand`: the pose that the nodes are in.
pub(super) fn write(
    clip: &Clip,
    skeleton: &Skeleton,
    stand: &Pose,
    buffer: &mut Buffer,
) -> Animation {
    let ends = match clip.times[..] {
        [first, .., last] => vec![first, last],
        _ => clip.times.clone(),
    };
    let held_frames = if clip.times.len() > 1 { vec![0, clip.times.len() - 1] } else { vec![0] };
    let times = |values| Track { values, components: 1, bounds: true };
    let mut tracks = vec![times(clip.times.clone()), times(ends)];
    let mut channels = Vec::new();
    let mut add = |node, path, values: Vec<Vec<f32>>, is_held: bool| {
        let components = values[0].len();
        let values = if is_held {
            held_frames.iter().flat_map(|&frame| &values[frame]).copied().collect()
        } else {
            values.into_iter().flatten().collect()
        };
        channels.push(TrackChannel { node, path, is_held, track: tracks.len() });
        tracks.push(Track { values, components, bounds: false });
    };
    let root = Vec3::from(skeleton.joints()[0].position);
    let rest = root + Vec3::from(stand.translation);
    let positions: Vec<Vec3> =
        clip.poses.iter().map(|pose| root + Vec3::from(pose.translation)).collect();
    let is_held = positions.iter().all(|position| position.abs_diff_eq(positions[0], STILL));
    let is_rest = is_held && positions[0].abs_diff_eq(rest, STILL);
    let rotations: Vec<Vec<Quat>> =
        (0..skeleton.joints().len()).map(|joint| rotations(clip, joint)).collect();
    let held = |turns: &[Quat]| turns.iter().all(|turn| turn.abs_diff_eq(turns[0], STILL));
    let rests = |(joint, turns): (usize, &Vec<Quat>)| {
        let stands = Quat::from_array(stand.rotations[joint]);
        let near = |turn: Quat| turns[0].abs_diff_eq(turn, STILL);
        held(turns) && (near(stands) || near(-stands))
    };
    // An animation must have at least one channel, so a clip that never leaves the rest
    // pose gets the root's translation.
    if !is_rest || rotations.iter().enumerate().all(rests) {
        let values = positions.iter().map(|position| position.to_array().to_vec());
        add(0, "translation", values.collect(), is_held);
    }
    for (joint, turns) in rotations.iter().enumerate().filter(|&entry| !rests(entry)) {
        let values = turns.iter().map(|turn| turn.to_array().to_vec());
        add(joint, "rotation", values.collect(), held(turns));
    }
    animation(clip.name.clone(), tracks, channels, buffer)
}

/// What a channel moves, and with which track.
struct TrackChannel {
    node: usize,
    path: &'static str,
    /// Whether it has the time track of both ends, or of every frame.
    is_held: bool,
    track: usize,
}

/// Stores the tracks, of which the first two are the times of every frame and of both ends, without
/// times that no channel uses.
fn animation(
    name: String,
    tracks: Vec<Track>,
    channels: Vec<TrackChannel>,
    buffer: &mut Buffer,
) -> Animation {
    let used = |held| channels.iter().any(|channel| channel.is_held == held);
    let [moving, holding] = [used(false), used(true)];
    let mut kept: Vec<Track> = Vec::with_capacity(tracks.len());
    let mut number = vec![0; tracks.len()];
    for (index, track) in tracks.into_iter().enumerate() {
        if (index == 0 && !moving) || (index == 1 && !holding) {
            continue;
        }
        number[index] = kept.len();
        kept.push(track);
    }
    let accessors = buffer.tracks(&kept);
    let mut animation = Animation { name, channels: Vec::new(), samplers: Vec::new() };
    for TrackChannel { node, path, is_held, track } in channels {
        let sampler = animation.samplers.len();
        animation.channels.push(Channel { sampler, target: ChannelTarget { node, path } });
        let input = accessors[number[usize::from(is_held)]];
        let output = accessors[number[track]];
        animation.samplers.push(AnimationSampler { input, interpolation: "LINEAR", output });
    }
    animation
}

/// The rotations of a joint. Signs are chosen so that successive quaternions are in the same
/// hemisphere, because some players do not interpolate along the shorter arc.
fn rotations(clip: &Clip, joint: usize) -> Vec<Quat> {
    let mut before = Quat::IDENTITY;
    let next = |pose: &uvgraft_avatar::rig::Pose| {
        let mut turn = Quat::from_array(pose.rotations[joint]).normalize();
        if turn.dot(before) < 0.0 {
            turn = -turn;
        }
        before = turn;
        turn
    };
    clip.poses.iter().map(next).collect()
}
