//! Motion of the jaw in morphs: the rigid motion that best fits the chin.

use glam::{DMat3, DQuat, DVec3, Vec3};
use uvgraft::{Anatomy, Landmark};

use super::MouthError;
use crate::Avatar;
use crate::rig::{HumanBone, Morph};

/// Radius around the foremost point of the chin in which the skin moves with the bone,
/// in distances between the eyes.
const CHIN: f64 = 0.38;

/// Penalty of translations against rotations about the hinge: the chin alone can hardly distinguish
/// them, and jaws rotate rather than slide.
const SLIDE: f64 = 0.25;

/// Gauss-Newton steps; few suffice, because rotations are small.
const STEPS: usize = 6;

/// The data from which the motion of the jaw is estimated.
#[derive(Debug, Clone)]
pub(super) struct Jaw {
    hinge: DVec3,
    /// Vertices of the chin, ascending.
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
    /// Displacement of a point.
    pub fn offset(&self, point: Vec3) -> Vec3 {
        let arm = point.as_dvec3() - self.hinge;
        (self.turn * arm - arm + self.shift).as_vec3()
    }
}

impl Jaw {
    /// Locates chin and hinge; without a jaw joint, the hinge is between the ears, slightly lower.
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

    /// The rigid motion of the jaw in a morph.
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

/// Vertices within a distance of a point, ascending.
pub(super) fn near(positions: &[[f32; 3]], point: DVec3, radius: f64) -> Vec<u32> {
    let is_near = |position: &[f32; 3]| Vec3::from(*position).as_dvec3().distance(point) < radius;
    (0..).zip(positions).filter(|(_, position)| is_near(position)).map(|(v, _)| v).collect()
}

/// Fits a rotation R and a translation a that map `arms` to `arms + offsets`, by Gauss-Newton.
///
/// Minimises `Σ |offset - (R arm - arm) - a|² + SLIDE n |a|²`. The penalty decides what
/// the chin alone can hardly: whether the jaw rotates or slides. For a small further
/// rotation ω the residual changes by ω × R arm, and the best a is the mean residual
/// divided by `1 + SLIDE`, so eliminating it leaves a 3 × 3 system for ω.
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
            matrix += inertia(*arm);
            right += arm.cross(*missing);
        }
        matrix -= inertia(mean_arm) * (count * share);
        right -= mean_arm.cross(mean_missing) * (count * share);
        // Rotation about the line from the hinge to the chin hardly moves the chin and
        // would follow noise, so the system is damped.
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

/// The inertia matrix of a unit mass at `v`: |v|² 1 - v vᵀ.
fn inertia(v: DVec3) -> DMat3 {
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
    fn a_rotation_about_the_hinge_is_recovered() {
        let arms = chin();
        let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.0, 0.0));
        let offsets: Vec<DVec3> = arms.iter().map(|&arm| turn * arm - arm).collect();
        let (found, shift) = rigid(&arms, &offsets);
        let motion = Motion { hinge: DVec3::ZERO, turn: found, shift };
        // At the lower incisors and at the back of the tongue.
        for point in [Vec3::new(0.0, -0.03, 0.075), Vec3::new(0.015, -0.025, 0.03)] {
            let arm = point.as_dvec3();
            let wanted = (turn * arm - arm).as_vec3();
            assert!(
                motion.offset(point).distance(wanted) < 3e-4,
                "{}",
                motion.offset(point) - wanted
            );
        }
    }

    #[test]
    fn no_motion_stays_none_and_a_slide_is_mostly_recovered() {
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
