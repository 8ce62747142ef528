//! The rig of the figure: joints, weights, and the T-pose.

mod hands;
pub(crate) mod head;
pub(crate) mod joints;
mod trunk;

use glam::{Mat3, Quat, Vec3 as Point};

use self::joints::{LEFT, RIGHT};
use super::arms::finger_joints;
use super::body_shape::ARM;
use super::head_shape::EYE_LEVEL;
use super::surface::{Kind, Part};
use super::{Figure, expressions, motion};
use crate::Avatar;
use crate::rig::{HumanBone, Pose, RigError, Skeleton, Skin};
use crate::vector::{Vec3, vec3};

const BONES: usize = HumanBone::ALL.len();

/// How far a vertex follows each bone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shares([f32; BONES]);

impl Default for Shares {
    fn default() -> Self {
        Self([0.0; BONES])
    }
}

impl Shares {
    fn all(bone: HumanBone) -> Self {
        let mut shares = Self::default();
        shares.add(bone, 1.0);
        shares
    }

    fn add(&mut self, bone: HumanBone, share: f32) {
        self.0[bone as usize] += share;
    }

    fn of(&self, bone: HumanBone) -> f32 {
        self.0[bone as usize]
    }

    /// Gives a fraction of one bone's share to another.
    fn pass(&mut self, from: HumanBone, to: HumanBone, fraction: f32) {
        let share = self.of(from) * fraction;
        self.add(from, -share);
        self.add(to, share);
    }
}

/// The shares of a point of a part, in world space, in centimetres.
fn shares(part: Part, p: Vec3, lower_lip: bool) -> Shares {
    let own = if p.x < 0.0 { RIGHT } else { LEFT };
    match part.kind {
        Kind::Eye => Shares::all(own.eye),
        Kind::Ear | Kind::Hair => Shares::all(HumanBone::Head),
        Kind::Shoe => {
            let mut shares = Shares::all(own.foot);
            let bent = crate::vector::smoothstep(
                joints::BALL.z - 2.6,
                joints::BALL.z + 2.6,
                p.z + 0.13 * (p.folded().x - joints::BALL.x),
            );
            shares.pass(own.foot, own.toes, bent);
            shares
        }
        Kind::Finger(number) => hands::finger(number, p),
        Kind::Arm => {
            let mut shares = trunk::shares(p);
            hands::palm(&mut shares, p);
            shares
        }
        Kind::Face => {
            let mut shares = trunk::shares(p);
            let jaw = head::jaw(p - vec3(0.0, EYE_LEVEL, 0.0), lower_lip);
            shares.pass(HumanBone::Head, HumanBone::Jaw, jaw);
            shares
        }
        Kind::Chest | Kind::Shirt | Kind::Sleeve | Kind::Leg => trunk::shares(p),
    }
}

impl Figure {
    /// The figure with a rig: all bones of VRM's humanoid by their names, in T-pose, with
    /// expressions and the clips `idle`, `wave` and `walk`.
    ///
    /// No vertex follows more than four joints. In the pose in which the figure was modelled, arms
    /// 40° down, the rig shows exactly its mesh.
    pub fn avatar(&self) -> Avatar {
        self.try_avatar().expect("the figure's own rig is sound")
    }

    fn try_avatar(&self) -> Result<Avatar, RigError> {
        let modelled = Skeleton::new(joints::joints())?;
        let (skin, _) = Skin::new(self.influences(), BONES)?.pruned(MOST_INFLUENCES);
        let motions = modelled.motions(&t_pose())?;
        let mut joints = modelled.joints().to_vec();
        for (joint, motion) in joints.iter_mut().zip(&motions) {
            joint.position = motion.point(joint.position);
        }
        let skeleton = Skeleton::new(joints)?;
        let back = skeleton.motions(&modelled_pose())?;
        let turns = skin.turns(&back);
        let shifts = skin.pose(&vec![[0.0; 3]; self.body.positions().len()], &back);
        // Blended motions shrink what is between two joints. Undoing them instead of doing them
        // makes the modelled pose, from which limbs then go either way, the one without loss.
        let undo = |((&position, turn), shift): ((&[f32; 3], &Mat3), [f32; 3])| {
            (turn.inverse() * (Point::from(position) - Point::from(shift))).into()
        };
        let positions = self.body.positions().iter().zip(&turns).zip(shifts).map(undo).collect();
        let mesh = self
            .body
            .clone()
            .with_positions(positions)
            .map_err(|_| RigError::NotFinite { what: "a vertex in T-pose".to_owned() })?;
        let morphs = expressions::morphs(self);
        let expressions = expressions::expressions(&morphs);
        let clips = motion::clips(&skeleton);
        let avatar = Avatar { mesh, skeleton, skin, morphs, expressions, clips };
        avatar.check()?;
        Ok(avatar)
    }

