//! Movements that expressions are made of.

use glam::Vec3;

use super::Face;

/// Something that moves a face: an expression component, a jaw, an eyelid.
#[derive(Debug, Clone)]
pub struct BlendBasis {
    /// Offset of each vertex at a coefficient of 1, in the mesh's unit.
    pub offsets: Vec<[f32; 3]>,
    /// The smallest and the largest coefficient.
    pub limits: [f32; 2],
    /// Whether it is the rotation of the jaw that opens the mouth: only expressions
    /// that speak or gape use it.
    pub is_jaw: bool,
}

/// Converts a point to head coordinates.
pub(super) fn local(face: &Face, point: Vec3) -> [f32; 3] {
    face.frame.local(point.to_array().map(f64::from)).map(|value| value as f32)
}
