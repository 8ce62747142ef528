//! HandPoseSpace poses from a few principal components, as in SMPL-H and SMPL-X.

use super::fields::{Axis, Fields};
use super::{BodyError, BodyModel};

/// Which hand, from the person's own point of view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[expect(missing_docs, reason = "nothing more to say")]
pub enum Hand {
    Left,
    Right,
}

/// Length of the rotation vectors of a hand's 15 joints, concatenated.
const VALUES: usize = 45;

/// The pose space of a hand: principal components of joint rotations, and the mean pose.
#[derive(Debug, Clone, Default)]
pub(super) struct HandPoseSpace {
    /// `[components][VALUES]`, by descending variance.
    components: Vec<f32>,
    mean: Option<[[f32; 3]; 15]>,
}

impl HandPoseSpace {
    /// Reads what the file has; without components, hands can only be posed joint by joint.
    pub(super) fn read(
        fields: &Fields<'_>,
        components: &'static str,
        mean: &'static str,
    ) -> Result<Self, BodyError> {
        let mut hand = Self::default();
        if fields.has(components) {
            let wanted = [Axis::Any("components"), Axis::Is(VALUES)];
            hand.components = fields.floats(components, &wanted)?.0.into_owned();
        }
        if fields.has(mean) {
            let (values, _) = fields.floats(mean, &[Axis::Is(VALUES)])?;
            hand.mean = <[[f32; 3]; 15]>::try_from(values.as_chunks::<3>().0).ok();
        }
        Ok(hand)
    }
}

impl BodyModel {
    fn hand(&self, side: Hand) -> &HandPoseSpace {
        &self.hands[side as usize]
    }

    /// Number of principal components of a hand's pose; 0 if the file has none.
    pub fn hand_components(&self, side: Hand) -> usize {
        self.hand(side).components.len() / VALUES
    }

    /// The mean pose of a hand as a rotation vector for each of its 15 joints, if the file has one.
    pub fn hand_mean(&self, side: Hand) -> Option<[[f32; 3]; 15]> {
        self.hand(side).mean
    }

    /// The rotation vectors of a hand's 15 joints: coefficients times components, without the mean.
    /// With `k` coefficients this equals `smplx` with `use_pca` and `num_pca_comps = k`.
    ///
    /// # Errors
    /// [`BodyError::Coefficients`] for more coefficients than the model has components,
    /// [`BodyError::Coefficient`] for one that is not finite.
    pub fn hand_turns(
        &self,
        side: Hand,
        coefficients: &[f32],
    ) -> Result<[[f32; 3]; 15], BodyError> {
        self.check_coefficients("hand components", coefficients, self.hand_components(side))?;
        let mut turns = [[0.0; 3]; 15];
        let components = self.hand(side).components.as_chunks::<VALUES>().0;
        for (&coefficient, component) in coefficients.iter().zip(components) {
            for (value, part) in turns.as_flattened_mut().iter_mut().zip(component) {
                *value += coefficient * part;
            }
        }
        Ok(turns)
    }
}
