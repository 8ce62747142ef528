//! Poses over time.

use super::{Pose, RigError};

/// An animation: poses at given times.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// The name shown by viewers.
    pub name: String,
    /// Seconds from the start, increasing.
    pub times: Vec<f32>,
    /// One for each time.
    pub poses: Vec<Pose>,
}

impl Clip {
    /// Checks it against a skeleton of `joints` joints.
    ///
    /// # Errors
    /// [`RigError::Clip`] if the times do not increase from 0 or later, or their number differs
    /// from that of the poses; also as [`Pose::check`].
    pub fn check(&self, joints: usize) -> Result<(), RigError> {
        let wrong = |problem| Err(RigError::Clip { clip: self.name.clone(), problem });
        if self.times.is_empty() {
            return wrong("has no frames");
        }
        if self.times.len() != self.poses.len() {
            return wrong("must have as many times as poses");
        }
        let first = self.times[0];
        if !(first.is_finite() && first >= 0.0) {
            return wrong("must not start before 0");
        }
        if !self.times.windows(2).all(|pair| pair[1].is_finite() && pair[0] < pair[1]) {
            return wrong("must have increasing times");
        }
        self.poses.iter().try_for_each(|pose| pose.check(joints))
    }

    /// Its length in seconds.
    pub fn seconds(&self) -> f32 {
        self.times.last().copied().unwrap_or(0.0)
    }
}
