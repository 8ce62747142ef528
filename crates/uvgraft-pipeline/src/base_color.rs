//! Bases of one colour: red, green, blue and alpha in sRGB, 1.0 for full intensity.

use uvgraft::{Channels, Depth, Encoding, Size, TexelFormat, Texture, TextureError};

/// The format of the base under a source: the source's own, with the channels that the colour needs.
pub fn format_under([r, g, b, alpha]: [f32; 4], source: TexelFormat) -> TexelFormat {
    let colored = source.channels.has_color() || r != g || g != b;
    let clear = source.channels.has_alpha() || alpha < 1.0;
    let channels = if colored { Channels::Rgb } else { Channels::Grey };
    let channels = if clear { channels.with_alpha() } else { channels };
    TexelFormat { channels, ..source }
}

/// A single texel, unrounded, for finding tones.
///
/// # Errors
/// [`TextureError::Memory`].
pub fn texel(unit: [f32; 4]) -> Result<Texture, TextureError> {
    Texture::filled(Size::square(1), Channels::Rgba, Encoding::Srgb, Depth::F32, &unit)
}

/// A texture of the colour in a format from [`format_under`].
///
/// # Errors
/// [`TextureError`] for sizes that no texture can have.
pub fn filled(unit: [f32; 4], size: Size, format: TexelFormat) -> Result<Texture, TextureError> {
    let filled = Texture::filled(size, Channels::Rgba, Encoding::Srgb, Depth::U8, &unit)?;
    Ok(filled.encoded_as(format.encoding).converted(format.channels, format.depth))
}
