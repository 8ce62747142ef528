//! Order statistics, and colour statistics transfer: gives one set of colours the mean and covariance
//! of another.
//!
//! Of all affine maps that do so, this one moves the colours least: the linear Monge-Kantorovich
//! map (Pitié and Kokaram, "The linear Monge-Kantorovitch linear colour mapping for example-based
//! colour transfer", CVMP 2007). Its matrix is symmetric positive definite: it scales colours along
//! three orthogonal axes and never rotates them around their mean.

use std::cmp::Ordering;

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// An affine colour transform: `matrix · rgb + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorMatch {
    matrix: [[f32; 3]; 3],
    offset: [f32; 3],
}

/// Why no colour transform could be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ColorMatchError {
    /// One side has no finite colour, so its mean is undefined.
    #[error("none of the {given} samples of the {side} has a finite colour")]
    NoSamples {
        /// `"source"` or `"base"`.
        side: &'static str,
        /// Number of samples, none of them finite.
        given: usize,
    },
}

impl ColorMatch {
    /// Limits of the gain, the factor by which colour differences change in any direction. Below,
    /// contrast would vanish; above, 8-bit quantisation noise would show as blotches.
    pub const GAIN: [f64; 2] = [0.5, 2.0];
    /// Limits of the gain in [`ColorMatch::keeping_contrast`], on top of the ratio of the means.
    /// Origin not recorded.
    pub const CONTRAST: [f64; 2] = [0.87, 1.15];
    /// With fewer finite samples on either side, only the mean is matched: a covariance estimated
    /// from `n` samples has a relative error of about `√(2/n)`, a third at this count.
    pub const MIN_FOR_SPREAD: usize = 16;
    /// Fraction of the samples that means and covariances are computed from; the outermost are
    /// trimmed. Sampled skin contains freckles, brows and strands of hair, a few percent of the
    /// texels, which would shift the mean by several levels. Both sides are trimmed by the same
    /// fraction, so the bias of the covariances cancels for distributions of the same shape.
    pub const KEPT: f64 = 0.9;

    /// The transform that maps the mean and covariance of `source` to those of `base`.
    ///
    /// - `source`, `base`: colours in any number and order; sRGB values as stored, 1.0 for white.
    ///   Samples that are not finite are skipped.
    ///
    /// Covariances are matched within the limits of [`ColorMatch::GAIN`]. A standard deviation
    /// of one 8-bit level is treated as noise: its variance is added to both covariances, and
    /// the matrix is blended with the identity by the signal-to-noise ratio of the side with
    /// less variance. Hence a side of uniform colour gives a pure shift, whatever the other
    /// side is like.
    ///
    /// # Errors
    /// [`ColorMatchError::NoSamples`] if a side has no finite colour.
    pub fn new(source: &[[f32; 3]], base: &[[f32; 3]]) -> Result<Self, ColorMatchError> {
        let [from, to] = [("source", source), ("base", base)].map(|(side, samples)| {
            Gaussian::robust(samples)
                .ok_or(ColorMatchError::NoSamples { side, given: samples.len() })
        });
        let (from, to) = (from?, to?);
        let matrix = if from.count.min(to.count) < Self::MIN_FOR_SPREAD {
            Matrix3::identity()
        } else {
            stretch(&from.covariance, &to.covariance).unwrap_or_else(Matrix3::identity)
        };
        Ok(Self::between(&from.mean, &to.mean, &matrix))
    }

