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
    let width = a.size().width as usize;
    let texels = ROWS * width;
    let term = |(a, b): (&f32, &f32)| of(f64::from(*a) - f64::from(*b));
    let sums = map_indices(a.size().texels().div_ceil(texels), |block| {
        let texels = block * texels..((block + 1) * texels).min(a.size().texels());
        let [a, b] = [a, b].map(|colors| colors.values(texels.clone()));
        match mask {
            None => a.iter().zip(b.iter()).map(term).sum::<f64>(),
            Some(mask) => a
                .chunks_exact(3)
                .zip(b.chunks_exact(3))
                .zip(&mask.selected()[texels])
                .filter(|(_, selected)| **selected)
                .map(|((a, b), _)| a.iter().zip(b).map(term).sum::<f64>())
                .sum(),
        }
    });
    let count = mask.map_or(a.size().texels(), Mask::count);
    Ok(sums.iter().sum::<f64>() / (count as f64 * 3.0))
}
