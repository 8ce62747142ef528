//! Gives one set of colours the mean and the covariance of another.
//!
//! Of all affine maps that do so this is the one that moves colours least: the linear
//! Monge-Kantorovich map (Pitié and Kokaram, "The linear Monge-Kantorovitch linear colour mapping
//! for example-based colour transfer", CVMP 2007). It is symmetric and positive, so it stretches
//! colours along three axes and never turns one hue into another's place.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// An affine map of colours: `matrix · rgb + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColorMatch {
    matrix: [[f32; 3]; 3],
    offset: [f32; 3],
}

/// Why no map of colours was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ColorMatchError {
    /// A mean needs at least one colour.
    #[error("no finite colour among the {given} samples of the {side}")]
    NoSamples {
        /// `"source"` or `"base"`.
        side: &'static str,
        /// How many samples there were, none of them finite.
        given: usize,
    },
}

impl ColorMatch {
    /// The least and the greatest factor by which differences between colours change, in any
    /// direction. Beyond it contrast would vanish, or the noise of 8 bits show as blotches.
    pub const GAIN: [f64; 2] = [0.5, 2.0];
    /// With fewer finite samples on either side colours are shifted only: a covariance from `n`
    /// samples is off by about `√(2/n)`, which is a third here.
    pub const LEAST_FOR_SPREAD: usize = 16;
    /// The share of samples that means and covariances are taken from; those farthest away are left
    /// out. Skin as it is sampled holds freckles, brows and strands of hair, a few of a hundred texels
    /// that would move a mean by several levels. Both sides lose the same share, so for clouds of one
    /// shape what that takes off the covariances cancels.
    pub const KEPT: f64 = 0.9;

    /// The map that carries `source`'s mean and covariance onto those of `base`.
    ///
    /// - `source`, `base`: colours, in any number and order; sRGB values as stored, 1.0 for white. Those
    ///   that are not finite are passed over.
    ///
    /// Covariances are matched as far as [`ColorMatch::GAIN`] allows. One level of 8 bits is taken for
    /// noise: it is added to both spreads, and the flatter side's spread beside it says how far
    /// the matrix is trusted over a mere shift. So colours that are all the same on one side or both
    /// give a shift, whatever the other side does.
    ///
    /// # Errors
    /// [`ColorMatchError::NoSamples`] if a side has no finite colour.
    pub fn new(source: &[[f32; 3]], base: &[[f32; 3]]) -> Result<Self, ColorMatchError> {
        let [from, to] = [("source", source), ("base", base)].map(|(side, samples)| {
            Gaussian::robust(samples)
                .ok_or(ColorMatchError::NoSamples { side, given: samples.len() })
        });
        let (from, to) = (from?, to?);
        let matrix = if from.count.min(to.count) < Self::LEAST_FOR_SPREAD {
            Matrix3::identity()
        } else {
            stretch(&from.covariance, &to.covariance)
        };
        let offset = to.mean - matrix * from.mean;
        Ok(Self {
            matrix: std::array::from_fn(|row| {
                std::array::from_fn(|column| matrix[(row, column)] as f32)
            }),
            offset: std::array::from_fn(|channel| offset[channel] as f32),
        })
    }

    /// The colour in place of `rgb`. Not clamped: near black and white it may leave `0.0..=1.0`.
    #[inline]
    pub fn apply(&self, rgb: [f32; 3]) -> [f32; 3] {
        let [r, g, b] = rgb;
        let channel = |k: usize| {
            let row = self.matrix[k];
            row[0] * r + row[1] * g + row[2] * b + self.offset[k]
        };
        [channel(0), channel(1), channel(2)]
    }

    /// The linear part, row by row; symmetric.
    pub fn matrix(&self) -> [[f32; 3]; 3] {
        self.matrix
    }

    /// What is added after it.
    pub fn offset(&self) -> [f32; 3] {
        self.offset
    }
}

/// Variance of what is taken for noise: one level of 8 bits.
const NOISE: f64 = 1.0 / (255.0 * 255.0);

