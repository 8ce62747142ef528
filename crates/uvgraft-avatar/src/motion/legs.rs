//! Inverse kinematics of legs: hip and knee rotate, the foot keeps its orientation in the world.

use glam::{Quat, Vec3};

use crate::rig::{HumanBone, Pose, Skeleton, posed_joints};

/// The joints of a leg, each the parent of the next.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    hip: usize,
    knee: usize,
    ankle: usize,
}

/// Legs stretch up to this fraction of their length, short of the point where the knee
/// snaps straight.
const STRETCH: f32 = 0.9995;

/// World positions and rotations of a leg's joints.
pub(super) struct LegPose {
    pub hip: Vec3,
    pub knee: Vec3,
    pub ankle: Vec3,
    turns: [Quat; 3],
    /// World rotation of the hip's parent.
    above: Quat,
}

impl Leg {
    /// Left and right leg; `None` unless thigh, shin and foot form chains.
    pub(super) fn both(skeleton: &Skeleton) -> Option<[Self; 2]> {
        use HumanBone as Bone;
        let leg = |bones: [Bone; 3]| {
            let [hip, knee, ankle] = bones.map(|bone| skeleton.human(bone));
            let leg = Self { hip: hip?, knee: knee?, ankle: ankle? };
            let hangs = |joint: usize, on| skeleton.joints()[joint].parent == Some(on);
            (hangs(leg.knee, leg.hip) && hangs(leg.ankle, leg.knee)).then_some(leg)
        };
        Some([
            leg([Bone::LeftUpperLeg, Bone::LeftLowerLeg, Bone::LeftFoot])?,
            leg([Bone::RightUpperLeg, Bone::RightLowerLeg, Bone::RightFoot])?,
        ])
    }

    /// Length from hip to knee to ankle, in metres.
    pub(super) fn length_m(&self, skeleton: &Skeleton) -> f32 {
        let place = |joint: usize| Vec3::from(skeleton.joints()[joint].position);
        place(self.hip).distance(place(self.knee)) + place(self.knee).distance(place(self.ankle))
    }

    /// The state of the leg in a pose.
    ///
    /// - `world`: rotation and position of every joint.
    pub(super) fn placed(&self, skeleton: &Skeleton, world: &[(Quat, Vec3)]) -> LegPose {
        let above = skeleton.joints()[self.hip].parent.map_or(Quat::IDENTITY, |up| world[up].0);
        let [hip, knee, ankle] = [self.hip, self.knee, self.ankle].map(|joint| world[joint]);
        LegPose { hip: hip.1, knee: knee.1, ankle: ankle.1, turns: [hip.0, knee.0, ankle.0], above }
    }

    /// Two-bone inverse kinematics: rotates hip and knee so that the ankle reaches a
    /// target, or gets as close as the leg allows.
    ///
    /// By the law of cosines, the distance d from hip to ankle determines the angle β between thigh
    /// and shin (of lengths a and b): d² = a² + b² + 2ab cos β. The knee takes the change of β,
    /// then the hip swings the ankle into the direction of the target along the shortest arc. The
    /// foot's rotation compensates for both.
    pub(super) fn reach(&self, placed: &LegPose, to: Vec3, pose: &mut Pose) {
        let (thigh, shin) = (placed.knee - placed.hip, placed.ankle - placed.knee);
        let (a, b) = (thigh.length(), shin.length());
        let now = placed.ankle.distance(placed.hip);
        if a * b < 1e-8 || now < 1e-4 {
            return;
        }
        let most = ((a + b) * STRETCH).max(now.min(a + b));
        let wanted = to.distance(placed.hip).clamp((a - b).abs() + 1e-4, most);
        // The bend of the knee, the angle between thigh and shin: 0 for a straight leg.
        let bend = |distance: f32| {
            let cosine = (distance * distance - a * a - b * b) / (2.0 * a * b);
            cosine.clamp(-1.0, 1.0).acos()
        };
        // A straight leg has no bending plane; knees bend about the thigh's sideways axis.
        let side = placed.turns[0] * Vec3::X;
        let axis = thigh.cross(shin);
        let axis = if axis.length() > 1e-3 * a * b { axis.normalize() } else { side };
        let flex = Quat::from_axis_angle(axis, bend(wanted) - bend(now));
        let foot = placed.knee + flex * shin - placed.hip;
        let (Some(foot), Some(to)) = (foot.try_normalize(), (to - placed.hip).try_normalize())
        else {
            return;
        };
        let swing = Quat::from_rotation_arc(foot, to);
        let hip = swing * placed.turns[0];
        let knee = swing * flex * placed.turns[1];
        pose.rotations[self.hip] = (placed.above.inverse() * hip).normalize().into();
        pose.rotations[self.knee] = (hip.inverse() * knee).normalize().into();
        pose.rotations[self.ankle] = (knee.inverse() * placed.turns[2]).normalize().into();
    }
}

/// World rotation and position of every joint, for a pose that has been checked.
pub(super) fn world(skeleton: &Skeleton, pose: &Pose) -> Vec<(Quat, Vec3)> {
    let joints = skeleton.joints().iter().zip(&pose.rotations).map(|(joint, &rotation)| {
        (joint.parent, joint.position.into(), Quat::from_array(rotation))
    });
    posed_joints(joints, pose.translation.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    #[test]
    fn feet_reach_their_targets_and_keep_their_rotation() {
        let skeleton = example::avatar().skeleton;
        let legs = Leg::both(&skeleton).unwrap();
        let mut bent = Pose::rest(skeleton.joints().len());
        bent.rotations[legs[0].hip] = Quat::from_rotation_x(-0.4).into();
        bent.rotations[legs[0].knee] = Quat::from_rotation_x(0.7).into();
        bent.rotations[0] = Quat::from_rotation_y(0.5).into();
        for start in [Pose::rest(skeleton.joints().len()), bent] {
            for leg in &legs {
                for by in [[0.0, 0.1, 0.05], [0.03, 0.01, -0.04], [0.0, 0.3, 0.2]] {
                    let before = world(&skeleton, &start);
                    let placed = leg.placed(&skeleton, &before);
                    let to = placed.ankle + Vec3::from(by);
                    let mut pose = start.clone();
                    leg.reach(&placed, to, &mut pose);
                    let after = world(&skeleton, &pose);
                    assert!(
                        after[leg.ankle].1.abs_diff_eq(to, 1e-4),
                        "{} {to}",
                        after[leg.ankle].1
                    );
                    assert!(after[leg.ankle].0.angle_between(before[leg.ankle].0) < 2e-3);
                    // Knees bend forwards of the line from hip to ankle.
                    let knee = after[leg.knee].1 - (after[leg.hip].1 + to) / 2.0;
                    assert!((after[leg.hip].0.inverse() * knee).z > -0.02, "{knee}");
                }
            }
        }
    }

    #[test]
    fn legs_stretch_towards_targets_out_of_reach() {
        let skeleton = example::avatar().skeleton;
        let [leg, _] = Leg::both(&skeleton).unwrap();
        let rest = Pose::rest(skeleton.joints().len());
        let before = world(&skeleton, &rest);
        let placed = leg.placed(&skeleton, &before);
        let mut pose = rest;
        leg.reach(&placed, placed.hip + Vec3::new(0.0, 0.0, 3.0), &mut pose);
        let foot = world(&skeleton, &pose)[leg.ankle].1 - placed.hip;
        assert!(
            foot.angle_between(Vec3::Z) < 1e-3 && foot.length() > 0.999 * leg.length_m(&skeleton)
        );
    }
}