    /// The transform that maps the mean of `source` to that of `base` by a ratio per channel, as
    /// light and pigment do, and matches covariances only within [`ColorMatch::CONTRAST`]. For
    /// skin: a face keeps its freckles and its shading, whatever the body's skin is like.
    ///
    /// With `R` the diagonal of the square roots of the ratios, the matrix is `R · B · R`, where
    /// `B` is `R⁻¹ · M · R⁻¹` for the matrix `M` of [`ColorMatch::new`] with its eigenvalues
    /// clamped. So it stays symmetric, and `B` holds the change of contrast beyond the ratio.
    ///
    /// # Errors
    /// As [`ColorMatch::new`].
    pub fn keeping_contrast(
        source: &[[f32; 3]],
        base: &[[f32; 3]],
    ) -> Result<Self, ColorMatchError> {
        let found = Self::new(source, base)?;
        let [from, to] = [source, base].map(Gaussian::robust);
        let (Some(from), Some(to)) = (from, to) else { return Ok(found) };
        let ratio = Vector3::from_fn(|k, _| (to.mean[k].max(1e-3) / from.mean[k].max(1e-3)).sqrt());
        let (scale, inverse) =
            (Matrix3::from_diagonal(&ratio), Matrix3::from_diagonal(&ratio.map(f64::recip)));
        let rows = found.matrix.map(|row| row.map(f64::from));
        let matrix = Matrix3::from_fn(|row, column| rows[row][column]);
        let [least, most] = Self::CONTRAST;
        let bounded = spectral(inverse * matrix * inverse, |gain| gain.clamp(least, most));
        let matrix = scale * bounded.unwrap_or_else(Matrix3::identity) * scale;
        Ok(Self::between(&from.mean, &to.mean, &matrix))
    }

    /// The transform with this linear part that maps one colour to another.
    fn between(from: &Vector3<f64>, to: &Vector3<f64>, matrix: &Matrix3<f64>) -> Self {
        let offset = to - matrix * from;
        Self {
            matrix: std::array::from_fn(|row| {
                std::array::from_fn(|column| matrix[(row, column)] as f32)
            }),
            offset: std::array::from_fn(|channel| offset[channel] as f32),
        }
    }

    /// Transforms a colour. Not clamped: results near black and white may leave `0.0..=1.0`.
    #[inline]
    pub fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let [r, g, b] = rgb;
        let channel = |k: usize| {
            let row = self.matrix[k];
            row[0] * r + row[1] * g + row[2] * b + self.offset[k]
        };
        [channel(0), channel(1), channel(2)]
    }

    /// The linear part, row-major; symmetric.
    pub fn matrix(&self) -> [[f32; 3]; 3] {
        self.matrix
    }

    /// The translation, added after the linear part.
    pub fn offset(&self) -> [f32; 3] {
        self.offset
    }
}

/// Variance that is treated as noise: that of a standard deviation of one 8-bit level.
const NOISE: f64 = 1.0 / (255.0 * 255.0);

/// The symmetric positive definite matrix that maps the covariance `from` to `to`, with
/// clamped gain.
///
/// With noise added to `A = from` and `B = to`, it is `A^-½ (A^½ B A^½)^½ A^-½` (Pitié and
/// Kokaram 2007). Its eigenvalues are the gains; they are clamped, since a nearly flat side
/// gives extreme ones, and blended with 1 by `v / (v + noise)`, where `v` is the lesser mean
/// variance: what little covariance such a side has is quantisation noise.
fn stretch(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let noise = Matrix3::identity() * NOISE;
    let root = spectral(from + noise, f64::sqrt)?;
    let inverse = spectral(from + noise, inverse_root)?;
    let map = inverse * spectral(root * (to + noise) * root, f64::sqrt)? * inverse;
    let flatter = from.trace().min(to.trace()).max(0.0) / 3.0;
    let trust = flatter / (flatter + NOISE);
    let [least, most] = ColorMatch::GAIN;
    spectral(map, |gain| 1.0 + trust * (gain.clamp(least, most) - 1.0))
}

fn inverse_root(value: f64) -> f64 {
    value.sqrt().recip()
}

/// Applies a function to the eigenvalues of a symmetric positive matrix. `None` if the
/// decomposition does not converge, as with values near the limits of floats.
fn spectral(matrix: Matrix3<f64>, power: impl Fn(f64) -> f64) -> Option<Matrix3<f64>> {
    const MAX_STEPS: usize = 100;
    /// Far below noise; raises eigenvalues that rounding made negative or zero.
    const MIN: f64 = 1e-12;
    // The decomposition reads one triangle only, and rounding made the two differ.
    let matrix = (matrix + matrix.transpose()) * 0.5;
    let eigen = SymmetricEigen::try_new(matrix, f64::EPSILON, MAX_STEPS)?;
    let values = eigen.eigenvalues.map(|value| power(value.max(MIN)));
    let axes = eigen.eigenvectors;
    Some(axes * Matrix3::from_diagonal(&values) * axes.transpose())
}

/// Trimmed mean and covariance of some points.
struct Gaussian {
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Number of finite points before trimming.
    count: usize,
}

