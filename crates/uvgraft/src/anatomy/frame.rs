use crate::vector::{Vector, cross, direction, dot, plus, sub};

/// The coordinates of a head: origin halfway between the centres of the eyes, x to the person's left, y up,
/// z where the face looks; the unit is the distance between the centres of the eyes.
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
    pub(super) fn new(origin: Vector, up: Vector, forward: Vector, unit: f64) -> Option<Self> {
        let x = direction(cross(up, forward))?;
        let z = direction(forward)?;
        Some(Self { origin, axes: [x, cross(z, x), z], unit })
    }

    /// A position of the mesh's space in the head's coordinates.
    pub fn local(&self, position: [f64; 3]) -> [f64; 3] {
        let offset = sub(position, self.origin);
        self.axes.map(|axis| dot(offset, axis) / self.unit)
    }

    /// A position of the head's coordinates in the mesh's space.
    pub fn world(&self, local: [f64; 3]) -> [f64; 3] {
        (0..3).fold(self.origin, |sum, k| plus(sum, local[k] * self.unit, self.axes[k]))
    }

    /// A direction of the mesh's space along the head's axes.
    pub(super) fn local_direction(&self, direction: Vector) -> Vector {
        self.axes.map(|axis| dot(direction, axis))
    }
}
