//! How a jaw moves in morphs: the rigid motion that is nearest to what the chin does.

use glam::{DMat3, DQuat, DVec3, Vec3};
use uvgraft::{Anatomy, Landmark};

use super::MouthError;
use crate::Avatar;
use crate::rig::{HumanBone, Morph};

/// How far from the foremost point of the chin its skin is still bone's, in distances between the eyes.
const CHIN: f64 = 0.38;

/// What a translation costs against a rotation about the hinge: the chin alone hardly tells them apart, and jaws
/// turn rather than slide.
const SLIDE: f64 = 0.25;

/// Steps of Gauss and Newton's; rotations are small.
const STEPS: usize = 6;

/// What tells how a jaw moves.
#[derive(Debug, Clone)]
pub(super) struct Jaw {
    hinge: DVec3,
    /// Vertices of the chin, rising.
    chin: Vec<u32>,
}

/// A rigid motion about a hinge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    hinge: DVec3,
    turn: DQuat,
    shift: DVec3,
}

impl Motion {
    /// How far it takes a place.
    pub fn offset(&self, place: Vec3) -> Vec3 {
        let arm = place.as_dvec3() - self.hinge;
        (self.turn * arm - arm + self.shift).as_vec3()
    }
}

impl Jaw {
    /// Finds chin and hinge; where there is no joint, the hinge is between the ears, a little lower.
    ///
    /// # Errors
    /// [`MouthError::Landmark`] for a face without a chin.
    pub fn find(avatar: &Avatar, anatomy: &Anatomy) -> Result<Self, MouthError> {
        let positions = avatar.mesh.positions();
        let chin = anatomy.point(Landmark::Chin).ok_or(MouthError::Landmark("chin"))?;
        let near = near(positions, DVec3::from(chin), CHIN * anatomy.frame().unit);
        if near.len() < 3 {
            return Err(MouthError::Landmark("chin"));
        }
        let joint = avatar.skeleton.human(HumanBone::Jaw);
        let joint =
            joint.map(|joint| DVec3::from(avatar.skeleton.joints()[joint].position.map(f64::from)));
        let hinge = joint.unwrap_or_else(|| DVec3::from(anatomy.frame().world([0.0, -0.45, -1.1])));
        Ok(Self { hinge, chin: near })
    }

    /// What a morph does to the jaw.
    pub fn motion(&self, positions: &[[f32; 3]], morph: &Morph) -> Motion {
        let mut offsets = vec![DVec3::ZERO; self.chin.len()];
        for (vertex, offset) in &morph.offsets {
            if let Ok(at) = self.chin.binary_search(vertex) {
                offsets[at] = Vec3::from(*offset).as_dvec3();
            }
        }
        let arms: Vec<DVec3> = self
            .chin
            .iter()
            .map(|&vertex| Vec3::from(positions[vertex as usize]).as_dvec3() - self.hinge)
            .collect();
        let (turn, shift) = rigid(&arms, &offsets);
        Motion { hinge: self.hinge, turn, shift }
    }
}

/// Vertices within a distance of a place, rising.
pub(super) fn near(positions: &[[f32; 3]], place: DVec3, radius: f64) -> Vec<u32> {
    let is_near = |position: &[f32; 3]| Vec3::from(*position).as_dvec3().distance(place) < radius;
    (0..).zip(positions).filter(|(_, position)| is_near(position)).map(|(v, _)| v).collect()
}

/// The rotation and translation that take `arms` nearest to `arms + offsets`, translations at a price.
///
/// For a small further turn ω, offsets are what is missing plus ω × arm + a, and for each ω the best a is a share
/// of the mean rest, so ω solves a system of three equations.
fn rigid(arms: &[DVec3], offsets: &[DVec3]) -> (DQuat, DVec3) {
    let count = arms.len() as f64;
    let share = 1.0 / (1.0 + SLIDE);
    let mean = |values: &[DVec3]| values.iter().sum::<DVec3>() / count;
    let mut turn = DQuat::IDENTITY;
    let mut shift = DVec3::ZERO;
    for _ in 0..STEPS {
        let turned: Vec<DVec3> = arms.iter().map(|&arm| turn * arm).collect();
        let missing: Vec<DVec3> =
            (0..arms.len()).map(|k| offsets[k] - (turned[k] - arms[k])).collect();
        let (mean_arm, mean_missing) = (mean(&turned), mean(&missing));
        let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
        for (arm, missing) in turned.iter().zip(&missing) {
            matrix += squared(*arm);
            right += arm.cross(*missing);
        }
        matrix -= squared(mean_arm) * (count * share);
        right -= mean_arm.cross(mean_missing) * (count * share);
        // Turns about the line from the hinge to the chin move it hardly and are told by noise.
        let trace = matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z;
        matrix += DMat3::from_diagonal(DVec3::splat(0.02 * trace));
        if matrix.determinant() <= 0.0 {
            break;
        }
        let step = matrix.inverse() * right;
        turn = (DQuat::from_scaled_axis(step) * turn).normalize();
        let rest: Vec<DVec3> =
            (0..arms.len()).map(|k| offsets[k] - (turn * arms[k] - arms[k])).collect();
        shift = mean(&rest) * share;
    }
    (turn, shift)
}

/// What a turn about the origin costs by axis: |v|² 1 - v vᵀ.
fn squared(v: DVec3) -> DMat3 {
    DMat3::from_diagonal(DVec3::splat(v.length_squared()))
        - DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A patch of skin in front of and below the hinge.
    fn chin() -> Vec<DVec3> {
        let at = |k: usize| {
            let (x, y) = ((k % 5) as f64 - 2.0, (k / 5) as f64 - 2.0);
            DVec3::new(0.008 * x, -0.05 + 0.008 * y, 0.08 - 0.002 * (x * x + y * y))
        };
        (0..25).map(at).collect()
    }

    #[test]
    fn a_turn_about_the_hinge_is_found_as_it_is() {
        let arms = chin();
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.0, 0.0));
        let offsets: Vec<DVec3> = arms.iter().map(|&arm| turn * arm - arm).collect();
        let (found, shift) = rigid(&arms, &offsets);
        let motion = Motion { hinge: DVec3::ZERO, turn: found, shift };
        // At the lower incisors and at the back of the tongue.
        for place in [Vec3::new(0.0, -0.03, 0.075), Vec3::new(0.015, -0.025, 0.03)] {
            let arm = place.as_dvec3();
            let wanted = (turn * arm - arm).as_vec3();
            assert!(
                motion.offset(place).distance(wanted) < 3e-4,
                "{}",
                motion.offset(place) - wanted
            );
        }
    }

    #[test]
    fn what_does_not_move_stays_and_a_slide_is_mostly_kept() {
        let arms = chin();
        let (turn, shift) = rigid(&arms, &vec![DVec3::ZERO; arms.len()]);
        assert!(turn.is_near_identity() && shift == DVec3::ZERO);
        let slide = DVec3::new(0.0, 0.0, 0.005);
        let (turn, shift) = rigid(&arms, &vec![slide; arms.len()]);
        let motion = Motion { hinge: DVec3::ZERO, turn, shift };
        let off = motion.offset(Vec3::new(0.0, -0.03, 0.075)) - slide.as_vec3();
        assert!(off.length() < 1.5e-3, "{off}");
    }
}