impl Gaussian {
    /// Trims outliers. `None` without a finite point.
    ///
    /// The nearest half of the points, by deviation from the median scaled by the median absolute
    /// deviation, gives a first estimate; two concentration steps follow, each taking the
    /// [`ColorMatch::KEPT`] nearest points in Mahalanobis distance. A plain mean and covariance
    /// would let outliers inflate the very distance that should reject them.
    fn robust(samples: &[[f32; 3]]) -> Option<Self> {
        let points: Vec<Vector3<f64>> = samples
            .iter()
            .filter(|sample| sample.iter().all(|value| value.is_finite()))
            .map(|sample| Vector3::from(sample.map(f64::from)))
            .collect();
        if points.is_empty() {
            return None;
        }
        // Median and median absolute deviation tolerate up to half of the points being outliers.
        let along = |axis: usize| points.iter().map(move |point| point[axis]);
        let middle = |values: &mut dyn Iterator<Item = f64>| quantile(values, 0.5).unwrap_or(0.0);
        let median = Vector3::from_fn(|axis, _| middle(&mut along(axis)));
        let scale = Vector3::from_fn(|axis, _| {
            let mut deviations = along(axis).map(|value| (value - median[axis]).abs());
            middle(&mut deviations) + NOISE.sqrt()
        });
        let distance = |point: &Vector3<f64>| (point - median).component_div(&scale).norm_squared();
        let mut moments = nearest(&points, 0.5, distance);
        for _ in 0..2 {
            let (mean, covariance) = moments;
            let noise = Matrix3::identity() * NOISE;
            let Some(whiten) = spectral(covariance + noise, inverse_root) else { break };
            let distance = |point: &Vector3<f64>| (whiten * (point - mean)).norm_squared();
            moments = nearest(&points, ColorMatch::KEPT, distance);
        }
        let (mean, covariance) = moments;
        Some(Self { mean, covariance, count: points.len() })
    }
}

/// Mean and covariance of the fraction `share` of points with the least `distance`, ties included.
fn nearest(
    points: &[Vector3<f64>],
    share: f64,
    distance: impl Fn(&Vector3<f64>) -> f64,
) -> (Vector3<f64>, Matrix3<f64>) {
    let farthest = quantile(points.iter().map(&distance), share).unwrap_or(0.0);
    // Distances that differ only by rounding of 32-bit colours count as ties.
    let farthest = farthest * (1.0 + 1e-6);
    moments(points.iter().map(|point| (*point, f64::from(distance(point) <= farthest))))
}

/// Numbers of a total order, as [`order_statistic`] needs it: `f32` and `f64` by their `total_cmp`.
pub trait TotalOrder: Copy {
    /// `total_cmp` of the type.
    fn total_cmp(&self, other: &Self) -> Ordering;
}

