//! Fitted cameras as JSON.

use std::io::{self, Write as _};
use std::path::Path;

use anyhow::Context;
use serde::Serialize;
use uvgraft_io::output::write_atomically;
use uvgraft_selfie::FittedPhoto;

use super::made::Selfie;

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

/// Writes the cameras in the order of the photographs.
pub(super) fn write(selfie: &Selfie, path: &Path) -> anyhow::Result<()> {
    let entry = |(fitted, size): (&FittedPhoto, uvgraft::Size)| CameraEntry {
        rotation: fitted.camera.rotation.transpose().to_cols_array_2d(),
        translation: fitted.camera.translation.to_array(),
        focal_px: fitted.camera.focal_px,
        center_px: fitted.camera.center_px,
        size: [size.width, size.height],
        residual_px: fitted.residual_px,
    };
    let sizes = selfie.photos.iter().map(|photo| photo.landmarks.size);
    let document = Document {
        eye_distance: selfie.head.unit(),
        cameras: selfie.fit.photos.iter().zip(sizes).map(entry).collect(),
    };
    let text = serde_json::to_string_pretty(&document)? + "\n";
    write_atomically::<io::Error>(path, |out| out.write_all(text.as_bytes()))
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(())
}
