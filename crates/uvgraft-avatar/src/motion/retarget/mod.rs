//! Brings a motion onto a skeleton: its turns ([`turns`]), its ways, and its feet onto the ground.

mod options;
#[cfg(test)]
mod tests;
mod turns;

use glam::{Quat, Vec3};

pub use self::options::{ClipOptions, Ground, Person, Retarget};
use self::turns::{Turn, lifts};
use super::ground::{Grounding, Reference, put_on_ground};
use super::resample::{self, Frame};
use super::soles::Soles;
use super::up::Up;
use super::{Motion, MotionError};
use crate::rig::{Clip, HumanBone, Pose, Skeleton};

/// Where the pelvis of the SMPL family's mean body is at rest, to a centimetre, in metres.
pub const MEAN_PELVIS: Vec3 = Vec3::new(0.0, -0.23, 0.03);
/// How long the legs of the SMPL family's mean body are, from hip to knee to ankle, to a centimetre, in metres.
pub const MEAN_LEG_M: f32 = 0.78;
/// Clips that begin facing elsewhere by less than this keep it: a step has its hips turned so.
const FRONT_DEG: f32 = 30.0;

impl Motion {
    /// The motion as a clip of a skeleton, Y up.
    ///
    /// # Errors
    /// [`MotionError::OtherSkeleton`] for one without hips, spine or legs, [`MotionError::Part`] and
    /// [`MotionError::Rate`] for options that leave nothing, [`MotionError::Rig`] where positions leave
    /// all bounds.
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
        let guess = Up::guess(self);
        let up = options.up.unwrap_or(guess.up);
        // Feet that stand are told apart by how slow they are, which takes all frames there are.
        let all =
            ClipOptions { fps: options.fps.filter(|_| options.ground == Ground::Keep), ..*options };
        let asked = resample::times(self, options)?;
        let mut frames = resample::frames(self, &all)?;
        for frame in &mut frames {
            frame.turns[0] = (up.upright() * frame.turns[0]).normalize();
            frame.place = up.upright() * frame.place;
        }
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
        let own = family.then_some(Person { skeleton, soles: None });
        let person = options.performer.or(own);
        // Where the pelvis is before the frame's translation, as the model of whoever moved has it.
        let pelvis = person.map_or(MEAN_PELVIS, |person| hips_at_rest(person.skeleton));
        let place = |frame: &Frame| up.upright() * pelvis + frame.place;
        let mut clip = Clip { name: name.to_owned(), times: Vec::new(), poses: Vec::new() };
        if options.ground == Ground::Keep {
            self.add_frames(&mut clip, skeleton, &turns, &frames, place);
            clip.check(skeleton.joints().len())?;
            return Ok((clip, report));
        }
        report.turned_deg = face_front(&mut frames, &place);
        report.scale = match options.performer {
            Some(person) => ratio(leg_m(skeleton), leg_m(person.skeleton)),
            None => ratio(leg_m(skeleton), Some(MEAN_LEG_M)),
        };
        let start = frames.first().map_or(Vec3::ZERO, &place);
        let rest = hips_at_rest(skeleton);
        // From the place at rest, as the crow walks; heights are put right below.
        let walked = |frame: &Frame, scale: f32, from: Vec3| {
            let way = (place(frame) - start) * scale;
            Vec3::new(from.x + way.x, place(frame).y * scale, from.z + way.z)
        };
        let scale = report.scale;
        self.add_frames(&mut clip, skeleton, &turns, &frames, |frame| walked(frame, scale, rest));
        clip.check(skeleton.joints().len())?;
        report.grounding = self.ground(&mut clip, skeleton, options, &frames, place)?;
        clip = resample::at_times(&clip, asked);
        clip.check(skeleton.joints().len())?;
        Ok((clip, report))
    }

    /// Puts a clip's feet on the ground, beside the person who moved if that one is known.
    fn ground(
        &self,
        clip: &mut Clip,
        skeleton: &Skeleton,
        options: &ClipOptions<'_>,
        frames: &[Frame],
        place: impl Fn(&Frame) -> Vec3,
    ) -> Result<Option<Grounding>, MotionError> {
        let soles = options.soles.cloned().or_else(|| Soles::of_joints(skeleton));
        let Some(soles) = soles else { return Ok(None) };
        let person = options.performer.filter(|_| options.ground == Ground::Clip);
        let mut reference = None;
        if let Some(Person { skeleton, soles }) = person {
            let lifts = vec![Quat::IDENTITY; skeleton.joints().len()];
            let turns = self.plan(skeleton, &self.sources(skeleton), &lifts);
            let mut recorded = Clip { times: Vec::new(), poses: Vec::new(), ..clip.clone() };
            self.add_frames(&mut recorded, skeleton, &turns, frames, place);
            let soles = soles.cloned().or_else(|| Soles::of_joints(skeleton));
            reference = soles.map(|soles| (skeleton, soles, recorded));
        }
        let reference =
            reference.as_ref().map(|(skeleton, soles, clip)| Reference { skeleton, soles, clip });
        let in_place = self.is_still();
        let done = put_on_ground(clip, skeleton, &soles, reference.as_ref(), in_place)?;
        Ok(Some(done))
    }

    /// Appends frames, the hips where `place` says.
    fn add_frames(
        &self,
        clip: &mut Clip,
        skeleton: &Skeleton,
        turns: &[Turn],
        frames: &[Frame],
        place: impl Fn(&Frame) -> Vec3,
    ) {
        let rest = hips_at_rest(skeleton);
        for frame in frames {
            clip.times.push(frame.time_s);
            let rotations = self.rotations(frame, turns);
            clip.poses.push(Pose { translation: (place(frame) - rest).into(), rotations });
        }
    }

    /// The motion's joints that a skeleton lacks.
    fn missing(&self, sources: &[Option<usize>]) -> Vec<&'static str> {
        let found = |source: usize| sources.contains(&Some(source));
        let joints = self.joints().iter().enumerate();
        joints.filter(|&(source, _)| !found(source)).map(|(_, &(name, _, _))| name).collect()
    }
}

