//! The rig of the figure: joints, skin weights and the T-pose.

mod hands;
pub(crate) mod head;
pub(crate) mod joints;
#[cfg(test)]
mod poses_tests;
mod trunk;

use glam::{Mat3, Quat, Vec3, vec3};
use uvgraft::easing::smoothstep;
use uvgraft_avatar::Avatar;
use uvgraft_avatar::face;
use uvgraft_avatar::rig::{
    Expression, ExpressionPreset, HumanBone, Pose, RigError, Skeleton, Skin,
};

use self::joints::{LEFT, RIGHT};
use super::arms::finger_joints;
use super::body_shape::ARM;
use super::head_shape::EYE_LEVEL;
use super::surface::{BodyPart, PartKind};
use super::{Figure, expressions, motion};
use crate::symmetry::Symmetry as _;

const BONES: usize = HumanBone::ALL.len();

/// Skin weights of a vertex, one for each bone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Weights([f32; BONES]);

impl Default for Weights {
    fn default() -> Self {
        Self([0.0; BONES])
    }
}

impl Weights {
    fn all(bone: HumanBone) -> Self {
        let mut weights = Self::default();
        weights.add(bone, 1.0);
        weights
    }

    fn add(&mut self, bone: HumanBone, weight: f32) {
        self.0[bone as usize] += weight;
    }

    fn of(&self, bone: HumanBone) -> f32 {
        self.0[bone as usize]
    }

    /// Moves a fraction of one bone's weight to another.
    fn pass(&mut self, from: HumanBone, to: HumanBone, fraction: f32) {
        let weight = self.of(from) * fraction;
        self.add(from, -weight);
        self.add(to, weight);
    }
}

/// The weights of a point of a part, in world space, in centimetres.
fn weights(part: BodyPart, p: Vec3, lip: Option<f32>) -> Weights {
    let own = if p.x < 0.0 { RIGHT } else { LEFT };
    match part.kind {
        PartKind::Eye => Weights::all(own.eye),
        PartKind::Ear | PartKind::Hair => Weights::all(HumanBone::Head),
        PartKind::Shoe => {
            let mut weights = Weights::all(own.foot);
            let bent = smoothstep(
                joints::BALL.z - 2.6,
                joints::BALL.z + 2.6,
                p.z + 0.13 * (p.folded().x - joints::BALL.x),
            );
            weights.pass(own.foot, own.toes, bent);
            weights
        }
        PartKind::Finger(number) => hands::finger(number, p),
        PartKind::Arm => {
            let mut weights = trunk::weights(part.kind, p);
            hands::palm(&mut weights, p);
            weights
        }
        PartKind::Face => {
            let mut weights = trunk::weights(part.kind, p);
            let jaw = head::jaw(p - vec3(0.0, EYE_LEVEL, 0.0), lip);
            weights.pass(HumanBone::Head, HumanBone::Jaw, jaw);
            weights
        }
        PartKind::Chest | PartKind::Shirt | PartKind::Sleeve | PartKind::Leg => {
            trunk::weights(part.kind, p)
        }
    }
}

impl Figure {
    /// The rigged figure: all bones of VRM's humanoid by name, in T-pose, with expressions and the
    /// clips `idle`, `wave` and `walk`.
    ///
    /// No vertex has more than four influences. In the pose in which the figure was modelled, arms
    /// 40° down, the skinned mesh equals the modelled one.
    pub fn avatar(&self) -> Avatar {
        self.try_avatar().expect("the figure's own rig is sound")
    }

