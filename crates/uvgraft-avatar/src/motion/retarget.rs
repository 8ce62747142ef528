//! Brings a motion onto a skeleton.
//!
//! At rest the bodies of the SMPL family stand in a T and their joints are aligned with the world,
//! so a rotation means the same on any skeleton that is at rest like that: joints are found by the
//! bones that they are, and turn as the motion's do. Where a skeleton has no joint for one of the
//! motion's, its rotation is handed on to what hangs on it. Arms that hang lower at rest are
//! lifted first, by the shortest rotation that takes them to where the family's are.

use glam::{Quat, Vec3};

use super::resample::{self, Frame};
use super::{Motion, MotionError};
use crate::rig::{Clip, HumanBone, Pose, RigError, Skeleton};

/// How a motion becomes a clip.
#[derive(Debug, Clone, Copy)]
pub struct ClipOptions<'a> {
    /// Frames a second, at most the motion's own; nothing keeps all frames.
    pub fps: Option<f64>,
    /// Where the clip begins in the motion, in seconds.
    pub start_s: f64,
    /// How long it is at most, in seconds.
    pub seconds: Option<f64>,
    /// Puts the lowest joint of all frames as high above 0 as it is at rest, or 2 cm where the
    /// skeleton does not stand on 0 at rest. AMASS's ground is near 0 in most recordings, not in all.
    pub ground: bool,
    /// The skeleton of the person who moved, where it is known: a model with the motion's
    /// [`betas`](Motion::betas). Without it, a body of the family is taken to be that person, and
    /// others are set beside the family's mean body.
    pub performer: Option<&'a Skeleton>,
}

impl Default for ClipOptions<'_> {
    /// 30 frames a second, all of the motion, where it was recorded.
    fn default() -> Self {
        Self { fps: Some(30.0), start_s: 0.0, seconds: None, ground: false, performer: None }
    }
}

