//! Animation clips: channels of keyframes for nodes.
//!
//! # Source
//! Khronos, "glTF 2.0 Specification", section 3.11 and appendix C, "Interpolation Modes".

use std::collections::HashMap;
use std::sync::Arc;

use super::accessor::Accessors;
use super::check::find;
use super::document::{Document, Sampler};
use super::error::SceneError;
use super::shared::shared;
use super::transform::{LocalTransform, unit};

/// An animation of a scene.
#[derive(Debug)]
pub struct Clip {
    /// Its name, which may be empty.
    pub name: String,
    /// Time of the last key, in seconds; the clip starts at 0.
    pub seconds: f32,
    pub(super) channels: Vec<Channel>,
    /// Number of channels that are ignored because they have no keys.
    pub channels_without_keys: usize,
}

#[derive(Debug)]
pub(super) struct Channel {
    pub node: usize,
    pub path: Path,
    interpolation: Interpolation,
    /// Key times in ascending order, at least one.
    times: Arc<[f32]>,
    /// `width` numbers for each key; three times as many for cubic splines.
    values: Arc<[f32]>,
    width: usize,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Interpolation {
    Linear,
    Step,
    Cubic,
}

/// Reads all animations of a file. Channels without a node, and channels with unknown paths, are
/// skipped: they belong to extensions. Channels without keys, which some exporters write for what
/// does not move, are counted and move nothing. Each other channel must have non-decreasing times, and
/// `keys · width` values, or three times as many for cubic splines (in-tangent, value,
/// out-tangent).
///
/// - `targets`: number of morph targets of each node.
pub(super) fn clips(
    document: &Document,
    accessors: &mut Accessors<'_>,
    targets: &[usize],
) -> Result<Vec<Clip>, SceneError> {
    let (mut clips, mut arrays) = (Vec::new(), KeyArrays::new(accessors));
    for (index, animation) in document.animations.iter().enumerate() {
        let mut clip = Clip {
            name: animation.name.clone().unwrap_or_default(),
            seconds: 0.0,
            channels: Vec::new(),
            channels_without_keys: 0,
        };
        for (number, channel) in animation.channels.iter().enumerate() {
            let place = format!("animation {index}, channel {number}");
            // Channels without a node belong to extensions.
            let Some(node) = channel.target.node else { continue };
            let Some(path) = Path::new(&channel.target.path) else { continue };
            let &targets = find(targets, node, "node", &place)?;
            let sampler = find(&animation.samplers, channel.sampler, "sampler", &place)?;
            let width = path.width(targets);
            let keys = Keys::read(sampler, path, width, &mut arrays, &place)?;
            let Some(Keys { interpolation, times, values }) = keys else {
                clip.channels_without_keys += 1;
                continue;
            };
            clip.seconds = times.last().map_or(clip.seconds, |&last| clip.seconds.max(last));
            let node = node as usize;
            clip.channels.push(Channel { node, path, interpolation, times, values, width });
        }
        clips.push(clip);
    }
    Ok(clips)
}

impl Path {
    /// `None` for those of extensions.
    fn new(name: &str) -> Option<Self> {
        Some(match name {
            "translation" => Self::Translation,
            "rotation" => Self::Rotation,
            "scale" => Self::Scale,
            "weights" => Self::Weights,
            _ => return None,
        })
    }

    /// Components of an element of its values.
    const fn components(self) -> usize {
        match self {
            Self::Translation | Self::Scale => 3,
            Self::Rotation => 4,
            Self::Weights => 1,
        }
    }

    /// Numbers at each key.
    ///
    /// - `targets`: number of the node's morph targets.
    const fn width(self, targets: usize) -> usize {
        match self {
            Self::Weights => targets,
            _ => self.components(),
        }
    }
}

/// Times and values that channels share: many move by the same times.
struct KeyArrays<'k, 'a> {
    accessors: &'k mut Accessors<'a>,
    times: HashMap<u32, Arc<[f32]>>,
    /// By accessor and width.
    values: HashMap<(u32, usize), Arc<[f32]>>,
}

impl<'k, 'a> KeyArrays<'k, 'a> {
    fn new(accessors: &'k mut Accessors<'a>) -> Self {
        Self { accessors, times: HashMap::new(), values: HashMap::new() }
    }

