//! The camera that all trackers' cameras are converted to.

use glam::{DMat3, DVec3};
use uvgraft::texture::{Size, Texture};

use super::error::TrackingError;
use super::rotation::is_rotation;

/// A pinhole camera without lens distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackedCamera {
    /// Focal length along x, in pixels, above 0.
    pub fx: f64,
    /// Focal length along y, in pixels, above 0.
    pub fy: f64,
    /// x of the principal point in pixels: 0 is the left edge of the image, and the centre of its
    /// first pixel is at 0.5.
    pub cx: f64,
    /// y of the principal point in pixels, downwards from the upper edge of the image.
    pub cy: f64,
    /// The size of the image to which these pixels belong, as the tracker states it.
    pub size: Size,
    /// From the world to the camera, by rows: a rotation and a translation, with the last row
    /// `[0, 0, 0, 1]`. Axes of the camera are those of OpenCV: x to the right of the image, y down,
    /// z forward.
    pub camera_from_world: [[f64; 4]; 4],
}

impl TrackedCamera {
    /// The pixel at which a point of the world appears, also outside of the image; `None` for points
    /// that are not in front of the camera.
    pub fn project(&self, world: [f64; 3]) -> Option<[f64; 2]> {
        let [x, y, z] = self.camera_point(world);
        (z > 0.0).then(|| [self.fx * x / z + self.cx, self.fy * y / z + self.cy])
    }

    /// A point of the world in the axes of the camera.
    pub fn camera_point(&self, world: [f64; 3]) -> [f64; 3] {
        let [a, b, c, _] = self.camera_from_world;
        [a, b, c].map(|row| row[0] * world[0] + row[1] * world[1] + row[2] * world[2] + row[3])
    }

    /// The same camera for an image that was scaled to another size.
    #[must_use]
    pub fn for_size(&self, size: Size) -> Self {
        let x = f64::from(size.width) / f64::from(self.size.width);
        let y = f64::from(size.height) / f64::from(self.size.height);
        let Self { fx, fy, cx, cy, .. } = *self;
        Self { fx: fx * x, fy: fy * y, cx: cx * x, cy: cy * y, size, ..*self }
    }
}

/// Intrinsic parameters in pixels: `fx`, `fy`, `cx` and `cy`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Intrinsics {
    pub(super) focal: [f64; 2],
    pub(super) center: [f64; 2],
    pub(super) size: Size,
}

/// A rotation and a translation after it, in OpenCV's axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    pub(super) rotation: DMat3,
    pub(super) translation: DVec3,
}

impl Pose {
    /// Splits a matrix of 3 or 4 rows.
    pub(super) fn from_rows(name: &'static str, rows: &[[f64; 4]]) -> Result<Self, TrackingError> {
        let wanted = "a rotation and a translation, as 3×4 or 4×4 numbers";
        let bad = || TrackingError::value(name, wanted, format_args!("{rows:?}"));
        let (&[a, b, c] | &[a, b, c, [0.0, 0.0, 0.0, 1.0]]) = rows else { return Err(bad()) };
        let rotation = [a, b, c].map(|[x, y, z, _]| [x, y, z]);
        let rotation = DMat3::from_cols_array_2d(&rotation).transpose();
        let translation = DVec3::new(a[3], b[3], c[3]);
        if is_rotation(&rotation) && translation.is_finite() {
            Ok(Self { rotation, translation })
        } else {
            Err(bad())
        }
    }

    /// From the camera to the world, if it was from the world to the camera, and back.
    pub(super) fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// The pose with the axes of the camera multiplied by 1 or -1, of a pose from the world to the
    /// camera.
    pub(super) fn with_axes(&self, signs: DVec3) -> Self {
        Self {
            rotation: DMat3::from_diagonal(signs) * self.rotation,
            translation: signs * self.translation,
        }
    }

