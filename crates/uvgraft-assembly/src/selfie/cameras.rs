//! Fitted cameras as JSON.

use serde::Serialize;
use uvgraft_pipeline::{Blame, Result};
use uvgraft_selfie::FittedPhoto;

use super::fitted::FittedSelfie;

#[derive(Serialize)]
struct Document {
    /// Distance between the eyes in the mesh's unit.
    eye_distance: f64,
    cameras: Vec<CameraEntry>,
}

/// A camera in OpenCV's axes. Nothing of the photograph's file: names tell more than one may want.
#[derive(Serialize)]
struct CameraEntry {
    /// From the head's space to the camera's, by rows.
    rotation: [[f64; 3]; 3],
    /// Added after the rotation, in the mesh's unit.
    translation: [f64; 3],
    focal_px: f64,
    center_px: [f64; 2],
    /// Width and height of the upright photograph.
    size: [u32; 2],
    /// Median distance of the landmarks from those of the fitted head.
    residual_px: f64,
}

impl FittedSelfie {
    /// The cameras in the order of the photographs, as JSON.
    ///
    /// For each: `rotation` (by rows) and `translation` from the head's space to the camera's, whose x
    /// points to the right, y down and z forwards; `focal_px` and `center_px`, where the centre of the
    /// first pixel is at 0.5; `size` of the photograph; and `residual_px`, the median distance of the
    /// landmarks from those of the fitted head. And `eye_distance`, in the mesh's unit.
    ///
    /// # Errors
    /// If a number is not finite.
    pub fn cameras_json(&self) -> Result<String> {
        let entry = |(fitted, size): (&FittedPhoto, uvgraft::Size)| CameraEntry {
            rotation: fitted.camera.rotation.transpose().to_cols_array_2d(),
            translation: fitted.camera.translation.to_array(),
            focal_px: fitted.camera.focal_px,
            center_px: fitted.camera.center_px,
            size: [size.width, size.height],
            residual_px: fitted.residual_px,
        };
        let sizes = self.photos.iter().map(|photo| photo.landmarks.size);
        let document = Document {
            eye_distance: self.head.unit(),
            cameras: self.fit.photos.iter().zip(sizes).map(entry).collect(),
        };
        Ok(serde_json::to_string_pretty(&document).or_work()? + "\n")
    }
}