    /// Times in ascending order.
    fn times(&mut self, index: u32, place: &str) -> Result<Arc<[f32]>, SceneError> {
        shared(&mut self.times, index, || {
            let times = self.accessors.floats::<1>(index, None)?.concat();
            if let Some(at) = (1..times.len()).find(|&k| times[k] < times[k - 1]) {
                let (before, after) = (times[at - 1], times[at]);
                let reason =
                    format!("times must increase, got {before} and then {after} at index {at}");
                return Err(SceneError::content(place, reason));
            }
            Ok(times.into())
        })
    }

    fn values(&mut self, index: u32, path: Path) -> Result<Arc<[f32]>, SceneError> {
        shared(&mut self.values, (index, path.components()), || {
            Ok(match path.components() {
                3 => self.accessors.floats::<3>(index, None)?.concat().into(),
                4 => self.accessors.floats::<4>(index, None)?.concat().into(),
                _ => self.accessors.floats::<1>(index, None)?.concat().into(),
            })
        })
    }
}

/// What a sampler interpolates.
struct Keys {
    interpolation: Interpolation,
    /// At least one.
    times: Arc<[f32]>,
    values: Arc<[f32]>,
}

impl Keys {
    /// `None` if there are no keys.
    fn read(
        sampler: &Sampler,
        path: Path,
        width: usize,
        arrays: &mut KeyArrays<'_, '_>,
        place: &str,
    ) -> Result<Option<Self>, SceneError> {
        let interpolation = match sampler.interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::Cubic,
            Some(other) => {
                let reason =
                    format!("interpolation must be LINEAR, STEP or CUBICSPLINE, got {other:?}");
                return Err(SceneError::content(place, reason));
            }
        };
        let (Some(input), Some(output)) = (sampler.input, sampler.output) else { return Ok(None) };
        let times = arrays.times(input, place)?;
        if times.is_empty() {
            return Ok(None);
        }
        let values = arrays.values(output, path)?;
        let a_key = if interpolation == Interpolation::Cubic { 3 * width } else { width };
        let wanted = times.len() * a_key;
        if values.len() != wanted {
            let (keys, found) = (times.len(), values.len());
            let reason = format!("{keys} keys must have {wanted} values, got {found}");
            return Err(SceneError::content(place, reason));
        }
        Ok(Some(Self { interpolation, times, values }))
    }
}

impl Channel {
    /// Writes the values at a time to a node; times are clamped to the first and last key.
    pub fn apply(&self, seconds: f32, placement: &mut LocalTransform, weights: &mut [f32]) {
        let rotation = self.path == Path::Rotation;
        let mut sampled = vec![0.0; self.width];
        self.sample(seconds, rotation, &mut sampled);
        match (self.path, &sampled[..]) {
            (Path::Translation, &[x, y, z]) => placement.translation = [x, y, z],
            (Path::Scale, &[x, y, z]) => placement.scale = [x, y, z],
            (Path::Rotation, &[x, y, z, w]) => placement.rotation = unit([x, y, z, w]).into(),
            (Path::Weights, values) if values.len() == weights.len() => {
                weights.copy_from_slice(values);
            }
            _ => {}
        }
    }

