//! Mean absolute error.

use super::{Colors, Mask, MetricError, difference};

/// The mean absolute error: the mean of `|a - b|` over the mask's texels and the three channels.
///
/// 0.0 for identical pictures, 1.0 for black against white; lower is better. One 8-bit level is
/// 1/255. Values outside `0.0..=1.0` are not clamped.
///
/// # Errors
/// [`MetricError::Size`] if the pictures or the mask differ in size.
pub fn l1(a: &Colors, b: &Colors, mask: Option<&Mask>) -> Result<f64, MetricError> {
    difference::mean(a, b, mask, f64::abs)
}

#[cfg(test)]
mod tests {
    use super::super::testing::{colors, mask};
    use super::*;

    /// Differences of 51 and 102 levels in one channel of two texels, and of 255 in all channels of
    /// a third.
    #[test]
    fn by_hand() {
        let a = colors((2, 2), &[0, 0, 0, 0, 102, 0, 255, 255, 255, 9, 9, 9]);
        let b = colors((2, 2), &[51, 0, 0, 0, 0, 0, 0, 0, 0, 9, 9, 9]);
        let close = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-7, "{found}");
        close(l1(&a, &b, None).unwrap(), (0.2 + 0.4 + 3.0) / 12.0);
        let first_row = mask((2, 2), |_, y| y == 0);
        close(l1(&a, &b, Some(&first_row)).unwrap(), (0.2 + 0.4) / 6.0);
        close(l1(&a, &a, None).unwrap(), 0.0);
    }

    #[test]
    fn sizes_must_agree() {
        let (a, b) = (colors((2, 2), &[0; 12]), colors((4, 1), &[0; 12]));
        assert!(matches!(l1(&a, &b, None), Err(MetricError::Size { what: "second texture", .. })));
        let other = mask((2, 3), |_, _| true);
        assert!(matches!(l1(&a, &a, Some(&other)), Err(MetricError::Size { what: "mask", .. })));
    }
}
