//! Puts feet where they shall be: the legs' rotations from the place of ankles, by the law of
//! cosines.

use glam::{Mat3, Quat, Vec3};

use super::posture::Posture;
use crate::rigging::joints::{LEFT, Limbs, RIGHT};

impl Posture<'_> {
    /// Keeps both feet where they are at rest, whatever the hips do.
    pub fn plant_both(&mut self) {
        for limbs in [LEFT, RIGHT] {
            let ankle = self.skeleton.joints()[limbs.foot as usize].position.into();
            self.plant(&limbs, ankle, Quat::IDENTITY);
        }
    }

    /// Bends a leg so that its ankle comes to a place, knee forward. What is out of reach is reached
    /// for.
    ///
    /// - `ankle`: in the world, in metres.
    /// - `foot`: the foot's rotation in the world.
    pub fn plant(&mut self, limbs: &Limbs, ankle: Vec3, foot: Quat) {
        let place = |bone| Vec3::from(self.skeleton.joints()[bone as usize].position);
        let hips_rest = place(uvgraft_avatar::rig::HumanBone::Hips);
        let hips = Quat::from_array(self.pose.rotations[0]);
        let root = hips_rest + Vec3::from(self.pose.translation);
        let hip = root + hips * (place(limbs.upper_leg) - hips_rest);
        let thigh = place(limbs.lower_leg) - place(limbs.upper_leg);
        let shin = place(limbs.foot) - place(limbs.lower_leg);
        let (a, b) = (thigh.length(), shin.length());
        let to = ankle - hip;
        let reach = to.length().clamp((a - b).abs() + 1e-4, a + b - 1e-4);
        let along = to.normalize();
        // Knees go where the hips face, and a little outwards as feet do.
        let knee = hips * Vec3::new(0.1 * limbs.sign, 0.0, 1.0);
        let forward = (knee - along * knee.dot(along)).normalize();
        let cos = ((a * a + reach * reach - b * b) / (2.0 * a * reach)).clamp(-1.0, 1.0);
        let bent_thigh = (along * cos + forward * (1.0 - cos * cos).sqrt()) * a;
        let bent_shin = along * reach - bent_thigh;
        // The plane in which the leg bends turns as a whole.
        let rest_normal = Vec3::new(0.1 * limbs.sign, 0.0, 1.0).cross(thigh);
        let normal = forward.cross(along);
        let upper = frame(bent_thigh, normal) * frame(thigh, rest_normal).inverse();
        let lower = frame(bent_shin, normal) * frame(shin, rest_normal).inverse();
        self.set(limbs.upper_leg, hips.inverse() * upper);
        self.set(limbs.lower_leg, upper.inverse() * lower);
        self.set(limbs.foot, lower.inverse() * foot);
    }
}

/// The rotation that takes the axes to a direction, what is square to it nearest a normal, and the
/// third.
fn frame(direction: Vec3, normal: Vec3) -> Quat {
    let x = direction.normalize();
    let y = (normal - x * normal.dot(x)).normalize();
    Quat::from_mat3(&Mat3::from_cols(x, y, x.cross(y)))
}
