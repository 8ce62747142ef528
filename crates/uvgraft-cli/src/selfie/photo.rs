//! One photograph: decoded, its face found, and cut to what is needed of it.

use std::path::{Path, PathBuf};

use uvgraft::{Depth, Size};
use uvgraft_io::image;
use uvgraft_selfie::landmarks::{FaceError, FaceNetworks};
use uvgraft_selfie::{Camera, PhotoLandmarks};

use super::options::PhotoArgs;
use super::window::{Bounds, Window};
use crate::failure::{OrBadInput, bad_input};

/// Largest size of a decoded photograph, in bytes.
const MOST_BYTES: usize = 400 << 20;

/// Where a focal length comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FocalSource {
    Option,
    Exif,
    Assumed,
}

/// A photograph with a face.
pub(crate) struct Photo {
    /// Its file, for messages.
    pub(crate) path: PathBuf,
    /// In pixels of the whole photograph.
    pub(crate) landmarks: PhotoLandmarks,
    /// Where the focal length in `landmarks` comes from.
    pub(crate) focal: FocalSource,
    /// What is kept of it.
    pub(crate) window: Window,
}

impl Photo {
    /// - `most`: largest number of pixels to keep.
    ///
    /// # Errors
    /// As bad input if the file is not an image of a face from the front.
    pub(super) fn read(
        path: &Path,
        networks: &FaceNetworks,
        args: &PhotoArgs,
        most: usize,
    ) -> anyhow::Result<Self> {
        check_size(path)?;
        let texture = image::read(path).or_bad_input()?.texture;
        let size = texture.size();
        let found =
            networks.find(&texture, args.choice()).map_err(|error| refused(path, &error))?;
        let given = args.focal_px(size).map(|focal| (focal, FocalSource::Option));
        let exif = || image::read_focal_length_px(path).ok().flatten();
        let (focal_px, focal) = given
            .or_else(|| exif().map(|focal| (focal, FocalSource::Exif)))
            .unwrap_or((Camera::usual_focal_px(size), FocalSource::Assumed));
        let window = Window::around(&found.points, texture, most).or_bad_input()?;
        let landmarks = PhotoLandmarks { points: found.points, size, focal_px: Some(focal_px) };
        Ok(Self { path: path.to_path_buf(), landmarks, focal, window })
    }

    /// Longer side of the face, in pixels of the photograph.
    pub(crate) fn face_px(&self) -> f64 {
        let Bounds { low, high } = Bounds::of(&self.landmarks.points);
        (high[0] - low[0]).max(high[1] - low[1])
    }
}

/// Refuses photographs that need too much memory, before they are decoded.
fn check_size(path: &Path) -> anyhow::Result<()> {
    let header = image::read_header(path).or_bad_input()?;
    let bytes = match header.depth {
        Depth::U8 => 1,
        Depth::U16 => 2,
        Depth::F32 => 4,
    };
    let Size { width, height } = header.size;
    let texels = u64::from(width) * u64::from(height);
    let wanted = texels.saturating_mul((header.channels.count() * bytes) as u64);
    if wanted <= MOST_BYTES as u64 {
        return Ok(());
    }
    let most = MOST_BYTES / (header.channels.count() * bytes) / 1_000_000;
    Err(bad_input(format!(
        "{}: a photograph like this must have at most {most} megapixels, got {}",
        path.display(),
        texels / 1_000_000,
    )))
}

fn refused(path: &Path, error: &FaceError) -> anyhow::Error {
    let path = path.display();
    match error {
        FaceError::Several { count } => bad_input(format!(
            "{path}: the photograph must show one face, got {count}; choose one by --face N, where 1 \
             is the largest"
        )),
        FaceError::Number { number, count } => {
            bad_input(format!("{path}: --face must be from 1 to {count}, got {number}"))
        }
        error => bad_input(format!("{path}: {error}")),
    }
}
