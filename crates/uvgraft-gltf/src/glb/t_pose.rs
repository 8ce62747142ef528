//! VRM's T-pose: arms, hands and fingers straight out to the sides with the palms down, thumbs
//! half-way to the front, feet straight ahead on the floor.
//!
//! The file's nodes are in this pose while the skin stays bound to the mesh's rest pose, so a clip
//! gives bit-identical vertices in a VRM and a GLB file: nothing is skinned twice.
//!
//! Source: VRM Consortium, "VRMC_vrm-1.0", `tpose.md`: definitions 1.2 to 1.8. The roll
//! of the thumbs about their own axes is left unchanged: rolling them as specified turns
//! the ball of the thumb inside out.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::{Quat, Vec3};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{HumanBone, Pose, RigError, Skeleton};

/// The left arm's bones from the shoulder out, each with the bone at its end.
const ARM: [(HumanBone, HumanBone); 3] = {
    use HumanBone as Bone;
    [
        (Bone::LeftUpperArm, Bone::LeftLowerArm),
        (Bone::LeftLowerArm, Bone::LeftHand),
        (Bone::LeftHand, Bone::LeftMiddleProximal),
    ]
};
/// The left hand's fingers from the thumb on, each from the hand outwards.
const FINGERS: [[HumanBone; 3]; 5] = {
    use HumanBone as Bone;
    [
        [Bone::LeftThumbMetacarpal, Bone::LeftThumbProximal, Bone::LeftThumbDistal],
        [Bone::LeftIndexProximal, Bone::LeftIndexIntermediate, Bone::LeftIndexDistal],
        [Bone::LeftMiddleProximal, Bone::LeftMiddleIntermediate, Bone::LeftMiddleDistal],
        [Bone::LeftRingProximal, Bone::LeftRingIntermediate, Bone::LeftRingDistal],
        [Bone::LeftLittleProximal, Bone::LeftLittleIntermediate, Bone::LeftLittleDistal],
    ]
};
/// Rotations below this are ignored, in radians: a hundredth of a degree.
const STILL: f32 = 2e-4;
/// Feet that point farther outwards than this are not aligned, since nobody stands like that, in
/// radians.
const MAX_SPLAY: f32 = 0.8;
/// A vertex belongs to a joint if its weight there is above this.
const OWN: f32 = 0.5;

/// World directions that bones should point in, for the bones that need one.
struct Aims<'a> {
    skeleton: &'a Skeleton,
    /// For each joint, the direction of its bone at rest and the target direction.
    bones: Vec<Option<(Vec3, Vec3)>>,
    /// For each joint, a rest-pose direction to turn to the front as far as a roll about the bone
    /// allows.
    fronts: Vec<Option<Vec3>>,
}

/// The pose that turns an avatar's rest pose into VRM's T-pose; `None` if it is already
/// in one, or has no arms. Legs are unchanged except for the feet, and the height of
/// the lowest vertex is preserved.
///
/// # Errors
/// [`RigError`] if the avatar's parts are inconsistent.
pub fn t_pose(avatar: &Avatar) -> Result<Option<Pose>, RigError> {
    let joints = avatar.skeleton.joints();
    let none = || vec![None; joints.len()];
    let mut aims =
        Aims { skeleton: &avatar.skeleton, bones: none(), fronts: vec![None; joints.len()] };
    for right in [false, true] {
        aims.arm(avatar, right);
        aims.foot(avatar, right);
    }
    let mut pose = aims.pose();
    let rests = |turn: &[f32; 4]| Quat::from_array(*turn).angle_between(Quat::IDENTITY) < STILL;
    if pose.rotations.iter().all(rests) {
        return Ok(None);
    }
    // Rotating a foot can lift it off the floor if its sole is not level.
    let before = avatar.lowest(avatar.mesh.positions());
    let after = avatar.lowest(&avatar.posed(&pose, &[])?);
    if let (Some(before), Some(after)) = (before, after) {
        pose.translation[1] = before - after;
    }
    Ok(Some(pose))
}

