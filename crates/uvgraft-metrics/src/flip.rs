//! FLIP: the difference seen when alternating between two pictures.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild: "FLIP: A Difference Evaluator
//! for Alternating Images", 2020, in the authors' C++ implementation through the crate `nv-flip`.

use uvgraft::texture::Value;
use uvgraft::threads::map_indices;

use super::{Colors, Mask, MetricError, same_size};

/// Rows that are evaluated in one block. The implementation needs some 100 bytes per texel, which
/// would be gigabytes for a whole texture.
const ROWS: usize = 128;

/// Rows above and below that affect an error: at [`PIXELS_PER_DEGREE`] the spatial filter has a
/// radius of 10 texels, the feature filter of 9.
const HALO: usize = 10;

/// Viewing conditions: 0.7 m from a display 3840 texels and 0.7 m wide, FLIP's default.
pub const PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

/// LDR-FLIP at 67 texels per degree of visual angle: the mean of its error map, over the mask if
/// there is one.
///
/// 0.0 for identical pictures up to 1.0; lower is better. Pictures are quantised to 8 bits, as a
/// display shows them; values outside `0.0..=1.0` are clamped. The filters read up to 10 texels
/// beyond the mask.
///
/// # Errors
/// [`MetricError::Size`] if the pictures or the mask differ in size.
///
/// # Source
/// The authors' `flip-evaluator` with its default settings, to which the mean is equal within 1e-4.
pub fn flip(a: &Colors, b: &Colors, mask: Option<&Mask>) -> Result<f64, MetricError> {
    same_size(a, b, mask)?;
    let (width, height) = (a.size().width as usize, a.size().height as usize);
    let sums = map_indices(height.div_ceil(ROWS), |block| {
        let rows = block * ROWS..((block + 1) * ROWS).min(height);
        let texels = rows.start * width..rows.end * width;
        let selected = mask.map(|mask| &mask.selected()[texels]);
        if selected.is_some_and(|selected| !selected.contains(&true)) {
            return 0.0;
        }
        let with_halo = rows.start.saturating_sub(HALO)..(rows.end + HALO).min(height);
        let skipped = (rows.start - with_halo.start) * width;
        let [a, b] = [a, b].map(|colors| picture(colors, with_halo.clone()));
        let errors = nv_flip::flip(a, b, PIXELS_PER_DEGREE).to_vec();
        let errors = errors[skipped..][..rows.len() * width].iter().copied().map(f64::from);
        match selected {
            None => errors.sum::<f64>(),
            Some(selected) => errors
                .zip(selected)
                .filter(|(_, selected)| **selected)
                .map(|(error, _)| error)
                .sum(),
        }
    });
    let count = mask.map_or(a.size().texels(), Mask::count);
    Ok(sums.iter().sum::<f64>() / count as f64)
}

/// A range of rows in the implementation's image type.
fn picture(colors: &Colors, rows: std::ops::Range<usize>) -> nv_flip::FlipImageRgb8 {
    let width = colors.size().width;
    let texels = rows.start * width as usize..rows.end * width as usize;
    let levels = colors.levels(texels.clone()).unwrap_or_else(|| {
        colors.values(texels).iter().map(|&value| u8::from_unit(value)).collect()
    });
    nv_flip::FlipImageRgb8::with_data(width, rows.len() as u32, &levels)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{colors, mask, noise};
    use super::*;

    /// The block size must not affect the result: the same map, to the bit, as from
    /// all rows at once.
    #[test]
    fn blocks_do_not_show() {
        let size = (50, 300);
        let (a, b) = (noise(size, 1), noise(size, 2));
        let map = nv_flip::flip(picture(&a, 0..300), picture(&b, 0..300), PIXELS_PER_DEGREE);
        let map = map.to_vec();
        for row in [0, 117, 127, 128, 129, 138, 255, 256, 299] {
            let chosen = mask(size, |_, y| y == row);
            let errors = &map[row as usize * 50..][..50];
            let wanted = errors.iter().copied().map(f64::from).sum::<f64>() / 50.0;
            assert_eq!(flip(&a, &b, Some(&chosen)).unwrap(), wanted, "row {row}");
        }
    }

    #[test]
    fn ends_of_the_scale() {
        let same = noise((30, 30), 1);
        assert_eq!(flip(&same, &same, None).unwrap(), 0.0);
        let (green, blue) = ([0, 255, 0].repeat(900), [0, 0, 255].repeat(900));
        // The largest colour difference within sRGB, which defines the top of the scale.
        let largest = flip(&colors((30, 30), &green), &colors((30, 30), &blue), None).unwrap();
        assert!((largest - 1.0).abs() < 1e-3, "{largest}");
    }
}
