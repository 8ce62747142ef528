//! Poses in the parameters of body models: a rotation vector for each joint.

use super::{BodyError, BodyModel, Hand};
use crate::rig::Pose;

/// A pose of a body model.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyPose {
    /// Translation of the body, in metres.
    pub translation: [f32; 3],
    /// For each joint its rotation vector: the axis times the angle in radians.
    pub turns: Vec<[f32; 3]>,
}

impl BodyPose {
    /// The rest pose.
    pub fn rest(model: &BodyModel) -> Self {
        Self { translation: [0.0; 3], turns: vec![[0.0; 3]; model.kind().joint_count()] }
    }

    /// Replaces the rotations of a hand's joints by a combination of components; see
    /// [`BodyModel::hand_turns`].
    ///
    /// # Errors
    /// See [`BodyModel::hand_turns`].
    pub fn with_hand(
        mut self,
        model: &BodyModel,
        side: Hand,
        coefficients: &[f32],
    ) -> Result<Self, BodyError> {
        let turns = model.hand_turns(side, coefficients)?;
        for (turn, hand) in self.fingers(model, side)?.iter_mut().zip(turns) {
            *turn = hand;
        }
        Ok(self)
    }

    /// Adds the mean poses of the hands to the rotations of their joints. `smplx` does so unless
    /// `flat_hand_mean` is set; AMASS poses already include them.
    ///
    /// # Errors
    /// [`BodyError::Count`] if the pose does not have the model's number of joints.
    pub fn with_hand_means(mut self, model: &BodyModel) -> Result<Self, BodyError> {
        for side in [Hand::Left, Hand::Right] {
            let Some(mean) = model.hand_mean(side) else { continue };
            for (turn, mean) in self.fingers(model, side)?.iter_mut().zip(mean) {
                for (value, mean) in turn.iter_mut().zip(mean) {
                    *value += mean;
                }
            }
        }
        Ok(self)
    }

    fn fingers(&mut self, model: &BodyModel, side: Hand) -> Result<&mut [[f32; 3]], BodyError> {
        let (found, wanted) = (self.turns.len(), model.kind().joint_count());
        if found != wanted {
            return Err(BodyError::Count { what: "rotations of a pose", found, wanted });
        }
        Ok(match model.kind().fingers() {
            Some(first) => &mut self.turns[first[side as usize]..][..15],
            None => &mut [],
        })
    }

    /// Converts it to a pose of the skeleton.
    pub fn to_pose(&self) -> Pose {
        Pose::from_axis_angles(self.translation, &self.turns)
    }
}