impl Aims<'_> {
    fn joint(&self, bone: HumanBone, right: bool) -> Option<usize> {
        let bone = if right { bone.mirrored() } else { bone };
        self.skeleton.human(bone)
    }

    fn origin(&self, joint: usize) -> Vec3 {
        self.skeleton.joints()[joint].position.into()
    }

    fn aim(&mut self, joint: usize, end: Vec3, to: Vec3) {
        if let Some(along) = (end - self.origin(joint)).try_normalize() {
            self.bones[joint] = Some((along, to));
        }
    }

    fn arm(&mut self, avatar: &Avatar, right: bool) {
        let out = if right { Vec3::NEG_X } else { Vec3::X };
        for (bone, end) in ARM {
            let (Some(bone), Some(end)) = (self.joint(bone, right), self.joint(end, right)) else {
                continue;
            };
            self.aim(bone, self.origin(end), out);
        }
        // The palm faces down if the index finger is in front of the little finger.
        let knuckle =
            |aims: &Self, finger: usize| Some(aims.origin(aims.joint(FINGERS[finger][0], right)?));
        if let (Some(hand), Some(index), Some(little)) =
            (self.joint(HumanBone::LeftHand, right), knuckle(self, 1), knuckle(self, 4))
        {
            self.fronts[hand] = Some(index - little);
        }
        let aside = Vec3::new(out.x * FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2);
        for (number, finger) in FINGERS.iter().enumerate() {
            let to = if number == 0 { aside } else { out };
            for place in 0..finger.len() {
                let Some(joint) = self.joint(finger[place], right) else { continue };
                let next = finger.get(place + 1).and_then(|&next| self.joint(next, right));
                let end = next.map(|next| self.origin(next)).or_else(|| center(avatar, joint));
                if let Some(end) = end {
                    self.aim(joint, end, to);
                }
            }
        }
    }

    /// Rotates a foot about the vertical axis, which keeps its sole on the floor.
    fn foot(&mut self, avatar: &Avatar, right: bool) {
        let Some(foot) = self.joint(HumanBone::LeftFoot, right) else { return };
        let toes = self.joint(HumanBone::LeftToes, right);
        let Some(ahead) = length_of_foot(avatar, foot, toes) else { return };
        if ahead.angle_between(Vec3::Z) < MAX_SPLAY {
            self.bones[foot] = Some((ahead, Vec3::Z));
        }
    }

    /// Solves for the joint rotations, parents first. With `above` the parent's world rotation, a
    /// joint gets `world = arc(above · along, to) · above`, then a roll about `to` that brings its
    /// front direction as close to +Z as possible; its local rotation is `above⁻¹ · world`.
    fn pose(&self) -> Pose {
        let joints = self.skeleton.joints();
        let mut pose = Pose::rest(joints.len());
        let mut world = vec![Quat::IDENTITY; joints.len()];
        for (index, joint) in joints.iter().enumerate() {
            let above = joint.parent.map_or(Quat::IDENTITY, |parent| world[parent]);
            world[index] = above;
            if let Some((along, to)) = self.bones[index] {
                // The shortest arc from where the parent's rotation leaves the bone, so that
                // nothing twists.
                world[index] = (Quat::from_rotation_arc(above * along, to) * above).normalize();
                if let Some(front) = self.fronts[index] {
                    let front = (world[index] * front).reject_from_normalized(to);
                    if let Some(front) = front.try_normalize() {
                        let turn = Quat::from_rotation_arc(front, Vec3::Z);
                        world[index] = (turn * world[index]).normalize();
                    }
                }
            }
            let local = (above.inverse() * world[index]).normalize();
            if local.angle_between(Quat::IDENTITY) >= STILL {
                pose.rotations[index] = local.into();
            } else {
                world[index] = above;
            }
        }
        pose
    }
}

