//! A pose under construction: joints rotate by degrees, feet are planted on the ground.

use glam::{Quat, Vec3};
use uvgraft_avatar::rig::{HumanBone, Pose, Skeleton};

use crate::rigging::joints::{LEFT, Limbs, RIGHT};

pub(super) struct Posture<'a> {
    pub skeleton: &'a Skeleton,
    pub pose: Pose,
}

impl<'a> Posture<'a> {
    /// Standing upright with relaxed arms and hands; the legs are as in the T-pose.
    pub fn standing(skeleton: &'a Skeleton) -> Self {
        let pose = Pose::rest(skeleton.joints().len());
        let mut posture = Self { skeleton, pose };
        for limbs in [LEFT, RIGHT] {
            posture.hang(&limbs, 0.0, 16.0);
            posture.curl(&limbs, 1.0);
        }
        posture
    }

    /// Lets an arm hang.
    ///
    /// - `swing`: forward swing, in degrees.
    /// - `bend`: bend of the elbow, in degrees.
    pub fn hang(&mut self, limbs: &Limbs, swing: f32, bend: f32) {
        let s = limbs.sign;
        self.set(limbs.shoulder, degrees([0.0, 0.0, s * -5.0]));
        let arm = degrees([-4.0 - swing, 0.0, 0.0]) * degrees([0.0, 0.0, s * -70.0]);
        self.set(limbs.upper_arm, arm * degrees([12.0, 0.0, 0.0]));
        self.set(limbs.lower_arm, degrees([0.0, s * -bend, 0.0]));
        self.set(limbs.hand, degrees([0.0, 0.0, s * -4.0]));
    }

    /// Bends all fingers: 0 is straight, 1 relaxed, 5 a fist.
    pub fn curl(&mut self, limbs: &Limbs, amount: f32) {
        for (number, bones) in limbs.fingers.iter().enumerate() {
            let position = |bone| Vec3::from(self.skeleton.joints()[bone as usize].position);
            let along = (position(bones[1]) - position(bones[0])).normalize();
            let (goal, bends) = if number == 0 {
                // The thumb bends across the palm.
                (Vec3::new(limbs.sign * 0.2, -0.5, -0.8), [2.0, 6.0, 8.0])
            } else {
                let outer = number as f32 - 1.0;
                (Vec3::NEG_Y, [11.0 + 2.0 * outer, 15.0 + outer, 9.0])
            };
            let axis = along.cross(goal).normalize();
            for (&bone, bend) in bones.iter().zip(bends) {
                let bend: f32 = bend * amount;
                self.set(bone, Quat::from_axis_angle(axis, bend.to_radians()));
            }
        }
    }

    /// Rotates a bone further, by degrees about the world's X, then Y, then Z, its parent being at
    /// rest.
    pub fn turn(&mut self, bone: HumanBone, turn: [f32; 3]) {
        self.set(bone, degrees(turn) * self.of(bone));
    }

    pub fn set(&mut self, bone: HumanBone, rotation: Quat) {
        self.pose.rotations[bone as usize] = rotation.normalize().into();
    }

    /// Interpolates from the current rotation of a bone to another one.
    pub fn towards(&mut self, bone: HumanBone, goal: Quat, share: f32) {
        self.set(bone, self.of(bone).slerp(goal, share));
    }

    pub fn of(&self, bone: HumanBone) -> Quat {
        Quat::from_array(self.pose.rotations[bone as usize])
    }

    /// Moves the hips by centimetres.
    pub fn move_hips(&mut self, by: [f32; 3]) {
        for (value, by) in self.pose.translation.iter_mut().zip(by) {
            *value += 0.01 * by;
        }
    }
}

/// A rotation by degrees about X, then Y, then Z.
pub(super) fn degrees([x, y, z]: [f32; 3]) -> Quat {
    Quat::from_rotation_z(z.to_radians())
        * Quat::from_rotation_y(y.to_radians())
        * Quat::from_rotation_x(x.to_radians())
}