    fn try_avatar(&self) -> Result<Avatar, RigError> {
        let modelled = Skeleton::new(joints::joints())?;
        let (skin, _) = Skin::new(self.influences(), BONES)?.pruned(MAX_INFLUENCES);
        let motions = modelled.motions(&t_pose())?;
        let mut joints = modelled.joints().to_vec();
        for (joint, motion) in joints.iter_mut().zip(&motions) {
            joint.position = motion.point(joint.position);
        }
        let skeleton = Skeleton::new(joints)?;
        let back = skeleton.motions(&modelled_pose())?;
        let turns = skin.turns(&back);
        let shifts = skin.pose(&vec![[0.0; 3]; self.body.positions().len()], &back);
        // Linear blend skinning shrinks the surface between two joints. The T-pose mesh is
        // therefore computed by inverting the skinning to the modelled pose, not by
        // skinning into the T-pose: this makes the modelled pose, from which limbs bend
        // either way, the exact one.
        let undo = |((&position, turn), shift): ((&[f32; 3], &Mat3), [f32; 3])| {
            (turn.inverse() * (Vec3::from(position) - Vec3::from(shift))).into()
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
        let materials = Vec::new();
        let mut avatar = Avatar { mesh, materials, skeleton, skin, morphs, expressions, clips };
        face::add_gaze(&mut avatar);
        avatar.expressions.push(Expression::preset(ExpressionPreset::Neutral, Vec::new()));
        avatar.check()?;
        Ok(avatar)
    }

    fn influences(&self) -> Vec<Vec<(usize, f32)>> {
        let parts = self.parts_of_vertices();
        let lips = self.lips_of_vertices();
        let positions = self.body.positions().iter();
        positions
            .zip(parts)
            .zip(lips)
            .map(|((&position, part), lip)| {
                let weights = weights(part, Vec3::from(position) * 100.0, lip);
                let kept = |&(_, weight): &(usize, f32)| weight > MIN_WEIGHT;
                weights.0.into_iter().enumerate().filter(kept).collect()
            })
            .collect()
    }

    /// For each vertex of the body, its coordinate along the lips; see [`Figure::lips`].
    pub(crate) fn lips_of_vertices(&self) -> Vec<Option<f32>> {
        let mut lips = vec![None; self.body.positions().len()];
        for &(vertex, along) in &self.lips {
            lips[vertex as usize] = Some(along);
        }
        lips
    }

    /// The part of each body vertex; where two parts meet, the first one.
    pub(crate) fn parts_of_vertices(&self) -> Vec<BodyPart> {
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

const MAX_INFLUENCES: usize = 4;
/// Smaller weights have no visible effect.
const MIN_WEIGHT: f32 = 1e-3;

/// Rotations from the modelled pose to the T-pose.
fn t_pose() -> Pose {
    let mut pose = Pose::rest(BONES);
    // The angle by which the arms are down, and the part of it by which the shoulders
    // rise with them.
    let down = (-ARM.y).atan2(ARM.x);
    let lifted = 0.14;
    for limbs in [LEFT, RIGHT] {
        let mut turn = |bone: HumanBone, quat: Quat| pose.rotations[bone as usize] = quat.into();
        let z = |angle: f32| Quat::from_rotation_z(limbs.sign * angle);
        turn(limbs.shoulder, z(lifted));
        turn(limbs.upper_arm, z(down - lifted));
        // Fingers are straightened, but stay spread.
        for number in 1..5 {
            let joints =
                finger_joints(number).map(|p| if limbs.sign < 0.0 { p.mirrored() } else { p });
            let mut inner = Quat::IDENTITY;
            for k in 0..3 {
                let bone = joints[k + 1] - joints[k];
                let arm = Vec3::new(limbs.sign * ARM.x, ARM.y, 0.0);
                let straight = Vec3::new(0.0, 0.0, bone.z) + arm * bone.dot(arm);
                let outer = Quat::from_rotation_arc(bone.normalize(), straight.normalize());
                turn(limbs.fingers[number][k], inner.inverse() * outer);
                inner = outer;
            }
        }
    }
    pose
}

/// Rotations from the T-pose back to the modelled pose.
fn modelled_pose() -> Pose {
    let forward = t_pose();
    let joints = joints::joints();
    let mut world: Vec<Quat> = Vec::with_capacity(joints.len());
    for (joint, &rotation) in joints.iter().zip(&forward.rotations) {
        let parent = joint.parent.map_or(Quat::IDENTITY, |parent| world[parent]);
        world.push(parent * Quat::from_array(rotation));
    }
    // World rotations from the T-pose are the inverse ones; local ones are relative to the parent.
    let local = joints.iter().zip(&world).map(|(joint, turned)| {
        let parent = joint.parent.map_or(Quat::IDENTITY, |parent| world[parent]);
        (parent * turned.inverse()).normalize().into()
    });
    Pose { translation: [0.0; 3], rotations: local.collect() }
}

#[cfg(test)]
mod tests {
    use super::super::surface::Side;
    use super::*;

    #[test]
    fn has_all_bones_with_the_right_parents() {
        let avatar = Figure::new().avatar();
        let joints = avatar.skeleton.joints();
        assert_eq!(joints.len(), HumanBone::ALL.len());
        let parent = |name: &str| {
            let joint = avatar.skeleton.human(HumanBone::named(name).unwrap()).unwrap();
            joints[joint].parent.map(|parent| joints[parent].name.as_str())
        };
        for (names, wanted) in [
            ("hips", None),
            ("spine leftUpperLeg rightUpperLeg", Some("hips")),
            ("chest", Some("spine")),
            ("upperChest", Some("chest")),
            ("neck leftShoulder rightShoulder", Some("upperChest")),
            ("head", Some("neck")),
            ("leftEye rightEye jaw", Some("head")),
            ("leftLowerLeg", Some("leftUpperLeg")),
            ("rightFoot", Some("rightLowerLeg")),
            ("leftToes", Some("leftFoot")),
            ("rightUpperArm", Some("rightShoulder")),
            ("leftLowerArm", Some("leftUpperArm")),
            ("leftHand", Some("leftLowerArm")),
            ("leftThumbMetacarpal leftIndexProximal leftLittleProximal", Some("leftHand")),
            ("leftThumbProximal", Some("leftThumbMetacarpal")),
            ("rightRingIntermediate", Some("rightRingProximal")),
            ("rightMiddleDistal", Some("rightMiddleIntermediate")),
        ] {
            for name in names.split(' ') {
                assert_eq!(parent(name), wanted, "{name}");
            }
        }
    }

    #[test]
    fn stands_in_a_t() {
        let avatar = Figure::new().avatar();
        let place = |bone| Vec3::from(avatar.skeleton.joints()[bone as usize].position);
        for limbs in [LEFT, RIGHT] {
            for (from, to) in [
                (limbs.upper_arm, limbs.lower_arm),
                (limbs.lower_arm, limbs.hand),
                (limbs.fingers[2][0], limbs.fingers[2][1]),
                (limbs.fingers[2][1], limbs.fingers[2][2]),
            ] {
                let along = (place(to) - place(from)).normalize();
                let off = along.angle_between(Vec3::X * limbs.sign).to_degrees();
                // Fingers are slightly spread, in the plane of the hand.
                let most = if to == limbs.lower_arm || to == limbs.hand { 0.1 } else { 2.5 };
                assert!(off < most && along.y.abs() < 0.01, "{} is {off} deg off", from.name());
            }
            // Palms face down if thumbs are in front.
            assert!(place(limbs.fingers[0][2]).z > place(limbs.hand).z + 0.03);
        }
        let lowest = avatar.mesh.positions().iter().map(|p| p[1]).fold(f32::INFINITY, f32::min);
        assert!(lowest.abs() < 1e-3, "{lowest}");
    }

    #[test]
    fn the_modelled_pose_shows_the_modelled_mesh() {
        let figure = Figure::new();
        let avatar = figure.avatar();
        let posed = avatar.posed(&modelled_pose(), &[]).unwrap();
        for (vertex, (&found, &wanted)) in posed.iter().zip(figure.body.positions()).enumerate() {
            // Inverting and reapplying in f32 costs a few micrometres.
            let off = Vec3::from(found).distance(Vec3::from(wanted));
            assert!(off < 2e-5, "vertex {vertex} is {off} m off");
        }
    }

    #[test]
    fn weights_change_gently_and_sum_to_one() {
        /// Weights change fastest in the corners of the mouth and between the thighs, where one
        /// surface touches another that it must not follow.
        const STEEPEST_PER_CM: f32 = 2.5;
        const PRUNED: f32 = 0.02;
        let figure = Figure::new();
        let skin = figure.avatar().skin;
        assert!((0..skin.vertices()).all(|vertex| skin.of(vertex).len() <= MAX_INFLUENCES));
        let dense = |vertex: u32| {
            let mut dense = [0.0_f32; BONES];
            for &(joint, weight) in skin.of(vertex as usize) {
                dense[usize::from(joint)] = weight;
            }
            assert!((dense.iter().sum::<f32>() - 1.0).abs() < 1e-5, "vertex {vertex}");
            dense
        };
        let place = |vertex: u32| Vec3::from(figure.body.positions()[vertex as usize]) * 100.0;
        for face in figure.body.faces() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                let length = place(a).distance(place(b));
                let differing = dense(a).into_iter().zip(dense(b)).map(|(a, b)| (a - b).abs());
                let most = differing.fold(0.0, f32::max);
                assert!(
                    most <= STEEPEST_PER_CM * length + PRUNED,
                    "{most} over {length} cm at {}",
                    place(a)
                );
            }
        }
    }

    #[test]
    fn pruning_to_four_joints_is_nearly_lossless() {
        let (_, pruning) =
            Skin::new(Figure::new().influences(), BONES).unwrap().pruned(MAX_INFLUENCES);
        assert!(pruning.most < 0.06 && pruning.mean < 1e-3, "{pruning:?}");
    }

    #[test]
    fn eyes_hair_and_skull_are_rigid() {
        let figure = Figure::new();
        let skin = figure.avatar().skin;
        let parts = figure.parts_of_vertices();
        let mut skull = 0;
        for (vertex, part) in parts.iter().enumerate() {
            let height_cm = figure.body.positions()[vertex][1] * 100.0 - EYE_LEVEL;
            let wanted = match (part.kind, part.side) {
                (PartKind::Eye, Side::Left) => HumanBone::LeftEye,
                (PartKind::Eye, _) => HumanBone::RightEye,
                (PartKind::Ear | PartKind::Hair, _) => HumanBone::Head,
                (PartKind::Face, _) if height_cm > -2.0 => HumanBone::Head,
                _ => continue,
            };
            skull += usize::from(part.kind == PartKind::Face);
            assert_eq!(skin.of(vertex), [(wanted as u16, 1.0)], "vertex {vertex}, {part:?}");
        }
        assert!(skull > 1000);
    }

    #[test]
    fn weights_and_joints_are_symmetric() {
        let figure = Figure::new();
        let parts = figure.parts_of_vertices();
        let mut opposite: [usize; BONES] = std::array::from_fn(|bone| bone);
        for (number, bone) in HumanBone::ALL.iter().enumerate() {
            if let Some(rest) = bone.name().strip_prefix("left") {
                let other = HumanBone::named(&format!("right{rest}")).unwrap() as usize;
                (opposite[number], opposite[other]) = (other, number);
            }
        }
        for (&position, part) in figure.body.positions().iter().zip(parts) {
            let p = Vec3::from(position) * 100.0;
            // On the symmetry plane the side is ambiguous.
            if p.x == 0.0 {
                continue;
            }
            let (here, there) = (weights(part, p, None), weights(part, p.mirrored(), None));
            for bone in 0..BONES {
                assert!((here.0[bone] - there.0[opposite[bone]]).abs() < 1e-4, "{part:?} {p:?}");
            }
        }
        let joints = figure.avatar().skeleton.joints().to_vec();
        for (number, joint) in joints.iter().enumerate() {
            let other = Vec3::from(joints[opposite[number]].position).mirrored();
            assert!((Vec3::from(joint.position) - other).length() < 1e-4, "{}", joint.name);
        }
    }

    #[test]
    fn is_the_same_every_time() {
        let (one, other) = (Figure::new().avatar(), Figure::new().avatar());
        assert_eq!(one.mesh, other.mesh);
        assert_eq!((one.skin, one.morphs, one.clips), (other.skin, other.morphs, other.clips));
    }
}
