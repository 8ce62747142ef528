//! Peak signal-to-noise ratio.

use super::{Colors, Mask, MetricError, difference};

/// The peak signal-to-noise ratio in decibels, over the mask's texels and the three channels.
///
/// Higher is better; identical pictures give infinity. Values are sRGB-encoded with a peak of 1.0;
/// linear textures are converted first, because a ratio of linear values would not be comparable.
///
/// # Errors
/// [`MetricError::Size`] if the pictures or the mask differ in size.
///
/// # Source
/// `10 log10(1 / MSE)`, as scikit-image's `peak_signal_noise_ratio` with `data_range=1`.
pub fn psnr(a: &Colors, b: &Colors, mask: Option<&Mask>) -> Result<f64, MetricError> {
    let mean_square = difference::mean(a, b, mask, |difference| difference * difference)?;
    // A negated logarithm would be -0.0 for black against white, where the mean square is 1.0.
    Ok(10.0 * mean_square.recip().log10())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{colors, mask};
    use super::*;

    #[test]
    fn by_hand() {
        let a = colors((2, 1), &[0, 0, 0, 100, 100, 100]);
        let b = colors((2, 1), &[51, 51, 51, 100, 100, 100]);
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-5, "{found}");
        // Mean squares of 0.02 and 0.04.
        close(psnr(&a, &b, None).unwrap(), 16.989_700);
        close(psnr(&a, &b, Some(&mask((2, 1), |x, _| x == 0))).unwrap(), 13.979_400);
        let same = psnr(&a, &b, Some(&mask((2, 1), |x, _| x == 1)));
        assert_eq!(same.unwrap(), f64::INFINITY);
        let (black, white) = (colors((1, 1), &[0; 3]), colors((1, 1), &[255; 3]));
        assert_eq!(psnr(&black, &white, None).unwrap().to_bits(), 0.0f64.to_bits());
    }
}
