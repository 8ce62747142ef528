//! The coordinate system in which a mouth is built.

use glam::Vec3;
use uvgraft::{Anatomy, Landmark};

use super::MouthError;

/// The distance between the eyes that all lengths refer to, in millimetres.
const EYES_MM: f64 = 64.0;

/// Mouth coordinates: origin where the lips meet in the middle, x to the person's left, y up, z to
/// the front; in millimetres of a face whose eyes are 64 mm apart.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    origin: Vec3,
    axes: [Vec3; 3],
    /// A millimetre in the mesh's unit.
    mm: f32,
}

impl Frame {
    pub fn new(anatomy: &Anatomy) -> Result<Self, MouthError> {
        let mouth = anatomy.point(Landmark::Mouth).ok_or(MouthError::Landmark("mouth"))?;
        let head = anatomy.frame();
        // Projected onto the plane of symmetry, because the landmark may be off it.
        let mut local = head.local(mouth);
        local[0] = 0.0;
        let vector = |v: [f64; 3]| Vec3::from(v.map(|x| x as f32));
        Ok(Self {
            origin: vector(head.world(local)),
            axes: head.axes.map(vector),
            mm: (head.unit / EYES_MM) as f32,
        })
    }

    /// Raises the origin, by an amount in its own millimetres.
    pub fn raised(mut self, by: f32) -> Self {
        self.origin = self.world(Vec3::new(0.0, by, 0.0));
        self
    }

    /// From the mesh's space.
    pub fn local(&self, position: [f32; 3]) -> Vec3 {
        let offset = (Vec3::from(position) - self.origin) / self.mm;
        Vec3::from(self.axes.map(|axis| axis.dot(offset)))
    }

    /// Into the mesh's space.
    pub fn world(&self, local: Vec3) -> Vec3 {
        let [x, y, z] = self.axes;
        self.origin + (x * local.x + y * local.y + z * local.z) * self.mm
    }
}
