//! Pictures composed of panels and captions.

use std::path::Path;

use anyhow::Context;
use font8x8::UnicodeFonts;
use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_io::image::{self, Format, Image};

use crate::canvas::Canvas;
use crate::failure::bad_input;

/// An 8-bit RGB canvas.
pub(crate) struct Picture {
    size: Size,
    values: Vec<u8>,
}

pub(crate) type Rgb = [u8; 3];

/// Side of an unscaled glyph in pixels.
const GLYPH: u32 = 8;

/// Checks that a path has an image extension.
///
/// - `what`: what the picture is called, with its article.
pub(crate) fn check_name(path: &Path, what: &str) -> anyhow::Result<()> {
    match Format::from_path(path) {
        Some(_) => Ok(()),
        None => Err(bad_input(format!(
            "{}: {what} must be an image; extension must be one of {}",
            path.display(),
            Format::extension_list()
        ))),
    }
}

impl Picture {
    pub(crate) fn new(size: Size, background: Rgb) -> Self {
        Self { size, values: background.repeat(size.texels()) }
    }

    pub(crate) fn size(&self) -> Size {
        self.size
    }

    /// Sets a pixel; positions outside are ignored.
    pub(crate) fn set(&mut self, x: u32, y: u32, color: Rgb) {
        if x < self.size.width && y < self.size.height {
            let at = (y as usize * self.size.width as usize + x as usize) * 3;
            self.values[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Draws an 8-bit RGB texture with its top left corner at `(left, top)`.
    pub(crate) fn paste(&mut self, panel: &Texture, left: u32, top: u32) {
        let Texels::U8(values) = panel.texels() else { return };
        let (width, channels) = (panel.size().width, panel.channels().count());
        for (index, texel) in (0u32..).zip(values.chunks_exact(channels)) {
            let color = if channels >= 3 { [texel[0], texel[1], texel[2]] } else { [texel[0]; 3] };
            self.set(left + index % width, top + index / width, color);
        }
    }

    /// Draws text with its top left corner at `(left, top)`, at `scale` times the font's 8 pixels.
    /// Characters missing in the font become question marks.
    pub(crate) fn text(&mut self, text: &str, left: u32, top: u32, scale: u32, color: Rgb) {
        for (index, character) in (0u32..).zip(text.chars()) {
            let glyph = font8x8::BASIC_FONTS
                .get(character)
                .or_else(|| font8x8::LATIN_FONTS.get(character))
                .or_else(|| font8x8::GREEK_FONTS.get(character))
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

    /// The width of a text drawn by [`Picture::text`], in pixels.
    pub(crate) fn text_width(text: &str, scale: u32) -> u32 {
        text.chars().count() as u32 * GLYPH * scale
    }

    /// The longest prefix of a text that fits a width.
    pub(crate) fn fitted(text: &str, width: u32, scale: u32) -> String {
        if Self::text_width(text, scale) <= width {
            return text.to_owned();
        }
        let room = width / Self::text_width("m", scale);
        text.chars().take(room.saturating_sub(2) as usize).chain("..".chars()).collect()
    }

    /// Draws lines and areas.
    pub(crate) fn draw(&mut self, paint: impl FnOnce(&mut Canvas<'_>)) -> anyhow::Result<()> {
        let opaque = |rgb: &[u8]| [rgb[0], rgb[1], rgb[2], 255];
        let mut rgba: Vec<u8> = self.values.chunks_exact(3).flat_map(opaque).collect();
        let mut canvas = Canvas::new(&mut rgba, self.size)
            .with_context(|| format!("no canvas of {}", self.size))?;
        paint(&mut canvas);
        for (to, from) in self.values.chunks_exact_mut(3).zip(rgba.chunks_exact(4)) {
            to.copy_from_slice(&from[..3]);
        }
        Ok(())
    }

    /// The picture as a texture.
    pub(crate) fn into_texture(self) -> anyhow::Result<Texture> {
        let texels = Texels::U8(self.values);
        Ok(Texture::new(self.size, Channels::Rgb, Encoding::Srgb, texels)?)
    }

    /// Writes the picture; the format follows the file's extension.
    pub(crate) fn write(self, path: &Path) -> anyhow::Result<()> {
        let texture = self.into_texture()?;
        let options = image::WriteOptions::default().compress(true);
        image::write(&Image { texture, icc: None }, path, &options)
            .map(drop)
            .with_context(|| format!("cannot write {}", path.display()))
    }
}
