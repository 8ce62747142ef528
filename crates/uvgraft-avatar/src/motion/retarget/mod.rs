//! Retargets a motion to a skeleton: joint rotations ([`turns`]), translations, and ground contact.

mod options;
#[cfg(test)]
mod tests;
mod turns;

use glam::{Quat, Vec3};

pub use self::options::{ClipOptions, GroundMode, Performer, Retarget};
use self::turns::{Turn, lifts};
use super::ground::{Grounding, Reference, put_on_ground};
use super::resample::{self, Frame};
use super::soles::Soles;
use super::up::UpAxis;
use super::{Motion, MotionError};
use crate::rig::{Clip, HumanBone, Pose, Skeleton};

/// Rest position of the pelvis in the SMPL family's mean body, to a centimetre, in metres.
pub const MEAN_PELVIS: Vec3 = Vec3::new(0.0, -0.23, 0.03);
/// Leg length of the SMPL family's mean body, from hip to knee to ankle, to a centimetre, in
/// metres.
pub const MEAN_LEG_M: f32 = 0.78;
/// Clips whose initial direction is off by less than this stay so: hips are rotated
/// that far in a step.
const FRONT_DEG: f32 = 30.0;

impl Frame {
    /// Turns a frame that was recorded with another up axis.
    fn stand_upright(&mut self, up: UpAxis) {
        self.turns[0] = (up.upright() * self.turns[0]).normalize();
        self.translation = up.upright() * self.translation;
    }
}

impl Motion {
    /// Converts the motion to a clip of a skeleton, Y up.
    ///
    /// With [`GroundMode::Keep`] translations stay as recorded. Otherwise the clip is turned to the
    /// front, its path is scaled by the ratio of leg lengths and its feet are corrected, all at the
    /// frame rate of the recording; it is resampled last.
    ///
    /// # Errors
    /// [`MotionError::OtherSkeleton`] for a skeleton without hips, spine or legs,
    /// [`MotionError::Part`] and [`MotionError::Rate`] for options that leave no frames,
    /// [`MotionError::Rig`] if positions overflow.
    pub fn clip(
        &self,
        skeleton: &Skeleton,
        name: &str,
        options: &ClipOptions<'_>,
    ) -> Result<(Clip, Retarget), MotionError> {
        self.check_bones(skeleton)?;
        let sources = self.sources(skeleton);
        let family = self.is_of_family(skeleton);
        let lifts = lifts(skeleton, family);
        let turns = self.plan(skeleton, &sources, &lifts);
        let guess = UpAxis::guess(self);
        let up = options.up.unwrap_or(guess.up);
        // Contacts are detected by speed, which needs all frames of the motion.
        let all = ClipOptions {
            fps: options.fps.filter(|_| options.ground == GroundMode::Keep),
            ..*options
        };
        let times = resample::times(self, options)?;
        let mut frames = resample::frames(self, &all)?;
        frames.iter_mut().for_each(|frame| frame.stand_upright(up));
        let mut report = Retarget {
            missing: self.missing(&sources),
            still: still(skeleton, &sources),
            scale: 1.0,
            up,
            up_is_certain: options.up.is_some() || guess.is_certain,
            in_place: self.is_still(),
            turned_deg: 0.0,
            grounding: None,
            arms_deg: lifts.iter().map(angle_deg).fold(0.0, f32::max),
        };
        let person = options.performer.or(family.then_some(Performer { skeleton, soles: None }));
        // Where the pelvis is before the frame's translation, in the model of the performer.
        let pelvis = person.map_or(MEAN_PELVIS, |person| hips_at_rest(person.skeleton));
        let hips_of = |frame: &Frame| up.upright() * pelvis + frame.translation;
        let mut clip = Clip { name: name.to_owned(), times: Vec::new(), poses: Vec::new() };
        if options.ground == GroundMode::Keep {
            self.add_frames(&mut clip, skeleton, &turns, &frames, hips_of);
            clip.check(skeleton.joints().len())?;
            return Ok((clip, report));
        }
        report.turned_deg = face_front(&mut frames, &hips_of);
        let performer_leg_m = match options.performer {
            Some(person) => leg_m(person.skeleton),
            None => Some(MEAN_LEG_M),
        };
        report.scale = ratio(leg_m(skeleton), performer_leg_m);
        let start = frames.first().map_or(Vec3::ZERO, &hips_of);
        let rest = hips_at_rest(skeleton);
        // The path starts at the rest position and is scaled horizontally; heights are
        // corrected below.
        let walked = |frame: &Frame, scale: f32, from: Vec3| {
            let offset = (hips_of(frame) - start) * scale;
            Vec3::new(from.x + offset.x, hips_of(frame).y * scale, from.z + offset.z)
        };
        let scale = report.scale;
        self.add_frames(&mut clip, skeleton, &turns, &frames, |frame| walked(frame, scale, rest));
        clip.check(skeleton.joints().len())?;
        report.grounding = self.ground(&mut clip, skeleton, options, &frames, hips_of)?;
        clip = resample::at_times(&clip, times);
        clip.check(skeleton.joints().len())?;
        Ok((clip, report))
    }

