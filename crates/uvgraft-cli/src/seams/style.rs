//! Colours of the text in pictures of seams.

/// Of titles, sRGB.
pub(super) const TITLE: [u8; 3] = [236, 238, 242];
/// Of other text, sRGB.
pub(super) const TEXT: [u8; 3] = [176, 182, 192];
