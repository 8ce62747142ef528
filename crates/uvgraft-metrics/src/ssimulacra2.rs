//! SSIMULACRA 2, a perceptual score for compressed pictures.
//!
//! Sneyers: <https://github.com/cloudinary/ssimulacra2>, through the crate `fast-ssim2`. The other
//! permissively licensed crate, `ssimulacra2` 0.5.1, has as many dependencies and takes four times
//! as long for two 4096² textures (12.5 s instead of 3), with 2 GB instead of 0.5. Their scores
//! differ by less than 0.02 points there.

use std::borrow::Cow;
use std::ops::Range;

use fast_ssim2::{PixelDescriptor, PixelSlice, Ssimulacra2Config, StripConfig, TransferFunction};
use uvgraft::texture::{Size, Value};

use super::{Colors, Mask, MetricError, same_size};

/// The shortest side for which the score is defined.
const MIN: u32 = 8;

/// Rows that are scored in one strip, and halo rows above and below it. Affects the second decimal
/// of the score: with all rows of 4096² at once, rounding in the filter lowers it by up to 0.07
/// points, and it takes 1.4 GB more.
const STRIP: (usize, usize) = (256, 96);

/// The SSIMULACRA 2 score of `b` as a copy of `a`: 100.0 for identical pictures, 90 where hardly
/// anybody sees a difference side by side, 50 for medium quality, below 0.0 beyond the range that
/// it is made for. Not symmetric.
///
/// Values outside `0.0..=1.0` are clamped. With a mask, texels outside it get the first picture's
/// values, and both pictures are cropped to the mask's bounding box. Unselected texels within that
/// box count as identical and raise the score, so scores with different masks are not comparable.
///
/// # Errors
/// [`MetricError::Size`] if the pictures or the mask differ in size, [`MetricError::TooSmall`] if
/// they, or the mask's bounding box, are smaller than 8 texels a side.
pub fn ssimulacra2<'a>(
    a: &'a Colors,
    b: &'a Colors,
    mask: Option<&Mask>,
) -> Result<f64, MetricError> {
    same_size(a, b, mask)?;
    let frame = mask.map_or_else(|| Frame::whole(a.size()), Frame::around);
    let size = frame.size();
    if size.width.min(size.height) < MIN {
        let metric =
            if mask.is_some() { "SSIMULACRA 2 within a mask's bounds" } else { "SSIMULACRA 2" };
        return Err(MetricError::TooSmall { metric, least: MIN, found: size });
    }
    // The crate keeps copies of its input: 8 bits, which most textures have, save 1 GB at 4096²
    // compared with floats.
    let floats;
    let levels = frame.cut([a, b], mask, levels);
    let (values, format) = match &levels {
        Some(levels) => (levels.each_ref().map(|levels| &levels[..]), PixelDescriptor::RGB8_SRGB),
        None => {
            let values = |colors: &'a Colors, texels| Some(colors.values(texels));
            floats = frame.cut([a, b], mask, values).expect("every texture has values");
            let bytes = floats.each_ref().map(|values| bytemuck::cast_slice(values));
            (bytes, PixelDescriptor::RGBF32.with_transfer(TransferFunction::Srgb))
        }
    };
    let stride = values[0].len() / size.height as usize;
    let [a, b] = values.map(|bytes| {
        PixelSlice::new(bytes, size.width, size.height, stride, format).expect("whole rows")
    });
    let (rows, halo) = STRIP;
    let strips =
        StripConfig::new(rows).with_halo_rows(halo).with_parallel_strips(cfg!(feature = "threads"));
    let config = Ssimulacra2Config::default().with_strip(strips);
    let score = fast_ssim2::compute_ssimulacra2_with_config(&a, &b, &config);
    Ok(score.expect("two pictures of one size, large enough, without opacity"))
}

/// The values at 8 bits, if that is lossless up to the rounding of float conversion; a 16-bit step
/// is 0.0039 8-bit levels.
fn levels(colors: &Colors, texels: Range<usize>) -> Option<Cow<'_, [u8]>> {
    let level_of = |&value: &f32| {
        let level = u8::from_unit(value);
        ((value * 255.0 - f32::from(level)).abs() < 1e-3).then_some(level)
    };
    colors.levels(texels.clone()).or_else(|| colors.values(texels).iter().map(level_of).collect())
}

/// The part of two pictures that is scored.
struct Frame {
    /// Width of the pictures.
    width: usize,
    columns: Range<usize>,
    rows: Range<usize>,
}

impl Frame {
    fn whole(size: Size) -> Self {
        let (width, height) = (size.width as usize, size.height as usize);
        Self { width, columns: 0..width, rows: 0..height }
    }

    /// The mask's bounding box.
    fn around(mask: &Mask) -> Self {
        let width = mask.size().width as usize;
        let (mut left, mut right, mut top, mut bottom) = (width, 0, usize::MAX, 0);
        for (row, selected) in mask.selected().chunks_exact(width).enumerate() {
            let Some(first) = selected.iter().position(|&selected| selected) else { continue };
            let last = selected.iter().rposition(|&selected| selected).unwrap_or(first);
            (left, right) = (left.min(first), right.max(last + 1));
            (top, bottom) = (top.min(row), row + 1);
        }
        Self { width, columns: left..right, rows: top..bottom }
    }

