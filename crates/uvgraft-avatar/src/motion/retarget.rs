//! Brings a motion onto a skeleton.
//!
//! At rest the bodies of the SMPL family stand in a T and their joints are aligned with the world,
//! so a rotation means the same on any skeleton that is at rest like that: joints are found by the
//! bones that they are, and turn as the motion's do. Where a skeleton has no joint for one of the
//! motion's, its rotation is handed on to what hangs on it. Arms that hang lower at rest are
//! lifted first, by the shortest rotation that takes them to where the family's are.

use glam::{Quat, Vec3};

use super::ground::{Grounding, Reference, put_on_ground};
use super::resample::{self, Frame};
use super::soles::Soles;
use super::up::Up;
use super::{Motion, MotionError};
use crate::rig::{Clip, HumanBone, Pose, Skeleton};

/// Where a clip's feet are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ground {
    /// Translations stay as they were recorded, whoever plays them.
    #[default]
    Keep,
    /// Feet stand on y = 0 where the feet of the person who moved stood; ways are as much longer as the
    /// body's legs are. The first frame is at the body's place at rest and faces the front. Needs
    /// [`ClipOptions::performer`]; without, as [`Ground::Feet`].
    Clip,
    /// The same with nobody known: the body's own feet stand where they are low and slow.
    Feet,
}

/// A person who moved.
#[derive(Debug, Clone, Copy)]
pub struct Person<'a> {
    /// The person's joints at rest, in the model's own space.
    pub skeleton: &'a Skeleton,
    /// The person's feet.
    pub soles: Option<&'a Soles>,
}

/// How a motion becomes a clip.
#[derive(Debug, Clone, Copy)]
pub struct ClipOptions<'a> {
    /// Frames a second, at most the motion's own; nothing keeps all frames.
    pub fps: Option<f64>,
    /// Where the clip begins in the motion, in seconds.
    pub start_s: f64,
    /// How long it is at most, in seconds.
    pub seconds: Option<f64>,
    /// Where feet are.
    pub ground: Ground,
    /// Which axis of the recording points up; nothing finds out.
    pub up: Option<Up>,
    /// The person who moved, where it is known: a model with the motion's [`betas`](Motion::betas).
    /// With [`Ground::Keep`] and nobody, a body of the family is taken to be that person, in the space of
    /// its model, and others are set beside the family's mean body.
    pub performer: Option<Person<'a>>,
    /// The feet of the body that plays the clip; nothing takes them from its joints.
    pub soles: Option<&'a Soles>,
}

impl Default for ClipOptions<'_> {
    /// 30 frames a second, all of the motion, where it was recorded.
    fn default() -> Self {
        Self {
            fps: Some(30.0),
            start_s: 0.0,
            seconds: None,
            ground: Ground::Keep,
            up: None,
            performer: None,
            soles: None,
        }
    }
}

/// What became of a motion on a skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct Retarget {
    /// Joints of the motion that the skeleton lacks; those between others hand their rotations on.
    pub missing: Vec<&'static str>,
    /// Joints of the skeleton that the motion has not: they stay as at rest.
    pub still: Vec<String>,
    /// What translations were multiplied by: the ratio of leg lengths; 1 where they are kept.
    pub scale: f32,
    /// Which axis of the recording was taken to point up.
    pub up: Up,
    /// The motion left no doubt about it, or it was given.
    pub up_is_certain: bool,
    /// The file does not say where the body was: its clip stays in one place.
    pub in_place: bool,
    /// How far the whole clip was turned about the vertical to face the front at its start, in degrees.
    pub turned_deg: f32,
    /// What was done about the ground; nothing where translations are kept.
    pub grounding: Option<Grounding>,
    /// How far an arm at rest was turned to where the family has it, in degrees; 0 for a T.
    pub arms_deg: f32,
}

/// Without these no motion of a body makes sense.
const NEEDED: [HumanBone; 4] =
    [HumanBone::Hips, HumanBone::Spine, HumanBone::LeftUpperLeg, HumanBone::RightUpperLeg];
/// The family's mean body, to a centimetre: the pelvis at rest, and hip to knee to ankle, in metres.
pub(crate) const MEAN_PELVIS: Vec3 = Vec3::new(0.0, -0.23, 0.03);
pub(crate) const MEAN_LEG_M: f32 = 0.78;
/// Arms that are turned less against the family's are taken as they are.
const LEAST_ARM_DEG: f32 = 15.0;
/// Clips that begin facing elsewhere by less than this keep it: a step has its hips turned so.
const FRONT_DEG: f32 = 30.0;