    /// Puts a clip's feet on the ground, with the performer as the reference if known.
    fn ground(
        &self,
        clip: &mut Clip,
        skeleton: &Skeleton,
        options: &ClipOptions<'_>,
        frames: &[Frame],
        hips_of: impl Fn(&Frame) -> Vec3,
    ) -> Result<Option<Grounding>, MotionError> {
        let soles = options.soles.cloned().or_else(|| Soles::of_joints(skeleton));
        let Some(soles) = soles else { return Ok(None) };
        let person = options.performer.filter(|_| options.ground == GroundMode::Clip);
        let mut reference = None;
        if let Some(Performer { skeleton, soles }) = person {
            let lifts = vec![Quat::IDENTITY; skeleton.joints().len()];
            let turns = self.plan(skeleton, &self.sources(skeleton), &lifts);
            let mut recorded = Clip { times: Vec::new(), poses: Vec::new(), ..clip.clone() };
            self.add_frames(&mut recorded, skeleton, &turns, frames, hips_of);
            let soles = soles.cloned().or_else(|| Soles::of_joints(skeleton));
            reference = soles.map(|soles| (skeleton, soles, recorded));
        }
        let reference =
            reference.as_ref().map(|(skeleton, soles, clip)| Reference { skeleton, soles, clip });
        let in_place = self.is_still();
        let done = put_on_ground(clip, skeleton, &soles, reference.as_ref(), in_place)?;
        Ok(Some(done))
    }

    /// Appends frames with the hips at `hips_of(frame)`.
    fn add_frames(
        &self,
        clip: &mut Clip,
        skeleton: &Skeleton,
        turns: &[Turn],
        frames: &[Frame],
        hips_of: impl Fn(&Frame) -> Vec3,
    ) {
        let rest = hips_at_rest(skeleton);
        for frame in frames {
            clip.times.push(frame.time_s);
            let rotations = self.rotations(frame, turns);
            clip.poses.push(Pose { translation: (hips_of(frame) - rest).into(), rotations });
        }
    }

    /// Joints of the motion that the skeleton lacks.
    fn missing(&self, sources: &[Option<usize>]) -> Vec<&'static str> {
        let found = |source: usize| sources.contains(&Some(source));
        let joints = self.joints().iter().enumerate();
        joints.filter(|&(source, _)| !found(source)).map(|(_, &(name, _, _))| name).collect()
    }
}

/// Rest position of the hips, whose presence has been checked.
fn hips_at_rest(skeleton: &Skeleton) -> Vec3 {
    let hips = skeleton.human(HumanBone::Hips).unwrap_or(0);
    skeleton.joints()[hips].position.into()
}

/// Joints of the skeleton that the motion lacks.
fn still(skeleton: &Skeleton, sources: &[Option<usize>]) -> Vec<String> {
    let joints = skeleton.joints().iter().zip(sources);
    joints.filter(|(_, source)| source.is_none()).map(|(joint, _)| joint.name.clone()).collect()
}

fn angle_deg(turn: &Quat) -> f32 {
    turn.angle_between(Quat::IDENTITY).to_degrees()
}

/// Rotates all frames about the vertical so that the first one faces the front, unless it nearly
/// does or faces up or down. Returns the angle in degrees.
fn face_front(frames: &mut [Frame], hips_of: &impl Fn(&Frame) -> Vec3) -> f32 {
    let Some(first) = frames.first() else { return 0.0 };
    let ahead = first.turns[0] * Vec3::Z;
    let level = Vec3 { y: 0.0, ..ahead };
    let angle = level.x.atan2(level.z);
    if level.length() < 0.5 || angle.to_degrees().abs() < FRONT_DEG {
        return 0.0;
    }
    let turn = Quat::from_rotation_y(-angle);
    let start = hips_of(first);
    for frame in frames {
        // About the initial position of the hips.
        let offset = hips_of(frame) - start;
        frame.translation += turn * offset - offset;
        frame.turns[0] = (turn * frame.turns[0]).normalize();
    }
    -angle.to_degrees()
}

/// Length from hip to knee to ankle on the left.
fn leg_m(skeleton: &Skeleton) -> Option<f32> {
    let at = |bone| skeleton.human(bone).map(|at| Vec3::from(skeleton.joints()[at].position));
    let knee = at(HumanBone::LeftLowerLeg)?;
    let (hip, ankle) = (at(HumanBone::LeftUpperLeg)?, at(HumanBone::LeftFoot)?);
    Some(hip.distance(knee) + knee.distance(ankle))
}

fn ratio(leg_m: Option<f32>, performers_m: Option<f32>) -> f32 {
    match (leg_m, performers_m) {
        (Some(leg), Some(performers)) if performers > 0.0 && leg > 0.0 => leg / performers,
        _ => 1.0,
    }
}
