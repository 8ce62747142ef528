//! A picture put together from panels and captions.

use std::path::Path;

use anyhow::Context;
use font8x8::UnicodeFonts;
use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_io::image::{self, Image};

/// An 8-bit RGB picture that is drawn on.
pub(crate) struct Picture {
    size: Size,
    values: Vec<u8>,
}

pub(crate) type Rgb = [u8; 3];

/// Side of a glyph before it is enlarged, in pixels.
const GLYPH: u32 = 8;

impl Picture {
    pub(crate) fn new(size: Size, background: Rgb) -> Self {
        Self { size, values: background.repeat(size.texels()) }
    }

    /// Colours a pixel; what lies outside is ignored.
    pub(crate) fn set(&mut self, x: u32, y: u32, color: Rgb) {
        if x < self.size.width && y < self.size.height {
            let at = (y as usize * self.size.width as usize + x as usize) * 3;
            self.values[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Lays an 8-bit RGB texture down with its top left corner at `(left, top)`.
    pub(crate) fn paste(&mut self, panel: &Texture, left: u32, top: u32) {
        let Texels::U8(values) = panel.texels() else { return };
        let (width, channels) = (panel.size().width, panel.channels().count());
        for (index, texel) in (0u32..).zip(values.chunks_exact(channels)) {
            let color = if channels >= 3 { [texel[0], texel[1], texel[2]] } else { [texel[0]; 3] };
            self.set(left + index % width, top + index / width, color);
        }
    }

    /// Writes text with its top left corner at `(left, top)`, `scale` times the font's 8 pixels
    /// high. Characters that the font lacks become a question mark.
    pub(crate) fn text(&mut self, text: &str, left: u32, top: u32, scale: u32, color: Rgb) {
        for (index, character) in (0u32..).zip(text.chars()) {
            let glyph = font8x8::BASIC_FONTS
                .get(character)
                .or_else(|| font8x8::LATIN_FONTS.get(character))
                .or_else(|| font8x8::BASIC_FONTS.get('?'))
                .unwrap_or([0; 8]);
            for (row, bits) in (0u32..).zip(glyph) {
                for column in (0..GLYPH).filter(|column| bits >> column & 1 == 1) {
                    let x = left + (index * GLYPH + column) * scale;
                    let y = top + row * scale;
                    for offset in 0..scale * scale {
                        self.set(x + offset % scale, y + offset / scale, color);
                    }
                }
            }
        }
    }

    /// How wide [`Picture::text`] writes a text, in pixels.
    pub(crate) fn text_width(text: &str, scale: u32) -> u32 {
        text.chars().count() as u32 * GLYPH * scale
    }

    /// Writes the picture; the format follows the file's extension.
    pub(crate) fn write(self, path: &Path) -> anyhow::Result<()> {
        let texels = Texels::U8(self.values);
        let texture = Texture::new(self.size, Channels::Rgb, Encoding::Srgb, texels)?;
        let options = image::WriteOptions { compress: true, ..Default::default() };
        image::write(&Image { texture, icc: None }, path, &options)
            .map(drop)
            .with_context(|| format!("cannot write {}", path.display()))
    }
}
