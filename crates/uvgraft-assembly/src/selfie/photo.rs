//! One photograph: decoded, its face found, and cut to what is needed of it.

use std::path::PathBuf;

use uvgraft::{Size, Texture};
use uvgraft_files::input::Input;
use uvgraft_image::{self as image, Header, Image};
use uvgraft_io::tracking::TrackedFrame;
use uvgraft_pipeline::{Blame, Failure, Observer, Result};
use uvgraft_selfie::landmarks::{FaceError, FaceNetworks};
use uvgraft_selfie::{Camera, FittedPhoto, PhotoLandmarks, Pixels};

use super::frames::Frame;
use super::request::PhotoOptions;
use super::tracked;
use super::window::{Bounds, Window};

/// Largest size of a decoded photograph, in bytes.
const MOST_BYTES: usize = 400 << 20;

/// Where a focal length comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FocalSource {
    Option,
    Exif,
    Tracker,
    Assumed,
}

/// A photograph with a face.
pub(crate) struct Photo {
    /// What to call it in messages: its file.
    pub(crate) name: PathBuf,
    /// In pixels of the whole photograph.
    pub(crate) landmarks: PhotoLandmarks,
    /// Where the focal length in `landmarks` comes from.
    pub(crate) focal: FocalSource,
    /// What is kept of its pixels.
    pub(super) window: Window,
    /// What a tracker knows of it.
    pub(crate) tracked: Option<TrackedFrame>,
    /// Where its optical axis is, in pixels.
    center_px: [f64; 2],
}

impl Photo {
    /// A photograph, and its pixels around the face.
    ///
    /// - `most`: largest number of pixels to keep.
    ///
    /// # Errors
    /// As bad input if the file is not an image of a face from the front.
    pub(super) fn read(
        frame: Frame<'_>,
        networks: &FaceNetworks,
        options: &PhotoOptions,
        most: usize,
        observer: &dyn Observer,
    ) -> Result<(Self, Texture)> {
        let input = frame.image();
        let opened = image::open(input).or_input()?;
        check_size(input, &opened.header())?;
        let exif_px = opened.focal_length_px();
        let Image { mut texture, icc } = opened.decode().or_input()?;
        check_profile(input, icc.as_deref(), observer);
        let tracked = match frame {
            Frame::Image(_) => None,
            Frame::Tracked(tracked) => {
                texture = tracked::masked(texture, tracked.mask.as_ref())?;
                Some(tracked.frame.clone())
            }
        };
        let size = texture.size();
        let found =
            networks.find(&texture, options.choice()).map_err(|error| refused(input, &error))?;
        if found.is_in_texture() {
            observer.warn(format_args!(
                "{input}: looks like the texture of a head rather than a photograph: the skin goes \
                 on where the jaw ends; carry textures by `uvgraft transfer`, or give them to \
                 `uvgraft avatar` as a face texture"
            ));
        }
        let given = options.focal_px(size).map(|focal| (focal, FocalSource::Option));
        let camera = tracked.as_ref().map(|frame| frame.camera.for_size(size));
        let by_tracker = camera.map(|camera| (tracked::focal_px(&camera), FocalSource::Tracker));
        let center_px = camera.map_or_else(
            || [size.width, size.height].map(|side| 0.5 * f64::from(side)),
            |camera| [camera.cx, camera.cy],
        );
        let (focal_px, focal) = given
            .or(by_tracker)
            .or(exif_px.map(|focal| (focal, FocalSource::Exif)))
            .unwrap_or((Camera::usual_focal_px(size), FocalSource::Assumed));
        let (window, pixels) = Window::around(&found.points, texture, most).or_input()?;
        let landmarks = PhotoLandmarks { points: found.points, size, focal_px: Some(focal_px) };
        let name = input.name().to_path_buf();
        Ok((Self { name, landmarks, focal, window, tracked, center_px }, pixels))
    }

    /// Its landmarks as if the optical axis were in the middle of it, as fits assume.
    pub(super) fn centered(&self) -> PhotoLandmarks {
        let [dx, dy] = self.off_center();
        let points = self.landmarks.points.iter().map(|&[x, y, z]| [x - dx, y - dy, z]);
        PhotoLandmarks { points: points.collect(), ..self.landmarks.clone() }
    }

    /// What is kept of its pixels, in the same way.
    pub(super) fn centered_pixels<'a>(&self, kept: &'a Texture) -> Pixels<'a> {
        let [dx, dy] = self.off_center();
        let Window { offset: [x, y], scale } = self.window;
        Pixels { texture: kept, offset: [x - dx, y - dy], scale }
    }

    /// A fit to [`Photo::centered`] as one to the photograph.
    pub(super) fn uncentered(&self, mut fitted: FittedPhoto) -> FittedPhoto {
        let shift = self.off_center();
        for k in [0, 1] {
            fitted.camera.center_px[k] += shift[k];
            fitted.landmarks.iter_mut().for_each(|point| point[k] += shift[k]);
        }
        fitted
    }

    fn off_center(&self) -> [f64; 2] {
        let size = self.landmarks.size;
        [
            self.center_px[0] - 0.5 * f64::from(size.width),
            self.center_px[1] - 0.5 * f64::from(size.height),
        ]
    }

    /// Longer side of the face, in pixels of the photograph.
    pub(crate) fn face_px(&self) -> f64 {
        let Bounds { low, high } = Bounds::of(&self.landmarks.points);
        (high[0] - low[0]).max(high[1] - low[1])
    }
}

/// Refuses photographs that need too much memory, before they are decoded.
fn check_size(input: &Input, header: &Header) -> Result<()> {
    let Size { width, height } = header.size;
    let texels = u64::from(width) * u64::from(height);
    let wanted = texels.saturating_mul((header.channels.count() * header.depth.bytes()) as u64);
    if wanted <= MOST_BYTES as u64 {
        return Ok(());
    }
    let most = MOST_BYTES / (header.channels.count() * header.depth.bytes()) / 1_000_000;
    Err(Failure::input(format!(
        "{input}: a photograph like this must have at most {most} megapixels, got {}",
        texels / 1_000_000,
    )))
}

/// Warns of colours that are not those of sRGB, as which all are read.
fn check_profile(input: &Input, icc: Option<&[u8]>, observer: &dyn Observer) {
    // Descriptions are ASCII or UTF-16.
    let names: [&[u8]; 2] = [b"sRGB", b"s\0R\0G\0B"];
    let is_srgb =
        |icc: &[u8]| names.iter().any(|name| icc.windows(name.len()).any(|window| window == *name));
    if icc.is_some_and(|icc| !is_srgb(icc)) {
        observer.warn(format_args!(
            "{input}: its colour profile is not sRGB; colours may be paler than they are"
        ));
    }
}

fn refused(input: &Input, error: &FaceError) -> Failure {
    match error {
        FaceError::Several { count } => Failure::option(format!(
            "{input}: the photograph must show one face, got {count}; choose one by `face_number` N, where 1 \
             is the largest"
        )),
        FaceError::Number { number, count } => Failure::option(format!(
            "{input}: `face_number` must be from 1 to {count}, got {number}"
        )),
        error => Failure::input(format!("{input}: {error}")),
    }
}
