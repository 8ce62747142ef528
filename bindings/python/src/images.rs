//! Image files from and to arrays.

use std::path::PathBuf;

use pyo3::prelude::*;
use uvgraft_image::{self as image, Format, WriteError, WriteOptions};

use crate::arrays::{array, texture};
use crate::error::{bad_value, failed, of_file, of_reading, warn_caller};

/// Read an image file.
///
/// Parameters
/// ----------
/// path : path
///     PNG, JPEG, WebP, TIFF or EXR, detected from the content. EXIF orientation is applied.
///
/// Returns
/// -------
/// ndarray, shape (height, width, channels)
///     uint8, uint16 or float32, with 1 to 4 channels, as the file has them.
///
/// Raises
/// ------
/// OSError
///     If the file cannot be read.
/// uvgraft.Error
///     If it is not a whole image, or too large.
#[pyfunction]
pub(crate) fn read_image(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyAny>> {
    let read = py.detach(|| image::read(&path)).map_err(of_reading)?;
    array(py, read.texture, false)
}

/// Write an image file, whole or not at all.
///
/// Parameters
/// ----------
/// path : path
///     Its extension says the format.
/// image : ndarray or PIL image
///     1 to 4 channels.
/// encoding : {"srgb", "linear", "data"}
///     What its values are.
/// compress : bool
///     Write a smaller PNG, TIFF or EXR file, more slowly.
/// quality : int, optional
///     JPEG quality, 1 to 100, for JPEG files only; by default 95.
///
/// Warns
/// -----
/// UserWarning
///     If the format cannot hold all of the image.
///
/// Raises
/// ------
/// OSError
///     If the file cannot be written.
/// ValueError
///     If an option means nothing to the format.
/// uvgraft.Error
///     If the format cannot hold the image.
#[pyfunction]
#[pyo3(signature = (path, image, *, encoding="srgb", compress=false, quality=None))]
pub(crate) fn write_image(
    py: Python<'_>,
    path: PathBuf,
    image: &Bound<'_, PyAny>,
    encoding: &str,
    compress: bool,
    quality: Option<u8>,
) -> PyResult<()> {
    let encoding = crate::arguments::chosen("encoding", encoding)?;
    if let Some(quality) = quality.filter(|quality| !(1..=100).contains(quality)) {
        return Err(bad_value(format_args!("quality must be from 1 to 100, got {quality}")));
    }
    let texture = texture(image, "image", encoding)?.texture;
    let mut options = WriteOptions::default().compress(compress);
    options.jpeg_quality = quality;
    if let Some(format) = Format::from_path(&path) {
        options.check(&[format]).map_err(bad_value)?;
    }
    let written = py.detach(|| image::write(&texture.into(), &path, &options));
    let written = written.map_err(|error| match error {
        WriteError::Encode { reason: image::EncodeError::Io(reason), .. } => {
            of_file(&reason, &path)
        }
        error => failed(error),
    })?;
    let losses = written.losses.iter().map(|loss| format!("{}: {loss}", path.display()));
    warn_caller(py, losses.collect())
}
