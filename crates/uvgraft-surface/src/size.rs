//! Sizes of textures, and of layouts that are drawn.

/// Width and height in texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Size {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Size {
    /// The longest side that a texture may have.
    pub const MAX_SIDE: u32 = 32_768;

    /// A size of `width` × `height` texels.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// A square of `side` × `side` texels.
    pub const fn square(side: u32) -> Self {
        Self::new(side, side)
    }

    /// Number of texels, `usize::MAX` if it overflows.
    pub const fn texels(self) -> usize {
        // A product beyond 32-bit addressing must not look like a small one.
        (self.width as usize).saturating_mul(self.height as usize)
    }

    /// Whether both have the same aspect ratio, within a texel of the longest side: images of one layout in
    /// different sizes do.
    pub fn has_aspect_ratio_of(self, other: Self) -> bool {
        let product = |a: u32, b: u32| u64::from(a) * u64::from(b);
        let difference =
            product(self.width, other.height).abs_diff(product(other.width, self.height));
        let sides = [self.width, self.height, other.width, other.height];
        difference <= sides.into_iter().map(u64::from).max().unwrap_or(0)
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}×{}", self.width, self.height)
    }
}