/// Where the hips are at rest; that there are some was checked.
fn hips_at_rest(skeleton: &Skeleton) -> Vec3 {
    let hips = skeleton.human(HumanBone::Hips).unwrap_or(0);
    skeleton.joints()[hips].position.into()
}

/// The joints of a skeleton that a motion has not.
fn still(skeleton: &Skeleton, sources: &[Option<usize>]) -> Vec<String> {
    let joints = skeleton.joints().iter().zip(sources);
    joints.filter(|(_, source)| source.is_none()).map(|(joint, _)| joint.name.clone()).collect()
}

fn angle_deg(turn: &Quat) -> f32 {
    turn.angle_between(Quat::IDENTITY).to_degrees()
}

/// Turns all frames about the vertical so that the first one faces the front, unless it nearly does or
/// faces up or down. Returns by how much, in degrees.
fn face_front(frames: &mut [Frame], place: &impl Fn(&Frame) -> Vec3) -> f32 {
    let Some(first) = frames.first() else { return 0.0 };
    let ahead = first.turns[0] * Vec3::Z;
    let level = Vec3 { y: 0.0, ..ahead };
    let angle = level.x.atan2(level.z);
    if level.length() < 0.5 || angle.to_degrees().abs() < FRONT_DEG {
        return 0.0;
    }
    let turn = Quat::from_rotation_y(-angle);
    let start = place(first);
    for frame in frames {
        // About the place where the hips begin.
        let way = place(frame) - start;
        frame.place += turn * way - way;
        frame.turns[0] = (turn * frame.turns[0]).normalize();
    }
    -angle.to_degrees()
}

/// From hip to knee to ankle on the left.
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
