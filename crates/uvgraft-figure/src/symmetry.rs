//! The figure's left and right: it is symmetric about the plane x = 0.

use glam::Vec3;

/// Points and directions seen from the other side.
pub(crate) trait Symmetry {
    /// The same on the figure's left, where `x` is positive.
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
