//! Fields of values on a layout's texels: blurred, sampled between texels.

use uvgraft::Size;
use uvgraft::threads::{for_each_chunk, map_indices};

/// The bilinear mean of the four values around a UV coordinate, whose centres are at `+0.5`.
pub(crate) fn bilinear<const N: usize>(size: Size, values: &[[f32; N]], uv: [f32; 2]) -> [f32; N] {
    let (width, height) = (size.width as i64, size.height as i64);
    let (x, y) = (uv[0] * width as f32 - 0.5, uv[1] * height as f32 - 0.5);
    let (left, top) = (x.floor(), y.floor());
    let (fx, fy) = (x - left, y - top);
    let at = |dx: i64, dy: i64| {
        let x = (left as i64 + dx).clamp(0, width - 1);
        let y = (top as i64 + dy).clamp(0, height - 1);
        values[(y * width + x) as usize]
    };
    let [a, b, c, d] = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)];
    std::array::from_fn(|k| {
        let above = a[k] + (b[k] - a[k]) * fx;
        let below = c[k] + (d[k] - c[k]) * fx;
        above + (below - above) * fy
    })
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
    fn values_are_sampled_between_centres() {
        let values = [[0.0], [1.0], [2.0], [3.0]];
        let size = Size::square(2);
        assert_eq!(bilinear(size, &values, [0.25, 0.25]), [0.0]);
        assert_eq!(bilinear(size, &values, [0.5, 0.5]), [1.5]);
        assert_eq!(bilinear(size, &values, [2.0, 0.5]), [2.0]);
    }
}
