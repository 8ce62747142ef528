//! The figure's left and right: it is symmetric about the plane x = 0.

use glam::Vec3;

/// Reflection of points and directions.
pub(crate) trait Symmetry {
    /// The point or its mirror image, whichever is on the figure's left (positive `x`).
    fn folded(self) -> Self;
    /// The mirror image.
    fn mirrored(self) -> Self;
}

impl Symmetry for Vec3 {
    fn folded(self) -> Self {
        self.with_x(self.x.abs())
    }

    fn mirrored(self) -> Self {
        self.with_x(-self.x)
    }
}