    fn size(&self) -> Size {
        Size::new(self.columns.len() as u32, self.rows.len() as u32)
    }

    /// Values of both pictures, with the first one's outside the mask; `None` if one has none of the kind.
    fn cut<'a, T: Copy>(
        &self,
        pictures: [&'a Colors; 2],
        mask: Option<&Mask>,
        values: impl Fn(&'a Colors, Range<usize>) -> Option<Cow<'a, [T]>>,
    ) -> Option<[Cow<'a, [T]>; 2]> {
        let Some(mask) = mask else {
            let [a, b] = pictures.map(|colors| values(colors, 0..colors.size().texels()));
            return Some([a?, b?]);
        };
        let (mut first, mut second) = (Vec::new(), Vec::new());
        for row in self.rows.clone() {
            let texels = row * self.width + self.columns.start..row * self.width + self.columns.end;
            let selected = &mask.selected()[texels.clone()];
            let [a, b] = pictures.map(|colors| values(colors, texels.clone()));
            let (a, b) = (a?, b?);
            first.extend_from_slice(&a);
            for ((a, b), selected) in a.chunks_exact(3).zip(b.chunks_exact(3)).zip(selected) {
                second.extend_from_slice(if *selected { b } else { a });
            }
        }
        Some([first.into(), second.into()])
    }
}

#[cfg(test)]
mod tests {
    use uvgraft::color::Encoding;
    use uvgraft::texture::{Channels, Texels, Texture};

    use super::super::testing::{mask, noise};
    use super::*;

    #[test]
    fn identical_pictures_score_100() {
        let a = noise((40, 33), 1);
        assert_eq!(ssimulacra2(&a, &a, None).unwrap(), 100.0);
        assert!(ssimulacra2(&a, &noise((40, 33), 2), None).unwrap() < 20.0);
    }

    /// Pictures with more than 8 bits take a different path into the crate.
    #[test]
    fn depths_agree() {
        let float = |values: Vec<f32>| {
            let size = Size::new(values.len() as u32 / 3, 1);
            let texels = Texels::F32(values);
            Colors::new(Texture::new(size, Channels::Rgb, Encoding::Srgb, texels).unwrap()).unwrap()
        };
        let wanted: Vec<u8> = (0..=254).collect();
        let stored = float(wanted.iter().map(|&v| f32::from(v) * (1.0 / 255.0)).collect());
        assert_eq!(levels(&stored, 0..85).unwrap(), wanted);
        assert_eq!(levels(&float(vec![0.5; 3]), 0..1), None);
        let (a, b) = (noise((40, 33), 1), noise((40, 33), 2));
        let found = ssimulacra2(&a, &b, None).unwrap();
        let mut values = b.values(0..40 * 33).into_owned();
        values[0] += 1e-4;
        let texels = Texels::F32(values);
        let b = Texture::new(b.size(), Channels::Rgb, Encoding::Srgb, texels).unwrap();
        let float = ssimulacra2(&a, &Colors::new(b).unwrap(), None).unwrap();
        assert!(found != float && (found - float).abs() < 1e-2, "{found}, {float}");
    }

    #[test]
    fn masks_cut_out_and_cover() {
        let (a, b) = (noise((40, 33), 1), noise((40, 33), 2));
        let inside = |x: u32, y: u32| (3..30).contains(&x) && (5..20).contains(&y);
        let cut = |colors: &Colors| {
            let texels: Vec<u8> = (5..20)
                .flat_map(|y| colors.values(y * 40 + 3..y * 40 + 30).into_owned())
                .map(|value| (value * 255.0).round() as u8)
                .collect();
            super::super::testing::colors((27, 15), &texels)
        };
        let found = ssimulacra2(&a, &b, Some(&mask((40, 33), inside))).unwrap();
        assert_eq!(found, ssimulacra2(&cut(&a), &cut(&b), None).unwrap());
        // Half of the texels differ, so the score lies between this one and 100.
        let half = mask((40, 33), |x, y| inside(x, y) && (x, y) != (4, 6) && x % 2 == 1);
        let diluted = ssimulacra2(&a, &b, Some(&half)).unwrap();
        assert!(found < diluted && diluted < 100.0, "{found}, {diluted}");
    }

    #[test]
    fn eight_texels_a_side() {
        let small = noise((7, 20), 1);
        let error = ssimulacra2(&small, &small, None);
        assert!(matches!(error, Err(MetricError::TooSmall { least: 8, .. })));
        let a = noise((20, 20), 1);
        let few = mask((20, 20), |x, y| x < 7 && y < 9);
        assert!(matches!(ssimulacra2(&a, &a, Some(&few)), Err(MetricError::TooSmall { .. })));
        let enough = mask((20, 20), |x, y| x < 8 && y < 8);
        assert_eq!(ssimulacra2(&a, &a, Some(&enough)).unwrap(), 100.0);
    }
}