/// The symmetric positive matrix that makes a covariance `to` of a covariance `from`, with bounded
/// gain, and the closer to the identity the flatter one of them is.
fn stretch(from: &Matrix3<f64>, to: &Matrix3<f64>) -> Matrix3<f64> {
    let noise = Matrix3::identity() * NOISE;
    let root = powered(from + noise, f64::sqrt);
    let inverse = powered(from + noise, |value| value.sqrt().recip());
    let middle = root * (to + noise) * root;
    // Rounding made it a little asymmetric, which the decomposition would take for half the matrix.
    let middle = powered((middle + middle.transpose()) * 0.5, f64::sqrt);
    let map = inverse * middle * inverse;
    let flatter = from.trace().min(to.trace()).max(0.0) / 3.0;
    let trust = flatter / (flatter + NOISE);
    let [least, most] = ColorMatch::GAIN;
    powered((map + map.transpose()) * 0.5, |gain| 1.0 + trust * (gain.clamp(least, most) - 1.0))
}

/// A symmetric matrix with its eigenvalues, at least those of noise's rounding, replaced.
fn powered(matrix: Matrix3<f64>, power: impl Fn(f64) -> f64) -> Matrix3<f64> {
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(matrix);
    let values = eigenvalues.map(|value| power(value.max(1e-12)));
    eigenvectors * Matrix3::from_diagonal(&values) * eigenvectors.transpose()
}

/// Mean and covariance of the greater part of some points.
struct Gaussian {
    mean: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// How many finite points there were.
    count: usize,
}

impl Gaussian {
    /// Leaves out the points farthest away. `None` without a finite point.
    fn robust(samples: &[[f32; 3]]) -> Option<Self> {
        let points: Vec<Vector3<f64>> = samples
            .iter()
            .filter(|sample| sample.iter().all(|value| value.is_finite()))
            .map(|sample| Vector3::from(sample.map(f64::from)))
            .collect();
        if points.is_empty() {
            return None;
        }
        // Median and median deviation withstand anything that half of the points are not part of.
        let along = |axis: usize| points.iter().map(move |point| point[axis]);
        let median = Vector3::from_fn(|axis, _| quantile(along(axis).collect(), 0.5));
        let scale = Vector3::from_fn(|axis, _| {
            let deviations = along(axis).map(|value| (value - median[axis]).abs()).collect();
            quantile(deviations, 0.5) + NOISE.sqrt()
        });
        let apart = |point: &Vector3<f64>| (point - median).component_div(&scale).norm_squared();
        let mut moments = nearest(&points, 0.5, apart);
        for _ in 0..2 {
            let (mean, covariance) = moments;
            let whiten =
                powered(covariance + Matrix3::identity() * NOISE, |value| value.sqrt().recip());
            let apart = |point: &Vector3<f64>| (whiten * (point - mean)).norm_squared();
            moments = nearest(&points, ColorMatch::KEPT, apart);
        }
        let (mean, covariance) = moments;
        Some(Self { mean, covariance, count: points.len() })
    }
}

/// Mean and covariance of the share of points for which `apart` is least, and their equals.
fn nearest(
    points: &[Vector3<f64>],
    share: f64,
    apart: impl Fn(&Vector3<f64>) -> f64,
) -> (Vector3<f64>, Matrix3<f64>) {
    let farthest = quantile(points.iter().map(&apart).collect(), share);
    moments(points.iter().map(|point| (*point, if apart(point) <= farthest { 1.0 } else { 0.0 })))
}

/// The value that a share of all is at or below.
///
/// # Panics
/// If there is none.
pub(super) fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    let rank = ((values.len() - 1) as f64 * share) as usize;
    *values.select_nth_unstable_by(rank, f64::total_cmp).1
}

/// Mean and covariance of weighted points; zeros where all weights are.
pub(super) fn moments(
    points: impl Iterator<Item = (Vector3<f64>, f64)> + Clone,
) -> (Vector3<f64>, Matrix3<f64>) {
    let weights: f64 = points.clone().map(|(_, weight)| weight).sum();
    if weights <= 0.0 {
        return (Vector3::zeros(), Matrix3::zeros());
    }
    let sum = points.clone().fold(Vector3::zeros(), |sum, (point, weight)| sum + point * weight);
    let mean: Vector3<f64> = sum / weights;
    // In a second pass: squares would cancel where points are close together.
    let covariance = points.fold(Matrix3::zeros(), |sum: Matrix3<f64>, (point, weight)| {
        let apart = point - mean;
        sum + apart * apart.transpose() * weight
    });
    (mean, covariance / weights)
}
