//! Pictures composed of panels and captions.

use std::path::Path;

use uvgraft::{Channels, Encoding, Size, Texels, Texture};
use uvgraft_image::{self as image, Format, Image};
use uvgraft_pipeline::{Blame, Context, Failure, Result};

use super::canvas::Canvas;
use super::font::FontSize;

/// A picture that is drawn: an 8-bit RGB canvas for panels, lines and captions.
pub struct Sheet {
    size: Size,
    values: Vec<u8>,
}

/// Red, green and blue.
pub type Rgb = [u8; 3];

/// Checks that a path has an image extension.
///
/// - `what`: what the picture is called, with its article.
///
/// # Errors
/// As bad input, with the extensions that there are.
pub fn check_name(path: &Path, what: &str) -> Result<()> {
    match Format::from_path(path) {
        Some(_) => Ok(()),
        None => Err(Failure::input(format!(
            "{}: {what} must be an image; extension must be one of {}",
            path.display(),
            Format::extension_list()
        ))),
    }
}

impl Sheet {
    /// A picture of one colour.
    pub fn new(size: Size, background: Rgb) -> Self {
        Self { size, values: background.repeat(size.texels()) }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> Size {
        self.size
    }

    /// Sets a pixel; positions outside are ignored.
    pub fn set(&mut self, x: u32, y: u32, color: Rgb) {
        if x < self.size.width && y < self.size.height {
            let at = (y as usize * self.size.width as usize + x as usize) * 3;
            self.values[at..at + 3].copy_from_slice(&color);
        }
    }

    /// Draws an 8-bit RGB texture with its top left corner at `(left, top)`.
    pub fn paste(&mut self, panel: &Texture, left: u32, top: u32) {
        let Texels::U8(values) = panel.texels() else { return };
        let (width, channels) = (panel.size().width, panel.channels().count());
        for (index, texel) in (0u32..).zip(values.chunks_exact(channels)) {
            let color = if channels >= 3 { [texel[0], texel[1], texel[2]] } else { [texel[0]; 3] };
            self.set(left + index % width, top + index / width, color);
        }
    }

    /// Draws text so that its capitals have their top left corner at about `(left, top)` and are `8 * scale` pixels
    /// high. Characters missing in the font become question marks.
    ///
    /// - `scale`: 1, or an even number.
    pub fn text(&mut self, text: &str, left: u32, top: u32, scale: u32, color: Rgb) {
        let font = FontSize::new(scale);
        let above = font.height() / 4;
        for (index, character) in (0u32..).zip(text.chars()) {
            let start = left + index * font.width();
            for ([x, y], coverage) in font.coverage(character) {
                if let Some(y) = (top + y).checked_sub(above) {
                    self.blend(start + x, y, color, coverage);
                }
            }
        }
    }

    /// Covers a share of a pixel, of 255; positions outside are ignored.
    fn blend(&mut self, x: u32, y: u32, color: Rgb, coverage: u8) {
        if x >= self.size.width || y >= self.size.height {
            return;
        }
        let at = (y as usize * self.size.width as usize + x as usize) * 3;
        let share = u32::from(coverage);
        for (value, over) in self.values[at..at + 3].iter_mut().zip(color) {
            let sum = u32::from(*value) * (255 - share) + u32::from(over) * share;
            *value = ((sum + 127) / 255) as u8;
        }
    }

    /// The width of a text drawn by [`Sheet::text`], in pixels.
    pub fn text_width(text: &str, scale: u32) -> u32 {
        text.chars().count() as u32 * FontSize::new(scale).width()
    }

    /// The longest prefix of a text that fits a width.
    pub fn fitted(text: &str, width: u32, scale: u32) -> String {
        if Self::text_width(text, scale) <= width {
            return text.to_owned();
        }
        let room = width / Self::text_width("m", scale);
        text.chars().take(room.saturating_sub(2) as usize).chain("..".chars()).collect()
    }

    /// Draws lines and areas.
    ///
    /// # Errors
    /// If the picture is too large to be drawn on.
    pub fn draw(&mut self, paint: impl FnOnce(&mut Canvas<'_>)) -> Result<()> {
        let opaque = |rgb: &[u8]| [rgb[0], rgb[1], rgb[2], 255];
        let mut rgba: Vec<u8> = self.values.chunks_exact(3).flat_map(opaque).collect();
        let mut canvas = Canvas::new(&mut rgba, self.size)
            .ok_or_else(|| Failure::work(format!("no canvas of {}", self.size)))?;
        paint(&mut canvas);
        for (to, from) in self.values.chunks_exact_mut(3).zip(rgba.chunks_exact(4)) {
            to.copy_from_slice(&from[..3]);
        }
        Ok(())
    }

    /// The picture as a texture.
    ///
    /// # Errors
    /// If it has no pixels.
    pub fn into_texture(self) -> Result<Texture> {
        let texels = Texels::U8(self.values);
        Texture::new(self.size, Channels::Rgb, Encoding::Srgb, texels).or_work()
    }

    /// Writes the picture; the format follows the file's extension.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(self, path: &Path) -> Result<()> {
        write(self.into_texture()?, path)
    }
}

/// Writes a drawn picture, compressed well; the format follows the file's extension.
///
/// # Errors
/// If the file cannot be written.
pub fn write(picture: Texture, path: &Path) -> Result<()> {
    let options = image::WriteOptions::default().compress(true);
    // Drawings have 8-bit RGB, of which nothing is lost.
    image::write(&Image::from(picture), path, &options)
        .map(drop)
        .or_work()
        .context(format_args!("cannot write {}", path.display()))
}
