//! Cameras and FLAME parameters of tracked videos, as four head trackers write them.
//!
//! | | detected by | axes of cameras | intrinsics | rotations |
//! |---|---|---|---|---|
//! | VHAP | `transforms*.json` with `flame_param_path` or `timestep_index` | OpenGL, camera to world | pixels | axis-angle |
//! | metrical-tracker | `checkpoint/*.frame` | OpenCV, or PyTorch3D | pixels, or NDC | six numbers |
//! | INSTA | `transforms*.json` with `exp_path` | OpenCV, camera to world | pixels | six numbers |
//! | IMavatar | `flame_params.json` with `world_mat` | OpenGL, world to camera | relative to the image | axis-angle |
//!
//! All become a [`TrackedCamera`] in OpenCV's axes and [`FlameParameters`] with axis-angle
//! rotations. Each file here is one tracker's, with the source of its format on top.
//!
//! Paths in JSON files must be relative and stay within the folder, as written; those of VHAP may
//! also lead to folders beside it, because its combined data sets refer to them. Images must exist;
//! masks and meshes are optional, and are given where there is a file.

mod camera;
mod error;
mod flame;
mod imavatar;
mod insta;
mod json;
mod metrical;
mod paths;
mod rotation;
#[cfg(test)]
mod tests;
mod transforms;
mod vhap;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use self::camera::TrackedCamera;
pub use self::error::{ReadTrackingError, TrackingError};
pub use self::flame::FlameParameters;
use uvgraft_files::input::ReadError;

/// Maximum number of frames of a folder.
pub const MAX_FRAMES: usize = 1 << 18;

/// Checks a number of frames against [`MAX_FRAMES`].
fn check_frames(found: usize) -> Result<(), TrackingError> {
    if found > MAX_FRAMES {
        return Err(TrackingError::TooMany { what: "frames", most: MAX_FRAMES, found });
    }
    Ok(())
}

/// A head tracker.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Tracker {
    /// VHAP, in the form it exports for GaussianAvatars.
    Vhap,
    /// metrical-tracker, of MICA's authors.
    MetricalTracker,
    /// INSTA's input, made from metrical-tracker's output.
    Insta,
    /// IMavatar's and PointAvatar's input, from DECA.
    Imavatar,
}

impl std::fmt::Display for Tracker {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Vhap => "VHAP",
            Self::MetricalTracker => "metrical-tracker",
            Self::Insta => "INSTA",
            Self::Imavatar => "IMavatar",
        })
    }
}

/// Which part of a data set a frame belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Subset {
    /// The data set is not divided, or was read as a whole.
    Whole,
    /// For training.
    Train,
    /// For validation.
    Validation,
    /// For testing.
    Test,
}

/// A tracked video, or several of the same person.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracking {
    /// Who tracked it.
    pub tracker: Tracker,
    /// The frames, sorted by time step, then camera. At least one.
    pub frames: Vec<TrackedFrame>,
    /// The person's shape coefficients: those of the frames, or their mean where they differ. Empty
    /// for INSTA.
    pub shape: Arc<[f32]>,
    /// The mesh of the shape without expression and with the jaw opened by 12°, which
    /// metrical-tracker writes (`canonical.obj`) and INSTA copies.
    pub canonical_mesh: Option<PathBuf>,
}

/// An image with its camera and head.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedFrame {
    /// The image, which exists. INSTA's have an alpha channel that is the mask.
    pub image: PathBuf,
    /// An image that is white where the person is.
    pub mask: Option<PathBuf>,
    /// The mesh of the posed head in the world (OBJ or PLY), without texture coordinates.
    pub mesh: Option<PathBuf>,
    /// The name of the camera; `0` for trackers of a single one.
    pub camera_id: String,
    /// The time step. Cameras that saw the same moment have the same.
    pub timestep: u32,
    /// Which part of a divided data set.
    pub subset: Subset,
    /// The camera.
    pub camera: TrackedCamera,
    /// The head.
    pub flame: FlameParameters,
}

/// Which tracker wrote a folder, by the content of its files; `None` for other folders, such as
/// images alone.
///
/// # Errors
/// [`ReadTrackingError`] if the folder or a file that decides cannot be read, or is damaged.
pub fn detect(folder: &Path) -> Result<Option<Tracker>, ReadTrackingError> {
    // An error for what is not a folder.
    std::fs::read_dir(folder)
        .map_err(|reason| ReadError::Io { path: folder.to_owned(), reason })?;
    if metrical::is_it(folder)? {
        return Ok(Some(Tracker::MetricalTracker));
    }
    if imavatar::is_it(folder)? {
        return Ok(Some(Tracker::Imavatar));
    }
    transforms::tracker(folder)
}

/// Reads a folder.
///
/// # Errors
/// [`ReadTrackingError`] with the file: if it is of no tracker ([`detect`]), if a file is missing,
/// damaged or beyond a limit, if an image is missing, and for cameras and parameters that are not
/// possible.
pub fn read(folder: &Path) -> Result<Tracking, ReadTrackingError> {
    let content = |reason| ReadError::Content { path: folder.to_owned(), reason };
    let Some(tracker) = detect(folder)? else {
        return Err(content(vhap::not_exported(folder).unwrap_or(TrackingError::Unknown)));
    };
    let mut frames = match tracker {
        Tracker::Vhap => vhap::read(folder),
        Tracker::MetricalTracker => metrical::read(folder),
        Tracker::Insta => insta::read(folder),
        Tracker::Imavatar => imavatar::read(folder),
    }?;
    // Subsets may overlap: INSTA's frames for validation are among those for testing.
    let mut known = HashSet::new();
    frames.retain(|frame| known.insert(frame.image.clone()));
    frames.sort_by(|a, b| (a.timestep, &a.camera_id).cmp(&(b.timestep, &b.camera_id)));
    let Some(shape) = mean_shape(&frames) else { return Err(content(TrackingError::NoFrames)) };
    let canonical_mesh = match tracker {
        Tracker::MetricalTracker | Tracker::Insta => paths::optional(folder.join("canonical.obj")),
        Tracker::Vhap | Tracker::Imavatar => None,
    };
    Ok(Tracking { tracker, frames, shape, canonical_mesh })
}

/// The shape of the frames, or the mean of different ones; `None` without frames. Missing
/// coefficients are 0.
fn mean_shape(frames: &[TrackedFrame]) -> Option<Arc<[f32]>> {
    let first = &frames.first()?.flame.shape;
    if frames
        .iter()
        .all(|frame| Arc::ptr_eq(&frame.flame.shape, first) || frame.flame.shape == *first)
    {
        return Some(Arc::clone(first));
    }
    let length = frames.iter().map(|frame| frame.flame.shape.len()).max().unwrap_or(0);
    let mut sum = vec![0.0; length];
    for frame in frames {
        for (sum, &value) in sum.iter_mut().zip(frame.flame.shape.iter()) {
            *sum += f64::from(value);
        }
    }
    Some(sum.into_iter().map(|sum| (sum / frames.len() as f64) as f32).collect())
}
