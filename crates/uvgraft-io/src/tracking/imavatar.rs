//! Folders that IMavatar and PointAvatar read.
//!
//! Source: IMavatar, `preprocess/DECA/optimize.py` (writes), `code/datasets/real_dataset.py` and
//! `code/utils/rend_util.py` (read), `code/flame/FLAME.py`:
//! - `flame_params.json` has `frames`, `shape_params` and `intrinsics`; images are
//!   `image/NAME.png`, masks `mask/NAME.png`.
//! - `world_mat` leads from the world to the camera, 3×4, with OpenGL's axes (the camera looks along
//!   -z). A point appears at `intrinsics[0] * x / z + intrinsics[2]`, and likewise y. Since z is
//!   negative, `intrinsics[0]` is negative too.
//! - `intrinsics` are relative to the size of the image. In an old form, whose last value is above 1,
//!   they are pixels of an image of 512 pixels a side.
//! - `pose` is FLAME's 15 numbers: global, neck, jaw, left and right eye, as axis-angle vectors.
//! - FLAME is 4 times as large as in metres, and so is the world.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::Deserialize;
use uvgraft::texture::Size;

use super::camera::{Intrinsics, Pose};
use super::error::{ReadTrackingError, TrackingError};
use super::flame::{FlameParameters, coefficients, fixed};
use super::json::{self, First, Frames};
use super::paths::{Reach, existing, number, optional, stated};
use super::{Subset, TrackedCamera, TrackedFrame};
use uvgraft_files::input::ReadError;
use uvgraft_image as image;

const FILE: &str = "flame_params.json";
const WANTED: &str = "FLAME parameters for IMavatar";

/// The side of images to which the old form of the intrinsic parameters refers.
const OLD_SIDE: f64 = 512.0;

/// The size of FLAME in the world.
const SCALE: f32 = 4.0;

#[derive(Deserialize)]
struct File {
    frames: Frames<Frame>,
    intrinsics: [f64; 4],
    shape_params: Vec<f32>,
}

#[derive(Deserialize)]
struct Frame {
    file_path: String,
    world_mat: Vec<[f64; 4]>,
    expression: Vec<f32>,
    pose: Vec<f32>,
}

pub(super) fn is_it(folder: &Path) -> Result<bool, ReadTrackingError> {
    #[derive(Deserialize)]
    struct File {
        frames: Option<First<Keys>>,
    }
    #[derive(Deserialize)]
    struct Keys {
        world_mat: Option<serde::de::IgnoredAny>,
    }
    let Some(path) = optional(folder.join(FILE)) else { return Ok(false) };
    let file: File = json::read(&path, WANTED)?;
    Ok(file.frames.and_then(|frames| frames.0).is_some_and(|frame| frame.world_mat.is_some()))
}

pub(super) fn read(folder: &Path) -> Result<Vec<TrackedFrame>, ReadTrackingError> {
    let path = folder.join(FILE);
    let file: File = json::read(&path, WANTED)?;
    let content = |reason| ReadError::Content { path: path.clone(), reason };
    coefficients("shape_params", &file.shape_params).map_err(content)?;
    let shape: Arc<[f32]> = file.shape_params.into();
    let mut frames = Vec::with_capacity(file.frames.0.len());
    for (index, frame) in file.frames.0.into_iter().enumerate() {
        let content = |reason: TrackingError| content(reason.in_frame(index));
        let (image, mask) = pictures(folder, index, &frame.file_path).map_err(content)?;
        let image = existing(image)?;
        let size = image::read_header(&image).map_err(|error| error.map_content(Into::into))?.size;
        frames.push(TrackedFrame {
            camera: camera(&frame.world_mat, file.intrinsics, size).map_err(content)?,
            timestep: number(&image).unwrap_or(index as u32),
            mask,
            mesh: None,
            camera_id: "0".to_owned(),
            subset: Subset::Whole,
            flame: flame(frame, &shape).map_err(content)?,
            image,
        });
    }
    Ok(frames)
}

/// The image, and the mask in the folder beside its own.
fn pictures(
    folder: &Path,
    index: usize,
    stem: &str,
) -> Result<(PathBuf, Option<PathBuf>), TrackingError> {
    let file = format!("{stem}.png");
    let image = stated(folder, (index, "file_path"), &file, Reach::Folder)?;
    let mask = stated(folder, (index, "file_path"), &file.replace("image", "mask"), Reach::Folder)?;
    let mask = if mask == image { None } else { optional(mask) };
    Ok((image, mask))
}

fn camera(
    world_mat: &[[f64; 4]],
    intrinsics: [f64; 4],
    size: Size,
) -> Result<TrackedCamera, TrackingError> {
    let (width, height) = (f64::from(size.width), f64::from(size.height));
    let unit = if intrinsics[3] > 1.0 { OLD_SIDE } else { 1.0 };
    let [fx, fy, cx, cy] = intrinsics;
    let [fx, cx] = [fx, cx].map(|value| value / unit * width);
    let [fy, cy] = [fy, cy].map(|value| value / unit * height);
    // fx x / z is -fx x / (-z), where -z is forward.
    let signs = [-fx.signum(), -fy.signum(), -1.0];
    if signs[0] * signs[1] * signs[2] < 0.0 {
        let wanted = "a negative and a positive focal length first, as the camera looks along -z";
        return Err(TrackingError::value("intrinsics", wanted, format_args!("{intrinsics:?}")));
    }
    let pose = Pose::from_rows("world_mat", world_mat)?.with_axes(signs.into());
    pose.camera(&Intrinsics { focal: [fx.abs(), fy.abs()], center: [cx, cy], size })
}

fn flame(frame: Frame, shape: &Arc<[f32]>) -> Result<FlameParameters, TrackingError> {
    coefficients("expression", &frame.expression)?;
    let pose: [f32; 15] = fixed("pose", &frame.pose)?;
    let (joints, _) = pose.as_chunks::<3>();
    let &[rotation, neck, jaw, left, right] = joints else { unreachable!("15 is 5 times 3") };
    Ok(FlameParameters {
        expression: frame.expression,
        rotation,
        neck,
        jaw: Some(jaw),
        eyes: Some([left, right]),
        scale: SCALE,
        ..FlameParameters::at_rest(Arc::clone(shape))
    })
}
