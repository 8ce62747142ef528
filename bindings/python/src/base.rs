//! What textures are laid over: an array, an image file, a colour, or nothing.

use std::path::PathBuf;

use pyo3::prelude::*;
use uvgraft::{Content, Encoding, Size, TexelFormat, Texture};
use uvgraft_pipeline::{BaseSource, base_color};

use crate::arrays::{GivenTexture, texture};
use crate::error::{bad_type, of_pipeline, of_texture};

/// A base as it was given.
#[derive(Clone)]
pub(crate) enum Base {
    Texture(GivenTexture),
    /// Red, green, blue and alpha, sRGB, 1.0 for full intensity.
    Color([f32; 4]),
}

impl Base {
    /// - `name`: of the argument.
    pub(crate) fn new(
        given: Option<&Bound<'_, PyAny>>,
        name: &str,
        content: Content,
        encoding: Encoding,
    ) -> PyResult<Self> {
        let Some(given) = given else { return Ok(Self::Color(default_color(content))) };
        if let Ok(path) = given.extract::<PathBuf>() {
            let text = path.to_string_lossy();
            if text.starts_with('#') {
                return match BaseSource::parse(&text).map_err(of_pipeline)? {
                    BaseSource::Color(color) => Ok(Self::Color(color)),
                    BaseSource::Image(_) => {
                        Err(bad_type(format_args!("{name} must be a colour such as #808080")))
                    }
                };
            }
        }
        texture(given, name, encoding).map(Self::Texture)
    }

    /// The size of a texture.
    pub(crate) fn size(&self) -> Option<Size> {
        match self {
            Self::Texture(given) => Some(given.texture.size()),
            Self::Color(_) => None,
        }
    }

    /// The format of the base under a source.
    pub(crate) fn format(&self, source: TexelFormat) -> TexelFormat {
        match self {
            Self::Texture(given) => given.texture.format(),
            Self::Color(color) => base_color::format_under(*color, source),
        }
    }

    /// Its colours, for tones: a single texel of a colour.
    pub(crate) fn colors(&self) -> PyResult<Texture> {
        match self {
            Self::Texture(given) => Ok(given.texture.clone()),
            Self::Color(color) => base_color::texel(*color).map_err(of_texture),
        }
    }

    /// All of its texels, in a format from [`Base::format`].
    pub(crate) fn into_texture(self, size: Size, format: TexelFormat) -> PyResult<Texture> {
        match self {
            Self::Texture(given) => Ok(given.texture),
            Self::Color(color) => base_color::filled(color, size, format).map_err(of_texture),
        }
    }
}

/// Transparent for colours, flat for normals, 0 for other data, which has no alpha.
fn default_color(content: Content) -> [f32; 4] {
    match content {
        Content::Color => [0.0; 4],
        Content::Normals(_) => [0.5, 0.5, 1.0, 1.0],
        _ => [0.0, 0.0, 0.0, 1.0],
    }
}