/// The centroid of the vertices that follow a joint more than all others together.
fn center(avatar: &Avatar, joint: usize) -> Option<Vec3> {
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for (vertex, &place) in avatar.mesh.positions().iter().enumerate() {
        let follows = |&(found, weight): &(u16, f32)| usize::from(found) == joint && weight > OWN;
        if avatar.skin.of(vertex).iter().any(follows) {
            sum += Vec3::from(place);
            count += 1.0;
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// The horizontal direction of a foot: the principal axis of its vertices in the XZ plane.
fn length_of_foot(avatar: &Avatar, foot: usize, toes: Option<usize>) -> Option<Vec3> {
    let mut places = Vec::new();
    for (vertex, &[x, _, z]) in avatar.mesh.positions().iter().enumerate() {
        let own = |&&(joint, _): &&(u16, f32)| {
            usize::from(joint) == foot || Some(usize::from(joint)) == toes
        };
        let share: f32 = avatar.skin.of(vertex).iter().filter(own).map(|&(_, weight)| weight).sum();
        if share > OWN {
            places.push([x, z]);
        }
    }
    if places.len() < 3 {
        return None;
    }
    let count = places.len() as f32;
    let mean: [f32; 2] =
        std::array::from_fn(|axis| places.iter().map(|place| place[axis]).sum::<f32>() / count);
    let [mut xx, mut xz, mut zz] = [0.0_f32; 3];
    for [x, z] in places {
        let (x, z) = (x - mean[0], z - mean[1]);
        (xx, xz, zz) = (xx + x * x, xz + x * z, zz + z * z);
    }
    // The principal axis of a symmetric 2 × 2 matrix, here the covariance.
    let angle = 0.5 * (2.0 * xz).atan2(zz - xx);
    Some(Vec3::new(angle.sin(), 0.0, angle.cos()))
}

#[cfg(test)]
mod tests {
    use uvgraft::Mesh;
    use uvgraft_avatar::rig::{Joint, Skin};
    use uvgraft_figure::Figure;

    use super::*;

    /// An avatar that is only a left arm, with a placeholder mesh.
    fn left_arm(elbow: [f32; 3], hand: [f32; 3]) -> Avatar {
        let joint = |name: &str, parent, position, human| Joint {
            name: name.to_owned(),
            parent,
            position,
            human,
        };
        let joints = vec![
            joint("root", None, [0.0; 3], None),
            joint("a", Some(0), [0.2, 1.4, 0.0], Some(HumanBone::LeftUpperArm)),
            joint("b", Some(1), elbow, Some(HumanBone::LeftLowerArm)),
            joint("c", Some(2), hand, Some(HumanBone::LeftHand)),
        ];
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let uv = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
        Avatar {
            mesh: Mesh::from_triangles(positions, uv, &[[0, 1, 2]], &[[0, 1, 2]]).unwrap(),
            skeleton: Skeleton::new(joints).unwrap(),
            skin: Skin::new([[(0, 1.0)], [(0, 1.0)], [(0, 1.0)]], 4).unwrap(),
            morphs: Vec::new(),
            expressions: Vec::new(),
            materials: Vec::new(),
            clips: Vec::new(),
        }
    }

    #[test]
    fn bent_arms_become_straight() {
        // Down to the elbow at 45°, then forwards.
        let avatar = left_arm([0.4, 1.2, 0.0], [0.4, 1.2, 0.3]);
        let pose = t_pose(&avatar).unwrap().unwrap();
        let motions = avatar.skeleton.motions(&pose).unwrap();
        let length = 0.08_f32.sqrt();
        for (joint, wanted) in [(2, [0.2 + length, 1.4, 0.0]), (3, [0.5 + length, 1.4, 0.0])] {
            let found = motions[joint].point(avatar.skeleton.joints()[joint].position);
            assert!(Vec3::from(found).abs_diff_eq(wanted.into(), 1e-6), "{found:?}");
        }
    }

    #[test]
    fn a_t_pose_is_left_unchanged() {
        let avatar = left_arm([0.5, 1.4, 0.0], [0.8, 1.4, 0.0]);
        assert_eq!(t_pose(&avatar).unwrap(), None);
        // A deviation of a few degrees is corrected, since that costs nothing in the file.
        let avatar = left_arm([0.5, 1.38, 0.0], [0.8, 1.38, 0.0]);
        assert!(t_pose(&avatar).unwrap().is_some());
    }

    #[test]
    fn hands_lie_flat_with_thumbs_to_the_front() {
        let mut avatar = Figure::new().avatar();
        // Bent fingers, rotated hands and splayed feet.
        let mut rest = Pose::rest(avatar.skeleton.joints().len());
        for right in [false, true] {
            let side = if right { -1.0 } else { 1.0 };
            let mut turn = |bone: HumanBone, axis: Vec3| {
                let bone = if right { bone.mirrored() } else { bone };
                let joint = avatar.skeleton.human(bone).unwrap();
                rest.rotations[joint] = Quat::from_scaled_axis(axis).into();
            };
            turn(HumanBone::LeftHand, Vec3::new(0.4, 0.1 * side, -0.2 * side));
            turn(HumanBone::LeftFoot, Vec3::new(0.0, 0.3 * side, 0.0));
            for finger in FINGERS {
                finger.into_iter().for_each(|bone| turn(bone, Vec3::new(0.1, 0.0, -0.3 * side)));
            }
        }
        let posed = avatar.posed(&rest, &[]).unwrap();
        avatar.mesh = avatar.mesh.with_positions(posed).unwrap();
        let motions = avatar.skeleton.motions(&rest).unwrap();
        let mut joints = avatar.skeleton.joints().to_vec();
        for (joint, motion) in joints.iter_mut().zip(motions) {
            joint.position = motion.point(joint.position);
        }
        avatar.skeleton = Skeleton::new(joints).unwrap();
        avatar = avatar.standing().unwrap();
        let pose = t_pose(&avatar).unwrap().unwrap();
        let motions = avatar.skeleton.motions(&pose).unwrap();
        let place = |bone: HumanBone| {
            let joint = avatar.skeleton.human(bone).unwrap();
            Vec3::from(motions[joint].point(avatar.skeleton.joints()[joint].position))
        };
        let off = |from: HumanBone, to: HumanBone, wanted: Vec3| {
            (place(to) - place(from)).angle_between(wanted).to_degrees()
        };
        for (right, out) in [(false, Vec3::X), (true, Vec3::NEG_X)] {
            let of = |bone: HumanBone| if right { bone.mirrored() } else { bone };
            for (number, finger) in FINGERS.iter().enumerate() {
                let wanted = if number == 0 { out + Vec3::Z } else { out };
                for pair in finger.windows(2) {
                    let off = off(of(pair[0]), of(pair[1]), wanted);
                    assert!(off < 0.1, "{}: {off}°", of(pair[0]).name());
                }
            }
            let across =
                place(of(HumanBone::LeftIndexProximal)) - place(of(HumanBone::LeftLittleProximal));
            assert!(across.z > 0.0 && across.y.abs() < 1e-4, "{across}");
        }
        let posed = avatar.posed(&pose, &[]).unwrap();
        let lowest = avatar.lowest(&posed).unwrap();
        assert!(lowest.abs() < 1e-4, "{lowest}");
    }
}
