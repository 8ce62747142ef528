//! How the formats of a texture and a base combine: the format of the result and the working
//! format.

use crate::color::Encoding;
use crate::texture::{Channels, Depth, TexelFormat, Texture};

/// The space in which colours are averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Averaging {
    /// As they are encoded: keeps round trips exact, and is what most tools do.
    #[default]
    Encoded,
    /// Linear light: sRGB is decoded, averaged and encoded again.
    Light,
}

/// The stored and the working format of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct Formats {
    result: TexelFormat,
    /// The channels that a result is stored with.
    stored: Channels,
    /// Whether colours are processed in linear light.
    as_light: bool,
    /// Whether values are processed as floats: those of normals, which are rotated before they are
    /// rounded.
    as_floats: bool,
}

impl Formats {
    pub fn new(source: TexelFormat, base: TexelFormat, averaging: Averaging) -> Self {
        let result = TexelFormat {
            channels: source.channels.union(base.channels),
            depth: source.depth.max(base.depth),
            encoding: base.encoding,
        };
        let as_light = averaging == Averaging::Light && base.encoding == Encoding::Srgb;
        Self { result, stored: result.channels, as_light, as_floats: false }
    }

    /// The formats for a normal map.
    #[must_use]
    pub fn of_normals(self) -> Self {
        let result = TexelFormat { encoding: Encoding::Data, ..self.result };
        Self { result, as_light: false, as_floats: true, ..self }
    }

    /// Stores results without alpha.
    #[must_use]
    pub fn opaque(self) -> Self {
        let has_color = self.result.channels.has_color();
        Self { stored: if has_color { Channels::Rgb } else { Channels::Grey }, ..self }
    }

    /// The format of results.
    pub fn stored(&self) -> TexelFormat {
        TexelFormat { channels: self.stored, ..self.result }
    }

    /// The channels in processing.
    pub fn channels(&self) -> Channels {
        self.result.channels
    }

    /// The encoding in processing.
    pub fn working_encoding(&self) -> Encoding {
        if self.as_light { Encoding::Linear } else { self.result.encoding }
    }

    /// Whether the last channel is alpha; the fourth channel of data is data.
    pub fn has_alpha(&self) -> bool {
        self.result.channels.has_alpha() && self.result.encoding != Encoding::Data
    }

    /// Whether texels of a format are processed and stored in just that format.
    pub fn is_kept(&self, format: TexelFormat) -> bool {
        let Self { result, stored, as_light, as_floats } = *self;
        // Data keeps its values, whatever their encoding is said to be.
        let is_encoded_so = result.encoding == Encoding::Data || format.encoding == result.encoding;
        let is_result = format.channels == result.channels && format.depth == result.depth;
        let is_processed_so = !as_light && (!as_floats || format.depth == Depth::F32);
        is_result && is_encoded_so && is_processed_so && stored == result.channels
    }

    /// Converts a source or a base to the working format of both.
    pub fn working(&self, texture: Texture) -> Texture {
        let Self { result, as_light, as_floats, .. } = *self;
        // Anything combined with data is data: converting only one of the two would make them
        // incomparable.
        let texture = match result.encoding {
            Encoding::Data => texture,
            encoding => texture.encoded_as(encoding),
        };
        if as_light {
            return texture.encoded_as(Encoding::Linear).converted(result.channels, Depth::F32);
        }
        let depth = if as_floats { Depth::F32 } else { result.depth };
        texture.converted(result.channels, depth)
    }

    /// Converts a result from the working format to the stored one.
    pub fn restore(&self, texture: Texture) -> Texture {
        let TexelFormat { depth, encoding, .. } = self.result;
        texture.encoded_as(encoding).converted(self.stored, depth)
    }
}
