//! How a texture and a base are brought together: what results are stored as, and worked out in.

use crate::color::Encoding;
use crate::texture::{Channels, Depth, TexelFormat, Texture};

/// What colours are while they are averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Averaging {
    /// As they are encoded, which keeps round trips exact and is what most tools do.
    #[default]
    Encoded,
    /// Light: sRGB is decoded, averaged and encoded again.
    Light,
}

/// What results are stored as, and what they are worked out in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Formats {
    result: TexelFormat,
    /// The channels that a result is stored with.
    stored: Channels,
    /// Whether colours are worked on as light.
    as_light: bool,
    /// Whether values are worked on as floats: those of normals, which are turned before they are rounded.
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

    /// The same for normals.
    #[must_use]
    pub fn of_normals(self) -> Self {
        let result = TexelFormat { encoding: Encoding::Data, ..self.result };
        Self { result, as_light: false, as_floats: true, ..self }
    }

    /// The same without opacity in what is stored.
    #[must_use]
    pub fn opaque(self) -> Self {
        let has_color = self.result.channels.has_color();
        Self { stored: if has_color { Channels::Rgb } else { Channels::Grey }, ..self }
    }

    /// What results are stored as.
    pub fn stored(&self) -> TexelFormat {
        TexelFormat { channels: self.stored, ..self.result }
    }

    /// The channels that are worked on.
    pub fn channels(&self) -> Channels {
        self.result.channels
    }

    /// In which encoding values are worked on.
    pub fn working_encoding(&self) -> Encoding {
        if self.as_light { Encoding::Linear } else { self.result.encoding }
    }

    /// Whether the last channel is opacity; the fourth channel of data is data.
    pub fn has_opacity(&self) -> bool {
        self.result.channels.has_alpha() && self.result.encoding != Encoding::Data
    }

    /// Brings a source or a base to the format that both are worked on in.
    pub fn working(&self, texture: Texture) -> Texture {
        let Self { result, as_light, as_floats, .. } = *self;
        // Anything next to data is data: converting one of the two would tear them apart.
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

    /// Brings a result to what it is stored as.
    pub fn restore(&self, texture: Texture) -> Texture {
        let TexelFormat { depth, encoding, .. } = self.result;
        texture.encoded_as(encoding).converted(self.stored, depth)
    }
}
