//! The frames of a render: a pose and an angle for each.

use uvgraft::listing::listed;
use uvgraft_gltf::scene::{Clip, PoseRequest, Scene};
use uvgraft_pipeline::{Failure, Result};

use super::{PoseOption, RenderRequest};

/// Maximum number of frames.
pub const MAX_FRAMES: usize = 3600;

/// A frame to draw.
pub(super) struct Frame {
    pub(super) posing: PoseRequest,
    pub(super) azimuth: f32,
}

impl RenderRequest {
    /// All frames; one for a still image.
    pub(super) fn frames(&self, scene: &Scene) -> Result<Vec<Frame>> {
        let posing = self.posing(scene)?;
        let mut count = usize::from(self.turntable.unwrap_or(1));
        let fps = self.fps.unwrap_or(25.0);
        if self.motion {
            let seconds = posing.clip.map_or(0.0, |(clip, _)| scene.clips()[clip].seconds);
            // The last frame would repeat the first.
            let wanted = (seconds * fps).round().max(1.0);
            if wanted > MAX_FRAMES as f32 {
                return Err(Failure::option(format!(
                    "{seconds} s at {fps} frames per second must be at most {MAX_FRAMES} frames, got \
                     {wanted}; use a lower `fps`"
                )));
            }
            count = wanted as usize;
        }
        let turn = if self.turntable.is_some() { 360.0 / count as f32 } else { 0.0 };
        let frame = |index: usize| {
            let mut posing = posing.clone();
            if let (true, Some((_, seconds))) = (self.motion, &mut posing.clip) {
                *seconds = index as f32 / fps;
            }
            Frame { posing, azimuth: self.azimuth + turn * index as f32 }
        };
        Ok((0..count).map(frame).collect())
    }

    /// The pose of the first frame.
    fn posing(&self, scene: &Scene) -> Result<PoseRequest> {
        let mut posing = PoseRequest::default();
        for part in &self.pose {
            match part {
                PoseOption::Named(stance) => posing.stance = *stance,
                PoseOption::Bone(bone, degrees) => posing.rotations.push((bone.clone(), *degrees)),
            }
        }
        posing.weights.clone_from(&self.expressions);
        let clip = self.clip(scene)?;
        if let (Some(clip), Some(frame)) = (clip, self.frame) {
            let Clip { name, seconds, .. } = &scene.clips()[clip];
            // A little more than the end is the end, as printed with one place.
            if frame > seconds + 0.05 {
                return Err(Failure::option(format!(
                    "`frame` must be within the clip {name:?}, which is {seconds:.2} s long, got \
                     {frame}"
                )));
            }
        }
        posing.clip = clip.map(|clip| (clip, self.frame.unwrap_or(0.0)));
        Ok(posing)
    }

    /// The requested animation clip, if any.
    fn clip(&self, scene: &Scene) -> Result<Option<usize>> {
        let clips = scene.clips();
        let Some(name) = &self.clip else {
            if clips.is_empty() && (self.motion || self.frame.is_some()) {
                return Err(Failure::input("the file has no animations"));
            }
            return Ok((self.motion || self.frame.is_some()).then_some(0));
        };
        let by_name = clips.iter().position(|clip| clip.name == *name);
        let by_number = || name.parse().ok().filter(|&index: &usize| index < clips.len());
        by_name.or_else(by_number).map(Some).ok_or_else(|| {
            if clips.is_empty() {
                return Failure::input(format!("no clip {name:?}: the file has no animations"));
            }
            let numbered = clips.iter().enumerate();
            let known = listed(numbered.map(|(index, clip)| format!("{index} ({})", clip.name)));
            Failure::input(format!("no clip {name:?}; must be one of {known}"))
        })
    }
}