    /// The camera with this pose from the world to the camera.
    pub(super) fn camera(&self, intrinsics: &Intrinsics) -> Result<TrackedCamera, TrackingError> {
        let Intrinsics { focal: [fx, fy], center: [cx, cy], size } = *intrinsics;
        for (name, focal) in [("focal length x", fx), ("focal length y", fy)] {
            if !(focal > 0.0 && focal.is_finite()) {
                return Err(TrackingError::value(name, "above 0 pixels", focal));
            }
        }
        for (name, center) in [("principal point x", cx), ("principal point y", cy)] {
            if !center.is_finite() {
                return Err(TrackingError::value(name, "finite", center));
            }
        }
        let [a, b, c] = self.rotation.transpose().to_cols_array_2d();
        let [x, y, z] = self.translation.to_array();
        let camera_from_world = [
            [a[0], a[1], a[2], x],
            [b[0], b[1], b[2], y],
            [c[0], c[1], c[2], z],
            [0.0, 0.0, 0.0, 1.0],
        ];
        Ok(TrackedCamera { fx, fy, cx, cy, size, camera_from_world })
    }
}

/// From OpenGL's axes of a camera (x right, y up, z backward) to OpenCV's, and back.
pub(super) const OPENGL: DVec3 = DVec3::new(1.0, -1.0, -1.0);

/// From PyTorch3D's axes of a camera (x left, y up, z forward) to OpenCV's, and back.
pub(super) const PYTORCH3D: DVec3 = DVec3::new(-1.0, -1.0, 1.0);

/// The size of an image stated in numbers that may be floats.
pub(super) fn size(width: f64, height: f64) -> Result<Size, TrackingError> {
    let side = |name, value: f64| {
        if value.fract() == 0.0 && (1.0..=f64::from(Texture::MAX_SIDE)).contains(&value) {
            return Ok(value as u32);
        }
        let wanted = format!("a number of pixels from 1 to {}", Texture::MAX_SIDE);
        Err(TrackingError::value(name, wanted, value))
    };
    Ok(Size::new(side("width", width)?, side("height", height)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> TrackedCamera {
        let size = Size::new(640, 480);
        let intrinsics = Intrinsics { focal: [1000.0, 800.0], center: [320.0, 240.0], size };
        // A quarter turn about y: x of the world is z of the camera.
        let rows = [[0.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 2.0]];
        Pose::from_rows("pose", &rows).unwrap().camera(&intrinsics).unwrap()
    }

    #[test]
    fn projects_by_hand() {
        // x = -0.1, y = 0.2, z = 2 + 2: 320 - 1000 * 0.1 / 4, 240 + 800 * 0.2 / 4.
        assert_eq!(camera().project([2.0, 0.2, 0.1]), Some([295.0, 280.0]));
        assert_eq!(camera().project([-2.0, 0.0, 0.0]), None);
        let half = camera().for_size(Size::new(320, 240));
        assert_eq!(half.project([2.0, 0.2, 0.1]), Some([147.5, 140.0]));
    }

    #[test]
    fn inverse_leads_back() {
        let rows = [[0.0, 0.0, -1.0, 3.0], [0.0, 1.0, 0.0, 4.0], [1.0, 0.0, 0.0, 5.0]];
        let inverse = Pose::from_rows("pose", &rows).unwrap().inverse();
        // The centre of the camera: [-5, -4, 3], which the rows take to 0.
        assert_eq!(inverse.translation, DVec3::new(-5.0, -4.0, 3.0));
        assert_eq!(inverse.inverse().translation, DVec3::new(3.0, 4.0, 5.0));
    }

    #[test]
    fn nonsense_is_refused() {
        let error = Pose::from_rows("pose", &[[1.0; 4]; 3]).unwrap_err().to_string();
        assert!(error.starts_with("`pose` must be a rotation and a translation"), "{error}");
        assert!(
            error.ends_with(
                "got [[1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0], [1.0, 1.0, 1.0, 1.0]]"
            ),
            "{error}"
        );
        assert!(Pose::from_rows("pose", &[[1.0; 4]; 2]).is_err());
        let pose = Pose { rotation: DMat3::ZERO, translation: DVec3::ZERO };
        let focal = |focal| {
            let intrinsics =
                Intrinsics { focal: [1.0, focal], center: [0.0; 2], size: Size::new(1, 1) };
            pose.camera(&intrinsics).map_err(|error| error.to_string())
        };
        assert_eq!(focal(0.0), Err("`focal length y` must be above 0 pixels, got 0".to_owned()));
        assert!(focal(f64::NAN).is_err() && focal(f64::INFINITY).is_err());
        for side in [0.0, -1.0, 0.5, f64::NAN, 1e9] {
            assert!(size(side, 1.0).is_err() && size(1.0, side).is_err(), "{side}");
        }
        assert_eq!(size(512.0, 256.0).unwrap(), Size::new(512, 256));
    }
}
