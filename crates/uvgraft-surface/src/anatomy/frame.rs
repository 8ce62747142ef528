use glam::{DMat3, DVec3};

use crate::directions::direction;

/// The coordinate frame of a head: origin halfway between the centres of the eyes, x to the
/// person's left, y up, z forward, in the direction the face looks. The unit is the
/// distance between the centres of the eyes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeadFrame {
    /// The origin in the mesh's space.
    pub origin: [f64; 3],
    /// Unit vectors along x, y and z in the mesh's space.
    pub axes: [[f64; 3]; 3],
    /// The distance between the centres of the eyes, in the mesh's unit.
    pub unit: f64,
}

impl HeadFrame {
    /// The right-handed frame of `up` and `forward`; `None` if they are parallel.
    pub(super) fn new(origin: DVec3, up: DVec3, forward: DVec3, unit: f64) -> Option<Self> {
        let x = direction(up.cross(forward))?;
        let z = direction(forward)?;
        let axes = [x, z.cross(x), z].map(<[f64; 3]>::from);
        Some(Self { origin: origin.to_array(), axes, unit })
    }

    /// Whether another frame is that of the same head, found with other errors: upside-down faces and
    /// napes are at least half a turn off.
    pub(super) fn is_near(&self, other: &Self) -> bool {
        /// Cosine between axes, 14 degrees.
        const PARALLEL: f64 = 0.97;
        /// In distances between the eyes. Origin not recorded.
        const NEAR: f64 = 0.3;
        let axis = |frame: &Self, axis: usize| DVec3::from(frame.axes[axis]);
        let is_parallel = |k: usize| axis(self, k).dot(axis(other, k)) > PARALLEL;
        let apart = DVec3::from(self.origin).distance(DVec3::from(other.origin));
        let is_alike = (0.8..1.25).contains(&(self.unit / other.unit));
        is_parallel(1) && is_parallel(2) && apart < NEAR * self.unit && is_alike
    }

    /// Transforms a position from the mesh's space to the head's coordinates.
    pub fn local(&self, position: [f64; 3]) -> [f64; 3] {
        self.to_local(position.into()).to_array()
    }

    pub(super) fn to_local(self, position: DVec3) -> DVec3 {
        self.local_direction(position - DVec3::from(self.origin)) / self.unit
    }

    /// Transforms a position from the head's coordinates to the mesh's space.
    pub fn world(&self, local: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = self.axes.map(DVec3::from);
        let [left, up, forward] = local.map(|value| value * self.unit);
        (DVec3::from(self.origin) + x * left + y * up + z * forward).to_array()
    }

    /// Rotates a direction from the mesh's space to the head's axes.
    pub(super) fn local_direction(&self, direction: DVec3) -> DVec3 {
        DMat3::from_cols_array_2d(&self.axes).transpose_mul_vec3(direction)
    }
}
