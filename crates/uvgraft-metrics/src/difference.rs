//! Sums over per-channel differences, for metrics that are a mean of them.

use uvgraft::threads::map_indices;

use super::{Colors, Mask, MetricError, same_size};

/// Rows that are summed in one block. Affects the last digits of the result, so it is not
/// a tuning option.
const ROWS: usize = 64;

/// The mean of `of(difference)` over texels and channels, in `f64`.
pub(super) fn mean(
    a: &Colors,
    b: &Colors,
    mask: Option<&Mask>,
    of: impl Fn(f64) -> f64 + Sync + Send,
) -> Result<f64, MetricError> {
    same_size(a, b, mask)?;
    let (width, height) = (a.size().width as usize, a.size().height as usize);
    let term = |(a, b): (&f32, &f32)| of(f64::from(*a) - f64::from(*b));
    let sums = map_indices(height.div_ceil(ROWS), |block| {
        let mut sum = 0.0;
        for row in block * ROWS..((block + 1) * ROWS).min(height) {
            let texels = row * width..(row + 1) * width;
            let [a, b] = [a, b].map(|colors| colors.values(texels.clone()));
            match mask {
                None => a.iter().zip(b.iter()).map(term).for_each(|term| sum += term),
                Some(mask) => a
                    .chunks_exact(3)
                    .zip(b.chunks_exact(3))
                    .zip(&mask.selected()[texels])
                    .filter(|(_, selected)| **selected)
                    .for_each(|((a, b), _)| sum += a.iter().zip(b).map(term).sum::<f64>()),
            }
        }
        sum
    });
    let count = mask.map_or(a.size().texels(), Mask::count);
    Ok(sums.iter().sum::<f64>() / (count as f64 * 3.0))
}
