//! A pinhole camera: x to the right, y down, z forward.

use glam::{DMat3, DVec3};

/// A camera without distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    /// From the head's space to the camera's.
    pub rotation: DMat3,
    /// Added after the rotation, in the head's unit.
    pub translation: DVec3,
    /// Focal length in pixels.
    pub focal_px: f64,
    /// Where the optical axis meets the image, in pixels.
    pub center_px: [f64; 2],
}

impl Pinhole {
    /// The rotation of a camera that sees a head which looks along +Z, with Y up, turned by angles
    /// in degrees.
    ///
    /// - `yaw`: to the right of the picture.
    /// - `pitch`: upwards.
    /// - `roll`: clockwise as one sees it.
    pub fn facing(yaw: f64, pitch: f64, roll: f64) -> DMat3 {
        let front = DMat3::from_diagonal(DVec3::new(1.0, -1.0, -1.0));
        // The axes are the camera's: x to the right, y down, z away.
        DMat3::from_rotation_z(roll.to_radians())
            * DMat3::from_rotation_x(pitch.to_radians())
            * DMat3::from_rotation_y(-yaw.to_radians())
            * front
    }

    /// Where a point appears in pixels, and its distance along the optical axis.
    pub fn project(&self, point: DVec3) -> [f64; 3] {
        let at = self.rotation * point + self.translation;
        let [x, y] = [at.x, at.y].map(|value| value * self.focal_px / at.z);
        [self.center_px[0] + x, self.center_px[1] + y, at.z]
    }

    /// The camera's position in the head's space.
    pub fn eye(&self) -> DVec3 {
        self.rotation.transpose() * -self.translation
    }
}