impl TotalOrder for f32 {
    fn total_cmp(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

impl TotalOrder for f64 {
    fn total_cmp(&self, other: &Self) -> Ordering {
        self.total_cmp(other)
    }
}

/// The value at a rank in ascending order; `None` of no values.
///
/// - `rank`: of the number of values, which is at least 1; below it.
///
/// No values are left out: NaN counts as greater than infinity, or less than minus infinity if its
/// sign bit is set.
///
/// # Panics
/// If the rank is not below the number of values.
pub fn order_statistic<T: TotalOrder>(
    values: impl IntoIterator<Item = T>,
    rank: impl FnOnce(usize) -> usize,
) -> Option<T> {
    let mut values: Vec<T> = values.into_iter().collect();
    let rank = if values.is_empty() { return None } else { rank(values.len()) };
    Some(*values.select_nth_unstable_by(rank, T::total_cmp).1)
}

/// The median, of an even number of values the upper of the two in the middle; `None` of no values.
///
/// It always is one of the values, which a mean of two is not: of labels or distances in steps that
/// would be a number that occurs nowhere. NaN is sorted as in [`order_statistic`].
pub fn median<T: TotalOrder>(values: impl IntoIterator<Item = T>) -> Option<T> {
    order_statistic(values, |count| count / 2)
}

/// The [`median`] of each channel, so a colour that may not be among those given; `None` of no colours.
pub fn median_color<T: TotalOrder, const N: usize>(
    colors: impl IntoIterator<Item = [T; N]>,
) -> Option<[T; N]> {
    let colors: Vec<[T; N]> = colors.into_iter().collect();
    let first = *colors.first()?;
    let channel = |k: usize| median(colors.iter().map(|color| color[k])).unwrap_or(first[k]);
    Some(std::array::from_fn(channel))
}

/// The largest value among the lowest fraction `share` of all, at least the lowest value; `None` of no
/// values. At one half, it is the lower of two values in the middle, unlike the [`median`]. NaN is
/// sorted as in [`order_statistic`].
///
/// - `share`: 0 to 1.
pub fn quantile<T: TotalOrder>(values: impl IntoIterator<Item = T>, share: f64) -> Option<T> {
    order_statistic(values, |count| ((count - 1) as f64 * share) as usize)
}

/// Mean and covariance of weighted points; zero if all weights are.
pub fn moments(
    points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone,
) -> (Vector3<f64>, Matrix3<f64>) {
    let weights: f64 = points.clone().map(|(_, weight)| weight).sum();
    if weights <= 0.0 {
        return (Vector3::zeros(), Matrix3::zeros());
    }
    let sum = points.clone().fold(Vector3::zeros(), |sum, (point, weight)| sum + point * weight);
    let mean: Vector3<f64> = sum / weights;
    // Two passes: a difference of squares would cancel where points are close together.
    let covariance = points.fold(Matrix3::zeros(), |sum: Matrix3<f64>, (point, weight)| {
        let offset = point - mean;
        sum + offset * offset.transpose() * weight
    });
    (mean, covariance / weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_even_counts_are_the_upper_of_two() {
        assert_eq!(median([3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([4.0_f32, 1.0, 2.0, 3.0]), Some(3.0));
        assert_eq!(median::<f64>([]), None);
        // NaN is the largest of all.
        assert_eq!(median([f64::NAN, 1.0, 2.0]), Some(2.0));
        assert_eq!(median([-f64::NAN, 1.0, 2.0]), Some(1.0));
        let colors = [[1.0, 9.0], [2.0, 8.0], [3.0, 7.0]];
        assert_eq!(median_color(colors), Some([2.0, 8.0]));
        assert_eq!(median_color::<f32, 3>([]), None);
    }

    #[test]
    fn quantiles_are_values() {
        let values = [4.0, 1.0, 3.0, 2.0];
        let found = [0.0, 0.5, 0.99, 1.0].map(|share| quantile(values, share));
        assert_eq!(found, [1.0, 2.0, 3.0, 4.0].map(Some));
        assert_eq!(quantile::<f32>([], 0.5), None);
        assert_eq!(order_statistic(values, |count| count * 9 / 10), Some(4.0));
    }

    /// Normally distributed colours, `mean + mix · z`.
    fn cloud(mean: [f32; 3], mix: [[f32; 3]; 3], count: usize, seed: u64) -> Vec<[f32; 3]> {
        let mut rng = fastrand::Rng::with_seed(seed);
        // The sum of twelve uniform numbers has variance 1 and is nearly normal.
        let mut normal = || (0..12).map(|_| rng.f32()).sum::<f32>() - 6.0;
        let colors = std::iter::repeat_with(|| {
            let z: [f32; 3] = std::array::from_fn(|_| normal());
            std::array::from_fn(|row| mean[row] + (0..3).map(|k| mix[row][k] * z[k]).sum::<f32>())
        });
        colors.take(count).collect()
    }

    /// Mean and covariance without trimming.
    fn plain(colors: &[[f32; 3]]) -> (Vector3<f64>, Matrix3<f64>) {
        moments(colors.iter().map(|rgb| (Vector3::from(rgb.map(f64::from)), 1.0)))
    }

    fn mapped(map: &ColorMatch, colors: &[[f32; 3]]) -> Vec<[f32; 3]> {
        colors.iter().map(|&rgb| map.apply(rgb)).collect()
    }

    /// The largest absolute difference from a diagonal matrix.
    fn off(matrix: [[f32; 3]; 3], diagonal: [f32; 3]) -> f32 {
        let entries = (0..9).map(|k| {
            let (row, column) = (k / 3, k % 3);
            let wanted = if row == column { diagonal[row] } else { 0.0 };
            (matrix[row][column] - wanted).abs()
        });
        entries.fold(0.0, f32::max)
    }

    const WARM: [[f32; 3]; 3] = [[0.060, 0.010, 0.0], [0.050, -0.015, 0.008], [0.045, 0.0, -0.02]];
    const COOL: [[f32; 3]; 3] = [[0.045, 0.012, 0.004], [0.055, -0.01, 0.01], [0.06, 0.008, -0.02]];

    #[test]
    fn mean_and_covariance_are_matched() {
        for seed in 0..4 {
            let source = cloud([0.7, 0.5, 0.42], WARM, 20_000, 2 * seed);
            let base = cloud([0.45, 0.38, 0.36], COOL, 20_000, 2 * seed + 1);
            let map = ColorMatch::new(&source, &base).unwrap();
            let (mean, covariance) = plain(&mapped(&map, &source));
            let (wanted_mean, wanted) = plain(&base);
            // The mean of 20,000 colours with a deviation of 0.1 is accurate to 0.0007 on either
            // side; trimmed means vary a little more.
            assert!((mean - wanted_mean).amax() < 0.002, "{mean} {wanted_mean}");
            // Covariances are accurate to 1 % on either side, trimmed ones less so.
            assert!((covariance - wanted).norm() < 0.05 * wanted.norm(), "{covariance} {wanted}");
            let (_, before) = plain(&source);
            assert!((before - wanted).norm() > 0.2 * wanted.norm(), "the test must see a change");
        }
    }

    #[test]
    fn equal_statistics_give_the_identity() {
        let source = cloud([0.7, 0.5, 0.42], WARM, 5000, 3);
        let mut base = source.clone();
        fastrand::Rng::with_seed(4).shuffle(&mut base);
        let map = ColorMatch::new(&source, &base).unwrap();
        for rgb in [[0.0; 3], [1.0; 3], [1.0, 0.0, 0.0], [0.7, 0.5, 0.42], [0.0, 1.0, 1.0]] {
            let result = map.apply(rgb);
            let change = (0..3).map(|k| (result[k] - rgb[k]).abs()).fold(0.0, f32::max);
            assert!(change < 1e-4, "{rgb:?} becomes {result:?}");
        }
    }

    /// Grids of 3 × 3 × 3 points, whose covariance is diagonal: two thirds of the squared half
    /// sides.
    #[test]
    fn agrees_with_hand_computed_gains() {
        let grid = |mean: [f32; 3], half: [f32; 3]| -> Vec<[f32; 3]> {
            (0..27)
                .map(|k| [k / 9, k / 3 % 3, k % 3])
                .map(|at| {
                    std::array::from_fn(|axis| mean[axis] + half[axis] * (at[axis] as f32 - 1.0))
                })
                .collect()
        };
        let source = grid([0.5, 0.4, 0.3], [0.10; 3]);
        let base = grid([0.6, 0.4, 0.2], [0.15, 0.08, 0.10]);
        let map = ColorMatch::new(&source, &base).unwrap();
        // Noise of 1/255 against 0.08 takes 0.4 % off a gain's difference from 1.
        assert!(off(map.matrix(), [1.5, 0.8, 1.0]) < 0.003, "{map:?}");
        let result = map.apply([0.5, 0.4, 0.3]);
        for (value, wanted) in result.into_iter().zip([0.6, 0.4, 0.2]) {
            assert!((value - wanted).abs() < 1e-5, "{result:?}");
        }
        // Gains of 20 and 1/20 are clamped.
        let wide = ColorMatch::new(&source, &grid([0.5; 3], [2.0, 0.005, 0.1])).unwrap();
        assert!(off(wide.matrix(), [2.0, 0.5, 1.0]) < 0.005, "{wide:?}");
    }

    /// Colours are scaled along three orthogonal axes, never rotated.
    #[test]
    fn the_matrix_is_symmetric_and_bounded() {
        for seed in 0..20 {
            let mut rng = fastrand::Rng::with_seed(seed);
            let mut mix =
                || std::array::from_fn(|_| std::array::from_fn(|_| 0.2 * (rng.f32() - 0.5)));
            let source = cloud([0.5; 3], mix(), 300, seed + 100);
            let base = cloud([0.4; 3], mix(), 300, seed + 200);
            let m = ColorMatch::new(&source, &base).unwrap().matrix();
            let matrix = Matrix3::from_fn(|row, column| f64::from(m[row][column]));
            assert!((matrix - matrix.transpose()).amax() < 1e-6, "{matrix}");
            let gains = matrix.symmetric_eigenvalues();
            assert!(gains.min() > 0.5 - 1e-6 && gains.max() < 2.0 + 1e-6, "{gains}");
        }
    }

    #[test]
    fn uniform_or_few_colors_give_a_shift() {
        let flat = vec![[0.5, 0.4, 0.3]; 100];
        let other = vec![[0.55, 0.35, 0.3]; 100];
        let rich = cloud([0.6, 0.5, 0.4], WARM, 100, 1);
        for (source, base) in [(&flat, &other), (&flat, &rich), (&rich, &flat)] {
            let map = ColorMatch::new(source, base).unwrap();
            assert!(off(map.matrix(), [1.0; 3]) < 1e-6, "{map:?}");
        }
        let map = ColorMatch::new(&flat, &other).unwrap();
        let shift = map.offset();
        assert!((shift[0] - 0.05).abs() < 1e-6 && (shift[1] + 0.05).abs() < 1e-6, "{shift:?}");
        // A standard deviation of one level gives a trust of one half.
        let mut nearly = other.clone();
        nearly.iter_mut().step_by(2).for_each(|rgb| *rgb = rgb.map(|value| value + 2.0 / 255.0));
        let map = ColorMatch::new(&rich, &nearly).unwrap();
        let gains = Matrix3::from_fn(|row, column| f64::from(map.matrix()[row][column]))
            .symmetric_eigenvalues();
        assert!(gains.min() > 0.74 && gains.min() < 0.76, "half way from 1 to 0.5: {gains}");

        let few = ColorMatch::new(&rich[..15], &cloud([0.2; 3], COOL, 500, 2)).unwrap();
        assert_eq!(few.matrix(), [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let one = ColorMatch::new(&[[0.25, 0.5, 0.75]], &[[0.5, 0.5, 0.5]]).unwrap();
        assert_eq!(one.offset(), [0.25, 0.0, -0.25]);
    }

    #[test]
    fn outliers_hardly_matter() {
        let source = cloud([0.7, 0.5, 0.42], WARM, 2000, 5);
        let base = cloud([0.45, 0.38, 0.36], COOL, 2000, 6);
        let clean = ColorMatch::new(&source, &base).unwrap();
        let mut dirty = source.clone();
        // Add 8 % hair and cloth.
        dirty.extend(vec![[0.05, 0.04, 0.04]; 100]);
        dirty.extend(vec![[0.1, 0.9, 0.2]; 74]);
        let map = ColorMatch::new(&dirty, &base).unwrap();
        let (a, b) = (clean.apply([0.7, 0.5, 0.42]), map.apply([0.7, 0.5, 0.42]));
        let change = (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f32::max);
        // Untrimmed, the mean would move by 13 levels in red.
        assert!(change < 1.5 / 255.0, "{a:?} {b:?}");
    }

    #[test]
    fn non_finite_samples_are_skipped() {
        let source = cloud([0.7, 0.5, 0.42], WARM, 100, 5);
        let base = cloud([0.45, 0.38, 0.36], COOL, 100, 6);
        let map = ColorMatch::new(&source, &base);
        let mut broken = source.clone();
        broken.insert(0, [f32::NAN, 0.5, 0.5]);
        broken.insert(50, [0.5, f32::INFINITY, 0.5]);
        assert_eq!(ColorMatch::new(&broken, &base), map);
        let nothing = ColorMatch::new(&source, &[[f32::NAN; 3]; 3]);
        assert_eq!(nothing, Err(ColorMatchError::NoSamples { side: "base", given: 3 }));
        let nothing = ColorMatch::new(&[], &base);
        assert_eq!(nothing, Err(ColorMatchError::NoSamples { side: "source", given: 0 }));
        // Absurd values give absurd transforms, but the solver terminates.
        let mut huge = base.clone();
        huge.extend([[f32::MAX; 3], [f32::MIN, 0.0, f32::MAX]].repeat(100));
        assert!(ColorMatch::new(&huge, &base).is_ok());
        assert!(ColorMatch::new(&source, &huge).is_ok());
    }
}
