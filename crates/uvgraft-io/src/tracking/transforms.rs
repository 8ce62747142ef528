//! `transforms.json`, the form of NeRF's data sets that VHAP and INSTA extend.
//!
//! Source: instant-ngp's loader, as in INSTA (`instant-ngp/src/nerf_loader.cu`): `fl_x`, `fl_y`,
//! `cx` and `cy` are pixels, `camera_angle_x` and `camera_angle_y` are fields of view in radians.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::camera::{Intrinsics, size};
use super::error::{ReadTrackingError, TrackingError};
use super::json::{self, First, Frames, Name};
use super::paths::optional;
use super::{Subset, TrackedFrame, Tracker, check_frames};
use uvgraft_files::input::ReadError;

const WANTED: &str = "a tracked data set (transforms.json)";

/// A file. Values that all frames share are beside them.
///
/// The optical values are listed twice, because `serde(flatten)` would keep every other value of a
/// damaged file in memory.
#[derive(Debug, Deserialize)]
struct Transforms {
    frames: Frames<Frame>,
    w: Option<f64>,
    h: Option<f64>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
}

#[derive(Debug, Deserialize)]
pub(super) struct Frame {
    pub(super) file_path: String,
    pub(super) transform_matrix: [[f64; 4]; 4],
    pub(super) timestep_index: Option<u32>,
    pub(super) camera_id: Option<Name>,
    pub(super) camera_index: Option<u32>,
    pub(super) fg_mask_path: Option<String>,
    pub(super) flame_param_path: Option<String>,
    pub(super) mesh_path: Option<String>,
    pub(super) exp_path: Option<String>,
    w: Option<f64>,
    h: Option<f64>,
    fl_x: Option<f64>,
    fl_y: Option<f64>,
    cx: Option<f64>,
    cy: Option<f64>,
    camera_angle_x: Option<f64>,
    camera_angle_y: Option<f64>,
}

/// The intrinsic parameters of a file or of one of its frames.
#[derive(Debug, Clone, Copy)]
pub(super) struct Optics {
    size: [Option<f64>; 2],
    focal: [Option<f64>; 2],
    center: [Option<f64>; 2],
    angles: [Option<f64>; 2],
}

impl Transforms {
    const fn optics(&self) -> Optics {
        let Self { w, h, fl_x, fl_y, cx, cy, camera_angle_x, camera_angle_y, .. } = *self;
        Optics {
            size: [w, h],
            focal: [fl_x, fl_y],
            center: [cx, cy],
            angles: [camera_angle_x, camera_angle_y],
        }
    }
}

impl Frame {
    pub(super) const fn optics(&self) -> Optics {
        let Self { w, h, fl_x, fl_y, cx, cy, camera_angle_x, camera_angle_y, .. } = *self;
        Optics {
            size: [w, h],
            focal: [fl_x, fl_y],
            center: [cx, cy],
            angles: [camera_angle_x, camera_angle_y],
        }
    }
}

impl Optics {
    /// The parameters in pixels. Without a focal length it follows from the field of view, and
    /// without a principal point it is the centre of the image.
    ///
    /// - `shared`: for what the frame lacks.
    pub(super) fn intrinsics(&self, shared: &Self) -> Result<Intrinsics, TrackingError> {
        let missing = |name| TrackingError::value(name, "a number", "nothing");
        let [w, h] = [0, 1].map(|axis| self.size[axis].or(shared.size[axis]));
        let (w, h) = (w.ok_or_else(|| missing("w"))?, h.ok_or_else(|| missing("h"))?);
        let size = size(w, h)?;
        let focal = |of: &Self| {
            let by_angle = |side: f64, angle: Option<f64>| Some(side / 2.0 / (angle? / 2.0).tan());
            let x = of.focal[0].or_else(|| by_angle(w, of.angles[0]));
            let y = of.focal[1].or_else(|| by_angle(h, of.angles[1]));
            Some([x.or(y)?, y.or(x)?])
        };
        let focal = focal(self).or_else(|| focal(shared)).ok_or_else(|| missing("fl_x"))?;
        let center = [(0, size.width), (1, size.height)].map(|(axis, side)| {
            self.center[axis].or(shared.center[axis]).unwrap_or(f64::from(side) / 2.0)
        });
        Ok(Intrinsics { focal, center, size })
    }
}

/// The files of a folder that exist: the whole data set, or else its subsets.
fn files(folder: &Path) -> Vec<(PathBuf, Subset)> {
    let at = |name: &str, subset| Some((optional(folder.join(name))?, subset));
    match at("transforms.json", Subset::Whole) {
        Some(whole) => vec![whole],
        None => [
            at("transforms_train.json", Subset::Train),
            at("transforms_val.json", Subset::Validation),
            at("transforms_test.json", Subset::Test),
        ]
        .into_iter()
        .flatten()
        .collect(),
    }
}

/// Why a frame was not read.
pub(super) enum FrameError {
    /// Its content was refused.
    Content(TrackingError),
    /// So was a file of it.
    File(ReadTrackingError),
}

impl From<TrackingError> for FrameError {
    fn from(error: TrackingError) -> Self {
        Self::Content(error)
    }
}

impl From<ReadTrackingError> for FrameError {
    fn from(error: ReadTrackingError) -> Self {
        Self::File(error)
    }
}

/// The frames of all files of a folder, in order.
///
/// - `read`: of a frame's number in its file, the frame, what the file's frames share, and the file's
///   subset.
pub(super) fn frames(
    folder: &Path,
    mut read: impl FnMut(usize, Frame, &Optics, Subset) -> Result<TrackedFrame, FrameError>,
) -> Result<Vec<TrackedFrame>, ReadTrackingError> {
    let mut frames = Vec::new();
    for (path, subset) in files(folder) {
        let file: Transforms = json::read(&path, WANTED)?;
        let shared = file.optics();
        let content = |reason| ReadError::Content { path: path.clone(), reason };
        check_frames(frames.len() + file.frames.0.len()).map_err(content)?;
        for (index, frame) in file.frames.0.into_iter().enumerate() {
            let frame = read(index, frame, &shared, subset);
            frames.push(frame.map_err(|error| match error {
                FrameError::Content(reason) => content(reason.in_frame(index)),
                FrameError::File(error) => error,
            })?);
        }
    }
    Ok(frames)
}

/// Which tracker's the data set is, by what its first frame refers to.
pub(super) fn tracker(folder: &Path) -> Result<Option<Tracker>, ReadTrackingError> {
    #[derive(Deserialize)]
    struct File {
        frames: Option<First<Keys>>,
    }
    #[derive(Deserialize)]
    struct Keys {
        timestep_index: Option<u32>,
        flame_param_path: Option<String>,
        exp_path: Option<String>,
    }
    for (path, _) in files(folder) {
        let file: File = json::read(&path, WANTED)?;
        match file.frames.and_then(|frames| frames.0) {
            // VHAP has `exp_path` too where it exports meshes.
            Some(Keys { timestep_index: Some(_), .. } | Keys { flame_param_path: Some(_), .. }) => {
                return Ok(Some(Tracker::Vhap));
            }
            Some(Keys { exp_path: Some(_), .. }) => return Ok(Some(Tracker::Insta)),
            _ => {}
        }
    }
    Ok(None)
}