    fn influences(&self) -> Vec<Vec<(usize, f32)>> {
        let parts = self.parts_of_vertices();
        let lower_lip = self.in_lower_lip();
        let positions = self.body.positions().iter();
        positions
            .zip(parts)
            .zip(lower_lip)
            .map(|((&position, part), lower_lip)| {
                let shares = shares(part, Vec3::from(position) * 100.0, lower_lip);
                let kept = |&(_, share): &(usize, f32)| share > LEAST_SHARE;
                shares.0.into_iter().enumerate().filter(kept).collect()
            })
            .collect()
    }

    /// For each vertex of the body whether it is one of the lower lip's.
    pub(crate) fn in_lower_lip(&self) -> Vec<bool> {
        let mut lower_lip = vec![false; self.body.positions().len()];
        for &vertex in &self.lower_lip {
            lower_lip[vertex as usize] = true;
        }
        lower_lip
    }

    /// Which part each vertex of the body belongs to; where two meet, the one that comes first.
    pub(crate) fn parts_of_vertices(&self) -> Vec<Part> {
        let mut parts = vec![self.body_parts[0].part; self.body.positions().len()];
        for part in self.body_parts.iter().rev() {
            for face in &self.body.faces()[part.faces.clone()] {
                for &vertex in face {
                    parts[vertex as usize] = part.part;
                }
            }
        }
        parts
    }
}

const MOST_INFLUENCES: usize = 4;
/// Less than this moves nothing visibly.
const LEAST_SHARE: f32 = 1e-3;

/// How the modelled figure takes its T-pose.
fn t_pose() -> Pose {
    let mut pose = Pose::rest(BONES);
    // How far the arms are down, and the part of it that lifts the shoulders with them.
    let down = (-ARM.y).atan2(ARM.x);
    let lifted = 0.14;
    for limbs in [LEFT, RIGHT] {
        let mut turn = |bone: HumanBone, quat: Quat| pose.rotations[bone as usize] = quat.into();
        let z = |angle: f32| Quat::from_rotation_z(limbs.sign * angle);
        turn(limbs.shoulder, z(lifted));
        turn(limbs.upper_arm, z(down - lifted));
        // Fingers are straight, and stay spread as they are.
        for number in 1..5 {
            let joints =
                finger_joints(number).map(|p| if limbs.sign < 0.0 { p.mirrored() } else { p });
            let mut inner = Quat::IDENTITY;
            for k in 0..3 {
                let bone = Point::from(<[f32; 3]>::from(joints[k + 1] - joints[k]));
                let arm = Point::new(limbs.sign * ARM.x, ARM.y, 0.0);
                let straight = Point::new(0.0, 0.0, bone.z) + arm * bone.dot(arm);
                let outer = Quat::from_rotation_arc(bone.normalize(), straight.normalize());
                turn(limbs.fingers[number][k], inner.inverse() * outer);
                inner = outer;
            }
        }
    }
    pose
}

/// How the figure takes from its T-pose the pose in which it was modelled.
fn modelled_pose() -> Pose {
    let forward = t_pose();
    let joints = joints::joints();
    let mut world: Vec<Quat> = Vec::with_capacity(joints.len());
    for (joint, &rotation) in joints.iter().zip(&forward.rotations) {
        let parent = joint.parent.map_or(Quat::IDENTITY, |parent| world[parent]);
        world.push(parent * Quat::from_array(rotation));
    }
    // The world rotations from T are the inverse ones; local ones are relative to the parent's.
    let local = joints.iter().zip(&world).map(|(joint, turned)| {
        let parent = joint.parent.map_or(Quat::IDENTITY, |parent| world[parent]);
        (parent * turned.inverse()).normalize().into()
    });
    Pose { translation: [0.0; 3], rotations: local.collect() }
}
