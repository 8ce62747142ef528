//! VRM's T-pose: arms, hands and fingers straight out to the sides with the palms down, thumbs half-way
//! to the front, feet straight ahead on the floor.
//!
//! The file's nodes stand in this pose while the skin stays bound to the pose of the mesh, so a clip
//! shows the same vertices, to the bit, in a VRM and a GLB: nothing is skinned twice.
//!
//! Source: VRM Consortium, "VRMC_vrm-1.0", `tpose.md`: definitions 1.2 to 1.8. How thumbs are rolled
//! about themselves is left as the body has it: that turns the ball of the thumb inside out.

use std::f32::consts::FRAC_1_SQRT_2;

use glam::{Quat, Vec3};
use uvgraft_avatar::Avatar;
use uvgraft_avatar::rig::{HumanBone, Pose, RigError, Skeleton};

/// The left arm's bones in order, each with the one at its end.
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
/// Turns below this are none, in radians: a hundredth of a degree.
const STILL: f32 = 2e-4;
/// Feet that point farther to the side than this are no feet of somebody who stands, in radians.
const MOST_SPLAY: f32 = 0.8;
/// A vertex tells where a joint's part is if it follows the joint this far.
const OWN: f32 = 0.5;

/// Where bones should point, in the world: nothing for those that may stay.
struct Aims<'a> {
    skeleton: &'a Skeleton,
    /// For each joint the direction of its bone at rest, and where that should point.
    bones: Vec<Option<(Vec3, Vec3)>>,
    /// For each joint what should then point to the front as far as it can, turning about the bone.
    fronts: Vec<Option<Vec3>>,
}

/// The pose that takes an avatar's rest to VRM's T-pose; `None` if it is in one, or has no arms. Legs
/// stay as they are but for the feet, and the height of the lowest vertex stays.
///
/// # Errors
/// [`RigError`] if the avatar's parts do not fit each other.
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
    // Feet that turn on the floor may come off it where their soles are not level.
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

    fn place(&self, joint: usize) -> Vec3 {
        self.skeleton.joints()[joint].position.into()
    }

    fn aim(&mut self, joint: usize, end: Vec3, to: Vec3) {
        if let Some(along) = (end - self.place(joint)).try_normalize() {
            self.bones[joint] = Some((along, to));
        }
    }

    fn arm(&mut self, avatar: &Avatar, right: bool) {
        let out = if right { Vec3::NEG_X } else { Vec3::X };
        for (bone, end) in ARM {
            let (Some(bone), Some(end)) = (self.joint(bone, right), self.joint(end, right)) else {
                continue;
            };
            self.aim(bone, self.place(end), out);
        }
        // The palm is down where the index finger is in front of the little one.
        let knuckle =
            |aims: &Self, finger: usize| Some(aims.place(aims.joint(FINGERS[finger][0], right)?));
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
                let end = next.map(|next| self.place(next)).or_else(|| middle(avatar, joint));
                if let Some(end) = end {
                    self.aim(joint, end, to);
                }
            }
        }
    }

    /// Turns a foot about the vertical, which leaves its sole on the floor.
    fn foot(&mut self, avatar: &Avatar, right: bool) {
        let Some(foot) = self.joint(HumanBone::LeftFoot, right) else { return };
        let toes = self.joint(HumanBone::LeftToes, right);
        let Some(ahead) = length_of_foot(avatar, foot, toes) else { return };
        if ahead.angle_between(Vec3::Z) < MOST_SPLAY {
            self.bones[foot] = Some((ahead, Vec3::Z));
        }
    }

    fn pose(&self) -> Pose {
        let joints = self.skeleton.joints();
        let mut pose = Pose::rest(joints.len());
        let mut world = vec![Quat::IDENTITY; joints.len()];
        for (index, joint) in joints.iter().enumerate() {
            let above = joint.parent.map_or(Quat::IDENTITY, |parent| world[parent]);
            world[index] = above;
            if let Some((along, to)) = self.bones[index] {
                // The shortest way on from where the parent took it, so that nothing is twisted.
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

/// The middle of what follows a joint more than others.
fn middle(avatar: &Avatar, joint: usize) -> Option<Vec3> {
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

/// Where a foot points, level: the direction in which its vertices are farthest from each other.
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
    // The principal axis of a symmetric matrix of two rows.
    let angle = 0.5 * (2.0 * xz).atan2(zz - xx);
    Some(Vec3::new(angle.sin(), 0.0, angle.cos()))
}

#[cfg(test)]
mod tests {
    use uvgraft::Mesh;
    use uvgraft_avatar::rig::{Joint, Skin};
    use uvgraft_figure::Figure;

    use super::*;

    /// An avatar of a left arm without a mesh to speak of.
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
    fn a_t_pose_is_left_alone() {
        let avatar = left_arm([0.5, 1.4, 0.0], [0.8, 1.4, 0.0]);
        assert_eq!(t_pose(&avatar).unwrap(), None);
        // Some degrees are not left: a file costs nothing by them.
        let avatar = left_arm([0.5, 1.38, 0.0], [0.8, 1.38, 0.0]);
        assert!(t_pose(&avatar).unwrap().is_some());
    }

    #[test]
    fn hands_lie_flat_with_thumbs_to_the_front() {
        let mut avatar = Figure::new().avatar();
        // Somebody with bent fingers, turned hands and splayed feet.
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
        avatar = avatar.rested_in(&rest).unwrap().standing().unwrap();
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
