//! Folders that INSTA reads, made from metrical-tracker's output.
//!
//! Source: INSTA, `scripts/transforms.py` (writes), `scripts/postprocess.py` (images) and
//! `instant-ngp/src/nerf_loader.cu` with `nerf_loader.h` (read):
//! - `transform_matrix` leads from the camera to the world and, unlike in other data sets of this
//!   form, has OpenCV's axes of the camera: it is the inverse of metrical-tracker's `opencv`.
//! - Intrinsic parameters are pixels, for all frames.
//! - `flame/exp/00000.txt` has an expression coefficient a line, `meshes/00000.obj` is the posed
//!   mesh and `canonical.obj` the shaped one. Shape, jaw and eyes are in the meshes only. (Its script
//!   has a list of other parameters that is commented out; `flame/shape`, `flame/jaw` and
//!   `flame/eyes` are read where they exist, as metrical-tracker has them.)
//! - Images have an alpha channel that is the mask; `seg_mask` has colours of parts of the face.

use std::path::{Path, PathBuf};

use super::TrackedFrame;
use super::camera::Pose;
use super::error::{ReadTrackingError, TrackingError};
use super::flame::{FlameParameters, MAX_COEFFICIENTS, Shared, coefficients, from_six_numbers};
use super::paths::{Reach, existing, number, optional, stated};
use super::transforms;
use uvgraft_files::input::{Input, ReadError};

/// Maximum size of a list of coefficients.
const MAX_BYTES: u64 = 1 << 16;

pub(super) fn read(folder: &Path) -> Result<Vec<TrackedFrame>, ReadTrackingError> {
    let mut shape = Shared::default();
    transforms::frames(folder, |index, frame, shared, subset| {
        let path = |name, path: &str| stated(folder, (index, name), path, Reach::Folder);
        let expression = frame
            .exp_path
            .as_deref()
            .ok_or_else(|| TrackingError::value("exp_path", "the path of a file", "nothing"))?;
        let mesh = frame.mesh_path.as_deref().map(|mesh| path("mesh_path", mesh)).transpose()?;
        let pose = Pose::from_rows("transform_matrix", &frame.transform_matrix)?.inverse();
        let image = path("file_path", &frame.file_path)?;
        let mesh = mesh.and_then(optional);
        let expression = path("exp_path", expression)?;
        let camera = pose.camera(&frame.optics().intrinsics(shared)?)?;
        let name = expression.file_name().unwrap_or_default().to_owned();
        let other = |parameter: &str| {
            let path = optional(folder.join("flame").join(parameter).join(&name));
            path.map(|path| numbers(&path).map(|found| (found, path))).transpose()
        };
        let flame = FlameParameters {
            expression: numbers(&expression)?,
            jaw: rotations::<1>("jaw", other("jaw")?)?.map(|[jaw]| jaw),
            eyes: rotations("eyes", other("eyes")?)?,
            ..FlameParameters::at_rest(
                shape.get(other("shape")?.map_or(Vec::new(), |(shape, _)| shape)),
            )
        };
        Ok(TrackedFrame {
            timestep: number(&image).unwrap_or(index as u32),
            image: existing(image)?,
            mask: None,
            mesh,
            camera_id: "0".to_owned(),
            subset,
            camera,
            flame,
        })
    })
}

type Numbers = (Vec<f32>, PathBuf);

fn rotations<const N: usize>(
    name: &'static str,
    found: Option<Numbers>,
) -> Result<Option<[[f32; 3]; N]>, ReadTrackingError> {
    let Some((values, path)) = found else { return Ok(None) };
    match from_six_numbers(name, &values) {
        Ok(turns) => Ok(Some(turns)),
        Err(reason) => Err(ReadError::Content { path, reason }),
    }
}

/// The numbers of a text file that `numpy.savetxt` writes, one a line.
fn numbers(path: &Path) -> Result<Vec<f32>, ReadTrackingError> {
    const NAME: &str = "coefficients";
    Input::from(path).parse(MAX_BYTES, |bytes| {
        let text = std::str::from_utf8(bytes)
            .map_err(|_| TrackingError::value(NAME, "text", "invalid UTF-8"))?;
        let parse = |word: &str| {
            word.parse::<f32>()
                .map_err(|_| TrackingError::value(NAME, "numbers", format_args!("`{word}`")))
        };
        let values = text.split_whitespace().take(MAX_COEFFICIENTS + 1).map(parse);
        let values = values.collect::<Result<Vec<f32>, TrackingError>>()?;
        coefficients(NAME, &values)?;
        Ok(values)
    })
}
