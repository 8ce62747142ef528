//! Folders that VHAP exports, which GaussianAvatars reads.
//!
//! Source: VHAP, `vhap/export_as_nerf_dataset.py` (writes), `vhap/data/nerf_dataset.py` and
//! GaussianAvatars' `scene/dataset_readers.py` (read), `vhap/combine_nerf_datasets.py` (combines):
//! - `transform_matrix` leads from the camera to the world, with OpenGL's axes of the camera.
//! - Intrinsic parameters are pixels, for each frame. The released data of GaussianAvatars has
//!   `camera_angle_x` instead.
//! - `flame_param/00000.npz` has arrays with one row: `shape` (without the row), `expr`, `rotation`,
//!   `neck_pose`, `jaw_pose`, `eyes_pose` (left and right), `translation` and maybe
//!   `static_offset`. Rotations are axis-angle vectors (`vhap/model/flame.py`); the translation is
//!   added after posing.
//! - A frame is a time step (`timestep_index`) seen by a camera (`camera_id`). Frames of the same
//!   time step share their parameters.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::TrackedFrame;
use super::camera::{OPENGL, Pose};
use super::error::{ReadTrackingError, TrackingError};
use super::flame::{FlameParameters, Shared, fixed, offsets, row};
use super::json::Name;
use super::paths::{Reach, existing, files_with, optional, stated};
use super::transforms;
use crate::arrays::{self, NamedArrays};
use uvgraft_files::input::Input;

/// Maximum size of a file of parameters. Those with offsets have about 150 kB.
const MAX_BYTES: u64 = 1 << 26;

/// The error for VHAP's own output, which has no images.
pub(super) fn not_exported(folder: &Path) -> Option<TrackingError> {
    let files = files_with(folder, "npz").ok()?;
    let mut names = files.iter().rev().filter_map(|path| path.file_name()?.to_str());
    let found = names.find(|name| name.starts_with("tracked_flame_params"))?.to_owned();
    Some(TrackingError::NotExported { found })
}

pub(super) fn read(folder: &Path) -> Result<Vec<TrackedFrame>, ReadTrackingError> {
    let mut heads = Heads::default();
    transforms::frames(folder, |index, frame, shared, subset| {
        let path = |name, path: &str| stated(folder, (index, name), path, Reach::Siblings);
        let maybe = |name, found: &Option<String>| match found {
            Some(found) => path(name, found).map(optional),
            None => Ok(None),
        };
        let mut image = path("file_path", &frame.file_path)?;
        if image.extension().is_none() {
            image.set_extension("png");
        }
        let parameters = frame.flame_param_path.as_deref().ok_or_else(|| {
            TrackingError::value(
                "flame_param_path",
                "the path of a file, as VHAP writes it with `param`",
                "nothing",
            )
        })?;
        let pose = Pose::from_rows("transform_matrix", &frame.transform_matrix)?.inverse();
        let mask = maybe("fg_mask_path", &frame.fg_mask_path)?;
        let mesh = maybe("mesh_path", &frame.mesh_path)?;
        let parameters = path("flame_param_path", parameters)?;
        let timestep =
            frame.timestep_index.unwrap_or_else(|| u32::try_from(index).unwrap_or(u32::MAX));
        let camera = pose.with_axes(OPENGL).camera(&frame.optics().intrinsics(shared)?)?;
        let flame = heads.read(&parameters)?;
        let numbered = || frame.camera_index.unwrap_or(0).to_string();
        let camera_id = frame.camera_id.map_or_else(numbered, |Name(name)| name);
        let image = existing(image)?;
        Ok(TrackedFrame { image, mask, mesh, camera_id, timestep, subset, camera, flame })
    })
}

/// The parameters of time steps, each read once.
#[derive(Default)]
struct Heads {
    read: HashMap<PathBuf, FlameParameters>,
    shape: Shared<f32>,
    offset: Shared<[f32; 3]>,
}

impl Heads {
    fn read(&mut self, path: &Path) -> Result<FlameParameters, ReadTrackingError> {
        if let Some(flame) = self.read.get(path) {
            return Ok(flame.clone());
        }
        let flame =
            Input::from(path).parse(MAX_BYTES, |bytes| self.parse(&arrays::parse(bytes)?))?;
        self.read.insert(path.to_owned(), flame.clone());
        Ok(flame)
    }

    fn parse(&mut self, arrays: &NamedArrays) -> Result<FlameParameters, TrackingError> {
        let get = |name| row(name, arrays.require(name)?);
        let static_offset = arrays.get("static_offset");
        let static_offset =
            static_offset.map(|array| offsets("static_offset", array)).transpose()?;
        let [a, b, c, d, e, f] = fixed("eyes_pose", &get("eyes_pose")?)?;
        Ok(FlameParameters {
            expression: get("expr")?,
            rotation: fixed("rotation", &get("rotation")?)?,
            translation: fixed("translation", &get("translation")?)?,
            neck: fixed("neck_pose", &get("neck_pose")?)?,
            jaw: Some(fixed("jaw_pose", &get("jaw_pose")?)?),
            eyes: Some([[a, b, c], [d, e, f]]),
            static_offset: static_offset.map(|offset| self.offset.get(offset)),
            ..FlameParameters::at_rest(self.shape.get(get("shape")?))
        })
    }
}
