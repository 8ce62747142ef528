//! The samples of texels, as numbers.

/// The samples that a texel is the mean of: a grid around its source position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlannedFootprint {
    /// Number of samples along the target's x and y, 32 at most.
    pub samples: [u32; 2],
    /// Offset (x, y) of the first sample from the texel's source position.
    pub first: [i64; 2],
    /// Offsets (x, y) from a sample to the next along the target's x and y.
    pub steps: [[i64; 2]; 2],
}
