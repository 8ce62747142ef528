//! What moves a face.

use glam::Vec3;

use super::Face;

/// Something that moves a face: a component of expression, a jaw, an eyelid.
#[derive(Debug, Clone)]
pub struct Movement {
    /// Where it takes each vertex with a coefficient of 1, in the mesh's unit.
    pub offsets: Vec<[f32; 3]>,
    /// The least and the largest coefficient.
    pub limits: [f32; 2],
    /// Whether it opens the mouth by the jaw's joint: only expressions that speak or gape use it.
    pub is_jaw: bool,
}

/// A place in the head's coordinates.
pub(super) fn local(face: &Face, place: Vec3) -> [f32; 3] {
    face.frame.local(place.to_array().map(f64::from)).map(|value| value as f32)
}
