//! Head textures as FATE bakes them from a video.
//!
//! A workspace holds them in two forms: the tensors that were trained, exactly
//! (`baking*/dump_texture/*_tex_dump.pth`), and pictures of them, of 8 bits
//! (`baking*/visualize_texture/*_color.png`). Both become textures in the conventions of this
//! program.
//!
//! Source: FATE (Zhang et al., "FATE: Full-head Gaussian Avatar with Textural Editing from
//! Monocular Video", CVPR 2025), as its published program bakes:
//! - `color` is `[1, 3, N, N]`, red = 0.5 + 0.5 tanh; `opacity` is `[1, 1, N, N]`, opacity =
//!   1 / (1 + exp(-value)). The colour is looked up after its tanh, the opacity before its sigmoid.
//! - Row 0 is v = 0 of the OBJ file, the bottom of a picture. Textures are looked up with their
//!   corners aligned: texel `i` of a row lies at `i / (N - 1)`, and between texels the lookup is
//!   linear.
//! - Pictures stand upright, and show colours of spherical harmonics, which are (red - 0.5) /
//!   0.2821, from -1.78 to 1.78.

mod find;
mod resample;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use uvgraft::texture::{Channels, Texture, TextureError};

pub use self::find::{TextureFile, TextureSource, find};
use self::resample::{Planes, Upright};
use crate::arrays::{ArraysError, MAX_FILE_BYTES, NamedArrays};
use crate::torch;
use uvgraft_files::input::{Input, ReadError};
use uvgraft_image::{self as image, ImageError};

/// The size that FATE bakes at.
pub const BAKED_SIZE: u32 = 512;

/// Half the range of colours in pictures.
const PICTURE_RANGE: f32 = 1.78;

/// The first basis function of spherical harmonics, 1 / (2 sqrt(pi)).
const HARMONIC: f32 = 0.282_094_8;