    /// Interpolates between the keys around a time.
    ///
    /// Cubic splines are Hermite: with `t` in 0 to 1 between keys `span` seconds apart,
    /// `(2t³ - 3t² + 1) a + (t³ - 2t² + t) span · out_a + (3t² - 2t³) b + (t³ - t²) span · in_b`.
    fn sample(&self, seconds: f32, rotation: bool, out: &mut [f32]) {
        let cubic = self.interpolation == Interpolation::Cubic;
        let after = self.times.partition_point(|&time| time <= seconds);
        let (from, to) = (after.saturating_sub(1), after.min(self.times.len() - 1));
        let value = |key: usize| {
            let part = if cubic { 3 * key + 1 } else { key };
            &self.values[part * self.width..][..self.width]
        };
        let span = self.times[to] - self.times[from];
        if from == to || after == 0 || span <= 0.0 || self.interpolation == Interpolation::Step {
            out.copy_from_slice(value(from));
            return;
        }
        let t = (seconds - self.times[from]) / span;
        let (a, b) = (value(from), value(to));
        if cubic {
            let tangent = |key: usize, side: usize| {
                &self.values[(3 * key + side) * self.width..][..self.width]
            };
            let (leaving, arriving) = (tangent(from, 2), tangent(to, 0));
            let (t2, t3) = (t * t, t * t * t);
            for k in 0..self.width {
                out[k] = (2.0 * t3 - 3.0 * t2 + 1.0) * a[k]
                    + (t3 - 2.0 * t2 + t) * span * leaving[k]
                    + (3.0 * t2 - 2.0 * t3) * b[k]
                    + (t3 - t2) * span * arriving[k];
            }
        } else if rotation {
            // Slerp along the shorter arc.
            let quaternion = |q: &[f32]| unit([q[0], q[1], q[2], q[3]]);
            out.copy_from_slice(&quaternion(a).slerp(quaternion(b), t).to_array());
        } else {
            for k in 0..self.width {
                out[k] = a[k] + (b[k] - a[k]) * t;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use uvgraft_tests::strip::{self, Strip};

    use super::*;
    use crate::scene::{PoseRequest, Scene};

    fn channel(interpolation: Interpolation, values: &[f32]) -> Channel {
        let times = vec![1.0, 3.0];
        Channel {
            node: 0,
            path: Path::Weights,
            interpolation,
            times: times.into(),
            values: values.into(),
            width: 1,
        }
    }

    fn at(channel: &Channel, seconds: f32) -> f32 {
        let mut weights = [9.0];
        channel.apply(seconds, &mut LocalTransform::default(), &mut weights);
        weights[0]
    }

    #[test]
    fn keys_are_interpolated_by_their_mode() {
        let linear = channel(Interpolation::Linear, &[2.0, 6.0]);
        let times = [0.0, 1.0, 1.5, 3.0, 9.0];
        assert_eq!(times.map(|t| at(&linear, t)), [2.0, 2.0, 3.0, 6.0, 6.0]);
        let step = channel(Interpolation::Step, &[2.0, 6.0]);
        assert_eq!(times.map(|t| at(&step, t)), [2.0, 2.0, 2.0, 6.0, 6.0]);
        // From 2, with out-tangent 1 per second, to 6, with in-tangent -1 per second, over 2
        // seconds: half-way, it is 0.5·2 + 0.125·2·1 + 0.5·6 - 0.125·2·(-1).
        let cubic = channel(Interpolation::Cubic, &[0.0, 2.0, 1.0, -1.0, 6.0, 0.0]);
        assert_eq!(at(&cubic, 2.0), 4.5);
        assert_eq!([0.0, 1.0, 3.0, 4.0].map(|t| at(&cubic, t)), [2.0, 2.0, 6.0, 6.0]);
    }
    #[test]
    fn channels_without_keys_move_nothing() {
        let mut strip = Strip::new();
        let none = strip.add(&[], 5126, 0, "SCALAR");
        let mut clip = strip.json["animations"][0].clone();
        for sampler in [
            json!({ "input": none, "output": strip::TURNS }),
            json!({ "input": none, "output": none }),
            json!({ "input": strip::TIMES }),
            json!({ "output": strip::TURNS }),
        ] {
            let samplers = clip["samplers"].as_array_mut().unwrap();
            let target = json!({ "node": 0, "path": "rotation" });
            let channel = json!({ "sampler": samplers.len(), "target": target });
            samplers.push(sampler);
            clip["channels"].as_array_mut().unwrap().push(channel);
        }
        let mut still = clip.clone();
        still["channels"].as_array_mut().unwrap().remove(0);
        let strip = strip.with("/animations", json!([clip, still]));
        let scene = Scene::read(&strip.glb()).unwrap();
        let clips = scene.clips().iter().map(|clip| (clip.channels_without_keys, clip.seconds));
        assert_eq!(clips.collect::<Vec<_>>(), [(4, 1.0), (4, 0.0)]);
        let at = |clip| {
            let posing = PoseRequest { clip: Some((clip, 1.0)), ..PoseRequest::default() };
            scene.pose(&posing).unwrap()[0].positions[5]
        };
        assert!((at(0)[0] + 1.0).abs() < 1e-6 && at(1) == [0.5, 2.0, 0.0], "{:?}", at(0));
    }
}
