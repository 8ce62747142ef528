//! Output folders of metrical-tracker.
//!
//! Source: metrical-tracker, `tracker.py` (`save_checkpoint`) and `flame/FLAME.py`:
//! - `checkpoint/00000.frame` is a torch file of NumPy arrays. The image is `input/00000.png`, the
//!   posed mesh `mesh/00000.ply`, and `canonical.obj` the shaped one.
//! - `opencv` has a camera by PyTorch3D's `opencv_from_cameras_projection`: `R` and `t` from the
//!   world to the camera, `K` in pixels of an image of `img_size` (height, width).
//! - `camera` has the same camera as it was optimised, which is read where there is no `opencv`: `R`
//!   as six numbers of a matrix that multiplies rows from the right, with PyTorch3D's axes (x left,
//!   y up, z forward); `fl` and `pp` in units of half the shorter side of the image (NDC), with the
//!   principal point relative to the centre and to the left and up.
//! - `flame` has `shape` (300), `exp` (100), and rotations as six numbers: `jaw`, and `eyes` (left
//!   and right). The head does not move: the camera does. `eyelids` weigh two blend shapes of the
//!   tracker's own.

use std::path::Path;

use uvgraft::texture::Size;

use super::camera::{Intrinsics, PYTORCH3D, Pose, size};
use super::error::{ReadTrackingError, TrackingError};
use super::flame::{FlameParameters, Shared, fixed, from_six_numbers, row};
use super::paths::{existing, files_with, number, optional};
use super::rotation::from_six;
use super::{Subset, TrackedCamera, TrackedFrame, check_frames};
use crate::arrays::{NamedArrays, NumericArray};
use crate::torch;
use uvgraft_files::input::{Input, ReadError};

/// Maximum size of a checkpoint. They have about 10 kB.
const MAX_BYTES: u64 = 1 << 24;

pub(super) fn is_it(folder: &Path) -> Result<bool, ReadTrackingError> {
    let checkpoints = folder.join("checkpoint");
    Ok(checkpoints.is_dir() && !files_with(&checkpoints, "frame")?.is_empty())
}

pub(super) fn read(folder: &Path) -> Result<Vec<TrackedFrame>, ReadTrackingError> {
    let checkpoints = folder.join("checkpoint");
    let files = files_with(&checkpoints, "frame")?;
    if let Err(reason) = check_frames(files.len()) {
        return Err(ReadError::Content { path: checkpoints, reason });
    }
    let mut shape = Shared::default();
    let mut frames = Vec::with_capacity(files.len());
    for (index, path) in files.into_iter().enumerate() {
        let (camera, flame) = Input::from(&path).parse(MAX_BYTES, |bytes| {
            let arrays = torch::parse(bytes)?;
            Ok::<_, TrackingError>((camera(&arrays)?, flame(&arrays, &mut shape)?))
        })?;
        let beside = |folder_name: &str, extension: &str| {
            let name = path.file_name().unwrap_or_default();
            folder.join(folder_name).join(name).with_extension(extension)
        };
        frames.push(TrackedFrame {
            image: existing(beside("input", "png"))?,
            mask: None,
            mesh: optional(beside("mesh", "ply")),
            camera_id: "0".to_owned(),
            timestep: number(&path).unwrap_or(index as u32),
            subset: Subset::Whole,
            camera,
            flame,
        });
    }
    Ok(frames)
}

/// Exactly `N` finite numbers, of any shape.
fn numbers<const N: usize>(
    arrays: &NamedArrays,
    name: &'static str,
) -> Result<[f64; N], TrackingError> {
    let array = arrays.require(name)?;
    let found: Result<[f64; N], _> = (&*array.f64s()).try_into();
    found.ok().filter(|values| values.iter().all(|value| value.is_finite())).ok_or_else(|| {
        let wanted = format!("{N} finite numbers");
        match array.shape() {
            shape if shape.iter().product::<usize>() != N => {
                TrackingError::value(name, wanted, format_args!("shape {shape:?}"))
            }
            _ => TrackingError::value(name, wanted, format_args!("{:?}", array.f64s())),
        }
    })
}

fn rows(values: [f64; 9]) -> [[f64; 3]; 3] {
    let [a, b, c, d, e, f, g, h, i] = values;
    [[a, b, c], [d, e, f], [g, h, i]]
}

fn camera(arrays: &NamedArrays) -> Result<TrackedCamera, TrackingError> {
    let [height, width] = numbers(arrays, "img_size")?;
    let size = size(width, height)?;
    if arrays.get("opencv.K").is_none() && arrays.get("camera.R").is_some() {
        return optimised(arrays, size);
    }
    let [[fx, skew, cx], [zero, fy, cy], last] = rows(numbers(arrays, "opencv.K")?);
    if [skew, zero] != [0.0; 2] || last != [0.0, 0.0, 1.0] {
        let found = format_args!("{:?}", [[fx, skew, cx], [zero, fy, cy], last]).to_string();
        return Err(TrackingError::value(
            "opencv.K",
            "[[fx, 0, cx], [0, fy, cy], [0, 0, 1]]",
            found,
        ));
    }
    let [a, b, c] = rows(numbers(arrays, "opencv.R")?);
    let [x, y, z] = numbers(arrays, "opencv.t")?;
    let pose = [[a[0], a[1], a[2], x], [b[0], b[1], b[2], y], [c[0], c[1], c[2], z]];
    let intrinsics = Intrinsics { focal: [fx, fy], center: [cx, cy], size };
    Pose::from_rows("opencv.R", &pose)?.camera(&intrinsics)
}

/// The camera as PyTorch3D has it.
fn optimised(arrays: &NamedArrays, size: Size) -> Result<TrackedCamera, TrackingError> {
    let six = numbers(arrays, "camera.R")?;
    let rotation = from_six(six).ok_or_else(|| {
        let found = format_args!("{six:?}").to_string();
        TrackingError::value("camera.R", "two independent directions", found)
    })?;
    let translation = numbers(arrays, "camera.t")?.into();
    // One focal length, or two.
    let [fx, fy] = match arrays.get("camera.fl").map(|array| array.f64s().len()) {
        Some(2) => numbers(arrays, "camera.fl")?,
        _ => numbers::<1>(arrays, "camera.fl").map(|[focal]| [focal; 2])?,
    };
    let [px, py] = numbers(arrays, "camera.pp")?;
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let unit = width.min(height) / 2.0;
    let intrinsics = Intrinsics {
        focal: [fx * unit, fy * unit],
        center: [width / 2.0 - px * unit, height / 2.0 - py * unit],
        size,
    };
    let pose = Pose { rotation: rotation.transpose(), translation };
    pose.with_axes(PYTORCH3D).camera(&intrinsics)
}

fn flame(arrays: &NamedArrays, shape: &mut Shared<f32>) -> Result<FlameParameters, TrackingError> {
    let get = |name| row(name, arrays.require(name)?);
    let eyelids = arrays.get("flame.eyelids").map(NumericArray::f32s);
    let eyelids = eyelids.map(|values| fixed("flame.eyelids", &values)).transpose()?;
    let [jaw] = from_six_numbers("flame.jaw", &get("flame.jaw")?)?;
    Ok(FlameParameters {
        expression: get("flame.exp")?,
        jaw: Some(jaw),
        eyes: Some(from_six_numbers("flame.eyes", &get("flame.eyes")?)?),
        eyelids,
        ..FlameParameters::at_rest(shape.get(get("flame.shape")?))
    })
}
