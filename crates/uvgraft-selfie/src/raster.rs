//! Fields of values on a layout's texels: blurred, sampled between texels.

use uvgraft::Size;
use uvgraft::sampler::{Beyond, bilinear};
use uvgraft::threads::{for_each_chunk, map_indices};

/// The bilinear mean of the four values around a UV coordinate; beyond the edge, those there.
pub(crate) fn sample<const N: usize>(size: Size, values: &[[f32; N]], uv: [f32; 2]) -> [f32; N] {
    let at_px = [f64::from(uv[0] * size.width as f32), f64::from(uv[1] * size.height as f32)];
    bilinear(size, at_px, Beyond::Edge, |x, y| values[(y * size.width + x) as usize])
}

/// A field's means over squares of texels, for what changes slowly.
#[derive(Debug, Clone)]
pub(crate) struct Squares<const N: usize> {
    /// Of the field.
    field: Size,
    /// Columns and rows.
    size: Size,
    values: Vec<[f32; N]>,
}

impl<const N: usize> Squares<N> {
    /// - `most`: columns and rows, at most.
    /// - `value`: of a texel.
    pub fn new(field: Size, most: u32, value: impl Fn(usize) -> [f32; N] + Sync) -> Self {
        let size = Size::new(field.width.min(most), field.height.min(most));
        let range = |index: u32, count: u32, texels: u32| {
            let start = |index: u32| {
                (u64::from(index) * u64::from(texels)).div_ceil(u64::from(count)) as usize
            };
            start(index)..start(index + 1)
        };
        let values = map_indices(size.texels(), |square| {
            let (column, row) = (square as u32 % size.width, square as u32 / size.width);
            let columns = range(column, size.width, field.width);
            let mut sum = [0.0; N];
            let mut count = 0.0;
            for y in range(row, size.height, field.height) {
                for x in columns.clone() {
                    let value = value(y * field.width as usize + x);
                    sum.iter_mut().zip(value).for_each(|(sum, value)| *sum += value);
                    count += 1.0;
                }
            }
            sum.map(|sum| sum / count)
        });
        Self { field, size, values }
    }

    /// As [`blurred`]; the radius in squares.
    #[must_use]
    pub fn blurred(&self, radius: usize) -> Self {
        Self { values: blurred(self.size, &self.values, radius), ..*self }
    }

    /// The same squares with other values.
    pub fn map<const M: usize>(&self, value: impl Fn(usize) -> [f32; M]) -> Squares<M> {
        let values = (0..self.values.len()).map(value).collect();
        Squares { field: self.field, size: self.size, values }
    }

    pub fn values(&self) -> &[[f32; N]] {
        &self.values
    }

    /// The value at a texel of the field, between the squares' centres.
    pub fn at(&self, texel: usize) -> [f32; N] {
        let width = self.field.width as usize;
        let (x, y) = ((texel % width) as f32 + 0.5, (texel / width) as f32 + 0.5);
        let uv = [x / self.field.width as f32, y / self.field.height as f32];
        sample(self.size, &self.values, uv)
    }
}

/// Three box blurs, which together are nearly a Gaussian; the edges repeat.
///
/// - `radius`: of each box, in texels; 0 changes nothing.
pub(crate) fn blurred<const N: usize>(
    size: Size,
    values: &[[f32; N]],
    radius: usize,
) -> Vec<[f32; N]> {
    let mut blurred = values.to_vec();
    if radius == 0 {
        return blurred;
    }
    let (width, height) = (size.width as usize, size.height as usize);
    for _ in 0..3 {
        for_each_chunk(&mut blurred, width, |_, row| {
            let line = boxed(row.len(), radius, |index| row[index]);
            row.copy_from_slice(&line);
        });
        let columns = map_indices(width, |x| boxed(height, radius, |y| blurred[y * width + x]));
        for_each_chunk(&mut blurred, width, |y, row| {
            row.iter_mut().zip(&columns).for_each(|(value, column)| *value = column[y]);
        });
    }
    blurred
}

/// The mean of `2 * radius + 1` values around each.
fn boxed<const N: usize>(
    count: usize,
    radius: usize,
    at: impl Fn(usize) -> [f32; N],
) -> Vec<[f32; N]> {
    let clamped = |index: i64| at(index.clamp(0, count as i64 - 1) as usize);
    let reach = radius as i64;
    let mut sum = [0.0_f64; N];
    for index in -reach..=reach {
        sum.iter_mut().zip(clamped(index)).for_each(|(sum, value)| *sum += f64::from(value));
    }
    let share = 1.0 / (2 * radius + 1) as f64;
    (0..count as i64)
        .map(|index| {
            let mean = sum.map(|sum| (sum * share) as f32);
            let (enters, leaves) = (clamped(index + reach + 1), clamped(index - reach));
            for k in 0..N {
                sum[k] += f64::from(enters[k]) - f64::from(leaves[k]);
            }
            mean
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_blur_keeps_the_mean_and_what_is_even() {
        let size = Size::new(31, 17);
        let even = vec![[0.25, 1.0]; size.texels()];
        for value in blurred(size, &even, 3) {
            assert!((value[0] - 0.25).abs() < 1e-6 && (value[1] - 1.0).abs() < 1e-6);
        }
        let mut point = vec![[0.0]; size.texels()];
        point[8 * 31 + 15] = [1.0];
        let spread = blurred(size, &point, 2);
        let sum: f32 = spread.iter().map(|value| value[0]).sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
        let right = spread[8 * 31 + 18][0];
        assert!((spread[8 * 31 + 12][0] - right).abs() < 1e-6);
        assert!((spread[11 * 31 + 15][0] - right).abs() < 1e-6);
    }

    #[test]
    fn squares_follow_what_changes_slowly() {
        let field = Size::new(100, 60);
        let slope = |texel: usize| [(texel % 100) as f32 + 0.5, (texel / 100) as f32 + 0.5];
        for most in [20, 33, 200] {
            let squares = Squares::new(field, most, slope);
            for texel in [30 * 100 + 50, 20 * 100 + 31] {
                let (found, wanted) = (squares.at(texel), slope(texel));
                assert!((0..2).all(|k| (found[k] - wanted[k]).abs() < 1.0), "{most}: {found:?}");
            }
        }
        let mean = |squares: &Squares<2>| squares.values().iter().map(|at| at[0]).sum::<f32>();
        let squares = Squares::new(field, 20, slope);
        assert!((mean(&squares) - mean(&squares.blurred(2))).abs() < 1e-2 * mean(&squares));
    }

    #[test]
    fn values_are_sampled_between_centres() {
        let values = [[0.0], [1.0], [2.0], [3.0]];
        let size = Size::square(2);
        assert_eq!(sample(size, &values, [0.25, 0.25]), [0.0]);
        assert_eq!(sample(size, &values, [0.5, 0.5]), [1.5]);
        assert_eq!(sample(size, &values, [2.0, 0.5]), [2.0]);
    }
}
