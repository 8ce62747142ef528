//! The part of a photograph around the face, which is all that is kept of it.

use uvgraft::{Averaging, Channels, Depth, Encoding, Filter, Size, Texels, Texture, TextureError};
use uvgraft_selfie::FittedPhoto;

/// A part of a photograph, possibly scaled down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Its first column and row in the photograph.
    pub(super) offset: [f64; 2],
    /// Its pixels per pixel of the photograph.
    pub(super) scale: [f64; 2],
}

impl Window {
    /// The part of a photograph around landmarks, the head with hair and neck, and its pixels: 8-bit
    /// RGB.
    ///
    /// - `most`: largest number of pixels to keep; a larger part is scaled down.
    pub(super) fn around(
        landmarks: &[[f64; 3]],
        photo: Texture,
        most: usize,
    ) -> Result<(Self, Texture), TextureError> {
        /// Margin around the landmarks, as a share of the face.
        const MARGIN: f64 = 1.0;
        let Bounds { low, high } = Bounds::of(landmarks);
        let face = (high[0] - low[0]).max(high[1] - low[1]);
        let size = photo.size();
        let sides = [size.width, size.height];
        let first =
            [0, 1].map(|k| (low[k] - MARGIN * face).clamp(0.0, f64::from(sides[k] - 1)) as u32);
        let last = [0, 1].map(|k| {
            let last = (high[k] + MARGIN * face).ceil().clamp(0.0, f64::from(sides[k])) as u32;
            last.max(first[k] + 1)
        });
        let cut = cut(photo, first, last)?;
        let full = cut.size();
        let shrink = (most as f64 / full.texels() as f64).sqrt().min(1.0);
        let side = |length: u32| ((f64::from(length) * shrink) as u32).max(1);
        let small = Size::new(side(full.width), side(full.height));
        let pixels = cut.resized(small, Filter::Lanczos3, Averaging::Encoded)?;
        let scale = [(small.width, full.width), (small.height, full.height)]
            .map(|(small, full)| f64::from(small) / f64::from(full));
        Ok((Self { offset: first.map(f64::from), scale }, pixels))
    }

    /// A position in the photograph as one in the window.
    pub(super) fn point(&self, at: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (at[k] - self.offset[k]) * self.scale[k])
    }

    /// A fitted photograph as one of the window.
    pub(super) fn fitted(&self, photo: &FittedPhoto) -> FittedPhoto {
        let mut fitted = photo.clone();
        // Both scales are the same but for the rounding of sides to pixels.
        let scale = (self.scale[0] * self.scale[1]).sqrt();
        fitted.camera.center_px = self.point(photo.camera.center_px);
        fitted.camera.focal_px *= scale;
        fitted.residual_px *= scale;
        for (to, &[x, y, z]) in fitted.landmarks.iter_mut().zip(&photo.landmarks) {
            let [x, y] = self.point([x, y]);
            *to = [x, y, z * scale];
        }
        fitted
    }
}

/// The rectangle around points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

impl Bounds {
    pub(super) fn of(points: &[[f64; 3]]) -> Self {
        let none = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        points.iter().fold(none, |bounds, point| Self {
            low: [0, 1].map(|k| bounds.low[k].min(point[k])),
            high: [0, 1].map(|k| bounds.high[k].max(point[k])),
        })
    }
}

/// Columns and rows of a texture, as 8-bit sRGB without alpha.
fn cut(photo: Texture, first: [u32; 2], last: [u32; 2]) -> Result<Texture, TextureError> {
    let rows = photo.rows(first[1]..last[1]);
    drop(photo);
    let rows = rows.encoded_as(Encoding::Srgb).converted(Channels::Rgb, Depth::U8);
    let row = rows.size().width as usize * 3;
    let size = Size::new(last[0] - first[0], last[1] - first[1]);
    let Texels::U8(values) = rows.into_texels() else { unreachable!("converted to 8 bits") };
    let columns = first[0] as usize * 3..last[0] as usize * 3;
    let texels = values.chunks_exact(row).flat_map(|row| &row[columns.clone()]).copied().collect();
    Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn photo() -> Texture {
        let size = Size::new(60, 40);
        let texels = (0..40u8).flat_map(|y| (0..60u8).flat_map(move |x| [x, y, 7])).collect();
        Texture::new(size, Channels::Rgb, Encoding::Srgb, Texels::U8(texels)).unwrap()
    }

    #[test]
    fn a_window_keeps_the_pixels_around_the_landmarks() {
        let landmarks = [[20.0, 10.0, 0.0], [28.0, 15.0, 0.0]];
        let (window, pixels) = Window::around(&landmarks, photo(), usize::MAX).unwrap();
        assert_eq!(pixels.size(), Size::new(24, 21));
        let first = [0, 1].map(|channel| (pixels.get(0, 0, channel) * 255.0).round());
        assert_eq!(first, [12.0, 2.0]);
        assert_eq!(window.point([12.5, 2.5]), [0.5, 0.5]);
    }

    #[test]
    fn a_large_window_is_scaled_down_and_ends_with_the_photograph() {
        let landmarks = [[20.0, 10.0, 0.0], [50.0, 30.0, 0.0]];
        let (window, pixels) = Window::around(&landmarks, photo(), 600).unwrap();
        assert_eq!(pixels.size(), Size::new(30, 20));
        assert_eq!(window.point([60.0, 40.0]), [30.0, 20.0]);
    }
}
