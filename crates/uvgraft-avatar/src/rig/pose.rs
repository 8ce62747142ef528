//! Poses of skeletons, and rigid motions of points.

use glam::{Quat, Vec3};

use super::RigError;

/// A pose: the rotation of each joint relative to its parent, and the translation of the root.
#[derive(Debug, Clone, PartialEq)]
pub struct Pose {
    /// Offset of the root from its rest position, in metres.
    pub translation: [f32; 3],
    /// Each joint's rotation relative to its parent, as a quaternion `[x, y, z, w]`;
    /// the identity at rest.
    pub rotations: Vec<[f32; 4]>,
}

impl Pose {
    /// The rest pose.
    pub fn rest(joints: usize) -> Self {
        Self { translation: [0.0; 3], rotations: vec![[0.0, 0.0, 0.0, 1.0]; joints] }
    }

    /// - `turns`: a rotation vector for each joint: the axis times the angle in radians.
    pub fn from_axis_angles(translation: [f32; 3], turns: &[[f32; 3]]) -> Self {
        let rotations = turns.iter().map(|&turn| Quat::from_scaled_axis(turn.into()).into());
        Self { translation, rotations: rotations.collect() }
    }

    /// Checks that there is a rotation of length near 1 for each joint.
    ///
    /// # Errors
    /// [`RigError::Count`] or [`RigError::NotFinite`].
    pub fn check(&self, joints: usize) -> Result<(), RigError> {
        let found = self.rotations.len();
        if found != joints {
            return Err(RigError::Count { what: "rotations of a pose", found, wanted: joints });
        }
        let unit = |q: &[f32; 4]| (Quat::from_array(*q).length() - 1.0).abs() < 1e-3;
        if let Some(joint) = self.rotations.iter().position(|q| !unit(q)) {
            return Err(RigError::NotFinite { what: format!("the rotation of joint {joint}") });
        }
        if !self.translation.iter().all(|value| value.is_finite()) {
            return Err(RigError::NotFinite { what: "the translation of a pose".to_owned() });
        }
        Ok(())
    }
}

/// A rotation, then a translation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    /// A quaternion `[x, y, z, w]`.
    pub rotation: [f32; 4],
    /// In metres.
    pub translation: [f32; 3],
}

impl Rigid {
    /// Transforms a point.
    pub fn point(&self, point: [f32; 3]) -> [f32; 3] {
        let turned = Quat::from_array(self.rotation) * Vec3::from(point);
        (turned + Vec3::from(self.translation)).into()
    }
}