/// Why a texture of FATE was rejected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FateError {
    /// Not a dump.
    #[error(transparent)]
    Arrays(#[from] ArraysError),
    /// A tensor has the wrong shape.
    #[error("`{name}` must have shape {wanted}, got {found:?}")]
    Shape {
        /// Which tensor.
        name: &'static str,
        /// Its shape.
        found: Vec<usize>,
        /// What it must be.
        wanted: String,
    },
    /// The training diverged.
    #[error("`{name}` must be finite, got {count} values that are NaN or infinite")]
    NotFinite {
        /// Which tensor.
        name: &'static str,
        /// How many.
        count: usize,
    },
    /// The folder contains no textures.
    #[error(
        "must be a FATE workspace after baking, with baking*/dump_texture/*tex_dump.pth or \
         baking*/visualize_texture/*color.png"
    )]
    Nothing,
    /// A picture cannot be read.
    #[error(transparent)]
    Picture(#[from] ImageError),
    /// The requested size is invalid.
    #[error(transparent)]
    Texture(#[from] TextureError),
}

/// A head texture and its confidence.
#[derive(Debug, Clone, PartialEq)]
pub struct FateTexture {
    /// The colours, as 32-bit floats of sRGB.
    pub color: Texture,
    /// The opacity of the head at each texel, as data of 32-bit floats with one channel. Near 0,
    /// the video showed nothing of the head.
    pub confidence: Option<Texture>,
}

/// A texture and its source.
#[derive(Debug, Clone, PartialEq)]
pub struct FateRead {
    /// The texture.
    pub texture: FateTexture,
    /// Path or name of the colours.
    pub file: PathBuf,
    /// Kind of the source.
    pub kind: TextureSource,
}

/// Reads a dump, resampled to `size` × `size` texels; see the module. Tensors other than `color`
/// and `opacity` are ignored; without `opacity` there is no confidence.
///
/// Each texel has the value that FATE itself interpolates at its centre, so a size much smaller
/// than the dump's, usually [`BAKED_SIZE`], skips texels.
///
/// # Errors
/// [`FateError`] unless it is a dump of square tensors, and for a size of 0 or beyond
/// [`Texture::MAX_SIDE`].
pub fn parse_dump(bytes: &[u8], size: u32) -> Result<FateTexture, FateError> {
    let arrays = torch::parse(bytes)?;
    let color = planes(&arrays, "color", 3, None, |value| 0.5 + 0.5 * value.tanh())?;
    let confidence = match arrays.get("opacity") {
        Some(_) => {
            // Infinite values cannot be interpolated; the curve is flat long before.
            let finite = |value: f32| value.clamp(-1e30, 1e30);
            let raw = planes(&arrays, "opacity", 1, Some(color.side), finite)?;
            Some(raw.texture(size, |value| 1.0 / (1.0 + (-value).exp()))?)
        }
        None => None,
    };
    Ok(FateTexture { color: color.texture(size, |value| value)?, confidence })
}

/// Reads a dump, or the newest texture of a workspace (a folder), resampled to `size` × `size` texels; see
/// [`find`] and [`parse_dump`].
///
/// # Errors
/// [`ReadError`], with the path, if there is no texture, or it cannot be read or is rejected.
pub fn read(input: impl Into<Input>, size: u32) -> Result<FateRead, ReadError<FateError>> {
    read_input(input.into(), size)
}

fn read_input(input: Input, size: u32) -> Result<FateRead, ReadError<FateError>> {
    let (input, kind) = match input.path().filter(|path| path.is_dir()) {
        Some(workspace) => {
            let TextureFile { file, kind, .. } = find(workspace)?;
            (Input::File(file), kind)
        }
        None => (input, TextureSource::Dump),
    };
    let texture = match kind {
        TextureSource::Dump => input.parse(MAX_FILE_BYTES, |bytes| parse_dump(bytes, size))?,
        TextureSource::Picture => read_pictures(input.name(), size)?,
    };
    Ok(FateRead { texture, file: input.name().to_path_buf(), kind })
}

/// The `C` planes of a tensor of shape `[1, C, N, N]`, where `N` must be `side` if given.
fn planes(
    arrays: &NamedArrays,
    name: &'static str,
    channels: usize,
    side: Option<usize>,
    activated: impl Fn(f32) -> f32,
) -> Result<Planes, FateError> {
    let array = arrays.require(name)?;
    let found = array.shape();
    let square = match *found {
        [1, count, height, width] if count == channels && height == width && height > 0 => {
            side.is_none_or(|side| side == height).then_some(height)
        }
        _ => None,
    };
    let side = square.ok_or_else(|| {
        let side = side.map_or("N".to_owned(), |side| side.to_string());
        let wanted = format!("[1, {channels}, {side}, {side}]");
        FateError::Shape { name, found: found.to_vec(), wanted }
    })?;
    let values = array.f32s();
    let count = values.iter().filter(|value| value.is_nan()).count();
    if count > 0 {
        return Err(FateError::NotFinite { name, count });
    }
    let values = values.iter().map(|&value| activated(value)).collect();
    Ok(Planes { values, channels, side, upright: Upright::No })
}

fn read_pictures(color: &Path, size: u32) -> Result<FateTexture, ReadError<FateError>> {
    // The picture of the opacity has the same number at the start of its name.
    let name = color.file_name().unwrap_or_default().to_string_lossy();
    let opacity = name.strip_suffix("color.png").map(|start| format!("{start}opacity.png"));
    let opacity = opacity.map(|name| color.with_file_name(name)).filter(|path| path.is_file());
    // Undoes the range of the picture, and converts spherical harmonics to colours.
    let color = read_picture(color, Channels::Rgb, size, |value| {
        (0.5 + HARMONIC * PICTURE_RANGE * (2.0 * value - 1.0)).clamp(0.0, 1.0)
    })?;
    let opacity = opacity.map(|path| read_picture(&path, Channels::Grey, size, |value| value));
    let confidence = opacity.transpose()?;
    Ok(FateTexture { color, confidence })
}

fn read_picture(
    path: &Path,
    channels: Channels,
    size: u32,
    meaning: impl Fn(f32) -> f32,
) -> Result<Texture, ReadError<FateError>> {
    let content = |reason| ReadError::Content { path: path.to_owned(), reason };
    let image = image::read(path).map_err(|error| error.map_content(FateError::Picture))?;
    let found = image.texture.size();
    if found.width != found.height {
        let found = vec![found.height as usize, found.width as usize];
        let wanted = "a square picture".to_owned();
        return Err(content(FateError::Shape { name: "picture", found, wanted }));
    }
    let planes = Planes::of_texture(&image.texture, channels, meaning);
    planes.texture(size, |value| value).map_err(|error| content(error.into()))
}