/// What became of a motion on a skeleton.
#[derive(Debug, Clone, PartialEq)]
pub struct Retarget {
    /// Joints of the motion that the skeleton lacks; those between others hand their rotations on.
    pub missing: Vec<&'static str>,
    /// Joints of the skeleton that the motion has not: they stay as at rest.
    pub still: Vec<String>,
    /// What translations were multiplied by: the ratio of leg lengths.
    pub scale: f32,
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
/// How high a skeleton's lowest joint may be above 0 for it to stand there.
const STANDS_M: f32 = 0.3;
/// How far the lowest joint is above the ground where the rest pose does not tell.
const SOLE_M: f32 = 0.02;

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
        let own = if family { Some(skeleton) } else { None };
        let (pelvis, scale) = match options.performer.or(own) {
            Some(performer) => (
                Vec3::from(performer.joints()[hips(performer)].position),
                ratio(leg_m(skeleton), leg_m(performer)),
            ),
            None => (MEAN_PELVIS, ratio(leg_m(skeleton), Some(MEAN_LEG_M))),
        };
        let rest = Vec3::from(skeleton.joints()[hips(skeleton)].position);
        let upright = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
        let mut clip = Clip { name: name.to_owned(), times: Vec::new(), poses: Vec::new() };
        for mut frame in resample::frames(self, options)? {
            // The root turns about the pelvis, which is beside the origin that is translated.
            let place = turned_upright(pelvis + frame.place) * scale;
            frame.turns[0] = (upright * frame.turns[0]).normalize();
            let rotations = self.rotations(&frame, &turns);
            clip.times.push(frame.time_s);
            clip.poses.push(Pose { translation: (place - rest).into(), rotations });
        }
        if options.ground {
            ground(&mut clip, skeleton)?;
        }
        clip.check(skeleton.joints().len())?;
        let found = |source: usize| sources.contains(&Some(source));
        let joints = self.joints().iter().enumerate();
        let missing =
            joints.filter(|&(source, _)| !found(source)).map(|(_, &(name, _, _))| name).collect();
        let joints = skeleton.joints().iter().zip(&sources);
        let still =
            joints.filter(|(_, source)| source.is_none()).map(|(joint, _)| joint.name.clone());
        let angle = |lift: &Quat| lift.angle_between(Quat::IDENTITY).to_degrees();
        let arms_deg = lifts.iter().map(angle).fold(0.0, f32::max);
        Ok((clip, Retarget { missing, still: still.collect(), scale, arms_deg }))
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

/// From Z up to Y up: -90° about x.
fn turned_upright(point: Vec3) -> Vec3 {
    Vec3::new(point.x, point.z, -point.y)
}

/// The number of the hips, which were checked to be there.
fn hips(skeleton: &Skeleton) -> usize {
    skeleton.human(HumanBone::Hips).unwrap_or(0)
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

/// Moves all frames up or down, so that the lowest joint of all is where it is at rest.
fn ground(clip: &mut Clip, skeleton: &Skeleton) -> Result<(), RigError> {
    let heights = |pose: &Pose| -> Result<f32, RigError> {
        let joints = skeleton.joints().iter().zip(skeleton.motions(pose)?);
        Ok(joints.map(|(joint, motion)| motion.point(joint.position)[1]).fold(f32::MAX, f32::min))
    };
    let rest = heights(&Pose::rest(skeleton.joints().len()))?;
    let wanted = if (0.0..STANDS_M).contains(&rest) { rest } else { SOLE_M };
    let mut lowest = f32::MAX;
    for pose in &clip.poses {
        lowest = lowest.min(heights(pose)?);
    }
    for pose in &mut clip.poses {
        pose.translation[1] += wanted - lowest;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use uvgraft_io::arrays::{NamedArrays, NumericArray};

    use super::*;
    use crate::rig::Joint;

    /// A motion of one frame: the turns of some of the body's joints, and the translation, Z up.
    fn motion(turns: &[(&str, [f32; 3])], place: [f32; 3]) -> Motion {
        let mut poses = vec![0.0; 66];
        for (name, turn) in turns {
            let joint = crate::body::BODY.iter().position(|entry| entry.0 == *name).unwrap();
            poses[3 * joint..][..3].copy_from_slice(turn);
        }
        let mut arrays = NamedArrays::new();
        arrays.insert("poses", NumericArray::new_f32(vec![1, 66], poses).unwrap());
        arrays.insert("trans", NumericArray::new_f32(vec![1, 3], place.to_vec()).unwrap());
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
    fn ways_are_as_long_as_legs_and_end_on_the_ground() {
        let skeleton = humanoid(false);
        let mut tall = skeleton.joints().to_vec();
        for joint in &mut tall {
            joint.position = (Vec3::from(joint.position) * 2.0).into();
        }
        let tall = Skeleton::new(tall).unwrap();
        let motion = motion(&[STANDS], [0.3, -0.77, 0.87]);
        let options = ClipOptions::default();
        let (clip, report) = motion.clip(&tall, "c", &options).unwrap();
        assert!((report.scale - 2.0).abs() < 1e-6);
        close(place(&tall, &clip, "hips"), Vec3::new(0.6, 1.8, 2.0));
        // Where the performer is known, its own pelvis counts.
        let options = ClipOptions { performer: Some(&skeleton), ..options };
        let (clip, report) = motion.clip(&tall, "c", &options).unwrap();
        assert!((report.scale - 2.0).abs() < 1e-6);
        // (0, 0.9, 0) + (0.3, -0.77, 0.87) with Z up is (0.3, 0.87, -0.13) with Y up.
        close(place(&tall, &clip, "hips"), Vec3::new(0.6, 1.74, -0.26));
        // The root is at 0 at rest, and the lowest joint, so it is there again.
        let options = ClipOptions { ground: true, ..options };
        let (clip, _) = motion.clip(&tall, "c", &options).unwrap();
        close(place(&tall, &clip, "hips"), Vec3::new(0.6, 1.8, -0.26));
    }
}
