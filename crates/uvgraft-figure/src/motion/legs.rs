//! Inverse kinematics of the legs: joint rotations from ankle positions, by the law of cosines.

use glam::{Mat3, Quat, Vec3};

use super::posture::Posture;
use crate::rigging::joints::{LEFT, Limbs, RIGHT};

impl Posture<'_> {
    /// Keeps both feet at their rest positions, wherever the hips move.
    pub fn plant_both(&mut self) {
        for limbs in [LEFT, RIGHT] {
            let ankle = self.skeleton.joints()[limbs.foot as usize].position.into();
            self.plant(&limbs, ankle, Quat::IDENTITY);
        }
    }

    /// Bends a leg so that its ankle reaches a position, with the knee forward. If it is out of
    /// reach, the leg stretches towards it.
    ///
    /// The angle at the hip between thigh `a` and the line of length `r` to the ankle is
    /// `acos((a² + r² - b²) / (2ar))`, `b` being the shin. That leaves the plane in which the leg
    /// bends; it is the one that contains the hips' forward direction.
    ///
    /// - `ankle`: in world space, in metres.
    /// - `foot`: world rotation of the foot.
    pub fn plant(&mut self, limbs: &Limbs, ankle: Vec3, foot: Quat) {
        let position = |bone| Vec3::from(self.skeleton.joints()[bone as usize].position);
        let hips_rest = position(uvgraft_avatar::rig::HumanBone::Hips);
        let hips = Quat::from_array(self.pose.rotations[0]);
        let root = hips_rest + Vec3::from(self.pose.translation);
        let hip = root + hips * (position(limbs.upper_leg) - hips_rest);
        let thigh = position(limbs.lower_leg) - position(limbs.upper_leg);
        let shin = position(limbs.foot) - position(limbs.lower_leg);
        let (a, b) = (thigh.length(), shin.length());
        let to = ankle - hip;
        let reach = to.length().clamp((a - b).abs() + 1e-4, a + b - 1e-4);
        let along = to.normalize();
        // Knees point where the hips face, and slightly outwards as feet do.
        let knee = hips * Vec3::new(0.1 * limbs.sign, 0.0, 1.0);
        let forward = (knee - along * knee.dot(along)).normalize();
        let cos = ((a * a + reach * reach - b * b) / (2.0 * a * reach)).clamp(-1.0, 1.0);
        let bent_thigh = (along * cos + forward * (1.0 - cos * cos).sqrt()) * a;
        let bent_shin = along * reach - bent_thigh;
        // The plane in which the leg bends rotates as a whole.
        let rest_normal = Vec3::new(0.1 * limbs.sign, 0.0, 1.0).cross(thigh);
        let normal = forward.cross(along);
        let upper = frame(bent_thigh, normal) * frame(thigh, rest_normal).inverse();
        let lower = frame(bent_shin, normal) * frame(shin, rest_normal).inverse();
        self.set(limbs.upper_leg, hips.inverse() * upper);
        self.set(limbs.lower_leg, upper.inverse() * lower);
        self.set(limbs.foot, lower.inverse() * foot);
    }
}

/// The rotation that maps X to `direction`, Y to the part of `normal` orthogonal to it, and Z to
/// their cross product.
fn frame(direction: Vec3, normal: Vec3) -> Quat {
    let x = direction.normalize();
    let y = (normal - x * normal.dot(x)).normalize();
    Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y)))
}