/// How one of the skeleton's joints is turned.
#[derive(Debug, Clone, Copy)]
enum Turn {
    Still,
    /// Like a joint of the motion.
    Same(usize),
    /// As a joint of the motion is in the world, seen from what another one is; between two lifted
    /// rests.
    Between {
        above: Option<usize>,
        source: usize,
        lift_above: Quat,
        lift: Quat,
    },
}

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

    fn check_bones(&self, skeleton: &Skeleton) -> Result<(), MotionError> {
        let missing: Vec<&str> = NEEDED
            .iter()
            .filter(|&&bone| skeleton.human(bone).is_none())
            .map(|bone| bone.name())
            .collect();
        if missing.is_empty() {
            return Ok(());
        }
        Err(MotionError::OtherSkeleton {
            joints: self.joints().len(),
            root: skeleton.joints()[0].name.clone(),
            others: skeleton.joints().len() - 1,
            missing: missing.join(", "),
        })
    }

    /// For each joint of the skeleton the motion's: the same bone, or the same name where neither is
    /// a bone.
    fn sources(&self, skeleton: &Skeleton) -> Vec<Option<usize>> {
        let source = |joint: &crate::rig::Joint| {
            self.joints().iter().position(|&(name, _, bone)| match joint.human {
                Some(human) => bone == Some(human),
                None => bone.is_none() && name == joint.name,
            })
        };
        skeleton.joints().iter().map(source).collect()
    }

    /// Whether a skeleton is at rest as the motion's body is: all joints of a body have its names.
    fn is_of_family(&self, skeleton: &Skeleton) -> bool {
        crate::body::BODY.iter().all(|&(name, _, _)| skeleton.find(name).is_some())
    }

    fn plan(&self, skeleton: &Skeleton, sources: &[Option<usize>], lifts: &[Quat]) -> Vec<Turn> {
        let joints = skeleton.joints();
        let turn = |joint: usize| {
            let Some(source) = sources[joint] else { return Turn::Still };
            let ancestors = std::iter::successors(joints[joint].parent, |&at| joints[at].parent);
            let above = ancestors.filter_map(|at| sources[at]).next();
            let lift = lifts[joint];
            let lift_above = joints[joint].parent.map_or(Quat::IDENTITY, |parent| lifts[parent]);
            let direct = self.joints()[source].1 == above;
            if direct && lift == Quat::IDENTITY && lift_above == Quat::IDENTITY {
                Turn::Same(source)
            } else {
                Turn::Between { above, source, lift_above, lift }
            }
        };
        (0..joints.len()).map(turn).collect()
    }

    fn rotations(&self, frame: &Frame, turns: &[Turn]) -> Vec<[f32; 4]> {
        let mut world: Vec<Quat> = Vec::with_capacity(frame.turns.len());
        for (&turn, &(_, parent, _)) in frame.turns.iter().zip(self.joints()) {
            world.push(parent.map_or(turn, |parent| (world[parent] * turn).normalize()));
        }
        let rotation = |turn: &Turn| match *turn {
            Turn::Still => Quat::IDENTITY,
            Turn::Same(source) => frame.turns[source],
            Turn::Between { above, source, lift_above, lift } => {
                let above = above.map_or(Quat::IDENTITY, |above| world[above]) * lift_above;
                (above.inverse() * world[source] * lift).normalize()
            }
        };
        turns.iter().map(|turn| rotation(turn).into()).collect()
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

/// For each joint the rotation from its rest to one with arms as the family has them.
fn lifts(skeleton: &Skeleton, family: bool) -> Vec<Quat> {
    use HumanBone::{
        LeftHand, LeftLowerArm, LeftUpperArm, RightHand, RightLowerArm, RightUpperArm,
    };
    let joints = skeleton.joints();
    let mut lifts = vec![Quat::IDENTITY; joints.len()];
    if family {
        return lifts;
    }
    let arms = [
        (LeftUpperArm, LeftLowerArm, Vec3::X),
        (LeftLowerArm, LeftHand, Vec3::X),
        (RightUpperArm, RightLowerArm, Vec3::NEG_X),
        (RightLowerArm, RightHand, Vec3::NEG_X),
    ];
    for joint in 0..joints.len() {
        // Hands and fingers are lifted as the forearm is.
        lifts[joint] = joints[joint].parent.map_or(Quat::IDENTITY, |parent| lifts[parent]);
        let Some(&(_, end, outwards)) =
            arms.iter().find(|&&(bone, _, _)| joints[joint].human == Some(bone))
        else {
            continue;
        };
        let Some(end) = skeleton.human(end) else { continue };
        let along = Vec3::from(joints[end].position) - Vec3::from(joints[joint].position);
        if let Some(along) = along.try_normalize() {
            let lower = along.angle_between(outwards).to_degrees() > LEAST_ARM_DEG;
            // The motion's joint turns what points outwards; this one first brings its arm there.
            lifts[joint] =
                if lower { Quat::from_rotation_arc(along, outwards) } else { Quat::IDENTITY };
        }
    }
    lifts
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use uvgraft_io::arrays::{NamedArrays, NumericArray};

    use super::*;
    use crate::rig::Joint;

    /// A motion of one frame: the turns of some of the body's joints, and the translation, Z up.
    fn motion(turns: &[(&str, [f32; 3])], place: [f32; 3]) -> Motion {
        frames(turns, &[place])
    }

    /// The same of several frames that differ in their translations.
    fn frames(turns: &[(&str, [f32; 3])], places: &[[f32; 3]]) -> Motion {
        let mut poses = vec![0.0; 66];
        for (name, turn) in turns {
            let joint = crate::body::BODY.iter().position(|entry| entry.0 == *name).unwrap();
            poses[3 * joint..][..3].copy_from_slice(turn);
        }
        let mut arrays = NamedArrays::new();
        let (count, poses) = (places.len(), poses.repeat(places.len()));
        arrays.insert("poses", NumericArray::new_f32(vec![count, 66], poses).unwrap());
        let places = places.as_flattened().to_vec();
        arrays.insert("trans", NumericArray::new_f32(vec![count, 3], places).unwrap());
        arrays.insert("mocap_framerate", NumericArray::new_f64(vec![], vec![30.0]).unwrap());
        Motion::from_arrays(&arrays).unwrap()
    }

    /// A humanoid on the ground without a chest. Its arms are level, or hang down by 45°.
    fn humanoid(hanging: bool) -> Skeleton {
        use HumanBone as B;
        type Entry = (&'static str, Option<usize>, [f32; 3], Option<HumanBone>);
        let reach = |length: f32| {
            let down = if hanging { length / 2_f32.sqrt() } else { 0.0 };
            [0.2 + if hanging { down } else { length }, 1.4 - down, 0.0]
        };
        let joints: [Entry; 12] = [
            ("root", None, [0.0; 3], None),
            ("hips", Some(0), [0.0, 0.9, 0.0], Some(B::Hips)),
            ("spine", Some(1), [0.0, 1.0, 0.0], Some(B::Spine)),
            ("shoulder", Some(2), [0.1, 1.4, 0.0], Some(B::LeftShoulder)),
            ("upper arm", Some(3), reach(0.0), Some(B::LeftUpperArm)),
            ("lower arm", Some(4), reach(0.3), Some(B::LeftLowerArm)),
            ("hand", Some(5), reach(0.6), Some(B::LeftHand)),
            ("tail", Some(1), [0.0, 0.9, -0.1], None),
            ("left thigh", Some(1), [0.1, 0.85, 0.0], Some(B::LeftUpperLeg)),
            ("left shin", Some(8), [0.1, 0.46, 0.0], Some(B::LeftLowerLeg)),
            ("left foot", Some(9), [0.1, 0.07, 0.0], Some(B::LeftFoot)),
            ("right thigh", Some(1), [-0.1, 0.85, 0.0], Some(B::RightUpperLeg)),
        ];
        let joint = |(name, parent, position, human): Entry| Joint {
            name: name.to_owned(),
            parent,
            position,
            human,
        };
        Skeleton::new(joints.map(joint).to_vec()).unwrap()
    }

    /// Where a joint of the skeleton comes to be in the first frame.
    fn place(skeleton: &Skeleton, clip: &Clip, name: &str) -> Vec3 {
        let joint = skeleton.find(name).unwrap();
        let motions = skeleton.motions(&clip.poses[0]).unwrap();
        motions[joint].point(skeleton.joints()[joint].position).into()
    }

    fn close(found: Vec3, wanted: Vec3) {
        assert!(found.abs_diff_eq(wanted, 1e-5), "{found} {wanted}");
    }

    /// What takes the family's rest, Y up, to a person who stands in a world with Z up.
    const STANDS: (&str, [f32; 3]) = ("pelvis", [FRAC_PI_2, 0.0, 0.0]);

    #[test]
    fn who_stands_in_a_recording_stands_on_the_ground() {
        let skeleton = humanoid(false);
        // The pelvis is 0.9 above the ground: it is 3 cm before the origin, which is below y = 0.23.
        let motion = motion(&[STANDS], [0.0, 0.23, 0.87]);
        let (clip, report) = motion.clip(&skeleton, "c", &ClipOptions::default()).unwrap();
        assert!((report.scale - 1.0).abs() < 1e-6 && report.arms_deg == 0.0, "{report:?}");
        assert_eq!(report.still, ["root", "tail"]);
        assert!(report.missing.contains(&"spine2") && report.missing.contains(&"head"));
        for joint in ["hips", "hand", "left foot"] {
            let rest = skeleton.joints()[skeleton.find(joint).unwrap()].position;
            close(place(&skeleton, &clip, joint), rest.into());
        }
    }

    #[test]
    fn what_a_missing_joint_turns_by_is_handed_on() {
        let skeleton = humanoid(false);
        let quarter = [0.0, 0.0, FRAC_PI_2];
        let turns = [STANDS, ("spine2", quarter)];
        let (clip, _) = motion(&turns, [0.0, 0.23, 0.87])
            .clip(&skeleton, "c", &ClipOptions::default())
            .unwrap();
        // There is no chest, so the shoulder turns about itself, and the arm points up.
        close(place(&skeleton, &clip, "upper arm"), Vec3::new(0.1, 1.5, 0.0));
        close(place(&skeleton, &clip, "hand"), Vec3::new(0.1, 2.1, 0.0));
    }

    #[test]
    fn hanging_arms_are_lifted() {
        let skeleton = humanoid(true);
        let turned = motion(&[STANDS, ("left_elbow", [0.0, 0.0, FRAC_PI_2])], [0.0, 0.23, 0.87]);
        let (clip, report) = turned.clip(&skeleton, "c", &ClipOptions::default()).unwrap();
        assert!((report.arms_deg - 45.0).abs() < 0.01, "{}", report.arms_deg);
        // The upper arm is level, and the lower arm is bent up from that.
        close(place(&skeleton, &clip, "lower arm"), Vec3::new(0.5, 1.4, 0.0));
        close(place(&skeleton, &clip, "hand"), Vec3::new(0.5, 1.7, 0.0));
    }

    #[test]
    fn ways_are_as_long_as_legs_unless_they_are_kept() {
        let skeleton = humanoid(false);
        let mut tall = skeleton.joints().to_vec();
        for joint in &mut tall {
            joint.position = (Vec3::from(joint.position) * 2.0).into();
        }
        let tall = Skeleton::new(tall).unwrap();
        let places = [[0.3, -0.77, 0.87], [0.3, -1.27, 0.97]];
        let motion = frames(&[STANDS], &places);
        let hips = |options: &ClipOptions<'_>| {
            let (clip, report) = motion.clip(&tall, "c", options).unwrap();
            let rest = hips_at_rest(&tall);
            (clip.poses.iter().map(|pose| rest + Vec3::from(pose.translation)).collect(), report)
        };
        // As recorded: (0, -0.23, 0.03) and the place with Z up are these with Y up.
        let (kept, report): (Vec<Vec3>, _) = hips(&ClipOptions::default());
        assert_eq!((report.scale, report.grounding), (1.0, None));
        close(kept[0], Vec3::new(0.3, 0.9, 1.0));
        close(kept[1], Vec3::new(0.3, 1.0, 1.5));
        // From the place at rest on, twice as far. It has one foot, so heights are only scaled.
        let feet = ClipOptions { ground: Ground::Feet, ..ClipOptions::default() };
        let (scaled, report) = hips(&feet);
        assert!((report.scale - 2.0).abs() < 1e-6);
        close(scaled[0], Vec3::new(0.0, 1.8, 0.0));
        close(scaled[1], Vec3::new(0.0, 2.0, 1.0));
        // Where the performer is known, its own legs count.
        let performer = Some(Person { skeleton: &tall, soles: None });
        let (own, report) = hips(&ClipOptions { ground: Ground::Clip, performer, ..feet });
        assert!((report.scale - 1.0).abs() < 1e-6);
        close(own[1] - own[0], Vec3::new(0.0, 0.1, 0.5));
    }

    #[test]
    fn clips_begin_facing_the_front() {
        let skeleton = humanoid(false);
        let turned = Quat::from_rotation_z(2.0) * Quat::from_rotation_x(FRAC_PI_2);
        let motion = frames(
            &[("pelvis", turned.to_scaled_axis().into())],
            &[[0.0, 0.0, 0.87], [2.0_f32.sin(), -2.0_f32.cos(), 0.87]],
        );
        let options = ClipOptions { ground: Ground::Feet, ..ClipOptions::default() };
        let (clip, report) = motion.clip(&skeleton, "c", &options).unwrap();
        assert!((report.turned_deg + 2.0_f32.to_degrees()).abs() < 0.1, "{}", report.turned_deg);
        // A metre ahead is along +Z then.
        let way = Vec3::from(clip.poses[1].translation) - Vec3::from(clip.poses[0].translation);
        close(way, Vec3::Z * report.scale);
        close(
            place(&skeleton, &clip, "hips"),
            Vec3::new(0.0, 0.9, 0.0) * Vec3::new(1.0, report.scale, 1.0),
        );
    }
}
